//! Clearance of a simulated robot.

use crate::sink::ClearanceNeed;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_sim::clearance::{BarPlace, ClearanceMeter, Clearances};

/// Where the bars are, in the order of [`robhaz_model::Bar::ALL`].
fn places(truth: &Truth) -> [BarPlace; 4] {
    let [link1, link2, link3] = truth.links;
    [truth.body, link1, link2, link3].map(|bar| BarPlace {
        centre: bar.position,
        angle: bar.angle,
    })
}

/// Measures the clearance of a simulated robot at a truth.
pub struct TruthClearance {
    meter: ClearanceMeter,
    /// The least that [`Self::at_change`] has found, m.
    least: f64,
    /// At which records the sinks of a run need it.
    pub(crate) need: ClearanceNeed,
}

impl TruthClearance {
    /// For the robot and the ground of a scene.
    pub fn of(scene: &Scene) -> Self {
        let robot = &scene.robot.robot;
        Self {
            meter: ClearanceMeter::new(&robot.geometry, scene.terrain.build(robot)),
            least: f64::INFINITY,
            need: ClearanceNeed::Always,
        }
    }

    /// Clearance of body and links.
    pub fn at(&mut self, truth: &Truth) -> Clearances {
        self.meter.measure(&places(truth))
    }

    /// Clearance of body and links where it matters for the least of a run and for touches: `None`
    /// where it is not below the least that this function has found before and no bar touches the
    /// ground, or has just left it.
    pub fn at_change(&mut self, truth: &Truth) -> Option<Clearances> {
        let found = self.meter.measure_below(&places(truth), self.least)?;
        self.least = self.least.min(found.least.1);
        Some(found)
    }

    /// As far as sinks need it.
    pub(crate) fn for_sinks(&mut self, truth: &Truth) -> Option<Clearances> {
        match self.need {
            ClearanceNeed::Never => None,
            ClearanceNeed::AtChanges => self.at_change(truth),
            ClearanceNeed::Always => Some(self.at(truth)),
        }
    }
}

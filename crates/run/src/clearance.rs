//! Clearance of a simulated robot.

use crate::description::RunDescription;
use robhaz_clearance::{BarPlace, ClearanceMeter, Clearances};
use robhaz_scene::Scene;
use robhaz_sim::Truth;

/// Where the bars are, in the order of [`robhaz_model::Bar::ALL`].
fn places(truth: &Truth) -> [BarPlace; 4] {
    let [link1, link2, link3] = truth.links;
    [truth.body, link1, link2, link3].map(|bar| BarPlace {
        centre: bar.position,
        angle: bar.angle,
    })
}

/// Measures the clearance of a simulated robot at a truth.
pub struct TruthClearance(ClearanceMeter);

impl TruthClearance {
    /// For the robot and the ground of a scene.
    pub fn of(scene: &Scene) -> Self {
        let robot = &scene.robot.robot;
        Self(ClearanceMeter::new(
            &robot.geometry,
            scene.terrain.build(robot),
        ))
    }

    /// For a run; `None` for recorded readings.
    pub(crate) fn of_run(run: &RunDescription) -> Option<Self> {
        let robot = &run.robot.robot;
        let terrain = run.world.as_ref()?.terrain.build(robot);
        Some(Self(ClearanceMeter::new(&robot.geometry, terrain)))
    }

    /// Clearance of body and links.
    pub fn at(&mut self, truth: &Truth) -> Clearances {
        self.0.measure(&places(truth))
    }
}

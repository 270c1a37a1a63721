//! Clearance of a simulated robot.

use robhaz_model::Bar;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_sim::clearance::{BarPlace, ClearanceMeter, Clearances};

/// Where the bars are, in the order of [`Bar::ALL`].
fn places(truth: &Truth) -> [BarPlace; 4] {
    Bar::ALL.map(|bar| BarPlace {
        centre: truth.bar(bar).position,
        angle: truth.bar(bar).angle,
    })
}

/// Measures the clearance of a simulated robot at a truth.
pub struct TruthClearance(ClearanceMeter);

impl TruthClearance {
    /// For the robot and the ground of a scene.
    pub fn of(scene: &Scene) -> Self {
        let robot = &scene.robot.robot;
        let ground = scene.terrain.build(robot);
        Self(ClearanceMeter::new(&robot.geometry, ground))
    }

    /// Clearance of body and links.
    pub fn at(&mut self, truth: &Truth) -> Clearances {
        self.0.measure(&places(truth))
    }
}

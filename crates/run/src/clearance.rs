//! Clearance of a simulated robot.

use crate::description::RunDescription;
use robhaz_clearance::{BarPlace, ClearanceMeter, Clearances};
use robhaz_model::Robot;
use robhaz_scene::{Scene, TerrainChoice};
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
        Self::new(&scene.robot.robot, &scene.terrain)
    }

    /// For a run; `None` for recorded readings.
    pub(crate) fn of_run(run: &RunDescription) -> Option<Self> {
        let world = run.world.as_ref()?;
        Some(Self::new(&run.robot.robot, &world.terrain))
    }

    fn new(robot: &Robot, terrain: &TerrainChoice) -> Self {
        let terrain = terrain.build(robot);
        Self(ClearanceMeter::new(&robot.geometry, terrain))
    }

    /// Clearance of body and links.
    pub fn at(&mut self, truth: &Truth) -> Clearances {
        self.0.measure(&places(truth))
    }
}

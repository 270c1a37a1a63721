//! The robot with its drives on its ground: forces from a state and the motor torques.

use super::carriers::Carriers;
use super::kinematics::{Linkage, State};
use crate::drive::Drive;
use crate::ground::Ground;
use crate::setup::PlantSetup;
use robhaz_model::Robot;

/// The equations of motion with all laws that act on the robot.
pub(crate) struct Mechanics {
    pub robot: Robot,
    pub drive: Drive,
    pub linkage: Linkage,
    pub(super) carriers: Carriers,
    pub ground: Ground,
}

impl Mechanics {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            robot: setup.robot.clone(),
            drive: setup.drive.clone(),
            linkage: Linkage::new(&setup.robot.geometry),
            carriers: Carriers::new(&setup.robot),
            ground: Ground::new(setup),
        }
    }

    /// Motor torques less the losses of the gears, N m.
    pub(super) fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| torques[i] - self.drive.loss_torque(state.omega[i]))
    }
}

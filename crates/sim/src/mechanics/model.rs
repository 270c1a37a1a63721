//! The robot with its drives on its ground: forces from a state and the motor torques.

use super::carriers::Carriers;
use super::forces::{Forces, NoForces};
use super::kinematics::{Kinematics, State};
use super::linkage::Linkage;
use crate::drive::Drive;
use crate::ground::Ground;
use crate::setup::PlantSetup;
use robhaz_model::Robot;

/// The equations of motion with all laws that act on the robot.
pub(crate) struct Mechanics {
    pub robot: Robot,
    pub drive: Drive,
    pub linkage: Linkage,
    carriers: Carriers,
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

    /// Writes accelerations and forces for given motor torques at the wheels, N m.
    ///
    /// # Errors
    /// [`NoForces`]
    #[inline]
    pub fn solve(
        &mut self,
        kinematics: &Kinematics,
        state: &State,
        torques: [f64; 3],
        forces: &mut Forces,
    ) -> Result<(), NoForces> {
        let drive_torque = self.drive_torque(state, torques);
        forces.solve(
            (&self.robot, &self.carriers),
            &mut self.ground,
            kinematics,
            state,
            drive_torque,
        )
    }

    /// Motor torques less the losses of the gears, N m.
    pub(super) fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        let of_wheel = |i: usize| torques[i] - self.drive.loss_torque(state.omega[i]);
        [of_wheel(0), of_wheel(1), of_wheel(2)]
    }
}

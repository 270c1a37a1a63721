//! The robot with its drives on its ground: forces from a state and the motor torques.

use super::carriers::Carriers;
use super::forces::{Forces, NoForces};
use super::kinematics::{Kinematics, State};
use super::linkage::Linkage;
use crate::drive::Drive;
use crate::error::BelowGround;
use crate::ground::{AxleState, Ground, GroundForces, WheelMotion};
use crate::setup::PlantSetup;
use crate::truth::WheelTruth;
use robhaz_model::Robot;
use robhaz_terrain::Contact;

/// The equations of motion with all laws that act on the robot.
pub(crate) struct Mechanics {
    pub robot: Robot,
    pub drive: Drive,
    pub linkage: Linkage,
    carriers: Carriers,
    ground: Ground,
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
        let ground = &mut self.ground;
        let act =
            |i: usize, wheel: &WheelMotion, forces: &mut GroundForces| ground.act(i, wheel, forces);
        forces.solve(
            (&self.robot, &self.carriers),
            kinematics,
            state,
            drive_torque,
            act,
        )
    }

    /// See [`Ground::queries`].
    #[cfg(test)]
    pub fn terrain_queries(&self) -> u64 {
        self.ground.queries()
    }

    /// The contacts of a wheel (0 front, 1 middle, 2 rear) at the last [`Self::solve`].
    pub(super) fn contacts(&self, wheel: usize) -> &[Contact] {
        self.ground.contacts(wheel)
    }

    /// Forces of given contacts on a wheel.
    ///
    /// # Errors
    /// [`BelowGround`]
    pub(super) fn act_at(
        &self,
        contacts: &[Contact],
        wheel: &WheelMotion,
    ) -> Result<GroundForces, BelowGround> {
        let mut forces = GroundForces::default();
        self.ground.act_at(contacts, wheel, &mut forces)?;
        Ok(forces)
    }

    /// Motor torques less the losses of the gears, N m.
    pub(super) fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        let of_wheel = |i: usize| torques[i] - self.drive.loss_torque(state.omega[i]);
        [of_wheel(0), of_wheel(1), of_wheel(2)]
    }

    /// See [`Ground::write_truth`].
    ///
    /// # Errors
    /// [`NoForces::BelowGround`]
    pub fn write_wheel_truth(
        &self,
        wheel: usize,
        forces: &GroundForces,
        motion: &WheelMotion,
        axle: AxleState,
        truth: &mut WheelTruth,
    ) -> Result<(), NoForces> {
        self.ground
            .write_truth(wheel, forces, motion, axle, truth)
            .map_err(|source| NoForces::BelowGround { wheel, source })
    }
}

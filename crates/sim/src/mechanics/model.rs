//! The robot with its drives on its ground: forces from a state and the motor torques.

use super::forces::{Forces, NoForces};
use super::kinematics::{Kinematics, State};
use crate::drive::Drive;
use crate::ground::{AxleState, Ground, GroundForces, WheelMotion};
use crate::setup::PlantSetup;
use crate::truth::WheelTruth;
use robhaz_model::{Robot, Vec2};
use robhaz_terrain::Contact;

/// Contacts of the three wheels.
pub(crate) type Contacts = [Vec<Contact>; 3];

/// The equations of motion with all laws that act on the robot.
pub(crate) struct Mechanics {
    pub robot: Robot,
    pub drive: Drive,
    ground: Ground,
}

impl Mechanics {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            robot: setup.robot.clone(),
            drive: setup.drive.clone(),
            ground: Ground::new(setup),
        }
    }

    /// Accelerations and forces for given motor torques at the wheels, N m.
    ///
    /// # Errors
    /// [`NoForces`]
    pub fn forces(
        &mut self,
        kinematics: &Kinematics,
        state: &State,
        torques: [f64; 3],
    ) -> Result<Forces, NoForces> {
        let drive_torque = self.drive_torque(state, torques);
        let ground = &mut self.ground;
        Forces::new(&self.robot, kinematics, state, drive_torque, |_, wheel| {
            ground.act(wheel)
        })
    }

    /// As [`Self::forces`], with the contacts at given places of the ground.
    ///
    /// # Errors
    /// [`NoForces`]
    pub fn forces_at(
        &self,
        contacts: &Contacts,
        kinematics: &Kinematics,
        state: &State,
        torques: [f64; 3],
    ) -> Result<Forces, NoForces> {
        let drive_torque = self.drive_torque(state, torques);
        let act = |i: usize, wheel: &WheelMotion| self.ground.act_at(&contacts[i], wheel);
        Forces::new(&self.robot, kinematics, state, drive_torque, act)
    }

    /// The contacts of a wheel whose centre is at `centre` (m). `found` is cleared first.
    pub fn find_contacts(&self, centre: Vec2, found: &mut Vec<Contact>) {
        self.ground.find(centre, found);
    }

    /// Motor torques less the losses of the gears, N m.
    fn drive_torque(&self, state: &State, torques: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| torques[i] - self.drive.loss_torque(state.omega[i]))
    }

    /// See [`Ground::truth`].
    ///
    /// # Errors
    /// [`NoForces::BelowGround`]
    #[inline]
    pub fn wheel_truth(
        &mut self,
        wheel: usize,
        forces: GroundForces,
        motion: &WheelMotion,
        axle: AxleState,
    ) -> Result<WheelTruth, NoForces> {
        self.ground
            .truth(forces, motion, axle)
            .map_err(|source| NoForces::BelowGround { wheel, source })
    }
}

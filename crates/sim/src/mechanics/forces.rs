//! The equations of motion: accelerations and forces at one state.
//!
//! Virtual power gives `M v' = sum J' (f - m b)` for the four rates v, with the velocities `J v`
//! and biases b of [`super::kinematics`]. The wheel spins relative to the links follow from eq. (2)
//! and are eliminated from these equations. Pin forces follow from Newton's and Euler's equations
//! of single bars.

use super::kinematics::{Kinematics, State};
use super::mass_matrix::Factorised;
use super::model::Mechanics;
use crate::drive::wheel_acceleration;
use crate::error::NoTruth;
use crate::ground::GroundForces;
use nalgebra::{SMatrix, Vector3, Vector4};
use robhaz_model::{Bar, Robot, Vec2, cross};

/// Accelerations at one state, and the forces that belong to them.
#[derive(Clone, Default)]
pub(crate) struct Forces {
    /// Time derivatives of [`State::rates`], m/s^2 and rad/s^2.
    pub accelerations: Vector4<f64>,
    /// Time derivatives of [`State::omega`], rad/s^2.
    pub omega_rates: Vector3<f64>,
    /// Forces of the ground on each wheel.
    pub ground: [GroundForces; 3],
    /// Torque of the end stops on link 1, N m.
    pub stop_torque: f64,
    /// Factorised mass matrix of the four rates.
    mass_matrix: Option<Factorised>,
}

impl Forces {
    /// Solves the equations of motion for given motor torques at the wheels, N m.
    ///
    /// # Errors
    /// [`NoTruth`]
    #[inline]
    pub fn solve(
        &mut self,
        mechanics: &mut Mechanics,
        kinematics: &Kinematics,
        torques: [f64; 3],
    ) -> Result<(), NoTruth> {
        let state = &kinematics.state;
        let drive_torque = mechanics.drive_torque(state, torques);
        let (robot, ground) = (&mechanics.robot, &mut mechanics.ground);
        let mass = &robot.mass;
        let (m, mut right) = mechanics.carriers.without_ground(robot, kinematics);
        let (jw, jr) = (mass.wheel_inertia, mass.rotor_inertia);
        let share = jw / (jw + jr);
        for (i, drive) in drive_torque.into_iter().enumerate() {
            let motion = kinematics.wheel(i);
            let by_ground = &mut self.ground[i];
            ground.act(&motion, by_ground, |_, _| ())?;
            let axle = &kinematics.axles[i];
            axle.add_force(by_ground.force, &mut right);
            // Eq. (2), solved for the spin's acceleration and substituted in the link's equation,
            // adds an inertia (see `Carriers`), and the share J_w/(J_w + J_r) of the torques.
            right[axle.row()] += by_ground.torque + share * (drive - by_ground.torque);
        }
        self.stop_torque = stop_torque_at(robot, state);
        right[2] += self.stop_torque;
        right[3] -= self.stop_torque;
        let factorised = m.factorised().ok_or(NoTruth::NoStep)?;
        self.accelerations = factorised.solve(&right);
        self.mass_matrix = Some(factorised);
        for (i, drive) in drive_torque.into_iter().enumerate() {
            let alpha_link = self.accelerations[kinematics.axles[i].row()];
            self.omega_rates[i] =
                wheel_acceleration(drive, self.ground[i].torque, alpha_link, mass);
        }
        Ok(())
    }

    /// Accelerations under a change of the generalised forces (N, N m), m/s^2 and rad/s^2, at the
    /// state of [`Self::solve`].
    pub(super) fn response<const M: usize>(
        &self,
        loads: &SMatrix<f64, 4, M>,
    ) -> Option<SMatrix<f64, 4, M>> {
        self.mass_matrix.map(|m| m.solve_each(loads))
    }

    /// Forces in P, Q, R, S on the first bar of `Pin::bars`, N, from Newton's and Euler's equations
    /// of body and link 3, and Newton's of link 1.
    pub fn pin_forces(&self, robot: &Robot, kinematics: &Kinematics) -> [Vec2; 4] {
        let mass = &robot.mass;
        let a = &self.accelerations;
        let gravity = Vec2::new(0.0, -robot.gravity);
        // Sum of all forces on a mass but its weight.
        let needed = |m: f64, acceleration: Vec2| (acceleration - gravity) * m;
        let [p, r, s] = kinematics.pins;
        let (body, link3) = (&kinematics.body_cg, &kinematics.link3_cg);
        let on_body = needed(mass.body, body.acceleration(a));
        let on_link3 = needed(mass.links[2], link3.acceleration(a));
        // The moments about P (body) and about R (link 3) contain the force in S alone.
        let moment_body =
            mass.body_inertia * kinematics.body.acceleration(a) + cross(body.arm - p, on_body);
        let moment_link3 = mass.link_inertias[2] * kinematics.link3.acceleration(a)
            + cross(link3.arm - r, on_link3);
        // (S - P) x s = moment_body, (S - R) x (-s) = moment_link3.
        let (c, d) = (s - p, s - r);
        let force_s = (d * moment_body + c * moment_link3) / cross(c, d);
        let force_p = on_body - force_s;
        let force_r = on_link3 + force_s;
        let mut force_q = force_p + needed(mass.links[0], kinematics.link_cgs[0].acceleration(a));
        for (i, carrier) in robot.geometry.carriers.iter().enumerate() {
            if carrier.bar() == Bar::Link1 {
                force_q +=
                    needed(mass.wheel, kinematics.axles[i].acceleration(a)) - self.ground[i].force;
            }
        }
        [force_p, force_q, force_r, force_s]
    }
}

/// Torque of the end stops on link 1, N m.
pub(super) fn stop_torque_at(robot: &Robot, state: &State) -> f64 {
    let (stop, [a, b]) = (&robot.geometry.stop, state.angles);
    stop.torque(a - b, state.rates[2] - state.rates[3])
}

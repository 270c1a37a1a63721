//! Derivatives of the accelerations by positions, velocities and torques.
//!
//! With the right-hand side Q of the equations of motion `M a = Q`, `M da = dQ - dM a`. Two parts
//! of the change have very different sizes. The ground's forces change by 1e5 N/m and 1e4 N s/m
//! with the motion of a wheel's centre, whose derivatives are the columns of the kinematics. At
//! constant forces of the ground, the rest changes with the posture and its rates alone; four more
//! evaluations of the kinematics give it.

use super::forces::{Forces, stop_torque_at};
use super::kinematics::Kinematics;
use super::model::Mechanics;
use crate::error::NoTruth;
use crate::ground::{Ground, GroundForces, WheelMotion};
use nalgebra::{SMatrix, Vector3, Vector4};
use robhaz_model::{Vec2, perp};
use robhaz_terrain::Contact;

/// Steps of the difference quotients: 10 nm and 10 nrad of position (2 mN of N), 1 um/s and 1
/// urad/s of velocity.
const POSITION_STEP: f64 = 1e-8;
const VELOCITY_STEP: f64 = 1e-6;

/// Number of columns.
const COLUMNS: usize = 14;
/// First column of the rates, of the spins, of the torques.
const RATES: usize = 4;
const SPINS: usize = 8;
const TORQUES: usize = 11;

/// Derivatives of the accelerations at one state: rows for the four rates and the three spins;
/// columns for the four coordinates, their rates, the three spins, and the torques of the drives
/// less their losses.
#[derive(Default)]
pub(crate) struct Tangents {
    /// The derivatives.
    pub matrix: SMatrix<f64, 7, COLUMNS>,
    forces: Forces,
    moved: Kinematics,
    displaced: Vec<Contact>,
}

impl Tangents {
    /// Evaluates the derivatives at a state with its kinematics and the motor torques, N m.
    ///
    /// # Errors
    /// [`NoTruth`]
    pub fn evaluate(
        &mut self,
        mechanics: &mut Mechanics,
        kinematics: &Kinematics,
        torques: [f64; 3],
    ) -> Result<(), NoTruth> {
        (self.forces).solve(mechanics, kinematics, torques)?;
        let (mut loads, mut spins) = (SMatrix::<f64, 4, COLUMNS>::zeros(), SMatrix::zeros());
        for wheel in 0..3 {
            let sums = (&mut loads, &mut spins);
            self.add_wheel(mechanics, kinematics, wheel, sums)?;
        }
        self.add_posture(mechanics, kinematics, &mut loads)?;
        let accelerations = self.forces.response(&loads).ok_or(NoTruth::NoStep)?;
        let mass = &mechanics.robot.mass;
        let (jw, jr) = (mass.wheel_inertia, mass.rotor_inertia);
        self.matrix.fixed_rows_mut::<4>(0).copy_from(&accelerations);
        for (i, carrier) in mechanics.robot.geometry.carriers.iter().enumerate() {
            let link = accelerations.row(2 + carrier.index());
            let row = (spins.row(i) + link * jw) / (jw + jr);
            self.matrix.set_row(4 + i, &row);
        }
        Ok(())
    }

    /// Adds what a wheel's motion and torque change: generalised forces, and torques on the spins.
    fn add_wheel(
        &mut self,
        mechanics: &Mechanics,
        kinematics: &Kinematics,
        wheel: usize,
        (loads, spins): (&mut SMatrix<f64, 4, COLUMNS>, &mut SMatrix<f64, 3, COLUMNS>),
    ) -> Result<(), NoTruth> {
        let motion = kinematics.wheel(wheel);
        let slopes = slopes(&mechanics.ground, &mut self.displaced, &motion)?;
        let axle = &kinematics.axles[wheel];
        let mass = &mechanics.robot.mass;
        let share = mass.wheel_inertia / (mass.wheel_inertia + mass.rotor_inertia);
        let mut add = |column: usize, change: SMatrix<f64, 5, 1>| {
            let [x, y, torque] = (slopes * change).into();
            let mut right = Vector4::zeros();
            axle.add_force(Vec2::new(x, y), &mut right);
            right[axle.row()] += (1.0 - share) * torque;
            let mut sum = loads.column_mut(column);
            sum += right;
            spins[(wheel, column)] -= torque;
        };
        // By each coordinate that moves the wheel, the derivatives of position and velocity, and of
        // the spin by its rate: the absolute spin is that relative to the link less the link's rate.
        for (k, by, velocity, spin) in [
            (0, Vec2::x(), Vec2::zeros(), 0.0),
            (1, Vec2::y(), Vec2::zeros(), 0.0),
            (axle.row(), perp(axle.arm), -axle.arm * axle.rate, -1.0),
        ] {
            add(k, [by.x, by.y, velocity.x, velocity.y, 0.0].into());
            add(RATES + k, [0.0, 0.0, by.x, by.y, spin].into());
        }
        add(SPINS + wheel, [0.0, 0.0, 0.0, 0.0, 1.0].into());
        loads[(axle.row(), TORQUES + wheel)] += share;
        spins[(wheel, TORQUES + wheel)] += 1.0;
        Ok(())
    }

    /// Adds what the posture and its rates change at constant forces of the ground and constant
    /// accelerations.
    fn add_posture(
        &mut self,
        mechanics: &Mechanics,
        kinematics: &Kinematics,
        loads: &mut SMatrix<f64, 4, COLUMNS>,
    ) -> Result<(), NoTruth> {
        let here = self.residual(mechanics, kinematics);
        for link in 0..2 {
            for (column, step) in [(2 + link, POSITION_STEP), (RATES + 2 + link, VELOCITY_STEP)] {
                let mut there = kinematics.state;
                if column < RATES {
                    there.angles[link] += step;
                } else {
                    there.rates[2 + link] += step;
                }
                let mut moved = std::mem::take(&mut self.moved);
                moved.set(&mechanics.linkage, &there)?;
                let residual = self.residual(mechanics, &moved);
                let mut sum = loads.column_mut(column);
                sum += (residual - here) / step;
                self.moved = moved;
            }
        }
        Ok(())
    }

    /// Generalised forces of weight, inertia, ground and stops, without the constant ones, at
    /// [`Self::forces`].
    fn residual(&self, mechanics: &Mechanics, kinematics: &Kinematics) -> Vector4<f64> {
        let (robot, a) = (&mechanics.robot, &self.forces.accelerations);
        let weight = Vec2::new(0.0, -robot.gravity);
        let mut right = Vector4::zeros();
        for (bar, cg, turning) in kinematics.free_bars() {
            let (mass, inertia) = robot.mass.of(bar);
            cg.add_force((weight - cg.acceleration(a)) * mass, &mut right);
            turning.add_torque(-inertia * turning.acceleration(a), &mut right);
        }
        // Inertia times the acceleration of its own angle does not change.
        for (cg, mass) in kinematics.link_cgs.iter().zip(robot.mass.links) {
            cg.add_force((weight - cg.acceleration(a)) * mass, &mut right);
        }
        for (axle, ground) in kinematics.axles.iter().zip(&self.forces.ground) {
            let inertia = (weight - axle.acceleration(a)) * robot.mass.wheel;
            axle.add_force(inertia + ground.force, &mut right);
        }
        let stop = stop_torque_at(robot, &kinematics.state);
        right[2] += stop;
        right[3] -= stop;
        right
    }
}

/// Derivatives of force (N) and torque (N m) of the ground on a wheel by its centre (m), velocity
/// (m/s) and absolute spin (rad/s). The contacts follow the centre to first order.
fn slopes(
    ground: &Ground,
    displaced: &mut Vec<Contact>,
    motion: &WheelMotion,
) -> Result<SMatrix<f64, 3, 5>, NoTruth> {
    let contacts = &ground.found[motion.wheel];
    let at = |contacts: &[Contact], motion: &WheelMotion| {
        let mut sum = GroundForces::default();
        ground.sum(contacts, motion, &mut sum, |_, _| ())?;
        Ok(Vector3::new(sum.force.x, sum.force.y, sum.torque))
    };
    let here = at(contacts, motion)?;
    let mut slopes = SMatrix::<f64, 3, 5>::zeros();
    for (k, axis) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
        let by = axis * POSITION_STEP;
        displaced.clear();
        displaced.extend(contacts.iter().map(|contact| contact.displaced(by)));
        let there = WheelMotion {
            centre: motion.centre + by,
            ..*motion
        };
        let there = at(displaced, &there)?;
        slopes.set_column(k, &((there - here) / POSITION_STEP));
        let there = WheelMotion {
            velocity: motion.velocity + axis * VELOCITY_STEP,
            ..*motion
        };
        slopes.set_column(2 + k, &((at(contacts, &there)? - here) / VELOCITY_STEP));
    }
    let there = WheelMotion {
        spin: motion.spin + VELOCITY_STEP,
        ..*motion
    };
    slopes.set_column(4, &((at(contacts, &there)? - here) / VELOCITY_STEP));
    Ok(slopes)
}

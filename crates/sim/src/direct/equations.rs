//! The equations of motion as the solver wants them: `dy/dt = f(t, y)`, and their Jacobian.

use super::mechanism::{Forces, Kinematics, NoForces, State};
use crate::drive::Drive;
use crate::ground::{Ground, GroundForces, WheelMotion};
use crate::plant::PlantSetup;
use crate::start::Start;
use differential_equations::linalg::Matrix;
use differential_equations::ode::ODE;
use nalgebra::Vector4;
use robhaz_model::{Robot, Vec2};
use std::cell::{Cell, RefCell};

/// Solver state: Q (m), angles of links 1 and 2 (rad), velocity of Q (m/s), rates of links 1 and 2 (rad/s), wheel spin
/// speeds (rad/s), integrals of the speed errors (rad). Wheel spins are left out: nothing depends on them.
pub(super) type Y = [f64; SIZE];
pub(super) const SIZE: usize = 14;
const RATES: usize = 4;
pub(super) const OMEGA: usize = 8;
const INTEGRAL: usize = 11;

pub(crate) struct Equations {
    pub robot: Robot,
    drive: Drive,
    ground: RefCell<Ground>,
    refusal: Cell<Option<NoForces>>,
}

/// The solver's state at time zero.
pub(super) fn start(start: &Start) -> Y {
    let state = &start.state;
    let mut y = [0.0; SIZE];
    y[..RATES].copy_from_slice(&[state.q.x, state.q.y, state.angles[0], state.angles[1]]);
    y[RATES..OMEGA].copy_from_slice(state.rates.as_slice());
    y[OMEGA..INTEGRAL].copy_from_slice(&state.omega);
    y[INTEGRAL..].copy_from_slice(&start.integrals);
    y
}

pub(super) fn state(y: &Y) -> State {
    State {
        q: Vec2::new(y[0], y[1]),
        angles: [y[2], y[3]],
        rates: Vector4::from_column_slice(&y[RATES..OMEGA]),
        omega: [y[OMEGA], y[OMEGA + 1], y[OMEGA + 2]],
    }
}

impl Equations {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            robot: setup.robot.clone(),
            drive: setup.drive,
            ground: RefCell::new(Ground::new(setup)),
            refusal: Cell::new(None),
        }
    }

    /// What the last evaluation that failed complained of.
    pub fn last_refusal(&self) -> Option<NoForces> {
        self.refusal.get()
    }

    /// Forgets what earlier trials complained of: a step has been taken.
    pub fn clear_refusal(&self) {
        self.refusal.set(None);
    }

    /// Motor torques at the wheels, N m.
    pub fn motor_torques(&self, t: f64, y: &Y) -> [f64; 3] {
        let set_speed = self.drive.set_speed(t, self.robot.geometry.wheel_radius);
        [0, 1, 2].map(|i| self.drive.torque(set_speed - y[OMEGA + i], y[INTEGRAL + i]))
    }

    /// Accelerations and forces for given motor torques, N m.
    pub fn forces(
        &self,
        kinematics: &Kinematics,
        state: &State,
        torques: [f64; 3],
    ) -> Result<Forces, NoForces> {
        let drive_torque =
            [0, 1, 2].map(|i| torques[i] - self.drive.viscous_damping * state.omega[i]);
        let mut ground = self.ground.borrow_mut();
        Forces::new(&self.robot, &mut ground, kinematics, state, drive_torque)
    }

    /// For the record only: of a wheel in the air, the gap to the nearest ground.
    pub fn or_gap(
        &self,
        wheel: usize,
        forces: GroundForces,
        kinematics: &Kinematics,
        state: &State,
    ) -> Result<GroundForces, NoForces> {
        let link_rate = state.rates[2 + self.robot.geometry.carriers[wheel].index()];
        let motion = WheelMotion {
            centre: kinematics.axle(wheel, state),
            velocity: kinematics.axle_velocity(wheel, state),
            spin: state.omega[wheel] - link_rate,
        };
        let ground = self.ground.borrow();
        ground
            .or_gap(forces, &motion)
            .map_err(|x| NoForces::BelowGround(wheel, x))
    }

    fn rates(&self, t: f64, y: &Y) -> Result<Y, NoForces> {
        let state = state(y);
        let kinematics = Kinematics::new(&self.robot, &state)?;
        let forces = self.forces(&kinematics, &state, self.motor_torques(t, y))?;
        let set_speed = self.drive.set_speed(t, self.robot.geometry.wheel_radius);
        let mut rates = [0.0; SIZE];
        rates[..RATES].copy_from_slice(&y[RATES..OMEGA]);
        rates[RATES..OMEGA].copy_from_slice(forces.accelerations.as_slice());
        for i in 0..3 {
            rates[OMEGA + i] = forces.omega_rates[i];
            rates[INTEGRAL + i] = self
                .drive
                .integral_rate(set_speed - y[OMEGA + i], y[INTEGRAL + i]);
        }
        Ok(rates)
    }
}

/// Steps of the difference quotients: 10 nm and 10 nrad of position (2 mN of N), 1 um/s and 1 urad/s of velocity.
const POSITION_STEP: f64 = 1e-8;
const VELOCITY_STEP: f64 = 1e-6;

impl ODE<f64, Y> for Equations {
    /// A state without forces gives NaN: the solver rejects the step and tries a shorter one.
    fn diff(&self, t: f64, y: &Y, dydt: &mut Y) {
        *dydt = self.rates(t, y).unwrap_or_else(|why| {
            self.refusal.set(Some(why));
            [f64::NAN; SIZE]
        });
    }

    fn jacobian(&self, t: f64, y: &Y, j: &mut Matrix<f64>) {
        let (mut here, mut there) = ([0.0; SIZE], [0.0; SIZE]);
        self.diff(t, y, &mut here);
        for column in 0..SIZE {
            let step = if column < RATES {
                POSITION_STEP
            } else {
                VELOCITY_STEP
            };
            let mut moved = *y;
            moved[column] += step;
            self.diff(t, &moved, &mut there);
            for row in 0..SIZE {
                j[(row, column)] = (there[row] - here[row]) / step;
            }
        }
    }
}

//! The equations of motion in the form of the solver: `dy/dt = f(t, y)`, with Jacobian and integrals.

use super::radau::Model;
use crate::balance::{Balance, WheelLoad};
use crate::drive::DriveResponse;
use crate::mechanics::{Contacts, Forces, Kinematics, Mechanics, NoForces, State};
use crate::setup::PlantSetup;
use crate::start::Start;
use nalgebra::{SMatrix, SVector};
use robhaz_model::{Vec2, WheelCommand};

/// Number of equations.
pub(super) const SIZE: usize = 14;
/// Solver state: Q (m), angles of links 1 and 2 (rad), velocity of Q (m/s), rates of links 1 and 2 (rad/s), wheel spin
/// speeds (rad/s), integrals of the speed errors (rad).
pub(super) type Y = SVector<f64, SIZE>;
/// Number of integrals: quantities that are integrated with the motion but do not influence it.
pub(super) const INTEGRALS: usize = 13;
/// Wheel spins relative to the links (rad), work of the motors (J). Then the rest of [`Balance`], if it is asked for:
/// impulses of the ground on the wheels (N s), loss in the gears, work of the ground, work of the stops (J).
pub(super) type Integrals = SVector<f64, INTEGRALS>;
const WORK: usize = 3;
const IMPULSE: usize = 4;
const GEAR: usize = 10;
const GROUND: usize = 11;
const STOP: usize = 12;
const RATES: usize = 4;
const OMEGA: usize = 8;
const INTEGRAL: usize = 11;

/// Longest step, s.
const LONGEST_STEP: f64 = 0.1;
/// Longest distance that the robot travels in a step, m: a fifth of a wheel's radius, so that a step cannot skip an
/// edge.
const LONGEST_WAY: f64 = 0.02;

/// A change of set speeds or commands that is nearer than this does not limit a step, s: it has been reached, to
/// rounding.
const SHORTEST_TO_CHANGE: f64 = 1e-9;

/// The equations of motion of a run.
pub(super) struct Equations {
    pub mechanics: Mechanics,
    /// Commands of the wheels.
    pub commands: [WheelCommand; 3],
    /// Time at which the commands may change next, s: no step goes beyond it. Infinite for commands that are held.
    pub next_command: f64,
    /// Whether all of [`Balance`] is integrated.
    balance: bool,
    /// Contacts at the state of the last Jacobian.
    contacts: Contacts,
    /// See [`Self::last_refusal`].
    refusal: Option<NoForces>,
}

/// The solver's state at time zero.
pub(super) fn start(start: &Start) -> Y {
    let state = &start.state;
    let mut y = Y::zeros();
    y.fixed_rows_mut::<4>(0).copy_from_slice(&[
        state.q.x,
        state.q.y,
        state.angles[0],
        state.angles[1],
    ]);
    y.fixed_rows_mut::<4>(RATES).copy_from(&state.rates);
    y.fixed_rows_mut::<3>(OMEGA).copy_from_slice(&state.omega);
    y.fixed_rows_mut::<3>(INTEGRAL)
        .copy_from_slice(&start.integrals);
    y
}

/// Coordinates and rates in the solver's state.
pub(super) fn state(y: &Y) -> State {
    State {
        q: Vec2::new(y[0], y[1]),
        angles: [y[2], y[3]],
        rates: y.fixed_rows::<4>(RATES).into_owned(),
        omega: [y[OMEGA], y[OMEGA + 1], y[OMEGA + 2]],
    }
}

/// Impulse and work among the integrals.
pub(super) fn balance(integrals: &Integrals) -> Balance {
    let impulse = |i: usize| Vec2::new(integrals[IMPULSE + 2 * i], integrals[IMPULSE + 2 * i + 1]);
    Balance {
        impulse: [impulse(0), impulse(1), impulse(2)],
        motor_work: integrals[WORK],
        gear_loss: integrals[GEAR],
        ground_work: integrals[GROUND],
        stop_work: integrals[STOP],
    }
}

impl Equations {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            mechanics: Mechanics::new(setup),
            commands: Default::default(),
            next_command: f64::INFINITY,
            balance: setup.balance,
            contacts: Default::default(),
            refusal: None,
        }
    }

    /// Reason of the last evaluation that failed.
    pub fn last_refusal(&self) -> Option<NoForces> {
        self.refusal
    }

    /// Forgets the failures of earlier trials, after a step has succeeded.
    pub fn clear_refusal(&mut self) {
        self.refusal = None;
    }

    /// Motor torques at the wheels, N m.
    pub fn motor_torques(&self, t: f64, y: &Y) -> [f64; 3] {
        self.drives(t, y).map(|drive| drive.torque)
    }

    /// What the drives of the wheels do.
    fn drives(&self, t: f64, y: &Y) -> [DriveResponse; 3] {
        let mechanics = &self.mechanics;
        let radius = mechanics.robot.geometry.wheel_radius;
        [0, 1, 2].map(|i| {
            let planned = mechanics.drive.set_speed(i, t, radius);
            let (omega, integral) = (y[OMEGA + i], y[INTEGRAL + i]);
            let command = self.commands[i];
            mechanics.drive.response(command, planned, omega, integral)
        })
    }

    /// The rates dy/dt.
    fn try_rates(&mut self, t: f64, y: &Y) -> Result<Y, NoForces> {
        let state = state(y);
        let torques = self.motor_torques(t, y);
        let kinematics = Kinematics::new(&self.mechanics.robot, &state)?;
        let forces = self.mechanics.forces(&kinematics, &state, torques)?;
        Ok(self.assembled(t, y, &forces))
    }

    /// The rates dy/dt with the contacts at [`Self::contacts`].
    fn try_rates_at_contacts(&self, t: f64, y: &Y) -> Result<Y, NoForces> {
        let state = state(y);
        let torques = self.motor_torques(t, y);
        let kinematics = Kinematics::new(&self.mechanics.robot, &state)?;
        let forces = self
            .mechanics
            .forces_at(&self.contacts, &kinematics, &state, torques)?;
        Ok(self.assembled(t, y, &forces))
    }

    /// The rates dy/dt from the accelerations.
    fn assembled(&self, t: f64, y: &Y, forces: &Forces) -> Y {
        let drives = self.drives(t, y);
        let mut rates = Y::zeros();
        rates
            .fixed_rows_mut::<4>(0)
            .copy_from(&y.fixed_rows::<4>(RATES));
        rates
            .fixed_rows_mut::<4>(RATES)
            .copy_from(&forces.accelerations);
        rates
            .fixed_rows_mut::<3>(OMEGA)
            .copy_from(&forces.omega_rates);
        for i in 0..3 {
            rates[INTEGRAL + i] = drives[i].integral_rate;
        }
        rates
    }

    /// Rates of [`Balance`], without the work of the motors.
    fn balance_rates(&mut self, t: f64, y: &Y) -> Result<Balance, NoForces> {
        let state = state(y);
        let torques = self.motor_torques(t, y);
        let mechanics = &mut self.mechanics;
        let kinematics = Kinematics::new(&mechanics.robot, &state)?;
        let forces = mechanics.forces(&kinematics, &state, torques)?;
        let mut rates = Balance {
            stop_work: forces.stop_torque * (state.rates[2] - state.rates[3]),
            ..Balance::default()
        };
        for (i, ground) in forces.ground.iter().enumerate() {
            let omega = state.omega[i];
            let load = WheelLoad::new(ground, mechanics.drive.loss_torque(omega));
            let motion = kinematics.wheel(&mechanics.robot, i, &state);
            rates.add_wheel(i, &load, &motion, omega, 1.0);
        }
        Ok(rates)
    }

    /// The Jacobian by difference quotients; `here` are the rates at `y`.
    fn try_jacobian(
        &mut self,
        t: f64,
        y: &Y,
        here: &Y,
    ) -> Result<SMatrix<f64, SIZE, SIZE>, NoForces> {
        let state = state(y);
        let kinematics = Kinematics::new(&self.mechanics.robot, &state)?;
        for (i, contacts) in self.contacts.iter_mut().enumerate() {
            let centre = kinematics.axle(i, &state);
            self.mechanics.find_contacts(centre, contacts);
        }
        let mut jacobian = SMatrix::<f64, SIZE, SIZE>::zeros();
        for column in 0..SIZE {
            let mut moved = *y;
            let (step, there) = if column < RATES {
                moved[column] += POSITION_STEP;
                (POSITION_STEP, self.try_rates(t, &moved)?)
            } else {
                // The contacts do not depend on the velocities.
                moved[column] += VELOCITY_STEP;
                (VELOCITY_STEP, self.try_rates_at_contacts(t, &moved)?)
            };
            jacobian.set_column(column, &((there - here) / step));
        }
        Ok(jacobian)
    }
}

/// Steps of the difference quotients: 10 nm and 10 nrad of position (2 mN of N), 1 um/s and 1 urad/s of velocity.
const POSITION_STEP: f64 = 1e-8;
const VELOCITY_STEP: f64 = 1e-6;

impl Model<SIZE, INTEGRALS> for Equations {
    fn rates(&mut self, t: f64, y: &Y) -> Option<Y> {
        let rates = self.try_rates(t, y);
        self.refusal = rates.err().or(self.refusal);
        rates.ok()
    }

    fn jacobian(&mut self, t: f64, y: &Y, rates: &Y) -> Option<SMatrix<f64, SIZE, SIZE>> {
        let jacobian = self.try_jacobian(t, y, rates);
        self.refusal = jacobian.err().or(self.refusal);
        jacobian.ok()
    }

    fn integrands(&mut self, t: f64, y: &Y) -> Integrals {
        let omega = [y[OMEGA], y[OMEGA + 1], y[OMEGA + 2]];
        let torques = self.motor_torques(t, y);
        let power = torques
            .iter()
            .zip(omega)
            .map(|(torque, omega)| torque * omega)
            .sum();
        let mut rates = Integrals::zeros();
        rates.fixed_rows_mut::<3>(0).copy_from_slice(&omega);
        rates[WORK] = power;
        if self.balance {
            match self.balance_rates(t, y) {
                Ok(balance) => {
                    for (i, impulse) in balance.impulse.iter().enumerate() {
                        rates
                            .fixed_rows_mut::<2>(IMPULSE + 2 * i)
                            .copy_from(impulse);
                    }
                    rates[GEAR] = balance.gear_loss;
                    rates[GROUND] = balance.ground_work;
                    rates[STOP] = balance.stop_work;
                }
                // The motion itself is valid, so the step counts; its balance is unknown.
                Err(_) => rates.fixed_rows_mut::<9>(IMPULSE).fill(f64::NAN),
            }
        }
        rates
    }

    fn longest_step(&self, t: f64, y: &Y) -> f64 {
        let speed = y[RATES].hypot(y[RATES + 1]);
        let longest = LONGEST_STEP.min(LONGEST_WAY / speed.max(1e-9));
        let to_command = self.next_command - t;
        let longest = if to_command > SHORTEST_TO_CHANGE {
            longest.min(to_command)
        } else {
            longest
        };
        // A step does not skip a change of the set speeds.
        let change = self.mechanics.drive.next_change(t + SHORTEST_TO_CHANGE);
        change.map_or(longest, |change| longest.min(change - t))
    }
}

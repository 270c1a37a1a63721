//! The equations of motion in the form of the solver: `dy/dt = f(t, y)`, with Jacobian and
//! integrals.

use super::jumps::Jumps;
use super::layout::{INTEGRAL, OMEGA, RATES, SIZE, Y, state};
use super::problem::Model;
use super::system::{Factors, Jacobian};
use crate::balance::{Balance, WheelLoad};
use crate::drive::DriveResponse;
use crate::mechanics::{Forces, Kinematics, Mechanics, NoForces, State, Tangents};
use crate::setup::PlantSetup;
use nalgebra::SVector;
use robhaz_model::{Vec2, WheelCommand};

/// Number of integrals: quantities that are integrated with the motion but do not influence it.
pub(super) const INTEGRALS: usize = 13;
/// Wheel spins relative to the links (rad), work of the motors (J). Then the rest of [`Balance`],
/// if it is asked for: impulses of the ground on the wheels (N s), loss in the gears, work of the
/// ground, work of the stops (J).
pub(super) type Integrals = SVector<f64, INTEGRALS>;
const WORK: usize = 3;
const IMPULSE: usize = 4;
const GEAR: usize = 10;
const GROUND: usize = 11;
const STOP: usize = 12;
/// Longest step, s.
const LONGEST_STEP: f64 = 0.1;
/// Longest distance that the robot travels in a step, m: a fifth of a wheel's radius, so that a
/// step cannot skip an edge.
const LONGEST_WAY: f64 = 0.02;

/// A change of set speeds or commands that is nearer than this does not limit a step, s: it has
/// been reached, to rounding.
const SHORTEST_TO_CHANGE: f64 = 1e-9;

/// First step after a jump on the ground, s: less than the time constant of a bare wheel on the
/// contact's damping (75 us).
const STEP_AFTER_JUMP: f64 = 5e-5;

/// The equations of motion of a run.
pub(super) struct Equations {
    pub mechanics: Mechanics,
    /// Commands of the wheels.
    pub commands: [WheelCommand; 3],
    /// Time at which the commands may change next, s: no step goes beyond it. Infinite for commands
    /// that are held.
    pub next_command: f64,
    jumps: Jumps,
    /// Time at which the step ends at one of [`Self::jumps`], s; infinite if it does not.
    jump_at: f64,
    /// Whether all of [`Balance`] is integrated.
    balance: bool,
    /// At the state of the last evaluation.
    pub kinematics: Kinematics,
    /// At the state of the last evaluation.
    pub forces: Forces,
    tangents: Tangents,
    /// See [`Self::last_refusal`].
    refusal: Option<NoForces>,
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
            jumps: Jumps::new(setup),
            jump_at: f64::INFINITY,
            balance: setup.balance,
            kinematics: Kinematics::default(),
            forces: Forces::default(),
            tangents: Tangents::default(),
            refusal: None,
        }
    }

    /// Reason of the last evaluation that failed.
    pub fn last_refusal(&self) -> Option<NoForces> {
        self.refusal
    }

    /// Clears the failures of earlier trials, after a step has succeeded.
    pub fn clear_refusal(&mut self) {
        self.refusal = None;
    }

    /// Motor torques at the wheels, N m.
    pub fn motor_torques(&self, t: f64, y: &Y) -> [f64; 3] {
        self.drives(t, y).map(|drive| drive.torque)
    }

    /// Set speed of all wheels without scalings, rad/s.
    fn start_speed(&self, t: f64) -> f64 {
        let radius = self.mechanics.robot.geometry.wheel_radius;
        self.mechanics.drive.start_speed(t, radius)
    }

    /// What the drives of the wheels do.
    fn drives(&self, t: f64, y: &Y) -> [DriveResponse; 3] {
        let start = self.start_speed(t);
        let drive = |wheel: usize| self.drive(wheel, start, t, y);
        [drive(0), drive(1), drive(2)]
    }

    /// What the drive of a wheel does; `start` is that of [`Self::start_speed`].
    #[inline(always)]
    fn drive(&self, wheel: usize, start: f64, t: f64, y: &Y) -> DriveResponse {
        let drive = &self.mechanics.drive;
        let planned = start * drive.factor(wheel, t);
        let (omega, integral) = (y[OMEGA + wheel], y[INTEGRAL + wheel]);
        drive.response(self.commands[wheel], planned, omega, integral)
    }

    /// Evaluates [`Self::kinematics`] and [`Self::forces`] at a state with these motor torques (N
    /// m).
    #[inline]
    pub fn evaluate(&mut self, state: &State, torques: [f64; 3]) -> Result<(), NoForces> {
        self.kinematics.set(&self.mechanics.linkage, state)?;
        self.mechanics
            .solve(&self.kinematics, state, torques, &mut self.forces)
    }

    /// The rates dy/dt.
    fn try_rates(&mut self, t: f64, y: &Y) -> Result<Y, NoForces> {
        let drives = self.drives(t, y);
        self.evaluate(&state(y), drives.map(|drive| drive.torque))?;
        let mut rates = Y::zeros();
        rates
            .fixed_rows_mut::<4>(0)
            .copy_from(&y.fixed_rows::<4>(RATES));
        rates
            .fixed_rows_mut::<4>(RATES)
            .copy_from(&self.forces.accelerations);
        rates
            .fixed_rows_mut::<3>(OMEGA)
            .copy_from(&self.forces.omega_rates);
        for (i, drive) in drives.iter().enumerate() {
            rates[INTEGRAL + i] = drive.integral_rate;
        }
        Ok(rates)
    }

    /// Rates of [`Balance`], without the work of the motors.
    fn balance_rates(&mut self, t: f64, y: &Y) -> Result<Balance, NoForces> {
        let state = state(y);
        let torques = self.motor_torques(t, y);
        self.evaluate(&state, torques)?;
        let (mechanics, kinematics, forces) = (&self.mechanics, &self.kinematics, &self.forces);
        let mut rates = Balance {
            stop_work: forces.stop_torque * (state.rates[2] - state.rates[3]),
            ..Balance::default()
        };
        for (i, ground) in forces.ground.iter().enumerate() {
            let omega = state.omega[i];
            let load = WheelLoad::new(ground, mechanics.drive.loss_torque(omega));
            let motion = kinematics.wheel(i, &state);
            rates.add_wheel(i, &load, &motion, omega, 1.0);
        }
        Ok(rates)
    }

    /// The Jacobian: that of the mechanics, with the drives by difference quotients.
    fn try_jacobian(&mut self, t: f64, y: &Y) -> Result<Jacobian, NoForces> {
        let state = state(y);
        let here = self.drives(t, y);
        self.kinematics.set(&self.mechanics.linkage, &state)?;
        let torques = here.map(|drive| drive.torque);
        self.tangents
            .evaluate(&mut self.mechanics, &self.kinematics, &state, torques)?;
        let matrix = &self.tangents.matrix;
        let mut jacobian = Jacobian {
            by_position: matrix.fixed_columns::<4>(0).into_owned(),
            by_velocity: matrix.fixed_columns::<7>(4).into_owned(),
            by_integral: Default::default(),
            integrals: Default::default(),
        };
        let mut moved = *y;
        for i in 0..3 {
            moved[OMEGA + i] += DRIVE_STEP;
        }
        let by_speed = self.drives(t, &moved);
        moved = *y;
        for i in 0..3 {
            moved[INTEGRAL + i] += DRIVE_STEP;
        }
        let by_integral = self.drives(t, &moved);
        for i in 0..3 {
            let torque =
                |there: &[DriveResponse; 3]| (there[i].torque - here[i].torque) / DRIVE_STEP;
            let rate = |there: &[DriveResponse; 3]| {
                (there[i].integral_rate - here[i].integral_rate) / DRIVE_STEP
            };
            let loss = |omega: f64| self.mechanics.drive.loss_torque(omega);
            let omega = state.omega[i];
            let loss = (loss(omega + DRIVE_STEP) - loss(omega)) / DRIVE_STEP;
            let response = matrix.column(11 + i);
            let mut column = jacobian.by_velocity.column_mut(4 + i);
            column += response * (torque(&by_speed) - loss);
            jacobian
                .by_integral
                .set_column(i, &(response * torque(&by_integral)));
            jacobian.integrals[i] = [rate(&by_speed), rate(&by_integral)];
        }
        Ok(jacobian)
    }
}

/// Step of the difference quotients of the drives, rad/s and rad.
const DRIVE_STEP: f64 = 1e-6;

impl Model<SIZE, INTEGRALS> for Equations {
    type System = Factors;

    fn rates(&mut self, t: f64, y: &Y) -> Option<Y> {
        let rates = self.try_rates(t, y);
        self.refusal = rates.err().or(self.refusal);
        rates.ok()
    }

    fn jacobian(&mut self, t: f64, y: &Y, _: &Y) -> Option<Jacobian> {
        let jacobian = self.try_jacobian(t, y);
        self.refusal = jacobian.as_ref().err().copied().or(self.refusal);
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

    fn longest_step(&mut self, t: f64, y: &Y, rates: &Y) -> f64 {
        if t >= self.jump_at {
            self.jump_at = f64::INFINITY;
            return STEP_AFTER_JUMP;
        }
        self.jump_at = f64::INFINITY;
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
        let longest = change.map_or(longest, |change| longest.min(change - t));
        if self.jumps.is_empty() {
            return longest;
        }
        let state = state(y);
        let robot = &self.mechanics.robot;
        if self
            .kinematics
            .set(&self.mechanics.linkage, &state)
            .is_err()
        {
            return longest;
        }
        let accelerations = rates.fixed_rows::<4>(RATES).into_owned();
        let motion = (&state, &accelerations);
        let next = self.jumps.next(robot, &self.kinematics, motion, longest);
        if next.arrives {
            self.jump_at = t + next.longest;
        }
        next.longest
    }
}

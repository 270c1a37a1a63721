//! The equations of motion in the form of the solver: `dy/dt = f(t, y)`, with Jacobian and
//! integrals.

use super::jumps::Jumps;
use super::radau::Model;
use super::system::{Factors, INTEGRAL, Jacobian, OMEGA, RATES, SIZE, Y, joined, state};
use crate::drive::DriveResponse;
use crate::engine::{Balance, WheelLoad};
use crate::error::NoTruth;
use crate::mechanics::{Forces, Kinematics, Mechanics, State, Tangents};
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
    /// Reason of the last evaluation that failed.
    pub refusal: Option<NoTruth>,
}

/// Impulse and work among the integrals.
pub(super) fn balance(integrals: &Integrals) -> Balance {
    let impulse = |i: usize| Vec2::new(integrals[IMPULSE + 2 * i], integrals[IMPULSE + 2 * i + 1]);
    // Behind the two components of three impulses.
    let [gear_loss, ground_work, stop_work] = [6, 7, 8].map(|i| integrals[IMPULSE + i]);
    Balance {
        impulse: [0, 1, 2].map(impulse),
        motor_work: integrals[WORK],
        gear_loss,
        ground_work,
        stop_work,
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

    /// Motor torques at the wheels, N m.
    pub fn motor_torques(&self, t: f64, y: &Y) -> [f64; 3] {
        self.drives(t, y).map(|drive| drive.torque)
    }

    /// What the drives of the wheels do.
    fn drives(&self, t: f64, y: &Y) -> [DriveResponse; 3] {
        let Mechanics { drive, robot, .. } = &self.mechanics;
        let start = drive.start_speed(t, robot.geometry.wheel_radius);
        [0, 1, 2].map(|wheel| {
            let planned = start * drive.factor(wheel, t);
            let (omega, integral) = (y[OMEGA + wheel], y[INTEGRAL + wheel]);
            drive.response(self.commands[wheel], planned, omega, integral)
        })
    }

    /// Evaluates [`Self::kinematics`] and [`Self::forces`] at a state with these motor torques (N
    /// m).
    #[inline]
    pub fn evaluate(&mut self, state: &State, torques: [f64; 3]) -> Result<(), NoTruth> {
        self.kinematics.set(&self.mechanics.linkage, state)?;
        (self.forces).solve(&mut self.mechanics, &self.kinematics, torques)
    }

    /// The rates dy/dt.
    fn try_rates(&mut self, t: f64, y: &Y) -> Result<Y, NoTruth> {
        let drives = self.drives(t, y);
        self.evaluate(&state(y), drives.map(|drive| drive.torque))?;
        let (a, spins) = (self.forces.accelerations, self.forces.omega_rates);
        let integrals = drives.map(|drive| drive.integral_rate);
        let velocities = y.fixed_rows::<4>(RATES).into_owned();
        Ok(joined(velocities, a, spins.into(), integrals))
    }

    /// Rates of [`Balance`] without the work of the motors, as the integrals from [`IMPULSE`] on.
    fn balance_rates(&mut self, t: f64, y: &Y) -> Result<[f64; 9], NoTruth> {
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
            let motion = kinematics.wheel(i);
            rates.add_wheel(&load, &motion, omega, 1.0);
        }
        let [a, b, c] = rates.impulse;
        let [gear, ground, stop] = [rates.gear_loss, rates.ground_work, rates.stop_work];
        Ok([a.x, a.y, b.x, b.y, c.x, c.y, gear, ground, stop])
    }

    /// The Jacobian: that of the mechanics, with the drives by difference quotients.
    fn try_jacobian(&mut self, t: f64, y: &Y) -> Result<Jacobian, NoTruth> {
        let state = state(y);
        let here = self.drives(t, y);
        self.kinematics.set(&self.mechanics.linkage, &state)?;
        let torques = here.map(|drive| drive.torque);
        (self.tangents).evaluate(&mut self.mechanics, &self.kinematics, torques)?;
        let matrix = &self.tangents.matrix;
        let mut jacobian = Jacobian {
            by_position: matrix.fixed_columns::<4>(0).into_owned(),
            by_velocity: matrix.fixed_columns::<7>(4).into_owned(),
            by_integral: Default::default(),
            integrals: Default::default(),
        };
        let [by_speed, by_integral] = [OMEGA, INTEGRAL].map(|first| {
            let mut moved = *y;
            for i in 0..3 {
                moved[first + i] += DRIVE_STEP;
            }
            self.drives(t, &moved)
        });
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
            let of_integral = response * torque(&by_integral);
            jacobian.by_integral.set_column(i, &of_integral);
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
        let mut rates = Integrals::zeros();
        rates.fixed_rows_mut::<3>(0).copy_from_slice(&omega);
        rates[WORK] = torques.iter().zip(omega).map(|(t, omega)| t * omega).sum();
        if self.balance {
            // The motion itself is valid, so the step counts; its balance is unknown.
            let balance = self.balance_rates(t, y).unwrap_or([f64::NAN; 9]);
            let mut from_impulse = rates.fixed_rows_mut::<9>(IMPULSE);
            from_impulse.copy_from_slice(&balance);
        }
        rates
    }

    fn longest_step(&mut self, t: f64, y: &Y, rates: &Y) -> f64 {
        // Whether the last step has ended at a jump; the next one does not, as far as is known.
        if t >= std::mem::replace(&mut self.jump_at, f64::INFINITY) {
            return STEP_AFTER_JUMP;
        }
        let speed = y[RATES].hypot(y[RATES + 1]);
        let longest = LONGEST_STEP.min(LONGEST_WAY / speed.max(1e-9));
        // A step does not skip a change of commands or set speeds.
        let command = Some(self.next_command).filter(|time| time - t > SHORTEST_TO_CHANGE);
        let change = self.mechanics.drive.next_change(t + SHORTEST_TO_CHANGE);
        let changes = command.into_iter().chain(change);
        let longest = changes.fold(longest, |longest, change| longest.min(change - t));
        if self.jumps.places.is_empty() {
            return longest;
        }
        let Mechanics { robot, linkage, .. } = &self.mechanics;
        if self.kinematics.set(linkage, &state(y)).is_err() {
            return longest;
        }
        let accelerations = rates.fixed_rows::<4>(RATES).into_owned();
        let (longest, arrives) =
            (self.jumps).next(robot, &self.kinematics, &accelerations, longest);
        if arrives {
            self.jump_at = t + longest;
        }
        longest
    }
}

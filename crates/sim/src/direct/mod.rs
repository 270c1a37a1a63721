//! The engine `direct`: equations of motion in minimal coordinates, integrated by Radau IIA of
//! order 5 with error control and dense output.
//!
//! The motion shares with [`crate::rapier`] only the terrain and the laws of contact, friction,
//! drive and stops. Both engines start from the same state, and a settled start is a solution of
//! the equations of motion (`mechanics`) that this engine integrates.
//!
//! The solver chooses its steps, tens of milliseconds on rolling ground. The state at a record is
//! the solver's dense output, and all forces are evaluated from this state.

mod equations;
mod jumps;
mod method;
mod radau;
mod system;

use crate::drive::Drive;
use crate::engine::{Engine, Instant};
use crate::error::{NoTruth, PlantError};
use crate::setup::PlantSetup;
use crate::start::Start;
use crate::truth::PinTruth;
use equations::{Equations, INTEGRALS, Integrals};
use radau::Radau;
use robhaz_model::{Bar, WheelCommand};
use system::{SIZE, Y};

/// Allowed local errors of a step per unit of tolerance: positions (m, rad), velocities (m/s,
/// rad/s), wheel speeds (rad/s), integrals (rad). An error of 10 nm in a penetration is 2 mN of N.
///
/// High gains amplify errors of wheel speeds and integrals. Their allowed errors are therefore
/// divided by the gain, so that the error of the torque is at most that of the default gains: 0.5 N
/// m from Kp and 5 N m from Ki per unit of tolerance.
fn weights(drive: &Drive) -> Y {
    let usual = Drive::default();
    let omega = 1e-1 * (usual.kp / drive.kp).min(1.0);
    let integral = 1e-1 * (usual.ki / drive.ki).min(1.0);
    Y::from([
        1e-3, 1e-3, 1e-2, 1e-2, // Q, theta
        1e-1, 1e-1, 1e-1, 1e-1, // their rates
        omega, omega, omega, // omega
        integral, integral, integral, // integrals
    ])
}
/// Smallest allowed error of a step, rad/s and rad: some hundred times the rounding error of a
/// wheel speed. Only the highest gains with the smallest tolerances need it; at 1e6 N m s it is a
/// torque of 0.1 uN m.
const ROUNDING: f64 = 1e-13;
/// First step, s: less than the time constant of a bare wheel on the contact's damping (75 us).
const FIRST_STEP: f64 = 1e-5;

/// A simulation by the equations of motion.
pub struct DirectEngine {
    equations: Equations,
    solver: Radau<SIZE, INTEGRALS, Equations>,
    period: f64,
    /// Commands from the next truth on.
    commands: [WheelCommand; 3],
    /// Number of truths so far. Time is this number times the period, without accumulated rounding.
    records: u64,
}

impl DirectEngine {
    /// The robot at its start.
    ///
    /// # Errors
    /// [`PlantError`] where the forces of the start cannot be computed.
    pub(crate) fn new(setup: &PlantSetup, start: &Start) -> Result<Self, PlantError> {
        let mut equations = Equations::new(setup);
        let scale = weights(&setup.drive) * setup.engine.tolerance;
        let scale = scale.map(|error| error.max(ROUNDING));
        let solver = Radau::new(&mut equations, &system::start(start), scale, FIRST_STEP);
        Ok(Self {
            solver: solver.map_err(|_| refusal(0.0, equations.refusal))?,
            equations,
            period: setup.period,
            commands: Default::default(),
            records: 0,
        })
    }

    /// The solver after its first step that reaches `time` (s), which must not decrease from call
    /// to call.
    fn reach(&mut self, time: f64) -> Result<&Radau<SIZE, INTEGRALS, Equations>, PlantError> {
        let (equations, solver) = (&mut self.equations, &mut self.solver);
        let mut left = most_steps(self.period);
        while solver.time < time {
            // A state that oscillates between two laws can take an unlimited number of tiny steps.
            if left == 0 {
                return Err(NoTruth::NoStep.at(solver.time));
            }
            left -= 1;
            solver
                .advance(equations)
                .map_err(|_| refusal(solver.time, equations.refusal))?;
            // The failures of earlier trials.
            equations.refusal = None;
        }
        Ok(solver)
    }

    /// Lets the commands act from `time` (s) on, the time of the last call of [`Self::reach`]. The
    /// forces jump there, so the solver starts anew. Where commands changed they may change again
    /// at the next truth, `next` (s): steps end there.
    fn take_commands(&mut self, time: f64, next: f64) -> Result<(), PlantError> {
        let equations = &mut self.equations;
        if equations.commands == self.commands {
            equations.next_command = f64::INFINITY;
            return Ok(());
        }
        equations.commands = self.commands;
        equations.next_command = next;
        let restarted = self.solver.restart(equations, time);
        restarted.map_err(|_| refusal(time, equations.refusal))
    }

    /// Evaluates all forces at a state.
    fn evaluate(
        &mut self,
        y: &Y,
        integrals: &Integrals,
        instant: &mut Instant,
    ) -> Result<(), NoTruth> {
        let time = instant.truth.time;
        let equations = &mut self.equations;
        let state = system::state(y);
        let torques = equations.motor_torques(time, y);
        equations.evaluate(&state, torques)?;
        let (mechanics, kinematics) = (&equations.mechanics, &equations.kinematics);
        let forces = &equations.forces;
        let truth = &mut instant.truth;
        truth.body = kinematics.bar(Bar::Body);
        truth.links = Bar::LINKS.map(|bar| kinematics.bar(bar));
        truth.stop_torque = forces.stop_torque;
        truth.loop_error = kinematics.loop_error(&mechanics.robot);
        for i in 0..3 {
            let motion = kinematics.wheel(i);
            let wheel = &mut truth.wheels[i];
            (wheel.angle, wheel.omega, wheel.torque) = (integrals[i], state.omega[i], torques[i]);
            (mechanics.ground).write_truth(&forces.ground[i], &motion, wheel)?;
        }
        let positions = kinematics.pins();
        let pin_forces = forces.pin_forces(&mechanics.robot, kinematics);
        truth.pins = [0, 1, 2, 3].map(|i| PinTruth {
            position: positions[i],
            force: pin_forces[i],
        });
        instant.contact_energy = forces.ground.iter().map(|g| g.energy).sum();
        instant.balance = equations::balance(integrals);
        Ok(())
    }
}

impl Engine for DirectEngine {
    fn mean_step(&self) -> f64 {
        self.solver.time / self.solver.work.steps.max(1) as f64
    }

    fn command(&mut self, commands: [WheelCommand; 3]) {
        self.commands = commands;
    }

    fn next_instant(&mut self, instant: &mut Instant) -> Result<(), PlantError> {
        let time = time_of(self.records, self.period);
        let (y, integrals) = self.reach(time)?.at(time);
        self.records += 1;
        self.take_commands(time, time_of(self.records, self.period))?;
        instant.truth.time = time;
        self.evaluate(&y, &integrals, instant)
            .map_err(|why| why.at(time))
    }
}

/// Time of a record, counted from 0, at a period (s), s.
fn time_of(record: u64, period: f64) -> f64 {
    // Exact below 2^53 records.
    record as f64 * period
}

/// Largest number of steps in one period (s): its length in steps of 1 us, at least 1000. An impact
/// on an edge needs some hundred in a millisecond.
fn most_steps(period: f64) -> u64 {
    (period / 1e-6).ceil().max(1000.0) as u64
}

/// The error at a time (s) at which no step was found, from the reason why the last trial had no
/// forces.
fn refusal(time: f64, why: Option<NoTruth>) -> PlantError {
    why.unwrap_or(NoTruth::NoStep).at(time)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests;

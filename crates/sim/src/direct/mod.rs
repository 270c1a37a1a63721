//! The plant on its equations of motion: minimal coordinates, Radau IIA of order 5 with error control and dense output.
//!
//! Nothing is shared with [`crate::rapier`] but the laws of contact, friction, drive and stops. The solver chooses its
//! steps, tens of milliseconds on rolling ground; the truth at a record is the solver's dense output there, and all forces
//! are evaluated from it.

mod equations;
mod mechanism;
mod radau;

use crate::drive::Drive;
use crate::plant::{Engine, Instant, PlantError, PlantSetup};
use crate::start::Start;
use crate::truth::{PinTruth, Truth};
use equations::{INTEGRALS, Integrals, SIZE, Y};
use mechanism::NoForces;
use radau::Radau;
use robhaz_model::Bar;

pub(crate) use equations::Equations;
pub(crate) use mechanism::{Forces, Kinematics, State};

/// The library behind this engine, its linear algebra; a test holds it against the locked version.
pub const LIBRARY: &str = "nalgebra 0.35.0";

/// Local errors allowed in a step, per unit of tolerance: positions (m, rad), velocities (m/s, rad/s), wheel speeds
/// (rad/s), integrals (rad). A penetration off by 10 nm is 2 mN of N.
///
/// High gains make torques of small errors. They get smaller errors of wheel speeds and integrals: the torque's error
/// is at most that of the default gains, 0.5 N m of Kp and 5 N m of Ki a unit of tolerance.
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
/// Smallest error asked for in a step, rad/s and rad: some hundred times the rounding of a wheel speed. Only the highest gains at
/// the smallest tolerances come near it; 1e6 N m s make 0.1 uN m of it.
const ROUNDING: f64 = 1e-13;
/// First step, s: below the fast pole of a bare wheel on the ground (75 us).
const FIRST_STEP: f64 = 1e-5;

/// The simulation on the equations of motion.
pub struct DirectEngine {
    equations: Equations,
    /// `None` before the first truth.
    solver: Option<Radau<SIZE, INTEGRALS>>,
    start: Y,
    weights: Y,
    tolerance: f64,
    period: f64,
    /// Truths handed out; time is this times the period, so that it does not drift.
    records: u64,
}

impl DirectEngine {
    /// The robot at its start.
    pub(crate) fn new(setup: &PlantSetup, start: &Start) -> Self {
        Self {
            equations: Equations::new(setup),
            solver: None,
            start: equations::start(start),
            weights: weights(&setup.drive),
            tolerance: setup.tolerance,
            period: setup.period,
            records: 0,
        }
    }

    /// State and integrals at `time` (s), which must not decrease from call to call.
    fn at(&mut self, time: f64) -> Result<(Y, Integrals), PlantError> {
        let equations = &mut self.equations;
        let solver = match &mut self.solver {
            Some(solver) => solver,
            none => {
                let scale = (self.weights * self.tolerance).map(|error| error.max(ROUNDING));
                let solver = Radau::new(equations, &self.start, scale, FIRST_STEP)
                    .map_err(|_| refusal(time, equations.last_refusal()))?;
                none.insert(solver)
            }
        };
        let mut left = most_steps(self.period);
        while solver.time() < time {
            // A state that rattles between two laws can be followed for ever, and gets nowhere.
            if left == 0 {
                return Err(PlantError::NoStep {
                    time: solver.time(),
                });
            }
            left -= 1;
            solver
                .advance(equations)
                .map_err(|_| refusal(solver.time(), equations.last_refusal()))?;
            equations.clear_refusal();
        }
        Ok(solver.at(time))
    }

    fn instant(&mut self, time: f64, y: &Y, integrals: &Integrals) -> Result<Instant, NoForces> {
        let equations = &mut self.equations;
        let state = equations::state(y);
        let kinematics = Kinematics::new(&equations.robot, &state)?;
        let torques = equations.motor_torques(time, y);
        let forces = equations.forces(&kinematics, &state, torques)?;
        let bar = |bar| kinematics.bar(bar, &state);
        let mut truth = Truth {
            time,
            body: bar(Bar::Body),
            links: Bar::LINKS.map(bar),
            stop_torque: forces.stop_torque,
            loop_error: kinematics.loop_error(&equations.robot),
            ..Truth::default()
        };
        for i in 0..3 {
            let ground = equations.or_gap(i, forces.ground[i], &kinematics, &state)?;
            truth.wheels[i] = ground.truth(
                kinematics.axle(i, &state),
                integrals[i],
                state.omega[i],
                torques[i],
            );
        }
        let positions = kinematics.pins(&state);
        for (i, force) in forces
            .pin_forces(&equations.robot, &kinematics)
            .into_iter()
            .enumerate()
        {
            truth.pins[i] = PinTruth {
                position: positions[i],
                force,
            };
        }
        Ok(Instant {
            truth,
            contact_energy: forces.ground.iter().map(|g| g.energy).sum(),
            balance: equations::balance(integrals),
        })
    }
}

impl Engine for DirectEngine {
    fn mean_step(&self) -> f64 {
        self.solver.as_ref().map_or(0.0, |solver| {
            #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
            let steps = solver.work().steps.max(1) as f64;
            solver.time() / steps
        })
    }

    fn next_instant(&mut self) -> Result<Instant, PlantError> {
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53 records")]
        let time = self.records as f64 * self.period;
        let (y, integrals) = self.at(time)?;
        self.records += 1;
        self.instant(time, &y, &integrals)
            .map_err(|why| refusal(time, Some(why)))
    }
}

/// Steps that one period may take, s: steps of 1 us throughout. A wheel that hits an edge needs some hundred in a millisecond.
fn most_steps(period: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive and bounded"
    )]
    let steps = (period / 1e-6).ceil().max(1000.0) as u64;
    steps
}

fn refusal(time: f64, why: Option<NoForces>) -> PlantError {
    match why {
        Some(NoForces::BelowGround(wheel, x)) => PlantError::WheelBelowGround {
            time,
            wheel: wheel + 1,
            x,
        },
        Some(NoForces::Loop(_)) => PlantError::LoopRange { time },
        _ => PlantError::NoStep { time },
    }
}

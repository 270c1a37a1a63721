//! The plant on its equations of motion: minimal coordinates, Radau IIA of order 5 with error control and dense output.
//!
//! Nothing is shared with [`crate::rapier`] but the laws of contact, friction, drive and stops. The solver chooses its
//! steps, tens of milliseconds on rolling ground; the truth at a record is the solver's dense output there, and all forces
//! are evaluated from it.

mod equations;
mod mechanism;
mod solver;

use crate::plant::{Engine, PlantError, PlantSetup};
use crate::start::Start;
use crate::truth::{PinTruth, Truth};
use equations::Y;
use mechanism::NoForces;
use robhaz_model::Bar;
use solver::Solver;

pub(crate) use equations::Equations;
pub(crate) use mechanism::{Forces, Kinematics, State};

/// The library behind this engine; a test holds it against the locked version.
pub const LIBRARY: &str = "differential-equations 0.7.0";

/// The simulation on the equations of motion.
pub struct DirectEngine {
    equations: Equations,
    solver: Solver,
    period: f64,
    /// Truths handed out; time is this times the period, so that it does not drift.
    records: u64,
}

impl DirectEngine {
    /// The robot at its start.
    pub(crate) fn new(setup: &PlantSetup, start: &Start) -> Self {
        let equations = Equations::new(setup);
        let solver = Solver::new(&equations, &equations::start(start), setup.tolerance);
        Self {
            equations,
            solver,
            period: setup.period,
            records: 0,
        }
    }

    /// Why the solver gave up: what the last evaluation complained of.
    fn error(&self, time: f64) -> PlantError {
        refusal(time, self.equations.last_refusal())
    }

    fn truth(&self, time: f64, y: &Y, spins: [f64; 3]) -> Result<Truth, NoForces> {
        let equations = &self.equations;
        let robot = &equations.robot;
        let state = equations::state(y);
        let kinematics = Kinematics::new(robot, &state)?;
        let torques = equations.motor_torques(time, y);
        let forces = equations.forces(&kinematics, &state, torques)?;
        let bar = |bar| kinematics.bar(bar, &state);
        let mut truth = Truth {
            time,
            body: bar(Bar::Body),
            links: Bar::LINKS.map(bar),
            stop_torque: forces.stop_torque,
            ..Truth::default()
        };
        for i in 0..3 {
            let ground = equations.or_gap(i, forces.ground[i], &kinematics, &state)?;
            truth.wheels[i] = ground.truth(
                kinematics.axle(i, &state),
                spins[i],
                state.omega[i],
                torques[i],
            );
        }
        let positions = kinematics.pins(&state);
        for (i, force) in forces
            .pin_forces(robot, &kinematics)
            .into_iter()
            .enumerate()
        {
            truth.pins[i] = PinTruth {
                position: positions[i],
                force,
            };
        }
        Ok(truth)
    }
}

impl Engine for DirectEngine {
    fn mean_step(&self) -> f64 {
        self.solver.mean_step()
    }

    fn next_truth(&mut self) -> Result<Truth, PlantError> {
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53 records")]
        let time = self.records as f64 * self.period;
        let (y, spins) = self
            .solver
            .at(time, &self.equations)
            .map_err(|time| self.error(time))?;
        self.records += 1;
        self.truth(time, &y, spins)
            .map_err(|why| refusal(time, Some(why)))
    }
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

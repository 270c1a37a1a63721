//! The plant as a caller sees it: created once, then asked for one truth per period.

use crate::direct::DirectEngine;
use crate::energy::EnergyWatch;
use crate::engine::{Balance, Engine, Instant};
use crate::error::{NoTruth, PlantError};
use crate::rapier::RapierEngine;
use crate::setup::{EngineKind, PlantSetup};
use crate::start::Start;
use crate::truth::Truth;
use robhaz_model::{Bar, Robot, WheelCommand};

/// A running simulation.
pub struct Plant {
    engine: Box<dyn Engine>,
    robot: Robot,
    watch: EnergyWatch,
    /// The last instant.
    instant: Instant,
    has_balance: bool,
}

impl Plant {
    /// Largest allowed gap of a pin, m. A larger one stops the run. With the default step the gap
    /// is about 1e-7 m on undulating ground.
    pub const MAX_LOOP_ERROR: f64 = 1e-4;

    /// Places the robot on the ground as [`EngineChoice::start`](crate::EngineChoice::start) asks.
    ///
    /// # Errors
    /// [`PlantError`] if the robot cannot stand there.
    pub fn new(setup: &PlantSetup) -> Result<Self, PlantError> {
        let start = Start::new(setup)?;
        Ok(Self {
            engine: match setup.engine.kind {
                EngineKind::Rapier => Box::new(RapierEngine::new(setup, &start)?),
                EngineKind::Direct => Box::new(DirectEngine::new(setup, &start)?),
            },
            robot: setup.robot.clone(),
            watch: EnergyWatch::new(&setup.robot),
            instant: Instant::default(),
            has_balance: setup.balance,
        })
    }

    /// Impulse and work up to the last truth; `None` if [`PlantSetup::balance`] is not set.
    pub fn balance(&self) -> Option<&Balance> {
        self.has_balance.then_some(&self.instant.balance)
    }

    /// Sets the commands of the wheels. They act from the time of the next truth on and are held
    /// until others do. The motor torques of that truth are already theirs. Without any command the
    /// drives follow their plan.
    pub fn command(&mut self, commands: [WheelCommand; 3]) {
        self.engine.command(commands);
    }

    /// Mean integration step since the start, s.
    pub fn mean_step(&self) -> f64 {
        self.engine.mean_step()
    }

    /// The truth at the current time. The simulation then advances by one period. The truth is
    /// borrowed, since it has 1.1 kB; `*` copies it.
    ///
    /// # Errors
    /// [`PlantError`] if the forces would be wrong. The plant must not be used afterwards.
    pub fn next_truth(&mut self) -> Result<&Truth, PlantError> {
        self.engine.next_instant(&mut self.instant)?;
        let truth = &self.instant.truth;
        let checked = check(truth).and_then(|()| self.watch.check(&self.robot, &self.instant));
        checked.map_err(|why| why.at(truth.time))?;
        Ok(truth)
    }
}

/// Checks that the state is in the range in which the forces are valid.
fn check(truth: &Truth) -> Result<(), NoTruth> {
    /// Largest gap between a wheel and the ground, m.
    const MAX_GAP: f64 = 1.0;
    for bar in Bar::ALL {
        let b = truth.bar(bar);
        let part = bar.name();
        let sum = b.position.x + b.position.y + b.angle + b.velocity.x + b.velocity.y + b.rate;
        if !sum.is_finite() {
            return Err(NoTruth::NotFinite { part });
        }
        if b.angle.abs() > std::f64::consts::FRAC_PI_2 {
            return Err(NoTruth::Overturned { part });
        }
    }
    for (i, wheel) in truth.wheels.iter().enumerate() {
        if wheel.penetration < -MAX_GAP {
            let (wheel, x) = (i + 1, wheel.position.x);
            return Err(NoTruth::OffTheGround { wheel, x });
        }
    }
    let distance = truth.loop_error;
    if distance > Plant::MAX_LOOP_ERROR {
        return Err(NoTruth::LoopOpen { distance });
    }
    Ok(())
}

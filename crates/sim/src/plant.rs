//! The plant as a caller sees it: set up once, then asked for the truth, one period after the other.

use crate::balance::Balance;
use crate::contact::ContactLaw;
use crate::direct::{self, DirectEngine};
use crate::drive::Drive;
use crate::energy::Watch;
use crate::friction::{FrictionLaw, Stretch};
use crate::rapier::{self, RapierEngine};
use crate::start::{NoRest, Start, StartKind};
use crate::truth::Truth;
use robhaz_model::{Bar, Robot, StanceError};
use robhaz_terrain::Terrain;

/// Which engine computes the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineKind {
    /// Rigid bodies and joints in rapier2d, with a fixed step.
    Rapier,
    /// The equations of motion in minimal coordinates, with a stiff solver.
    Direct,
}

impl EngineKind {
    /// All engines.
    pub const ALL: [Self; 2] = [Self::Rapier, Self::Direct];

    /// Name in scene files and summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rapier => "rapier",
            Self::Direct => "direct",
        }
    }

    /// The library behind it and its version.
    pub const fn library(self) -> &'static str {
        match self {
            Self::Rapier => rapier::LIBRARY,
            Self::Direct => direct::LIBRARY,
        }
    }
}

/// What every engine can do.
pub(crate) trait Engine {
    /// Mean integration step so far, s.
    fn mean_step(&self) -> f64;

    /// What is true at the current time; the simulation then goes on by one period.
    fn next_instant(&mut self) -> Result<Instant, PlantError>;
}

/// The truth, and the energies that [`Truth`] leaves out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Instant {
    pub truth: Truth,
    /// In the springs of the contacts, J.
    pub contact_energy: f64,
    /// Work of the motors; the other integrals are zero unless [`PlantSetup::balance`] asks for them.
    pub balance: Balance,
}

/// Everything that a simulation depends on.
#[derive(Clone)]
pub struct PlantSetup {
    /// The robot, checked by `Geometry::check` and `MassSet::check`.
    pub robot: Robot,
    /// The ground.
    pub terrain: Terrain,
    /// Eq. (10).
    pub contact: ContactLaw,
    /// Eq. (11).
    pub friction: FrictionLaw,
    /// Parts of the ground with friction coefficients of their own; they do not overlap.
    pub stretches: Vec<Stretch>,
    /// Eq. (2).
    pub drive: Drive,
    /// How the robot stands at time zero.
    pub start: StartKind,
    /// What computes the truth.
    pub engine: EngineKind,
    /// Greatest integration step of `rapier`, s. The step used divides the period, and is cut into up to
    /// [`rapier::MOST_PARTS`] parts where an edge hits a wheel or the friction is stiff.
    pub step: f64,
    /// Tolerance of `direct`: how large the error of one step may be, in units of 1 mm, 10 mrad, 0.1 m/s and 0.1 rad/s.
    pub tolerance: f64,
    /// Time between two truths, s.
    pub period: f64,
    /// Whether impulse and work are integrated for [`Plant::balance`]. It changes no bit of the truth. `rapier` then takes 2 to 3 %
    /// longer, `direct` 2 % on smooth ground and a quarter on stairs: it evaluates the forces once more at each node of its steps.
    pub balance: bool,
}

/// A run has left the range in which its forces mean something.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// A wheel's centre is below the ground.
    #[error("at t = {time:.4} s the centre of wheel {wheel} is below the ground (x = {x:.3} m)")]
    WheelBelowGround {
        /// When, s.
        time: f64,
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Where, m.
        x: f64,
    },
    /// The state is no longer a number: the step is too long for the contact, or the forces too great.
    #[error(
        "at t = {time:.4} s the state of {part} is not finite: the forces are too great for engine.step, or the ground threw the robot"
    )]
    NotFinite {
        /// When, s.
        time: f64,
        /// Which bar.
        part: &'static str,
    },
    /// A bar has turned by more than a right angle: the robot lies on its back, and only its wheels know the ground.
    #[error("at t = {time:.4} s {part} has turned over")]
    Overturned {
        /// When, s.
        time: f64,
        /// Which bar.
        part: &'static str,
    },
    /// A wheel is far from any ground.
    #[error("at t = {time:.4} s wheel {wheel} has left the ground by more than 1 m (x = {x:.1} m)")]
    OffTheGround {
        /// When, s.
        time: f64,
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Where, m.
        x: f64,
    },
    /// Under a raw start the ground is not level: wheels would be thrown out of it or fall.
    #[error(
        "at a raw start the ground under the wheels must be level at y = 0, but wheel {wheel} is {}",
        stands(*depth, *rest)
    )]
    Start {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Penetration, m; negative above the ground.
        depth: f64,
        /// Penetration under the mean load, m.
        rest: f64,
    },
    /// The settled start finds no static equilibrium.
    #[error("the robot finds no rest at its start: {why}")]
    NoRest {
        /// What is missing.
        why: NoRest,
    },
    /// The robot cannot stand, not even on level ground.
    #[error(transparent)]
    Stance(#[from] StanceError),
    /// The links have turned farther than the four-bar can close.
    #[error("at t = {time:.4} s links 1 and 2 have turned farther than the four-bar can close")]
    LoopRange {
        /// When, s.
        time: f64,
    },
    /// The solver finds no step that is accurate enough.
    #[error("at t = {time:.4} s the solver finds no step that is accurate enough")]
    NoStep {
        /// When, s.
        time: f64,
    },
    /// The integration makes energy: the forces are not those of the laws.
    #[error(
        "at t = {time:.4} s energy is made from nothing: {made:.1e} J since it was least; a smaller engine.step, a smaller engine.tolerance or the other engine.kind may hold"
    )]
    EnergyMade {
        /// When, s.
        time: f64,
        /// How much, J.
        made: f64,
    },
    /// The loop has drifted open: the pins cannot be trusted.
    #[error(
        "at t = {time:.4} s the pins of the four-bar are {distance:.1e} m apart: the forces are too great for engine.step"
    )]
    LoopOpen {
        /// When, s.
        time: f64,
        /// How far, m.
        distance: f64,
    },
}

/// A running simulation.
pub struct Plant {
    engine: Box<dyn Engine>,
    robot: Robot,
    watch: Watch,
    balance: Option<Balance>,
}

impl Plant {
    /// Loop error beyond which a run is stopped, m: a thousand times what the default step leaves on rolling ground.
    pub const MAX_LOOP_ERROR: f64 = 1e-4;

    /// Puts the robot on its ground as [`StartKind`] says.
    ///
    /// # Errors
    /// [`PlantError`] where the robot cannot stand.
    pub fn new(setup: &PlantSetup) -> Result<Self, PlantError> {
        let start = Start::new(setup)?;
        Ok(Self {
            engine: match setup.engine {
                EngineKind::Rapier => Box::new(RapierEngine::new(setup, &start)),
                EngineKind::Direct => Box::new(DirectEngine::new(setup, &start)),
            },
            robot: setup.robot.clone(),
            watch: Watch::new(&setup.robot),
            balance: setup.balance.then(Balance::default),
        })
    }

    /// Impulse and work up to the last truth; `None` unless [`PlantSetup::balance`] asked for them.
    pub fn balance(&self) -> Option<&Balance> {
        self.balance.as_ref()
    }

    /// Mean integration step so far, s.
    pub fn mean_step(&self) -> f64 {
        self.engine.mean_step()
    }

    /// The truth at the current time; the simulation then goes on by one period.
    ///
    /// # Errors
    /// [`PlantError`] where the forces would be wrong; the simulation must not be used further.
    pub fn next_truth(&mut self) -> Result<Truth, PlantError> {
        let instant = self.engine.next_instant()?;
        check(&instant.truth)?;
        self.watch.look(&self.robot, &instant)?;
        if let Some(balance) = &mut self.balance {
            *balance = instant.balance;
        }
        Ok(instant.truth)
    }
}

/// How deep a wheel is in the ground, in words; m.
fn stands(depth: f64, rest: f64) -> String {
    if depth > 0.0 {
        format!("{depth:.4} m deep in the ground, where its weight takes it {rest:.4} m deep")
    } else {
        format!("{:.4} m above the ground", -depth)
    }
}

fn check(truth: &Truth) -> Result<(), PlantError> {
    /// A gap to the ground beyond which a wheel has left it, m.
    const GONE: f64 = 1.0;
    let time = truth.time;
    for bar in Bar::ALL {
        let b = truth.bar(bar);
        let sum = b.position.x + b.position.y + b.angle + b.velocity.x + b.velocity.y + b.rate;
        if !sum.is_finite() {
            return Err(PlantError::NotFinite {
                time,
                part: bar.name(),
            });
        }
        if b.angle.abs() > std::f64::consts::FRAC_PI_2 {
            return Err(PlantError::Overturned {
                time,
                part: bar.name(),
            });
        }
    }
    for (i, wheel) in truth.wheels.iter().enumerate() {
        if wheel.penetration < -GONE {
            return Err(PlantError::OffTheGround {
                time,
                wheel: i + 1,
                x: wheel.position.x,
            });
        }
    }
    if truth.loop_error > Plant::MAX_LOOP_ERROR {
        return Err(PlantError::LoopOpen {
            time,
            distance: truth.loop_error,
        });
    }
    Ok(())
}

//! Everything that a simulation depends on.

use crate::contact::ContactLaw;
use crate::drive::Drive;
use crate::friction::{FrictionLaw, Stretch};
use robhaz_model::{Robot, named};
use robhaz_terrain::Terrain;

named! {
    /// The engine that computes the truth.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum EngineKind {
        /// Rigid bodies and joints in rapier2d, with a constant step that is divided during impacts
        /// and for stiff laws: [`crate::rapier`].
        Rapier = "rapier",
        /// Equations of motion in minimal coordinates, with a stiff solver: [`crate::direct`].
        Direct = "direct",
    }
}

impl EngineKind {
    /// Library behind the engine, with its version: the rigid bodies of `rapier`, the linear
    /// algebra of `direct`. A test compares both with the locked versions.
    pub const fn library(self) -> &'static str {
        match self {
            Self::Rapier => "rapier2d 0.36.1",
            Self::Direct => "nalgebra 0.35.0",
        }
    }
}

named! {
    /// State of the robot at time zero.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum StartKind {
        /// Static equilibrium under the robot's weight; the drives hold the wheels. Nothing changes
        /// until the drives start.
        ///
        /// On a slope, a friction law without true stiction needs slip: the robot starts with a
        /// small constant speed downhill.
        #[default]
        Settled = "settled",
        /// Nominal pose at rest, each wheel at the penetration of the mean wheel load. The robot
        /// settles in the first milliseconds of the run.
        Raw = "raw",
    }
}

/// The engine that computes the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineChoice {
    /// Which engine.
    pub kind: EngineKind,
    /// State of the robot at time zero.
    pub start: StartKind,
    /// Largest integration step of `rapier`, s. The step in use is the period over a whole number.
    /// It is divided further, into up to [`MOST_PARTS`](crate::stability::MOST_PARTS) parts, during
    /// impacts and where contact, friction or drive are stiff.
    pub step: f64,
    /// Tolerance of `direct`: allowed error of one step, in units of 1 mm, 10 mrad, 0.1 m/s and 0.1
    /// rad/s.
    pub tolerance: f64,
}

impl Default for EngineChoice {
    /// `rapier` with steps of 0.2 ms, five a record; it holds N to about 8 mN on rolling ground,
    /// `direct` to 0.2 mN.
    fn default() -> Self {
        Self {
            kind: EngineKind::Rapier,
            start: StartKind::default(),
            step: 2e-4,
            tolerance: 1e-5,
        }
    }
}

/// Everything that a simulation depends on.
#[derive(Clone)]
pub struct PlantSetup {
    /// The robot. It must have passed `Geometry::check` and `MassSet::check`.
    pub robot: Robot,
    /// The ground.
    pub terrain: Terrain,
    /// Law of the normal force, eq. (10).
    pub contact: ContactLaw,
    /// Law of the traction, eq. (11) or another form, and rolling resistance.
    pub friction: FrictionLaw,
    /// Stretches of the ground with their own friction coefficients. They do not overlap.
    pub stretches: Vec<Stretch>,
    /// The drives, eq. (2).
    pub drive: Drive,
    /// The engine that computes the truth.
    pub engine: EngineChoice,
    /// Time between two truths, s.
    pub period: f64,
    /// Whether the engine integrates impulse and work for
    /// [`Plant::balance`](crate::Plant::balance). The truth is the same to the bit. `rapier` then
    /// takes 2 to 3 % longer, `direct` 2 % on smooth ground and 25 % on stairs, because it
    /// evaluates the forces once more at each node of its steps.
    pub balance: bool,
}

impl PlantSetup {
    /// For tests: the default robot on a ground, with the defaults of a scene and the engine
    /// `direct`.
    #[cfg(test)]
    pub(crate) fn on(profile: robhaz_terrain::Profile) -> Self {
        Self {
            robot: Robot::default_a(),
            terrain: Terrain::new(profile),
            contact: ContactLaw::default(),
            friction: FrictionLaw::default(),
            stretches: Vec::new(),
            drive: Drive::default(),
            engine: EngineChoice {
                kind: EngineKind::Direct,
                ..EngineChoice::default()
            },
            period: 1e-3,
            balance: false,
        }
    }
}

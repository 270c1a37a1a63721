//! The keys of a scene file: all sections, those of engine and record.

use crate::estimators::Estimators;
use crate::form::{NAME, SEED, section, word};
use crate::key::keys;
use crate::quantity::{FREQUENCY, LONGEST_RUN, NONE, TIME, above, at_least, number};
use crate::scene::Scene;
use crate::terrain::Terrain;
use crate::{contact, drive, robot, sensors};
use robhaz_sim::{EngineKind, StartKind};

/// Longest step of `rapier`, s: an impact lasts some milliseconds. What is stable depends on robot and ground.
const LONGEST_STEP: f64 = 1e-3;
/// Fastest rate of records, Hz.
const FASTEST: f64 = 1e6;

keys! {
    /// The keys of a scene file, in the order of the resolved scene.
    pub(crate) SCENE: Scene;

    /// name of the scene: names the default output folder
    name ("the file's name without `.toml`"): NAME => |s| &mut s.name;

    /// seed of everything random in the run
    seed: SEED => |s| &mut s.seed;

    /// geometry and masses
    robot: robot::ROBOT => |s| &mut s.robot;

    /// the ground
    terrain: Terrain { is_part: false } => |s| &mut s.terrain;

    /// eqs. (10) and (11): wheel and ground
    contact: section(contact::KEYS) => |s| s;

    /// eq. (2): motors and their speed control
    drive: section(drive::KEYS) => |s| s;

    /// errors of the readings
    sensors: section(sensors::KEYS) => |s| s;

    /// differences between the nominal robot and the simulated one
    model_error: section(sensors::MODEL_ERROR) => |s| s;

    /// the engine that computes the truth
    engine: section(ENGINE) => |s| s;

    /// duration and rate of the records
    record: section(RECORD) => |s| s;

    /// the estimators
    estimator: Estimators => |s| &mut s.estimators;
}

keys! {
    ENGINE: Scene;

    /// which engine: rigid bodies in rapier2d, or the equations of motion with a stiff solver
    kind: word(&EngineKind::ALL, EngineKind::name) => |s| &mut s.engine.kind;

    /// pose at time zero: static equilibrium on the ground, or the nominal pose with all wheels at equal penetration,
    /// from which the robot settles
    start: word(&StartKind::ALL, StartKind::name) => |s| &mut s.engine.start;

    /// largest integration step of rapier, cut into 13 parts while an edge hits a wheel, and into as many as stiff laws
    /// need
    step: number(TIME, above(0.0).at_most(LONGEST_STEP)) => |s| &mut s.engine.step;

    /// error allowed in a step of direct, in units of 1 mm, 10 mrad, 0.1 m/s and 0.1 rad/s
    tolerance: number(NONE, at_least(1e-9).at_most(1e-2)) => |s| &mut s.engine.tolerance;
}

keys! {
    RECORD: Scene;

    /// simulated time; a whole number of records
    duration: number(TIME, above(0.0).at_most(LONGEST_RUN)) => |s| &mut s.record.duration;

    /// records a second
    rate: number(FREQUENCY, above(0.0).at_most(FASTEST)) => |s| &mut s.record.rate;

    /// errors are computed from this time on, after rest and start; below duration
    compare_from: number(TIME, at_least(0.0).at_most(LONGEST_RUN))
        => |s| &mut s.record.compare_from;
}

//! The sections whose keys set fields of the scene, and the keys of engine and record.

use crate::key::Key;
use crate::range::{LONGEST_RUN, above, at_least};
use crate::scene::Scene;
use crate::units::{FREQUENCY, NONE, TIME};
use crate::{contact, drive, name, seed, sensors};
use robhaz_sim::{EngineKind, StartKind};

/// A section of a scene file whose keys set fields of the scene.
pub(crate) struct Section {
    pub name: &'static str,
    pub meaning: &'static str,
    pub keys: &'static [Key<Scene>],
}

/// Longest step of `rapier`, s: an impact lasts some milliseconds. What is stable depends on robot and ground.
const LONGEST_STEP: f64 = 1e-3;
/// Fastest rate of records, Hz.
const FASTEST: f64 = 1e6;

/// A table that the reader ignores: the resolved scene names there the versions that wrote it.
pub(crate) const IGNORED: &str = "resolved";

/// The keys above all sections.
pub(crate) const TOP: &[Key<Scene>] = &[
    Key::own(
        "name",
        "the file's name without `.toml`",
        name::FORM,
        "name of the scene: names the default output folder",
    ),
    Key::own(
        "seed",
        "0",
        seed::FORM,
        "seed of everything random in the run",
    ),
];

/// All these sections, in the order of the resolved scene.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        name: contact::PATH,
        meaning: "eqs. (10) and (11): wheel and ground",
        keys: contact::KEYS,
    },
    Section {
        name: drive::PATH,
        meaning: "eq. (2): motors and their speed control",
        keys: drive::KEYS,
    },
    Section {
        name: sensors::PATH,
        meaning: "errors of the readings",
        keys: sensors::KEYS,
    },
    Section {
        name: sensors::MODEL_ERROR_PATH,
        meaning: "differences between the nominal robot and the simulated one",
        keys: sensors::MODEL_ERROR,
    },
    Section {
        name: "engine",
        meaning: "the engine that computes the truth",
        keys: ENGINE,
    },
    Section {
        name: "record",
        meaning: "duration and rate of the records",
        keys: RECORD,
    },
];

const ENGINE: &[Key<Scene>] = &[
    Key::word(
        "kind",
        &[EngineKind::Rapier.name(), EngineKind::Direct.name()],
        |s| s.engine.kind as usize,
        |s, i| s.engine.kind = EngineKind::ALL[i],
        "which engine: rigid bodies in rapier2d, or the equations of motion with a stiff solver",
    ),
    Key::word(
        "start",
        &[StartKind::Settled.name(), StartKind::Raw.name()],
        |s| s.engine.start as usize,
        |s, i| s.engine.start = StartKind::ALL[i],
        "pose at time zero: static equilibrium on the ground, or the nominal pose with all wheels at equal penetration, from which the robot settles",
    ),
    Key::number(
        "step",
        TIME,
        above(0.0).at_most(LONGEST_STEP),
        |s| &mut s.engine.step,
        "largest integration step of rapier, cut into 13 parts while an edge hits a wheel, and into as many as stiff laws need",
    ),
    Key::number(
        "tolerance",
        NONE,
        at_least(1e-9).at_most(1e-2),
        |s| &mut s.engine.tolerance,
        "error allowed in a step of direct, in units of 1 mm, 10 mrad, 0.1 m/s and 0.1 rad/s",
    ),
];

const RECORD: &[Key<Scene>] = &[
    Key::number(
        "duration",
        TIME,
        above(0.0).at_most(LONGEST_RUN),
        |s| &mut s.record.duration,
        "simulated time; a whole number of records",
    ),
    Key::number(
        "rate",
        FREQUENCY,
        above(0.0).at_most(FASTEST),
        |s| &mut s.record.rate,
        "records a second",
    ),
    Key::number(
        "compare_from",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |s| &mut s.record.compare_from,
        "errors are computed from this time on, after rest and start; below duration",
    ),
];

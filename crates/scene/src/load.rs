//! The keys of a scene file; from a file to a [`Scene`], and back.

use crate::error::SceneError;
use crate::estimators::Estimators;
use crate::form::{KeyReference, Out, word};
use crate::key::{self, keys, section};
use crate::quantity::{FREQUENCY, LONGEST_RUN, NONE, TIME, above, at_least, number};
use crate::reader::Reader;
use crate::scene::{Scene, SensorChoice};
use crate::source::Node;
use crate::terrain::Terrain;
use crate::values::{NAME, SEED, from_stem};
use crate::{checks, contact, drive, overrides, robot, sensors};
use robhaz_masses::ModelError;
use robhaz_sim::{EngineKind, StartKind};
use std::path::Path;
use std::sync::LazyLock;

/// Longest step of `rapier`, s: an impact lasts some milliseconds. What is stable depends on robot
/// and ground.
const LONGEST_STEP: f64 = 1e-3;
/// Fastest rate of records, Hz.
const FASTEST: f64 = 1e6;

keys! {
    /// The keys of a scene file, in the order of the resolved scene.
    pub(crate) SCENE: Scene;

    /// name of the scene: names the default output folder
    name ("the file's name without `.toml`"): NAME => name;

    /// seed of everything random in the run
    seed: SEED => seed;

    /// geometry and masses
    robot: robot::ROBOT => robot;

    /// the ground
    terrain: Terrain { is_part: false } => terrain;

    /// eqs. (10) and (11): wheel and ground
    contact: section(contact::KEYS) => self;

    /// eq. (2): motors and their speed control
    drive: section(drive::KEYS) => self;

    /// errors of the readings
    sensors: section(sensors::KEYS) => self;

    /// differences between the nominal robot and the simulated one
    model_error: section(sensors::MODEL_ERROR) => self;

    /// the engine that computes the truth
    engine: section(ENGINE) => self;

    /// duration and rate of the records
    record: section(RECORD) => self;

    /// the estimators
    estimator: Estimators => estimators;
}

keys! {
    ENGINE: Scene;

    /// which engine: rigid bodies in rapier2d, or the equations of motion with a stiff solver
    kind: word(&EngineKind::ALL, EngineKind::name) => engine.kind;

    /// pose at time zero: static equilibrium on the ground, or the nominal pose with all wheels at
    /// equal penetration, from which the robot settles
    start: word(&StartKind::ALL, StartKind::name) => engine.start;

    /// largest integration step of rapier, cut into 13 parts while an edge hits a wheel, and into
    /// as many as stiff laws need
    step: number(TIME, above(0.0).at_most(LONGEST_STEP)) => engine.step;

    /// error allowed in a step of direct, in units of 1 mm, 10 mrad, 0.1 m/s and 0.1 rad/s
    tolerance: number(NONE, at_least(1e-9).at_most(1e-2)) => engine.tolerance;
}

keys! {
    RECORD: Scene;

    /// simulated time; a whole number of records
    duration: number(TIME, above(0.0).at_most(LONGEST_RUN)) => record.duration;

    /// records a second
    rate: number(FREQUENCY, above(0.0).at_most(FASTEST)) => record.rate;

    /// errors are computed from this time on, after rest and start; below duration
    compare_from: number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => record.compare_from;
}

impl Scene {
    /// Reads a scene file; `overrides` are texts `key=value` that take precedence over the file,
    /// later ones over earlier ones.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file, of files that it names, and of the overrides.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        Reader::load(
            path,
            "a scene file in TOML, UTF-8",
            |text, shown, folder| Self::parse(text, shown, folder, overrides),
        )
    }

    /// Reads the text of a scene file.
    ///
    /// `source_name` is the file's name in messages, and the scene's name where the text gives
    /// none. Paths in the scene are relative to `base_dir`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(
        text: &str,
        source_name: &str,
        base_dir: &Path,
        overrides: &[String],
    ) -> Result<Self, SceneError> {
        let reader = Reader::new(base_dir.to_owned(), home_of);
        reader.read(source_name, text, |reader, mut root| {
            for text in overrides {
                overrides::apply(reader, &mut root, text);
            }
            sensors::drop_keys_of_other_grades(&mut root);
            contact::drop_keys_of_other_laws(&mut root);
            read(reader, &root, source_name)
        })
    }

    /// The scene as a file that reads back as exactly this scene, in any folder that also has
    /// copies of its [tracks](crate::TerrainChoice::tracks), named [`crate::Track::file_name`].
    /// `version` names the program that writes it, such as `robhaz 0.1.0, rapier2d 0.36.1`.
    pub fn to_toml(&self, version: &str) -> String {
        let comment =
            "A scene with every choice written out. SI units. It can be run again as it is.";
        Out::file(comment, version, SCENE, &mut self.clone())
    }
}

fn read(reader: &mut Reader, root: &Node, source_name: &str) -> Scene {
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let grade = sensors::chosen_grade(root);
    let mut scene = Scene {
        name: from_stem(&stem.to_string_lossy()),
        friction: contact::chosen_law(root),
        sensors: SensorChoice::of(grade),
        model_error: ModelError::of_grade(grade),
        ..Scene::default()
    };
    // The seed of random ground that has none of its own.
    let seed = root.get("seed").and_then(Node::whole);
    reader.seed = seed.and_then(|s| u64::try_from(s).ok()).unwrap_or_default();
    reader.table(SCENE, root, "", &mut scene);
    drive::choose_estimator(reader, root, &mut scene);
    drive::choose_rate(root, &mut scene);
    checks::check(reader, root, &scene);
    scene
}

/// Every key that a scene file can have, section by section.
pub fn reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    key::rows(&mut rows, SCENE, "", &mut Scene::default());
    rows
}

/// The table that has a key of this name, as written in a file.
pub(crate) fn home_of(name: &str) -> Option<String> {
    // Made once: it takes milliseconds.
    static KEYS: LazyLock<Vec<KeyReference>> = LazyLock::new(reference);
    let suffix = format!(".{name}");
    let keys = KEYS.iter().filter(|k| k.key.ends_with(&suffix));
    // A section rather than an item of a list.
    let key = keys.min_by_key(|k| k.key.contains("[]"))?;
    let section = key.key.strip_suffix(&suffix)?;
    Some(match section.strip_suffix("[]") {
        Some(list) => format!("[[{list}]]"),
        None => format!("[{section}]"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misplaced_keys_find_their_section() {
        assert_eq!(home_of("mu_s").as_deref(), Some("[contact]"));
        assert_eq!(home_of("observer_pole").as_deref(), Some("[[estimator]]"));
        assert_eq!(home_of("humidity"), None);
    }
}

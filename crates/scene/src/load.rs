//! The keys of a scene file, those of `[sensors]`, `[model_error]`, `[engine]` and `[record]` among
//! them; from a file to a [`Scene`], and back.

use crate::estimators::Estimators;
use crate::model_error::ModelError;
use crate::scene::{Scene, SensorChoice};
use crate::terrain::Terrain;
use crate::values::{LONGEST_RUN, MEASURED};
use crate::{checks, contact, drive, estimators, robot};
use robhaz_keys::prelude::*;
use robhaz_sim::sensors::{Grade, ImuPlace};
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
    sensors: section(SENSORS) => self;

    /// differences between the nominal robot and the simulated one
    model_error: section(MODEL_ERROR) => self;

    /// the engine that computes the truth
    engine: section(ENGINE) => self;

    /// duration and rate of the records
    record: section(RECORD) => self;

    /// the estimators
    estimator: Estimators => estimators;
}

// A grade sets every key of the sensors and the error of the nominal damping. The keys override
// single values.
keys! {
    SENSORS: Scene;

    /// preset of all sensor errors; each key below, except rate, overrides one of them
    grade: word(&Grade::ALL, Grade::name) => sensors.grade;

    /// samples a second, a whole multiple of record.rate
    rate: number(FREQUENCY, above(0.0).at_most(1e6)) => sensors.rate;

    /// counts of the encoder in a turn of the wheel; 0 for an exact angle
    encoder_counts: number(NONE, at_least(0.0).at_most(1e12)) => sensors.spec.encoder_counts;

    /// relative error of the torque's scale, standard deviation, drawn once a run and wheel
    torque_gain: number(NONE, at_least(0.0).at_most(1.0)) => sensors.spec.torque_gain;

    /// offset of the torque, standard deviation, drawn once a run and wheel
    torque_offset: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_offset;

    /// white noise of the torque, standard deviation of a sample
    torque_noise: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_noise;

    /// step in which the motor current is read, as a torque at the wheel; 0 for none
    torque_step: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_step;

    /// Coulomb friction in the reading alone, which shows torque + F sign(speed); it does not act
    /// on the robot
    torque_friction: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_friction;

    /// where inclinometers and gyros sit: on both links, or in the body, with an angle sensor in
    /// pin Q; each reading of a link is then one of the body less angles of the linkage
    imu: word(&ImuPlace::ALL, ImuPlace::name) => sensors.spec.imu;

    /// with imu = "body": white noise of the angle of pin Q, standard deviation of a sample
    pin_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.pin_noise;

    /// with imu = "body": bias of the angle of pin Q, standard deviation, drawn once a run
    pin_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.pin_bias;

    /// white noise of the inclinometers, standard deviation of a sample
    inclination_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.inclination_noise;

    /// bias of the inclinometers, standard deviation, drawn once a run and link
    inclination_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.inclination_bias;

    /// time constant of the inclinometers' low pass
    inclination_lag: number(TIME, at_least(0.0).at_most(1e3)) => sensors.spec.inclination_lag;

    /// what the inclinometers measure: the direction of gravity, or of the specific force, which
    /// includes the link's acceleration
    inclination_measures: MEASURED => sensors.spec.specific_force;

    /// white noise of the gyros, standard deviation of a sample
    rate_noise: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => sensors.spec.rate_noise;

    /// bias of the gyros at the start, standard deviation, drawn once a run and link
    rate_bias: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => sensors.spec.rate_bias;

    /// random walk of the gyros' bias: its standard deviation after one second
    rate_walk: number(RATE_WALK, at_least(0.0).at_most(1e2)) => sensors.spec.rate_walk;

    /// relative error of the gyros' scale, standard deviation, drawn once a run and link
    rate_scale: number(NONE, at_least(0.0).at_most(1.0)) => sensors.spec.rate_scale;

    /// RMS error of the contact angles given to the estimators
    contact_angle_error: number(ANGLE, at_least(0.0).at_most(1.0))
        => sensors.spec.contact_angle_error;

    /// correlation time of that error; 0 for white noise
    contact_angle_time: number(TIME, at_least(0.0).at_most(1e6)) => sensors.spec.contact_angle_time;

    /// standard deviation of the sampling time about its time stamp; at most 0.3 of the sampling
    /// period
    jitter: number(TIME, at_least(0.0).at_most(1.0)) => sensors.spec.jitter;

    /// share of the readings of each channel that are lost
    dropped: number(NONE, at_least(0.0).below(1.0)) => sensors.spec.dropped;
}

keys! {
    MODEL_ERROR: Scene;

    /// distance by which the body's centre of mass is moved in a random direction
    body_cg: number(LENGTH, at_least(0.0).at_most(1.0)) => model_error.body_cg;

    /// relative error of the masses of links 1 to 3, standard deviation; their inertias change in
    /// proportion
    link_masses: number(NONE, at_least(0.0).at_most(1.0)) => model_error.link_masses;

    /// distance by which each pin is moved, each in its own random direction
    pins: number(LENGTH, at_least(0.0).at_most(1.0)) => model_error.pins;

    /// relative error of the nominal damping B: with 0.1 it is 10 % too high; 0.1 with
    /// sensors.grade typical and poor
    viscous_damping: number(NONE, at_least(-1.0).at_most(10.0)) => model_error.viscous_damping;

    /// relative error of J_wheel
    wheel_inertia: number(NONE, above(-1.0).at_most(10.0)) => model_error.wheel_inertia;

    /// relative error of J_rotor
    rotor_inertia: number(NONE, above(-1.0).at_most(10.0)) => model_error.rotor_inertia;

    /// relative error of the wheels' radius
    wheel_radius: number(NONE, above(-1.0).at_most(10.0)) => model_error.wheel_radius;

    /// standard deviation of scales on which the simulated robot is weighed in six postures, which
    /// corrects the nominal one (weighing.md); 0: not weighed
    scales: number(FORCE, at_least(0.0).at_most(1e3)) => model_error.scales;
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

/// Where an override changes a part of a robot or of the estimators, the named or default one is
/// written out first.
const OVERRIDES: Overrides = Overrides {
    example: "drive.kp=2 or estimator.0.observer_pole=30",
    expand: |reader, path, present, origin| {
        let mut parts = [&robot::GEOMETRY_PART, &robot::MASS_PART].into_iter();
        match (parts.find(|part| part.path == path), present) {
            (Some(part), present) => part.written_out(reader, present.as_ref(), origin),
            (None, Some(present)) => Some(present),
            (None, None) if path == estimators::PATH => Some(estimators::default_node(origin)),
            (None, None) => Some(Node::new(origin, Value::Table(Vec::new()))),
        }
    },
};

impl Scene {
    /// Reads a scene file; `overrides` are texts `key=value` that take precedence over the file,
    /// later ones over earlier ones.
    ///
    /// # Errors
    /// [`FileError`] with all problems of the file, of files that it names, and of the overrides.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, FileError> {
        let (text, shown, folder) = Reader::load(path, "a scene file in TOML, UTF-8")?;
        Self::parse(&text, &shown, folder, overrides)
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
    ) -> Result<Self, FileError> {
        let reader = Reader::new(base_dir.to_owned(), home_of);
        reader.read(source_name, text, |reader, mut root| {
            for text in overrides {
                OVERRIDES.apply(reader, &mut root, text);
            }
            drop_keys_of_other_grades(&mut root);
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

    /// The files of the scene, each with its name: [`Self::to_toml`] as `scene.toml`, and the copies
    /// of its tracks.
    pub fn files(&self, version: &str) -> Vec<(String, Vec<u8>)> {
        let tracks = self.terrain.tracks.iter();
        let tracks = tracks.map(|track| (track.file_name(), track.bytes.to_vec()));
        let scene = ("scene.toml".to_owned(), self.to_toml(version).into());
        std::iter::once(scene).chain(tracks).collect()
    }
}

fn read(reader: &mut Reader, root: &Node, source_name: &str) -> Scene {
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let grade = chosen_grade(root);
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

/// The chosen grade. It is needed before all other keys, which override its values. An unknown word
/// is refused when the section is read.
fn chosen_grade(root: &Node) -> Grade {
    let name = root.find("sensors.grade").and_then(Node::as_text);
    let grade = Grade::ALL.into_iter().find(|g| Some(g.name()) == name);
    grade.unwrap_or(Grade::Ideal)
}

/// Removes the file's values of keys that a grade sets, where an override chooses the grade.
fn drop_keys_of_other_grades(root: &mut Node) {
    const GRADE: &str = "sensors.grade";
    let is_kept = |key: &str| ["grade", "rate"].contains(&key);
    let is_set = |key: &str| !is_kept(key) && key::names(SENSORS).contains(&key);
    root.drop_keys(GRADE, "sensors", is_set);
    root.drop_keys(GRADE, "model_error", |key| key == "viscous_damping");
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

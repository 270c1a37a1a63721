//! The keys of a log description; from a file to a [`LogChoice`], and back.

use super::choice::{LogChoice, LogSides, STATED};
use super::frame::READINGS;
use super::mapping::{self, CHANNELS, StatedAt};
use super::reading::{IMUS, READING};
use crate::estimators::Estimators;
use crate::robot::{ROBOT, RobotChoice};
use crate::values::{Covariance, MEASURED};
use robhaz_estimator::NoiseBudget;
use robhaz_estimator::statics::LoadCovariance;
use robhaz_keys::prelude::*;
use robhaz_masses::{Tolerances, WeighError};
use robhaz_model::Units;
use std::path::Path;

keys! {
    /// All keys, in the order of a resolved description.
    pub(crate) LOG: LogChoice;

    /// name of the log
    name: Maybe(NAME) => name;

    /// what the log is of: one side of a robot with two, a robot in the plane, such as a simulated
    /// one or a test rig, or both sides; by default both where it has readings of both
    sides: word(&LogSides::ALL, LogSides::name) => sides;

    /// geometry and masses
    robot: ROBOT => robot;

    /// eq. (2)
    drive: section(DRIVE) => self;

    /// wheel and ground
    contact: section(CONTACT) => self;

    /// standard deviations of all sensor errors, from data sheets
    budget: section(BUDGET) => self;

    /// what counts
    record: section(RECORD) => self;

    /// the estimators
    estimator: Estimators => estimators;

    /// name of the channel whose rows are the frames
    time_base ("the first"): Maybe(text("a text")) => (|l| &mut l.mapped().time_base);

    /// readings that the log does not have
    missing: list(
        word(READINGS, |name| name), "an array of names of readings", [0, READINGS.len()], || "",
    ) => (|l| &mut l.mapped().missing);

    /// tables or topics with a clock of their own
    channel: CHANNELS => (|l| &mut l.mapped().channels);

    /// columns of single readings
    reading: READING => (|l| &mut l.mapped().readings);

    /// columns of inertial measurement units
    imu: IMUS => (|l| &mut l.mapped().imus);
}

keys! {
    DRIVE: LogChoice;

    /// nominal damping B of the wheel module, at the wheel; unless stated that of robot A for a robot of this weight and size
    viscous_damping: number(ROTARY_DAMPING, at_least(0.0).at_most(1e3)) => viscous_damping;

    /// efficiency of the gears, of torques that are read before them (the motor's times the gear ratio):
    /// a driven wheel gets this part, a braking one gives the torque over this part; 1 of torques behind them
    gear_efficiency: number(NONE, at_least(0.1).at_most(1.0)) => gear_efficiency;
}

keys! {
    CONTACT: LogChoice;

    /// compression of wheel and ground at the mean wheel load: a wheel rolls with its radius less
    /// this
    compression: number(LENGTH, at_least(0.0).at_most(0.1)) => compression;
}

keys! {
    RECORD: LogChoice;

    /// errors and means count from this time on, after rest and start; 0 for a log that is shorter
    compare_from: number(TIME, at_least(0.0).at_most(1e6)) => compare_from;
}

keys! {
    BUDGET: LogChoice;

    /// counts of the encoder in a turn of the wheel; 0 for an exact angle; fewer where the log shows so
    encoder_counts: number(NONE, at_least(0.0).at_most(1e12)) => budget.encoder_counts;

    /// error of the time stamps
    jitter: number(TIME, at_least(0.0).at_most(1.0)) => budget.jitter;

    /// white noise of the torque, of a sample; `estimate` takes what a rounding leaves where that is more
    torque_noise ("what the log shows; where it shows none, 0.1 of robot A, else in proportion to weight and wheel radius"):
        number(TORQUE, at_least(0.0).at_most(1e3)) => budget.torque_noise;

    /// constant offset of the torque
    torque_offset ("0.1 of robot A, else in proportion to weight and wheel radius"):
        number(TORQUE, at_least(0.0).at_most(1e3)) => budget.torque_offset;

    /// relative error of the torque's scale
    torque_gain: number(NONE, at_least(0.0).at_most(1.0)) => budget.torque_gain;

    /// white noise of the angle of pin Q, of logs with pin_angle; `estimate` takes what the log shows
    /// where that is more
    pin_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => (|l| &mut l.pin[0]);

    /// constant error of that angle
    pin_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => (|l| &mut l.pin[1]);

    /// dry friction in the gears that the motor torque does not show, at the wheel
    gear_friction ("0.3 of robot A, else in proportion to weight and wheel radius"):
        number(TORQUE, at_least(0.0).at_most(1e3)) => budget.gear_friction;

    /// coefficient of the rolling resistance: its standard deviation about 0; 0.1 on loose soil
    rolling_resistance: number(NONE, at_least(0.0).at_most(1.0)) => budget.rolling_resistance;

    /// moment that a pin of the linkage transmits beside its force: friction of bushings, cables across it;
    /// ball bearings have none
    pin_moment: number(TORQUE, at_least(0.0).at_most(1e4)) => budget.pin_moment;

    /// white noise of the inclinometers, of a sample
    inclination_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.inclination_noise;

    /// constant error of the inclinometers
    inclination_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.inclination_bias;

    /// what the inclinometers measure: the direction of gravity, or of the specific force, which
    /// includes the link's acceleration
    inclination_measures: MEASURED => budget.specific_force;

    /// time constant of the inclinometers' low pass, 1/(2 pi bandwidth)
    inclination_lag: number(TIME, at_least(0.0).at_most(1e3)) => budget.inclination_lag;

    /// distance of an inclinometer from the centre of mass of its link
    inclination_place: number(LENGTH, at_least(0.0).at_most(10.0)) => budget.inclination_place;

    /// white noise of the gyros, of a sample
    rate_noise: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => budget.rate_noise;

    /// bias of the gyros at the start
    rate_bias: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => budget.rate_bias;

    /// random walk of the gyros' bias: its standard deviation after one second
    rate_walk: number(RATE_WALK, at_least(0.0).at_most(1e2)) => budget.rate_walk;

    /// error of the contact angles in the log
    contact_angle_error: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.contact_angle;

    /// correlation time of that error; 0 for white noise
    contact_angle_time: number(TIME, at_least(0.0).at_most(1e6)) => budget.contact_angle_time;

    /// error of the position of the body's nominal centre of mass; unless this, link_masses or load_covariance is stated, the robot counts as built to usual tolerances
    body_cg: number(LENGTH, at_least(0.0).at_most(1.0)) => budget.body_cg;

    /// relative error of the masses of links 1 to 3
    link_masses: number(NONE, at_least(0.0).at_most(1.0)) => budget.link_mass;

    /// mass that the body may carry or lack beside the robot's own: cargo, what an arm holds; of a log of one
    /// side, that side's part
    payload: number(MASS, at_least(0.0).at_most(1e5)) => budget.payload;

    /// covariance of masses, centres of mass and pins of a robot that was weighed, as
    /// `robhaz weigh` writes it (weighing.md); body_cg and link_masses are 0 then
    load_covariance: Covariance => budget.load_covariance;

    /// relative error of each wheel's rolling radius
    wheel_radius ("0.005 of a robot whose errors are not stated, else 0"):
        number(NONE, at_least(0.0).at_most(0.5)) => budget.wheel_radius;

    /// angle by which wheels are not parallel, of logs of both sides: toe, and play of the axles. It makes
    /// axial forces
    toe: number(ANGLE, at_least(0.0).at_most(0.2)) => budget.toe;

    /// error of each steering angle, of logs of both sides
    steering: number(ANGLE, at_least(0.0).at_most(0.2)) => budget.steering;

    /// slope across the way, of logs with sides = "one of two": it moves the weight from one side
    /// to the other
    cross_slope: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.cross_slope;
}

/// The rows of the tables of keys in `docs/logs.md`. The text explains the keys above all tables;
/// those of `[robot]` and `[[estimator]]` are as in a scene.
pub fn log_reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    key::rows(&mut rows, LOG, "", &mut LogChoice::default());
    let as_in_a_scene = |key: &str| key.starts_with("robot.") || key.starts_with("estimator");
    rows.retain(|row| row.key.contains('.') && !as_in_a_scene(&row.key));
    rows
}

impl LogChoice {
    /// Reads a log description. What it does not state is as in `base`.
    ///
    /// # Errors
    /// [`FileError`] with all problems of the file and of robot files that it names.
    pub fn load(path: &Path, base: Self) -> Result<Self, FileError> {
        let (text, shown, folder) = Reader::load(path, "a log description in TOML, UTF-8")?;
        Self::parse(&text, &shown, folder, base)
    }

    /// Reads the text of a log description. `source_name` is the file's name in messages; paths of
    /// robot files are relative to `base_dir`.
    ///
    /// # Errors
    /// As [`LogChoice::load`].
    pub fn parse(
        text: &str,
        source_name: &str,
        base_dir: &Path,
        base: Self,
    ) -> Result<Self, FileError> {
        // Keys of one section do not exist in another.
        let reader = Reader::new(base_dir.to_owned(), |_| None);
        reader.read(source_name, text, |reader, root| read(reader, &root, base))
    }

    /// The choice after the user's descriptions of the sensors and of the robot. Where neither
    /// states how exact the robot's masses, centres of mass and pins are, they count as people
    /// build them ([`Tolerances::built`]), and the text says so.
    ///
    /// # Errors
    /// [`FileError`] with all problems of a file; a robot that cannot stand in the postures of a
    /// drive.
    pub fn described(
        self,
        sensors: Option<&Path>,
        robot: Option<&Path>,
    ) -> Result<(Self, Option<String>), FileError> {
        let mut choice = self;
        // How exact the robot of a folder is says nothing of another one.
        let is_kept = |key: &&str| robot.is_none() || !OF_ROBOT.contains(key);
        choice.stated.retain(is_kept);
        if let Some(path) = sensors {
            choice = Self::load(path, choice)?;
        }
        if let Some(path) = robot {
            choice.take_robot(path)?;
        }
        let robot = &choice.robot.robot;
        let (usual, budget) = (NoiseBudget::typical_for(robot), &mut choice.budget);
        let lacks = |key: &str| !choice.stated.contains(key);
        if lacks("budget.gear_friction") {
            budget.gear_friction = usual.gear_friction;
        }
        if lacks("budget.torque_offset") {
            budget.torque_offset = usual.torque_offset;
        }
        if lacks("budget.torque_noise") {
            budget.torque_noise = usual.torque_noise;
        }
        if lacks("drive.viscous_damping") {
            // That of robot A, for a robot of this weight and size.
            let units = Units::of(robot);
            choice.viscous_damping = Self::default().viscous_damping * units.torque() * units.time;
        }
        if OF_ROBOT.iter().any(|key| choice.states(key)) {
            return Ok((choice, None));
        }
        let built = Tolerances::built(&choice.robot.robot);
        let loads = built.loads(&choice.robot.robot);
        let refused = |e: WeighError| FileError::unread("[robot]", e.to_string());
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(loads.map_err(refused)?);
        if !choice.stated.contains("budget.wheel_radius") {
            budget.wheel_radius = Tolerances::RADIUS;
        }
        let millimetres = |length: f64| (1e4 * length).round() / 10.0;
        let notice = format!(
            "budget.body_cg and budget.link_masses are not stated, so the robot counts as built to usual tolerances: its mass to {:.0} %, those of its parts to {:.0} %, centres of mass to {} mm, pins to {} mm, wheels to {} % of their radius; state them, or weigh the robot (docs/weighing.md)",
            100.0 * Tolerances::TOTAL,
            100.0 * built.mass,
            millimetres(built.centre),
            millimetres(built.pin),
            100.0 * Tolerances::RADIUS,
        );
        Ok((choice, Some(notice)))
    }

    /// Takes the robot of a file with the section `[robot]`, such as a scene or a weighed robot,
    /// and, where the file states them, the keys of `[budget]` that belong to the robot: `body_cg`,
    /// `link_masses`, `load_covariance`; and `drive.viscous_damping`, which the description may
    /// state, too. Other sections and keys have no effect.
    ///
    /// # Errors
    /// [`FileError`] with all problems of these keys, or a file without the section.
    pub fn take_robot(&mut self, path: &Path) -> Result<(), FileError> {
        let mut robot = RobotChoice::default();
        read_robot(path, |reader, root| {
            robot = RobotChoice::of_section(reader, root);
            let entries = |section: &str| root.get(section).and_then(Node::entries);
            for entry in entries("budget").unwrap_or_default() {
                if let Some(key) = of_robot(&entry.key) {
                    self.stated.insert(key);
                    reader.entry(BUDGET, entry, "budget", self);
                }
            }
            let mut drive = entries("drive").unwrap_or_default().iter();
            if let Some(entry) = drive.find(|entry| entry.key == "viscous_damping")
                && self.stated.insert("drive.viscous_damping")
            {
                reader.entry(DRIVE, entry, "drive", self);
            }
        })?;
        self.robot = robot;
        self.stated.insert("robot");
        Ok(())
    }

    /// The description as a file that reads back as this one. `version` names the program that
    /// writes it.
    pub fn to_toml(&self, version: &str) -> String {
        let comment = "What was known of a log, with every choice written out. SI units.";
        let mut written = self.clone();
        written.mapping = None;
        Out::file(comment, version, LOG, &mut written)
    }
}

/// What a file of a robot is.
const ROBOT_FILE: &str = "a file in TOML, UTF-8, with the section [robot] of a scene, such as the lines `[robot]`, `geometry = \"A\"` (or a file with a geometry), `mass = \"caption\"`";
/// Reads a file of a robot.
fn read_robot<T>(path: &Path, read: impl FnOnce(&mut Reader, &Node) -> T) -> Result<T, FileError> {
    let (text, shown, folder) = Reader::load(path, ROBOT_FILE)?;
    let reader = Reader::new(folder.to_owned(), |_| None);
    reader.read(&shown, &text, |reader, root| read(reader, &root))
}

/// The keys of `[budget]` that belong to the robot, not to its sensors.
const OF_ROBOT: [&str; 3] = [
    "budget.body_cg",
    "budget.link_masses",
    "budget.load_covariance",
];

/// That of this name in `[budget]`.
fn of_robot(name: &str) -> Option<&'static str> {
    let mut keys = OF_ROBOT.into_iter();
    keys.find(|key| key.strip_prefix("budget.") == Some(name))
}

impl RobotChoice {
    /// The robot of a file with the section `[robot]`, such as a scene. Other sections have no
    /// effect.
    ///
    /// # Errors
    /// [`FileError`] with all problems of `[robot]`, or a file without that section.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        read_robot(path, Self::of_section)
    }

    fn of_section(reader: &mut Reader, root: &Node) -> Self {
        let mut robot = Self::default();
        match root.get("robot") {
            Some(section) => ROBOT.read(reader, section, "robot", &mut robot),
            None => {
                let message = format!("has no section [robot]; allowed: {ROBOT_FILE}");
                reader.push(Problem::unread(root.origin.source.text.name(), message));
            }
        }
        robot
    }

    /// A weighed robot as a file: `[robot]`, and the keys of `[budget]` that go with it. `version`
    /// names the program that writes it.
    pub fn weighed_to_toml(&self, covariance: &LoadCovariance, version: &str) -> String {
        let comment =
            "A weighed robot, and how exact it is. SI units. For `robhaz estimate --robot`.";
        let mut robot = self.clone();
        let mut out = Out(Out::file(comment, version, &[], &mut robot));
        let about = "geometry and masses";
        ROBOT.tables(&mut out, "[robot]", "robot", about, &mut robot);
        let mut choice = LogChoice::default();
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(*covariance);
        out.head("[budget]", "errors of the weighing");
        let own = BUDGET.iter().filter(|key| of_robot(key.name).is_some());
        out.fields(own, &mut choice);
        out.0
    }
}

fn read(reader: &mut Reader, root: &Node, base: LogChoice) -> LogChoice {
    let has = |key: &str| root.find(key).is_some();
    let maps = ["time_base", "missing", "channel", "reading", "imu"];
    let maps = maps.into_iter().any(has);
    let mut choice = base;
    if maps {
        choice.mapping = None;
    }
    choice
        .stated
        .extend(STATED.split(' ').filter(|key| has(key)));
    if has("robot") {
        choice.robot = RobotChoice::default();
    }
    reader.table(LOG, root, "", &mut choice);
    if has("drive.viscous_damping") && !has("estimator") {
        choice.estimators.iter_mut().for_each(|e| e.damping = None);
    }
    if let Some(sides) = root.get("sides") {
        choice.sides_at = StatedAt::of(sides);
    }
    let tables = root
        .get("channel")
        .and_then(Node::array)
        .unwrap_or_default();
    if let Some(mapping) = &mut choice.mapping {
        for (channel, node) in mapping.channels.iter_mut().zip(tables) {
            channel.table_at = node.get("table").map(StatedAt::of).unwrap_or_default();
        }
    }
    if let (true, Some(mapping)) = (maps, &choice.mapping) {
        mapping::check(reader, root, mapping);
    }
    choice
}

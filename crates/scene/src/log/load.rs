//! From a file to a [`LogChoice`], and back.

use super::choice::LogChoice;
use super::keys::{BUDGET, DRIVE, LOG};
use super::mapping;
use crate::error::{Problem, SceneError};
use crate::form::{Form, Out};
use crate::key::keys;
use crate::reader::Reader;
use crate::robot::{ROBOT, RobotChoice};
use crate::source::Node;
use robhaz_estimator::NoiseBudget;
use robhaz_estimator::statics::LoadCovariance;
use robhaz_masses::{Tolerances, WeighError};
use robhaz_model::Units;
use std::path::Path;

impl LogChoice {
    /// Reads a log description. What it does not state is as in `base`.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file and of robot files that it names.
    pub fn load(path: &Path, base: Self) -> Result<Self, SceneError> {
        let allowed = "a log description in TOML, UTF-8";
        Reader::load(path, allowed, |text, shown, folder| {
            Self::parse(text, shown, folder, base)
        })
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
    ) -> Result<Self, SceneError> {
        // Keys of one section do not exist in another.
        let reader = Reader::new(base_dir.to_owned(), |_| None);
        reader.read(source_name, text, |reader, root| read(reader, &root, base))
    }

    /// The choice after the user's descriptions of the sensors and of the robot. Where neither
    /// states how exact the robot's masses, centres of mass and pins are, they count as people
    /// build them ([`Tolerances::built`]), and the text says so.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of a file; a robot that cannot stand in the postures of a
    /// drive.
    pub fn described(
        self,
        sensors: Option<&Path>,
        robot: Option<&Path>,
    ) -> Result<(Self, Option<String>), SceneError> {
        let mut choice = self;
        // How exact the robot of a folder is says nothing of another one.
        choice.states_loads &= robot.is_none();
        if let Some(path) = sensors {
            choice = Self::load(path, choice)?;
        }
        if let Some(path) = robot {
            choice.take_robot(path)?;
        }
        let robot = &choice.robot.robot;
        if !choice.states_friction {
            choice.budget.gear_friction = NoiseBudget::usual_gear_friction(robot);
        }
        if !choice.states_damping {
            // That of robot A, for a robot of this weight and size.
            let units = Units::of(robot);
            choice.viscous_damping = Self::default().viscous_damping * units.torque() * units.time;
        }
        if choice.states_loads {
            return Ok((choice, None));
        }
        let built = Tolerances::built(&choice.robot.robot);
        let loads = built.loads(&choice.robot.robot);
        let refused = |e: WeighError| SceneError::unread("[robot]", e.to_string());
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(loads.map_err(refused)?);
        if budget.payload <= 0.0 {
            budget.payload = Tolerances::PAYLOAD;
        }
        let millimetres = |length: f64| (1e4 * length).round() / 10.0;
        let notice = format!(
            "budget.body_cg and budget.link_masses are not stated, so the robot counts as built to usual tolerances: masses to {:.0} %, centres of mass to {} mm, pins to {} mm, an unstated payload of {:.1} % of its mass; state them, or weigh the robot (docs/weighing.md)",
            100.0 * built.mass,
            millimetres(built.centre),
            millimetres(built.pin),
            100.0 * budget.payload,
        );
        Ok((choice, Some(notice)))
    }

    /// Takes the robot of a file with the section `[robot]`, such as a scene or a weighed robot,
    /// and, where the file states them, the keys of `[budget]` that belong to the robot: `body_cg`,
    /// `link_masses`, `load_covariance`; and `drive.viscous_damping`, which the description may
    /// state, too. Other sections and keys have no effect.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of these keys, or a file without the section.
    pub fn take_robot(&mut self, path: &Path) -> Result<(), SceneError> {
        self.robot = RobotChoice::load(path)?;
        self.states_robot = true;
        Reader::load(path, ROBOT_FILE, |text, shown, folder| {
            let reader = Reader::new(folder.to_owned(), |_| None);
            reader.read(shown, text, |reader, root| {
                let budget = root.get("budget").and_then(Node::entries);
                for entry in budget.unwrap_or_default() {
                    if ROBOTS_BUDGET.contains(&entry.key.as_str()) {
                        self.states_loads = true;
                        reader.entry(BUDGET, entry, "budget", self);
                    }
                }
                let drive = root.get("drive").and_then(Node::entries);
                let mut drive = drive.unwrap_or_default().iter();
                if !self.states_damping
                    && let Some(entry) = drive.find(|entry| entry.key == "viscous_damping")
                {
                    self.states_damping = true;
                    reader.entry(DRIVE, entry, "drive", self);
                }
            })
        })
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
/// The keys of `[budget]` that belong to the robot, not to its sensors.
const ROBOTS_BUDGET: [&str; 3] = ["body_cg", "link_masses", "load_covariance"];

impl RobotChoice {
    /// The robot of a file with the section `[robot]`, such as a scene. Other sections have no
    /// effect.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of `[robot]`, or a file without that section.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Reader::load(path, ROBOT_FILE, |text, shown, folder| {
            let reader = Reader::new(folder.to_owned(), |_| None);
            reader.read(shown, text, |reader, root| {
                let mut robot = Self::default();
                match root.get("robot") {
                    Some(section) => ROBOT.read(reader, section, "robot", &mut robot),
                    None => {
                        let message = format!("has no section [robot]; allowed: {ROBOT_FILE}");
                        reader.push(Problem::unread(shown, message));
                    }
                }
                robot
            })
        })
    }

    /// A weighed robot as a file: `[robot]`, and the keys of `[budget]` that go with it. `version`
    /// names the program that writes it.
    pub fn weighed_to_toml(&self, covariance: &LoadCovariance, version: &str) -> String {
        let comment =
            "A weighed robot, and how exact it is. SI units. For `robhaz estimate --robot`.";
        let mut out = Out(Out::file(comment, version, WEIGHED, &mut self.clone()));
        let mut choice = LogChoice::default();
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(*covariance);
        out.head("[budget]", "errors of the weighing");
        let of_robot = BUDGET
            .iter()
            .filter(|key| ROBOTS_BUDGET.contains(&key.name));
        out.fields(of_robot, &mut choice);
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
    choice.states_loads |= ROBOTS_BUDGET
        .iter()
        .any(|key| has(&format!("budget.{key}")));
    choice.states_friction |= has("budget.gear_friction");
    choice.states_damping |= has("drive.viscous_damping");
    if has("robot") {
        (choice.robot, choice.states_robot) = (RobotChoice::default(), true);
    }
    reader.table(LOG, root, "", &mut choice);
    if has("drive.viscous_damping") && !has("estimator") {
        choice.estimators.iter_mut().for_each(|e| e.damping = None);
    }
    if let (true, Some(mapping)) = (maps, &choice.mapping) {
        mapping::check(reader, root, mapping);
    }
    choice
}

keys! {
    /// What a weighed robot has in its file beside the budget.
    WEIGHED: RobotChoice;

    /// geometry and masses
    robot: ROBOT => self;
}

//! From a file to a [`LogChoice`].

use super::choice::{LogChoice, LogEstimator};
use super::keys::SECTIONS;
use super::mapping;
use crate::error::SceneError;
use crate::reader::Reader;
use crate::robot::RobotChoice;
use crate::sections::IGNORED;
use crate::source::{Node, Source, Value};
use crate::{estimators, file, name, robot};
use robhaz_weigh::{Tolerances, WeighError};
use std::path::{Path, PathBuf};

/// Key of an estimator's own damping.
const DAMPING: &str = "viscous_damping";

impl LogChoice {
    /// Reads a log description. What it does not state is as in `base`.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file and of robot files that it names.
    pub fn load(path: &Path, base: Self) -> Result<Self, SceneError> {
        let shown = path.display().to_string();
        let text = read_text(path, "a log description in TOML, UTF-8")?;
        let base_dir = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &shown, base_dir, base)
    }

    /// Reads the text of a log description. `source_name` is the file's name in messages; paths of robot files are
    /// relative to `base_dir`.
    ///
    /// # Errors
    /// As [`LogChoice::load`].
    pub fn parse(
        text: &str,
        source_name: &str,
        base_dir: &Path,
        base: Self,
    ) -> Result<Self, SceneError> {
        file::check_toml(text).map_err(|error| SceneError::unread(source_name, error))?;
        // Keys of one section do not exist in another.
        let mut reader = Reader::new(base_dir.to_owned(), |_| None);
        let root = reader.document(&Source::file(source_name, text));
        let choice = read(&mut reader, &root, base);
        reader.finish(choice)
    }
}

impl LogChoice {
    /// The choice after the user's descriptions of the sensors and of the robot. Where neither states how exact the robot's
    /// masses, centres of mass and pins are, they count as people build them ([`Tolerances::BUILT`]), and the text says so.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of a file; a robot that cannot stand in the postures of a drive.
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
        if choice.states_loads {
            return Ok((choice, None));
        }
        let loads = Tolerances::BUILT.loads(&choice.robot.robot);
        let refused = |e: WeighError| SceneError::unread("[robot]", e.to_string());
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(loads.map_err(refused)?);
        let Tolerances { mass, centre, pin } = Tolerances::BUILT;
        let notice = format!(
            "how exact the robot's description is is not stated, so it counts as people build them: masses to {:.0} %, centres of mass to {:.0} mm, pins to {:.0} mm; state budget.body_cg and budget.link_masses, or weigh the robot (docs/weighing.md)",
            100.0 * mass,
            1e3 * centre,
            1e3 * pin,
        );
        Ok((choice, Some(notice)))
    }

    /// Takes the robot of a file with the section `[robot]`, such as a scene or a weighed robot, and, where the file states
    /// them, the keys of `[budget]` that belong to the robot: `body_cg`, `link_masses`, `load_covariance`. Other sections
    /// and keys have no effect.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of these keys, or a file without the section.
    pub fn take_robot(&mut self, path: &Path) -> Result<(), SceneError> {
        self.robot = RobotChoice::load(path)?;
        self.states_robot = true;
        let text = read_text(path, ROBOT_FILE)?;
        let mut reader = Reader::new(PathBuf::new(), |_| None);
        let root = reader.document(&Source::file(&path.display().to_string(), &text));
        let entries = root.get("budget").and_then(Node::entries);
        let keys = SECTIONS.iter().find(|s| s.name == "budget");
        if let (Some(entries), Some(section)) = (entries, keys) {
            for entry in entries {
                if ROBOTS_BUDGET.contains(&entry.key.as_str()) {
                    self.states_loads = true;
                    reader.entry(section.keys, entry, section.name, self);
                }
            }
        }
        reader.finish(())
    }
}

/// What a file of a robot is.
const ROBOT_FILE: &str = "a file in TOML, UTF-8, with the section [robot] of a scene, such as the lines `[robot]`, `geometry = \"A\"` (or a file with a geometry), `mass = \"caption\"`";
/// The keys of `[budget]` that belong to the robot, not to its sensors.
pub(super) const ROBOTS_BUDGET: [&str; 3] = ["body_cg", "link_masses", "load_covariance"];

impl RobotChoice {
    /// The robot of a file with the section `[robot]`, such as a scene. Other sections have no effect.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of `[robot]`, or a file without that section.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let allowed = ROBOT_FILE;
        let shown = path.display().to_string();
        let text = read_text(path, allowed)?;
        let base_dir = path.parent().unwrap_or(Path::new(""));
        let mut reader = Reader::new(base_dir.to_owned(), |_| None);
        let root = reader.document(&Source::file(&shown, &text));
        if root.get("robot").is_none() && reader.mark() == 0 {
            let message = format!("has no section [robot]; allowed: {allowed}");
            return Err(SceneError::unread(&shown, message));
        }
        let robot = robot::read(&mut reader, &root);
        reader.finish(robot)
    }
}

fn read_text(path: &Path, allowed: &str) -> Result<String, SceneError> {
    file::read_toml(path).map_err(|error| {
        let message = format!("{error}; allowed: {allowed}");
        SceneError::unread(&path.display().to_string(), message)
    })
}

fn read(reader: &mut Reader, root: &Node, base: LogChoice) -> LogChoice {
    top_level(reader, root);
    let mut choice = base;
    let budget = root.get("budget");
    choice.states_loads |= budget.is_some_and(|b| ROBOTS_BUDGET.iter().any(|k| b.get(k).is_some()));
    if let Some(node) = root.get("name") {
        choice.name = name::read(reader, node, "name");
    }
    if root.get("robot").is_some() {
        choice.robot = robot::read(reader, root);
        choice.states_robot = true;
    }
    for section in SECTIONS {
        if let Some(node) = root.get(section.name) {
            reader.table(section.keys, node, section.name, &mut choice);
        }
    }
    if root.get(estimators::PATH).is_some() {
        choice.estimators = read_estimators(reader, root, choice.viscous_damping);
    } else if root.find("drive.viscous_damping").is_some() {
        let damping = choice.viscous_damping;
        let listed = choice.estimators.iter_mut();
        listed.for_each(|e| e.viscous_damping = damping);
    }
    if let Some(mapping) = mapping::read(reader, root) {
        choice.mapping = Some(mapping);
    }
    choice
}

/// The list of estimators; those without a damping of their own get `damping`, N m s.
fn read_estimators(reader: &mut Reader, root: &Node, damping: f64) -> Vec<LogEstimator> {
    let items = match root.get(estimators::PATH).map(|n| &n.value) {
        Some(Value::Array(items)) => items.as_slice(),
        _ => &[],
    };
    let choices = estimators::read(reader, root).into_iter().enumerate();
    let of_choice = |(i, choice): (usize, estimators::EstimatorChoice)| {
        let has_own = items.get(i).is_some_and(|item| item.get(DAMPING).is_some());
        LogEstimator {
            viscous_damping: match has_own {
                true => choice.settings.viscous_damping,
                false => damping,
            },
            choice,
        }
    };
    choices.map(of_choice).collect()
}

/// Adds a problem for every entry that is neither a top-level key nor a section.
fn top_level(reader: &mut Reader, root: &Node) {
    let own = ["name", "robot", estimators::PATH];
    let of_mapping = [
        mapping::TIME_BASE,
        mapping::MISSING,
        mapping::CHANNEL,
        mapping::READING,
        mapping::IMU,
    ];
    let allowed: Vec<&str> = own
        .into_iter()
        .chain(of_mapping)
        .chain(SECTIONS.iter().map(|s| s.name))
        .collect();
    for entry in reader.entries(root, "") {
        if entry.key != IGNORED && !allowed.contains(&entry.key.as_str()) {
            reader.unknown(entry, "", &allowed);
        }
    }
}

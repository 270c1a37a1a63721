//! A study file with every choice made, and the scene of one run.

use crate::load::reference;
use crate::scene::Scene;
use robhaz_keys::prelude::*;
use robhaz_model::named;
use std::fmt;
use std::path::{Path, PathBuf};

/// What is varied in which scene: the content of a study file.
#[derive(Clone, Debug)]
pub struct StudyChoice {
    /// `name` of the file, else the file's stem: the name of the default output folder.
    pub name: String,
    /// The base scene, and where it was written.
    pub(super) base: (PathBuf, Origin),
    /// Overrides `key=value` of the base scene in every run, and where each was written.
    pub(super) overrides: Vec<(String, Origin)>,
    /// The axes in the file's order.
    pub axes: Vec<Axis>,
    /// How axes with a distribution are drawn; `None` without such an axis.
    pub draws: Option<Draws>,
    /// Runs that keep their full tables.
    pub tables: StudyTables,
    /// Text of the file.
    pub text: String,
}

impl StudyChoice {
    /// The base scene, relative to the folder of the study file unless absolute.
    pub fn scene(&self) -> &Path {
        &self.base.0
    }
}

/// How the axes with a distribution are drawn. Together they are one list of `count` samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Number of samples.
    pub count: u64,
    /// Seed of the draws.
    pub seed: u64,
    /// How the samples fill the space.
    pub method: DrawMethod,
}

named! {
    /// How samples fill the space of the axes with a distribution.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum DrawMethod {
        /// Latin hypercube (McKay, Beckman and Conover 1979): each axis has one sample in each of
        /// `count` equally likely intervals.
        #[default]
        LatinHypercube = "latin-hypercube",
        /// Independent draws. The first samples stay the same when there are more.
        Random = "random",
    }
}

/// Runs that keep their full tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum StudyTables {
    /// None.
    #[default]
    None,
    /// All.
    All,
    /// Those with these indices.
    Runs(Vec<u64>),
}

impl StudyTables {
    /// Whether a run keeps its tables.
    pub fn keeps(&self, run: u64) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Runs(runs) => runs.contains(&run),
        }
    }
}

/// An axis: keys of the scene that vary together.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Dotted keys, as `--set` takes them. More than one vary together.
    pub keys: Vec<String>,
    /// Their values.
    pub values: AxisValues,
    /// Where the keys were written.
    pub(super) keys_origin: Origin,
    /// Where the values were written.
    pub(super) origin: Origin,
}

/// The values of an axis.
#[derive(Clone, Debug)]
pub enum AxisValues {
    /// One item a value; each with one value a key.
    List(Vec<AxisItem>),
    /// `count` whole numbers from `first` on.
    Whole {
        /// The first.
        first: i64,
        /// Their number, at least 1.
        count: u64,
    },
    /// Drawn: see [`Draws`].
    Drawn(Distribution),
}

/// The values of all keys of an axis at one place of its list.
#[derive(Clone, Debug)]
pub struct AxisItem {
    /// Its name in the dataset, in place of the value of the first key.
    pub name: Option<String>,
    /// One a key.
    pub values: Vec<AxisValue>,
    pub(super) origin: Origin,
}

/// The distribution of a drawn axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Uniform between two numbers.
    Uniform(f64, f64),
    /// The logarithm is uniform, between two positive numbers.
    LogUniform(f64, f64),
    /// Normal, with mean and standard deviation.
    Normal(f64, f64),
    /// Whole numbers from the first to the last, equally likely.
    Whole(i64, i64),
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisValue {
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// True or false.
    Boolean(bool),
    /// An array or a table, as TOML.
    Toml(String),
}

impl AxisValue {
    /// `None` for what no key takes.
    pub(super) fn of(node: &Node) -> Option<Self> {
        Some(match &node.value {
            Value::Integer(Some(whole), _) => Self::Whole(i64::try_from(*whole).ok()?),
            Value::Float(number) if number.is_finite() => Self::Number(*number),
            Value::Text(text) => Self::Text(text.clone()),
            Value::Boolean(value) => Self::Boolean(*value),
            Value::Array(_) | Value::Table(_) => Self::Toml(node.origin.text().to_owned()),
            Value::Integer(None, _) | Value::Float(_) | Value::Other(_) => return None,
        })
    }
}

/// As TOML, which reads back as the same value.
impl fmt::Display for AxisValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Number(number) => f.write_str(&short(*number)),
            Self::Text(text) => write!(f, "{}", toml::Value::String(text.clone())),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Toml(text) => f.write_str(text),
        }
    }
}

impl Axis {
    /// Number of values; `None` for a drawn axis.
    pub fn length(&self) -> Option<u64> {
        match &self.values {
            AxisValues::List(items) => Some(items.len() as u64),
            AxisValues::Whole { count, .. } => Some(*count),
            AxisValues::Drawn(_) => None,
        }
    }

    /// SI unit of a bare number of a key, empty where it has none or the key is unknown.
    pub fn unit(key: &str) -> &'static str {
        let step = |step: Step<'_>| match step {
            Step::Key(name) => format!(".{name}"),
            Step::Index(_) => "[]".to_owned(),
        };
        let steps = steps(key).unwrap_or_default().into_iter().map(step);
        // As in the reference: `estimator[].observer_pole`.
        let pattern = steps.collect::<String>();
        let pattern = pattern.trim_start_matches('.');
        let rows = reference();
        let row = rows.iter().find(|row| row.key == pattern);
        row.map_or("", |row| row.unit)
    }
}

/// The value of a key in one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Index of the axis.
    pub axis: usize,
    /// Index in the axis' list; 0 for a drawn axis.
    pub item: u64,
    /// Dotted key.
    pub key: String,
    /// Its value.
    pub value: AxisValue,
    /// The name of the value, which the dataset shows in its place.
    pub name: Option<String>,
}

impl Setting {
    /// The override that sets it: `key=value`.
    pub fn as_override(&self) -> String {
        format!("{}={}", self.key, self.value)
    }
}

/// The text of a study's base scene, read once for all runs.
#[derive(Clone, Debug)]
pub struct BaseScene {
    /// Text of the file.
    pub text: String,
    path: PathBuf,
}

impl BaseScene {
    /// Reads the base scene of a study file in `folder`.
    ///
    /// # Errors
    /// [`FileError`] at the study's key `scene`.
    pub fn load(study: &StudyChoice, folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(study.scene());
        let text = source::read_toml(&path).map_err(|error| {
            let shown = path.display();
            let message = format!("{shown} {error}; allowed: a scene file in TOML, UTF-8");
            Problem::at(&study.base.1, "scene", message)
        })?;
        Ok(Self { text, path })
    }

    /// The scene of a run.
    ///
    /// # Errors
    /// [`FileError`] with all problems. Those that a setting or an item of `set` causes are at
    /// their place in the study file.
    pub fn scene(&self, study: &StudyChoice, settings: &[Setting]) -> Result<Scene, FileError> {
        let of_study = study.overrides.iter().map(|(text, _)| text.clone());
        let of_run = settings.iter().map(Setting::as_override);
        let overrides: Vec<String> = of_study.chain(of_run).collect();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let shown = self.path.display().to_string();
        Scene::parse(&self.text, &shown, folder, &overrides).map_err(|mut error| {
            for problem in &mut error.problems {
                if let Some(origin) = place(study, settings, problem) {
                    problem.move_to(origin);
                }
            }
            error
        })
    }
}

/// Where in the study file the override was written that a problem is about; `None` for a problem
/// of the base scene.
fn place<'a>(study: &'a StudyChoice, of: &[Setting], problem: &Problem) -> Option<&'a Origin> {
    let source = problem.origin.as_ref()?.source.text.name();
    let is_it = |text: &str| source.strip_prefix("--set ") == Some(text);
    // The last one of equal texts has the effect.
    if let Some(setting) = of.iter().rev().find(|s| is_it(&s.as_override())) {
        let axis = study.axes.get(setting.axis)?;
        if problem.message.starts_with("unknown key") {
            return Some(&axis.keys_origin);
        }
        let item = match &axis.values {
            AxisValues::List(items) => items.get(usize::try_from(setting.item).ok()?),
            _ => None,
        };
        return Some(item.map_or(&axis.origin, |item| &item.origin));
    }
    let mut of_set = study.overrides.iter().rev();
    let (_, origin) = of_set.find(|(text, _)| is_it(text))?;
    Some(origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_find_their_units() {
        assert_eq!(Axis::unit("drive.speed"), "m/s");
        assert_eq!(Axis::unit("estimator.0.observer_pole"), "rad/s");
        assert_eq!(Axis::unit("estimator[2].observer_pole"), "rad/s");
        assert_eq!(Axis::unit("no.such.key"), "");
    }

    /// Numbers keep their bits on the way through an override; texts are quoted.
    #[test]
    fn values_are_toml() {
        for number in [0.1 + 0.2, 1e-300, 12345.678, -0.0, 1e22] {
            let text = AxisValue::Number(number).to_string();
            let back: f64 = text.parse().expect("a number");
            assert_eq!(back.to_bits(), number.to_bits(), "{text}");
        }
        assert_eq!(AxisValue::Text("5 deg".into()).to_string(), "\"5 deg\"");
    }
}

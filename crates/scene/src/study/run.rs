//! The scene of one run of a study.

use super::axis::{Axis, AxisValue, AxisValues};
use super::choice::StudyChoice;
use crate::error::{Problem, SceneError};
use crate::scene::Scene;
use crate::source::{self, Origin};
use std::path::{Path, PathBuf};

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
    /// [`SceneError`] at the study's key `scene`.
    pub fn load(study: &StudyChoice, folder: &Path) -> Result<Self, SceneError> {
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
    /// [`SceneError`] with all problems. Those that a setting or an item of `set` causes are at
    /// their place in the study file.
    pub fn scene(&self, study: &StudyChoice, settings: &[Setting]) -> Result<Scene, SceneError> {
        let overrides: Vec<String> = study
            .overrides
            .iter()
            .map(|(text, _)| text.clone())
            .chain(settings.iter().map(Setting::as_override))
            .collect();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let shown = self.path.display().to_string();
        Scene::parse(&self.text, &shown, folder, &overrides).map_err(|error| {
            let moved = error
                .problems
                .into_iter()
                .map(|p| match place(study, settings, &p) {
                    Some(origin) => p.moved_to(origin),
                    None => p,
                });
            SceneError {
                problems: moved.collect(),
                count: error.count,
            }
        })
    }
}

/// Where in the study file the override was written that a problem is about; `None` for a problem
/// of the base scene.
fn place<'a>(
    study: &'a StudyChoice,
    settings: &[Setting],
    problem: &Problem,
) -> Option<&'a Origin> {
    let source = problem.origin.as_ref()?.source.text.name();
    let is_it = |text: &str| source.strip_prefix("--set ") == Some(text);
    // The last one of equal texts has the effect.
    if let Some(setting) = settings.iter().rev().find(|s| is_it(&s.as_override())) {
        return Some(study.axes.get(setting.axis)?.origin_of(setting.item));
    }
    let mut of_set = study.overrides.iter().rev();
    let (_, origin) = of_set.find(|(text, _)| is_it(text))?;
    Some(origin)
}

impl Axis {
    /// Where an item of its list was written.
    fn origin_of(&self, item: u64) -> &Origin {
        let item = usize::try_from(item).ok();
        match (&self.values, item) {
            (AxisValues::List(items), Some(item)) => {
                items.get(item).map_or(&self.origin, |item| &item.origin)
            }
            _ => &self.origin,
        }
    }
}

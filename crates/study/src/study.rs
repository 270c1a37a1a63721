//! What is to be run: a study file with its base scene, or a scene with many seeds; and what
//! identifies it.

use crate::ablation::{ladder, steps};
use crate::error::{Result, StudyError};
use crate::plan::Plan;
use robhaz_record::ScoreColumn;
use robhaz_scene::{BaseScene, EngineKind, FileError, Scene, StudyChoice};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// What a dataset was made from. Runs of two identities never mix.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Name of the study.
    pub name: String,
    /// The program and its engines.
    pub version: String,
    /// Number of runs.
    pub runs: u64,
    /// SHA-256 of all the other fields, of the columns of the dataset, and of everything that the
    /// scenes of representative runs hold: robot files and tracks count, too.
    pub sha256: String,
    /// Text of the study file.
    pub study: String,
    /// Text of the base scene.
    pub scene: String,
}

/// A study that is ready to run. It knows the settings of every run by its index alone, so that any
/// process computes any run without asking another.
#[derive(Clone, Debug)]
pub struct Study {
    /// The study file.
    pub choice: StudyChoice,
    /// What identifies the dataset.
    pub identity: Identity,
    /// Scenes that have every value of every axis, without those whose values do not go together:
    /// see [`Self::load`].
    pub scenes: Vec<Scene>,
    /// The settings of every run.
    pub plan: Plan,
    base: Base,
}

/// Where the scenes of the runs come from.
#[derive(Clone, Debug)]
enum Base {
    /// The text of a scene, in which the axes set keys.
    File(BaseScene),
    /// A scene whose one truth all runs observe, each with a seed of its own.
    Scene {
        /// What makes the truth: the control of a closed loop drives it with the scene's own seed
        /// and estimators.
        driven: Box<Scene>,
        /// What observes it.
        observing: Box<Scene>,
    },
}

impl Study {
    /// Reads a study file and its base scene, and checks every value of every list in a scene of
    /// its own; of whole numbers and draws the least and the largest. Values that are allowed alone
    /// and do not go together are no error as long as one of these scenes is right: their runs are
    /// rows with the reason.
    ///
    /// # Errors
    /// [`StudyError::Scene`] with all problems of one of these scenes.
    pub fn load(path: &Path) -> Result<Self> {
        let choice = StudyChoice::load(path)?;
        let base = BaseScene::load(&choice, path.parent().unwrap_or(Path::new("")))?;
        let text = base.text.clone();
        Self::new(choice, Base::File(base), text)
    }

    /// A scene with `seeds` seeds of its sensors, from its own on. Its truth is simulated once.
    /// `with_ladder` puts the [`ladder`] in place of its estimators. All samples of the sensors
    /// count, whatever the rate of its records.
    ///
    /// # Errors
    /// [`StudyError`]: no estimator, or no such seeds.
    pub fn of_scene(driven: &Scene, seeds: u64, with_ladder: bool) -> Result<Self> {
        let mut observing = driven.clone();
        observing.record.rate = driven.sensors.rate;
        if with_ladder {
            observing.estimators = ladder()?;
        }
        if observing.estimators.is_empty() {
            return Err(StudyError::Refused(format!(
                "{} has no estimator to study: leave out `estimator = []`, or study the --ladder (in Python ladder=True)",
                driven.name
            )));
        }
        let (first, name) = (driven.seed, &driven.name);
        let last = first.checked_add(seeds.max(1) - 1);
        if last.is_none_or(|last| i64::try_from(last).is_err()) {
            return Err(StudyError::Refused(format!(
                "{seeds} seeds from {first} on: the last seed must be below 2^63"
            )));
        }
        let set = match with_ladder {
            true => format!("set = ['''{}''']\n", steps()),
            false => String::new(),
        };
        let text = format!(
            "# robhaz study {name}.toml: its truth, observed with every seed.\nname = \"{name}\"\nscene = \"{name}.toml\"\n{set}\
             [[axis]]\nkey = \"seed\"\nfirst = {first}\ncount = {seeds}\n"
        );
        let choice = StudyChoice::parse(&text, "the study of a scene")?;
        let text = driven.to_toml("");
        let base = Base::Scene {
            driven: Box::new(driven.clone()),
            observing: Box::new(observing),
        };
        Self::new(choice, base, text)
    }

    fn new(choice: StudyChoice, base: Base, scene: String) -> Result<Self> {
        let plan = Plan::new(&choice);
        let mut study = Self {
            identity: Identity {
                name: choice.name.clone(),
                version: version(),
                runs: plan.runs(),
                sha256: String::new(),
                study: choice.text.clone(),
                scene,
            },
            choice,
            base,
            plan,
            scenes: Vec::new(),
        };
        let mut conflict = None;
        let mut scenes = Vec::new();
        for run in study.plan.representatives() {
            match study.scene(run) {
                Ok(scene) => scenes.push((run, scene)),
                Err(error) if error.is_conflict() => {
                    conflict.get_or_insert(error);
                }
                Err(error) => return Err(error.into()),
            }
        }
        if let Some(conflict) = conflict.filter(|_| scenes.is_empty()) {
            return Err(conflict.into());
        }
        let is_scene = matches!(study.base, Base::Scene { .. });
        let truth = |run: u64| {
            let scene = scenes.iter().find(|(of, _)| *of == run);
            scene.map(|(_, scene)| seen_by_plant(scene))
        };
        let first = truth(0);
        let same = |run: u64| is_scene || (first.is_some() && truth(run) == first);
        study.plan.share(same);
        study.identity.sha256 = hash(&study.identity, scenes.iter().map(|(_, scene)| scene));
        study.scenes = scenes.into_iter().map(|(_, scene)| scene).collect();
        Ok(study)
    }

    /// The scene of a run.
    ///
    /// # Errors
    /// [`FileError`] where the values of several axes do not go together.
    pub fn scene(&self, run: u64) -> Result<Scene, FileError> {
        match &self.base {
            Base::File(base) => base.scene(&self.choice, &self.plan.settings(run)),
            Base::Scene { driven, observing } => Ok(Scene {
                seed: driven.seed + run,
                ..Scene::clone(observing)
            }),
        }
    }

    /// Warnings about allowed values that may be mistakes, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for warning in self.scenes.iter().flat_map(Scene::warnings) {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        warnings
    }

    /// The scene whose one truth all runs observe; `None` of a study file, whose runs have truths
    /// of their own.
    pub(crate) fn driven(&self) -> Option<&Scene> {
        match &self.base {
            Base::File(_) => None,
            Base::Scene { driven, .. } => Some(driven),
        }
    }
}

/// What of a scene its truth depends on, with neutral values for all else. Where the control takes
/// readings it depends on the sensors and on the estimator that the control gets.
pub(crate) fn seen_by_plant(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.record.compare_from = 0.0;
    if !scene.control.kind.is_closed_loop() {
        let (neutral, rate) = (Scene::default(), scene.sensors.rate);
        scene.seed = neutral.seed;
        scene.model_error = neutral.model_error;
        scene.estimators = Vec::new();
        scene.control.estimator = None;
        scene.sensors = neutral.sensors;
        scene.sensors.rate = rate;
    }
    scene
}

fn hash<'a>(identity: &Identity, scenes: impl Iterator<Item = &'a Scene>) -> String {
    let mut hash = Sha256::new();
    let columns = ScoreColumn::all().iter().map(|column| column.name);
    let own = [
        &identity.name,
        &identity.version,
        &identity.study,
        &identity.scene,
    ];
    for text in own.into_iter().map(String::as_str).chain(columns) {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    for scene in scenes {
        hash.update(scene.to_toml(""));
    }
    format!("{:x}", hash.finalize())
}

/// The program and the libraries of its engines.
fn version() -> String {
    let engines = EngineKind::ALL.map(EngineKind::library).join(", ");
    format!("robhaz {}, {engines}", env!("CARGO_PKG_VERSION"))
}

//! A study file with its base scene, checked, and what identifies them.

use crate::error::SweepError;
use crate::plan::Plan;
use robhaz_scene::{BaseScene, EngineKind, Scene, SceneError, Setting, StudyChoice};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
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
    /// SHA-256 of the texts below, and of everything that the scenes of representative runs hold: robot files and
    /// tracks count, too.
    pub sha256: String,
    /// Text of the study file.
    pub study: String,
    /// Text of the base scene.
    pub scene: String,
}

impl Identity {
    /// The settings of every run: they follow from the text of the study file.
    ///
    /// # Errors
    /// [`SceneError`] where the text is no study.
    pub(crate) fn plan(&self, source_name: &str) -> Result<Plan, SceneError> {
        Ok(Plan::new(&StudyChoice::parse(&self.study, source_name)?))
    }
}

/// A study that is ready to run.
#[derive(Clone, Debug)]
pub struct Sweep {
    study: StudyChoice,
    base: BaseScene,
    plan: Plan,
    identity: Identity,
    warnings: Vec<String>,
}

impl Sweep {
    /// Reads a study file and its base scene, and checks every value of every list in a scene of its own; of whole numbers
    /// and draws the least and the largest. Values that are allowed alone and do not go together are no error as long as one
    /// of these scenes is right: their runs are rows with the reason.
    ///
    /// # Errors
    /// [`SweepError::Study`] with all problems of one of these scenes.
    pub fn load(path: &Path) -> Result<Self, SweepError> {
        let study = StudyChoice::load(path)?;
        let base = BaseScene::load(&study, path.parent().unwrap_or(Path::new("")))?;
        let plan = Plan::new(&study);
        let mut hash = Sha256::new();
        for text in [&study.text, &base.text] {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text);
        }
        let mut warnings = Vec::new();
        let (mut is_right, mut conflict) = (false, None);
        for run in plan.representatives() {
            let scene = match base.scene(&study, &plan.settings(run)) {
                Ok(scene) => scene,
                Err(error) if error.is_conflict() => {
                    conflict.get_or_insert(error);
                    continue;
                }
                Err(error) => return Err(error.into()),
            };
            is_right = true;
            hash.update(scene.to_toml(""));
            for warning in scene.warnings() {
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
        }
        if let Some(conflict) = conflict.filter(|_| !is_right) {
            return Err(conflict.into());
        }
        let identity = Identity {
            name: study.name.clone(),
            version: version(),
            runs: plan.runs(),
            sha256: hex(&hash.finalize()),
            study: study.text.clone(),
            scene: base.text.clone(),
        };
        Ok(Self {
            study,
            base,
            plan,
            identity,
            warnings,
        })
    }

    /// The study file.
    pub fn study(&self) -> &StudyChoice {
        &self.study
    }

    /// What identifies the dataset.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.plan.runs()
    }

    /// The settings of a run, from index 0 on.
    pub fn settings(&self, run: u64) -> Vec<Setting> {
        self.plan.settings(run)
    }

    /// The scene of a run.
    ///
    /// # Errors
    /// [`SceneError`] where the values of several axes do not go together.
    pub fn scene(&self, run: u64) -> Result<Scene, SceneError> {
        self.base.scene(&self.study, &self.settings(run))
    }

    /// Warnings about allowed values that may be mistakes, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    pub(crate) fn plan(&self) -> &Plan {
        &self.plan
    }
}

/// The program and the libraries of its engines.
fn version() -> String {
    let mut version = format!("robhaz {}", env!("CARGO_PKG_VERSION"));
    for kind in EngineKind::ALL {
        // Writing into a text cannot fail.
        let _ = write!(version, ", {}", kind.library());
    }
    version
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing into a text cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

//! Many seeds of one scene: how exact the estimators are, whether they know it, and what each step of `best` brings.
//!
//! The truth of a scene does not depend on what is random in its readings: it is computed once and observed anew for every seed.

mod ablation;
mod consistency;
mod score;

pub use ablation::ladder;
pub use consistency::{Consistency, Verdict};
pub use score::{Score, Summary};

use robhaz_run::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::{Plant, PlantError, Truth};

/// Why a scene cannot be studied.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The truth cannot be computed.
    #[error("the simulation stopped")]
    Plant(#[from] PlantError),
    /// The estimators cannot be told of the robot.
    #[error("model_error")]
    ModelError(#[from] ModelErrorTooLarge),
}

/// The truth of a scene at every sample of its sensors.
///
/// # Errors
/// [`StudyError::Plant`] when the run leaves its range of validity.
pub fn truth_of(scene: &Scene) -> Result<Vec<Truth>, StudyError> {
    let mut plant = Plant::new(&scene.plant_setup());
    let samples = (scene.record_count() - 1) * scene.samples_per_record() + 1;
    (0..samples)
        .map(|_| Ok(plant.next_truth()?))
        .collect::<Result<_, StudyError>>()
}

/// Observes a truth once, with the scene's seed: a score for each of its estimators.
///
/// # Errors
/// [`StudyError::ModelError`].
pub fn observe(scene: &Scene, truth: &[Truth]) -> Result<Vec<Score>, StudyError> {
    let mut observers = Observers::new(scene)?;
    let mut scores = vec![Score::default(); scene.estimators.len()];
    for truth in truth {
        let (_, estimates) = observers.observe(truth);
        if truth.time >= scene.record.compare_from {
            for (score, estimate) in scores.iter_mut().zip(estimates) {
                score.add(truth, estimate.as_ref().ok());
            }
        }
    }
    Ok(scores)
}

/// Observes a truth with each of `seeds`: a summary for each of the scene's estimators.
///
/// # Errors
/// As [`observe`].
pub fn study(
    scene: &Scene,
    truth: &[Truth],
    seeds: std::ops::Range<u64>,
) -> Result<Vec<Summary>, StudyError> {
    let mut summaries: Vec<Summary> = scene
        .estimators
        .iter()
        .map(|e| Summary::new(&e.name))
        .collect();
    let mut scene = scene.clone();
    for seed in seeds {
        scene.seed = seed;
        for (summary, score) in summaries.iter_mut().zip(observe(&scene, truth)?) {
            summary.add(&score);
        }
    }
    Ok(summaries)
}

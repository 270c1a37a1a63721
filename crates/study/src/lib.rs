//! Many seeds of one scene: how exact the estimators are, whether their stated covariance is right, and what each step from the
//! paper's estimator to `best` contributes.
//!
//! The truth of a scene does not depend on sensor noise: a [`TruthRun`] is simulated once and observed anew with every seed.

mod ablation;
mod consistency;
mod floor;
mod report;
mod seeds;
mod statistics;
mod truth_run;

pub use ablation::ladder;
pub use consistency::{Consistency, CovarianceVerdict};
pub use floor::{SampleNoise, floor};
pub use report::Report;
pub use seeds::{SeedErrors, SeedScores};
pub use statistics::Mean;
pub use truth_run::{TruthRun, TruthRunError};

use rayon::prelude::*;
use robhaz_run::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_score::Score;

/// Observes a truth once, with the scene's seed. Returns a score for each of the scene's estimators.
///
/// # Errors
/// [`ModelErrorTooLarge`] when the nominal robot that this seed draws is not a valid robot.
pub fn observe(scene: &Scene, run: &TruthRun) -> Result<Vec<Score>, ModelErrorTooLarge> {
    let mut observers = Observers::new(scene)?;
    let mut scores = vec![Score::new(truth_run::rule(scene)); scene.estimators.len()];
    for truth in run.samples() {
        let (_, estimates) = observers.observe(truth);
        for (score, estimate) in scores.iter_mut().zip(estimates) {
            score.add(truth, estimate.as_ref().ok());
        }
    }
    Ok(scores)
}

/// Observes a truth with each of `seeds`, on the threads of the current rayon pool. Returns the scores of each of the scene's
/// estimators. The result does not depend on the number of threads. `done` is called after every seed.
///
/// # Errors
/// As [`observe`], of the first seed in the list that fails.
pub fn study(
    scene: &Scene,
    run: &TruthRun,
    seeds: &[u64],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<SeedScores>, ModelErrorTooLarge> {
    let with_seed = |&seed: &u64| {
        let scene = Scene {
            seed,
            ..scene.clone()
        };
        let scores = observe(&scene, run);
        done();
        scores
    };
    // Collected in the order of the seeds; errors are looked at afterwards, so that the first one counts.
    let runs: Vec<_> = seeds.par_iter().map(with_seed).collect();
    let mut of_estimators: Vec<SeedScores> = scene
        .estimators
        .iter()
        .map(|e| SeedScores::new(&e.name))
        .collect();
    for scores in runs {
        for (of_estimator, score) in of_estimators.iter_mut().zip(scores?) {
            of_estimator.add(&score);
        }
    }
    Ok(of_estimators)
}

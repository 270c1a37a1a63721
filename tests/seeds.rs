//! The scores of estimators over many seeds of one truth, by the plain loop over its samples: what
//! `robhaz study` is compared with, and scores at one contact, which it has not.

use rayon::prelude::*;
use robhaz_run::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_score::{Bound, Inclusion, Rule, SampleNoise, Score, Statistics};
use robhaz_study::{Consistency, Mean, TruthRun};
use std::ops::Deref;

/// Observes a truth with each of `seeds`. Returns the scores of each of the scene's estimators.
pub fn study(
    scene: &Scene,
    run: &TruthRun,
    seeds: &[u64],
) -> Result<Vec<SeedScores>, ModelErrorTooLarge> {
    let observe = |&seed: &u64| {
        let scene = Scene {
            seed,
            ..scene.clone()
        };
        let mut observers = Observers::new(&scene)?;
        let rule = Rule {
            compare_from: scene.record.compare_from,
        };
        let mut scores = vec![Score::new(rule); scene.estimators.len()];
        for truth in run.samples() {
            let (_, estimates) = observers.observe(truth);
            for (score, estimate) in scores.iter_mut().zip(estimates) {
                score.add(truth, estimate.as_ref().ok());
            }
        }
        Ok::<_, ModelErrorTooLarge>(scores)
    };
    let runs: Vec<Vec<Score>> = seeds.par_iter().map(observe).collect::<Result<_, _>>()?;
    let of = |(k, e): (usize, &robhaz_scene::EstimatorChoice)| {
        let mut scores = SeedScores::new(&e.name);
        runs.iter().for_each(|run| scores.add(&run[k]));
        scores
    };
    Ok(scene.estimators.iter().enumerate().map(of).collect())
}

/// The Cramer-Rao bound of a scene on a truth, from one sample: [`Bound::nrmse`].
pub fn floor(scene: &Scene, run: &TruthRun) -> Option<f64> {
    let noise = SampleNoise::of(&scene.sensors.spec, scene.drive.gear_friction);
    let mut bound = Bound::new(noise, scene.robot.robot.clone());
    let rule = Rule {
        compare_from: scene.record.compare_from,
    };
    for truth in run.samples() {
        if let Inclusion::Included(compared) = rule.judge(truth) {
            bound.add(truth, &compared);
        }
    }
    bound.nrmse()
}

/// The errors of one estimator, one per seed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeedErrors(Vec<Statistics>);

impl SeedErrors {
    fn mean(&self, of: impl Fn(&Statistics) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.0.iter().filter_map(of).collect::<Vec<_>>())
    }

    /// Mean of [`Statistics::nrmse`].
    pub fn nrmse(&self) -> Option<Mean> {
        self.mean(Statistics::nrmse)
    }

    /// Mean RMS error of T over the wheels, N.
    pub fn traction_rmse(&self) -> Option<Mean> {
        self.mean(|errors| Some(errors.traction()?.rmse_all))
    }

    /// Mean of [`Statistics::stated`].
    pub fn stated(&self) -> Option<Mean> {
        self.mean(Statistics::stated)
    }

    /// Mean of [`Statistics::normalised`].
    pub fn normalised(&self) -> Option<Mean> {
        self.mean(Statistics::normalised)
    }

    /// Whether the stated covariance is right; `None` if the estimator states none.
    pub fn consistency(&self) -> Option<Consistency> {
        Some(Consistency {
            nees: self.mean(Statistics::nees)?,
            nis: self.mean(Statistics::nis),
            coverage: self.mean(Statistics::coverage)?,
        })
    }
}

/// The scores of one estimator over all samples that count, one per seed.
#[derive(Clone, Debug, PartialEq)]
pub struct SeedScores {
    /// Name of the estimator.
    pub name: String,
    all: SeedErrors,
    one_contact: SeedErrors,
    missing: u64,
}

impl Deref for SeedScores {
    type Target = SeedErrors;

    fn deref(&self) -> &SeedErrors {
        &self.all
    }
}

impl SeedScores {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            all: SeedErrors::default(),
            one_contact: SeedErrors::default(),
            missing: 0,
        }
    }

    fn add(&mut self, score: &Score) {
        self.all.0.push(**score);
        self.one_contact.0.push(*score.at_one_contact());
        self.missing += score.missing;
    }

    /// The errors over the samples at which no wheel has two contacts.
    pub fn at_one_contact(&self) -> &SeedErrors {
        &self.one_contact
    }

    /// Samples without an estimate, of all seeds together.
    pub fn missing(&self) -> u64 {
        self.missing
    }
}

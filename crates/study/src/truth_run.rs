//! The truth of a scene at every sample of its sensors.

use robhaz_run::{DrivenPlant, StartError, Stop};
use robhaz_scene::{PlantFailure, Scene};
use robhaz_score::{Bound, Compared, Inclusion, Rule, SampleNoise};
use robhaz_sim::Truth;
use std::sync::Arc;

/// Why a scene has no truth that can be observed.
#[derive(Debug, thiserror::Error)]
pub enum TruthRunError {
    /// The truth of the whole run is kept in memory.
    #[error(
        "the run has {found} samples; a study keeps all in memory and takes at most {MOST_SAMPLES}: shorten it, as with --set record.duration=20"
    )]
    TooLong {
        /// Samples of the scene's sensors.
        found: u64,
    },
    /// The simulation cannot start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The simulation left its range of validity.
    #[error("the simulation stopped")]
    Plant(#[from] PlantFailure),
    /// The caller stopped it.
    #[error("stopped by {0}")]
    Stopped(&'static str),
    /// No sample counts.
    #[error(
        "no sample counts: in each of the {compared} samples from {from} s on the contacts of a wheel have no equivalent single contact"
    )]
    NothingCounts {
        /// Samples from `record.compare_from` on.
        compared: usize,
        /// `record.compare_from`, s.
        from: f64,
    },
}

/// Which samples of a scene count.
pub(crate) fn rule(scene: &Scene) -> Rule {
    Rule {
        compare_from: scene.record.compare_from,
    }
}

/// The Cramer-Rao bound of the estimators of a scene, before its first sample.
pub(crate) fn bound(scene: &Scene) -> Bound {
    let noise = SampleNoise::of(&scene.sensors.spec, scene.drive.gear_friction);
    Bound::new(noise, scene.robot.robot.clone())
}

/// The Cramer-Rao bound of a scene on a truth, from one sample: [`Bound::nrmse`].
pub fn floor(scene: &Scene, run: &TruthRun) -> Option<f64> {
    let mut bound = bound(scene);
    run.counting()
        .for_each(|(truth, compared)| bound.add(truth, &compared));
    bound.nrmse()
}

/// Largest number of samples of a run, about 0.5 GB.
pub const MOST_SAMPLES: u64 = 500_000;

/// The truth at every sample of a scene's sensors, kept in memory. One run serves all seeds: without a
/// control that takes readings it does not depend on sensor noise; with one it is the run of the scene's own seed, which
/// other seeds observe without driving.
#[derive(Clone, Debug)]
pub struct TruthRun {
    truth: Arc<[Truth]>,
    rule: Rule,
}

impl TruthRun {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`TruthRunError`]
    pub fn of(scene: &Scene) -> Result<Self, TruthRunError> {
        let run = Self::simulate(scene, &|| None)?;
        match run.counted() {
            0 => Err(TruthRunError::NothingCounts {
                compared: run.left_out(),
                from: scene.record.compare_from,
            }),
            _ => Ok(run),
        }
    }

    /// The same for a truth of which no sample may count. `stop` is asked at every sample.
    pub(crate) fn simulate(scene: &Scene, stop: Stop<'_>) -> Result<Self, TruthRunError> {
        let found = (scene.record_count() - 1) * scene.samples_per_record() + 1;
        if found > MOST_SAMPLES {
            return Err(TruthRunError::TooLong { found });
        }
        let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
        let next = |_| match stop() {
            Some(cause) => Err(TruthRunError::Stopped(cause)),
            None => Ok(plant.next_truth().map_err(PlantFailure::from)?),
        };
        Ok(Self {
            truth: (0..found).map(next).collect::<Result<_, _>>()?,
            rule: rule(scene),
        })
    }

    /// The samples, for [`robhaz_run::Run::observing`].
    pub(crate) fn shared(&self) -> Arc<[Truth]> {
        Arc::clone(&self.truth)
    }

    /// Every sample.
    pub fn samples(&self) -> impl Iterator<Item = &Truth> {
        self.truth.iter()
    }

    /// The samples that count in a score, with the forces that estimates are compared with.
    pub fn counting(&self) -> impl Iterator<Item = (&Truth, Compared)> {
        let included = |truth| match self.rule.judge(truth) {
            Inclusion::Included(compared) => Some((truth, compared)),
            Inclusion::TooEarly | Inclusion::NoEquivalent => None,
        };
        self.truth.iter().filter_map(included)
    }

    /// Number of samples that count.
    pub fn counted(&self) -> usize {
        self.counting().count()
    }

    /// Number of samples left out because a wheel has no equivalent contact.
    pub fn left_out(&self) -> usize {
        let left_out = |truth: &&Truth| self.rule.judge(truth) == Inclusion::NoEquivalent;
        self.truth.iter().filter(left_out).count()
    }
}

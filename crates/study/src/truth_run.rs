//! The truth of a scene at every sample of its sensors.

use robhaz_run::{DrivenPlant, StartError};
use robhaz_scene::{PlantFailure, Scene};
use robhaz_score::{Compared, Inclusion, Rule};
use robhaz_sim::Truth;

/// Why a scene cannot be studied.
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

/// Largest number of samples of a run, about 0.5 GB.
pub const MOST_SAMPLES: u64 = 500_000;

/// The truth at every sample of a scene's sensors, kept in memory. One run serves all seeds: without a
/// control that takes readings it does not depend on sensor noise; with one it is the run of the scene's own seed, which
/// other seeds observe without driving.
#[derive(Clone, Debug)]
pub struct TruthRun {
    truth: Vec<Truth>,
    rule: Rule,
}

impl TruthRun {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`TruthRunError`]
    pub fn of(scene: &Scene) -> Result<Self, TruthRunError> {
        let found = (scene.record_count() - 1) * scene.samples_per_record() + 1;
        if found > MOST_SAMPLES {
            return Err(TruthRunError::TooLong { found });
        }
        let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
        let truth: Vec<Truth> = (0..found)
            .map(|_| plant.next_truth())
            .collect::<Result<_, _>>()
            .map_err(PlantFailure::from)?;
        let run = Self {
            truth,
            rule: rule(scene),
        };
        if run.counted() == 0 {
            return Err(TruthRunError::NothingCounts {
                compared: run.left_out(),
                from: scene.record.compare_from,
            });
        }
        Ok(run)
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

    /// How many of the samples that count have a wheel with two contacts.
    pub fn two_contacts(&self) -> usize {
        let two = |(_, compared): &(&Truth, Compared)| compared.two_contacts;
        self.counting().filter(two).count()
    }

    /// Number of samples left out because a wheel has no equivalent contact.
    pub fn left_out(&self) -> usize {
        let left_out = |truth: &&Truth| self.rule.judge(truth) == Inclusion::NoEquivalent;
        self.truth.iter().filter(left_out).count()
    }
}

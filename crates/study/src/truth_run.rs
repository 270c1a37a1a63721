//! The truth of a scene at every sample of its sensors.

use robhaz_run::{DrivenPlant, StartError, Stop};
use robhaz_scene::{PlantFailure, Scene};
use robhaz_score::{Bound, Rule, SampleNoise};
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

/// Largest number of samples of a run, about 0.5 GB.
pub const MOST_SAMPLES: u64 = 500_000;

/// The truth at every sample of a scene's sensors, kept in memory. One run serves all seeds: without a
/// control that takes readings it does not depend on sensor noise; with one it is the run of the scene's own seed, which
/// other seeds observe without driving.
#[derive(Clone, Debug)]
pub struct TruthRun(Arc<[Truth]>);

impl TruthRun {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`TruthRunError`]
    pub fn of(scene: &Scene) -> Result<Self, TruthRunError> {
        Self::simulate(scene, &|| None)
    }

    /// The same; `stop` is asked at every sample.
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
        Ok(Self((0..found).map(next).collect::<Result<_, _>>()?))
    }

    /// The samples, for [`robhaz_run::Run::observing`].
    pub(crate) fn shared(&self) -> Arc<[Truth]> {
        Arc::clone(&self.0)
    }

    /// Every sample.
    pub fn samples(&self) -> impl Iterator<Item = &Truth> {
        self.0.iter()
    }
}

//! The truth of a scene at every sample of its sensors.

use robhaz_run::{DrivenPlant, MOST_KEPT, RunError, Stop};
use robhaz_scene::{PlantFailure, Scene};
use robhaz_score::{Bound, Rule, SampleNoise};
use robhaz_sim::Truth;
use std::sync::Arc;

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

/// The truth at every sample of a scene's sensors, kept in memory. One run serves all seeds:
/// without a control that takes readings it does not depend on sensor noise; with one it is the run
/// of the scene's own seed, which other seeds observe without driving.
#[derive(Clone, Debug)]
pub struct TruthRun(Arc<[Truth]>);

impl TruthRun {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`RunError`]: it is too long, cannot start or does not reach its end.
    pub fn of(scene: &Scene) -> Result<Self, RunError> {
        Self::simulate(scene, &|| None)
    }

    /// The same; `stop` is asked at every sample.
    pub(crate) fn simulate(scene: &Scene, stop: Stop<'_>) -> Result<Self, RunError> {
        let found = (scene.record.count() - 1) * scene.samples_per_record() + 1;
        if found > MOST_KEPT {
            let (of, who) = ("samples", "a study");
            return Err(RunError::TooLong { found, of, who });
        }
        let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
        let next = |_| match stop() {
            Some(cause) => Err(RunError::Stopped { cause }),
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

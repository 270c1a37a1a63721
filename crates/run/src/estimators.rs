//! The estimators of a run, side by side on the same readings.

use crate::source::Sample;
use rayon::prelude::*;
use robhaz_estimator::whole::{WholeEstimate, WholeEstimator};
use robhaz_estimator::{
    Estimate, EstimateError, Estimator, EstimatorSettings, GroundPoint, SensorFrame,
};
use robhaz_model::Robot;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::Truth;
use robhaz_sim::sensors::Sensors;

/// Stands at the place of an estimate until it is there, and of one of a sample without readings of
/// both sides.
const MISSING: EstimateError = EstimateError::Missing { field: "any" };

/// The estimators of a run.
pub struct Estimators {
    estimators: Vec<Estimator>,
    /// The one estimator of a log of both sides, in place of others.
    whole: Option<Box<WholeEstimator>>,
    estimates: Vec<Result<Estimate, EstimateError>>,
    /// Points of the ground that each has completed, and no record has given.
    pub completed: Vec<Vec<GroundPoint>>,
}

impl Estimators {
    /// Estimators on a nominal robot, one for each of the settings.
    pub fn new(robot: &Robot, settings: impl IntoIterator<Item = EstimatorSettings>) -> Self {
        let settings = settings.into_iter();
        let estimators: Vec<_> = settings.map(|s| Estimator::new(robot, s)).collect();
        Self {
            estimates: Vec::with_capacity(estimators.len()),
            completed: vec![Vec::new(); estimators.len()],
            whole: None,
            estimators,
        }
    }

    /// The estimator of a log of both sides. Its sides count as two estimators.
    pub fn of_both(whole: WholeEstimator) -> Self {
        Self {
            whole: Some(Box::new(whole)),
            estimators: Vec::new(),
            estimates: Vec::new(),
            completed: vec![Vec::new(); 2],
        }
    }

    /// Updates every estimator with the readings of one sample. Returns the estimates in the order
    /// of the settings.
    pub fn update(&mut self, frame: &SensorFrame) -> &[Result<Estimate, EstimateError>] {
        self.estimates.clear();
        for (estimator, completed) in self.estimators.iter_mut().zip(&mut self.completed) {
            self.estimates.push(update(estimator, completed, frame));
        }
        &self.estimates
    }

    /// Updates every estimator with the readings of several samples, `on_threads` of the pool in which
    /// it is called. `to` then has the estimates of one sample after the other, each in the order of
    /// the settings. Each estimate goes straight to its place: it has more than a kB, and
    /// a copy costs as much as a part of its computation.
    pub(crate) fn update_all(
        &mut self,
        samples: &[Sample],
        to: &mut Vec<Result<Estimate, EstimateError>>,
        wholes: &mut Vec<Option<WholeEstimate>>,
        on_threads: bool,
    ) {
        let count = self.count();
        to.resize(samples.len() * count, Err(MISSING));
        wholes.clear();
        if let Some(whole) = &mut self.whole {
            for (sample, sides) in samples.iter().zip(to.chunks_mut(count)) {
                let both = sample.both.as_ref().ok_or(MISSING);
                let found = both.and_then(|both| whole.update(&both.readings));
                for (k, side) in sides.iter_mut().enumerate() {
                    *side = found.as_ref().map(|found| found.sides[k]).map_err(|e| *e);
                }
                wholes.push(found.ok());
            }
            return;
        }
        let (estimators, completed) = (&mut self.estimators, &mut self.completed);
        if !on_threads {
            for (sample, places) in samples.iter().zip(to.chunks_mut(count.max(1))) {
                let each = estimators.iter_mut().zip(completed.iter_mut());
                for ((estimator, completed), place) in each.zip(places) {
                    *place = update(estimator, completed, &sample.sensors);
                }
            }
            return;
        }
        let mut places: Vec<Vec<_>> = (0..count)
            .map(|_| Vec::with_capacity(samples.len()))
            .collect();
        for of_sample in to.chunks_mut(count.max(1)) {
            for (places, place) in places.iter_mut().zip(of_sample) {
                places.push(place);
            }
        }
        let estimators = estimators.par_iter_mut().zip(completed);
        estimators
            .zip(places)
            .for_each(|((estimator, completed), places)| {
                for (sample, place) in samples.iter().zip(places) {
                    *place = update(estimator, completed, &sample.sensors);
                }
            });
    }

    /// Number of the estimators.
    pub(crate) fn count(&self) -> usize {
        self.completed.len()
    }

    /// Copies of the points in the memory of each estimator.
    pub fn memory(&self) -> Vec<Vec<GroundPoint>> {
        let memories = self.estimators.iter().map(Estimator::ground);
        let mut memories: Vec<_> = memories.map(Iterator::collect).collect();
        memories.resize(self.count(), Vec::new());
        memories
    }
}

/// The estimate of a frame, after which `completed` has the points of the ground that the estimator
/// has left.
fn update(
    estimator: &mut Estimator,
    completed: &mut Vec<GroundPoint>,
    frame: &SensorFrame,
) -> Result<Estimate, EstimateError> {
    let estimate = estimator.update(frame);
    // A refused frame leaves the estimator as it was, with the points of the last one.
    if !matches!(estimate, Err(EstimateError::Time { .. })) {
        completed.extend(estimator.completed_ground());
    }
    estimate
}

/// The sensors and estimators of a scene: they turn the truth into readings and the readings into
/// estimates.
pub struct Observers {
    sensors: Sensors,
    /// Their completed points of the ground are those since the start.
    pub estimators: Estimators,
}

impl Observers {
    /// Sensors and estimators of a scene, with the errors that its seed draws.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the nominal robot is not a valid robot.
    pub fn new(scene: &Scene) -> Result<Self, ModelErrorTooLarge> {
        let settings = scene.estimators.iter().map(|e| scene.nominal_settings(e));
        let settings: Vec<_> = settings.collect::<Result<_, _>>()?;
        Ok(Self {
            sensors: scene.sensors(),
            estimators: Estimators::new(&scene.nominal_robot()?, settings),
        })
    }

    /// Reads the sensors at one sample and updates every estimator. Returns readings and estimates,
    /// in the scene's order.
    pub fn observe(&mut self, truth: &Truth) -> (SensorFrame, &[Result<Estimate, EstimateError>]) {
        let frame = self.sensors.read(truth);
        (frame, self.estimators.update(&frame))
    }
}

//! The estimators of a run, side by side on the same readings.

use crate::source::sensor_frame;
use robhaz_estimator::{Estimate, EstimateError, Estimator, EstimatorSettings, SensorFrame};
use robhaz_model::Robot;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::Truth;
use robhaz_sim::sensors::Sensors;

/// The estimators of a run.
pub struct Estimators {
    estimators: Vec<Estimator>,
    estimates: Vec<Result<Estimate, EstimateError>>,
}

impl Estimators {
    /// Estimators on a nominal robot, one for each of the settings.
    pub fn new(robot: &Robot, settings: impl IntoIterator<Item = EstimatorSettings>) -> Self {
        let settings = settings.into_iter();
        let estimators: Vec<_> = settings.map(|s| Estimator::new(robot, s)).collect();
        Self {
            estimates: Vec::with_capacity(estimators.len()),
            estimators,
        }
    }

    /// Updates every estimator with the readings of one sample. Returns the estimates in the order of the settings.
    pub fn update(&mut self, frame: &SensorFrame) -> &[Result<Estimate, EstimateError>] {
        self.estimates.clear();
        let updates = self.estimators.iter_mut().map(|e| e.update(frame));
        self.estimates.extend(updates);
        &self.estimates
    }
}

/// The sensors and estimators of a scene: they turn the truth into readings and the readings into estimates.
pub struct Observers {
    sensors: Sensors,
    estimators: Estimators,
    frame: Option<SensorFrame>,
}

impl Observers {
    /// Sensors and estimators of a scene, with the errors that its seed draws.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the nominal robot is not a valid robot.
    pub fn new(scene: &Scene) -> Result<Self, ModelErrorTooLarge> {
        let settings = scene.estimators.iter().map(|e| scene.nominal_settings(e));
        Ok(Self {
            sensors: scene.sensors(),
            estimators: Estimators::new(&scene.nominal_robot()?, settings),
            frame: None,
        })
    }

    /// Reads the sensors at one sample and updates every estimator. Returns readings and estimates, in the scene's order.
    pub fn observe(&mut self, truth: &Truth) -> (&SensorFrame, &[Result<Estimate, EstimateError>]) {
        let frame = self.frame.insert(sensor_frame(&self.sensors.read(truth)));
        (frame, self.estimators.update(frame))
    }
}

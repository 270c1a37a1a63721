//! The control of a scene: from readings and estimates to the commands of the wheels.

use robhaz_control::{ControlInput, Controller, FrictionTestResult};
use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_model::WheelCommand;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::drive::Drive;

/// The control of a scene, where it takes readings.
pub struct Driver {
    controller: Controller,
    /// The plan of the set speed.
    drive: Drive,
    /// Nominal radius, m.
    wheel_radius: f64,
    /// The estimator that the control gets, by its place among the estimates.
    estimator: Option<usize>,
}

impl Driver {
    /// The control of a scene before its first sample. `None` where the drives follow their own
    /// plan.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the nominal robot is not a valid robot.
    pub fn of(scene: &Scene) -> Result<Option<Self>, ModelErrorTooLarge> {
        if !scene.control.kind.is_closed_loop() {
            return Ok(None);
        }
        let settings = scene.control_settings()?;
        Ok(Some(Self {
            controller: Controller::new(&settings),
            drive: scene.drive.clone(),
            wheel_radius: settings.robot.geometry.wheel_radius,
            estimator: scene.control_estimator(),
        }))
    }

    /// Results of the friction tests so far, in their order.
    pub fn friction_tests(&self) -> impl Iterator<Item = FrictionTestResult> {
        self.controller.friction_tests().into_iter().flatten()
    }

    /// The commands that follow from readings and estimates of one sample, for the time from the
    /// next sample on.
    pub fn commands(
        &mut self,
        frame: &SensorFrame,
        estimates: &[Result<Estimate, EstimateError>],
    ) -> [WheelCommand; 3] {
        let estimate = self.estimator.and_then(|place| estimates.get(place));
        let travel = self.drive.travel_speed(frame.time, self.wheel_radius);
        self.controller.update(&ControlInput {
            frame,
            estimate: estimate.and_then(|e| e.as_ref().ok()),
            set_speed: travel / self.wheel_radius,
        })
    }
}

//! The control of a scene, from readings and estimates to the commands of the wheels; and a plant
//! that it drives.

use crate::error::{Result, RunError};
use crate::estimators::Observers;
use robhaz_control::{ControlInput, Controller, FrictionTestResult};
use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_model::WheelCommand;
use robhaz_scene::Scene;
use robhaz_sim::drive::Drive;
use robhaz_sim::{Balance, Plant, PlantError, PlantSetup, Truth};

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
    /// [`RunError::ModelError`] when the nominal robot is not a valid robot, [`RunError::Control`].
    pub fn of(scene: &Scene) -> Result<Option<Self>> {
        if !scene.control.kind.is_closed_loop() {
            return Ok(None);
        }
        let settings = scene.control_settings()?;
        Ok(Some(Self {
            controller: Controller::new(&settings)?,
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

/// A plant that its control drives, for those who need the truth alone: the same loop as
/// [`crate::Run`], without sinks, and with the one estimator that the control gets. The truth is
/// the same to the bit.
pub struct DrivenPlant {
    plant: Plant,
    /// Sensors, estimator and control, where the control takes readings.
    control: Option<(Observers, Driver)>,
}

impl DrivenPlant {
    /// The plant of a setup with the control of a scene. For a control that takes readings, the
    /// period of the setup is that of the sensors.
    ///
    /// # Errors
    /// [`RunError::Start`] and [`RunError::ModelError`].
    pub fn new(scene: &Scene, setup: &PlantSetup) -> Result<Self> {
        Ok(Self {
            control: control(scene)?,
            plant: Plant::new(setup).map_err(|cause| RunError::Start(cause.into()))?,
        })
    }

    /// The truth at the current time, which the sensors then read; the control sets its commands;
    /// the simulation advances by one period.
    ///
    /// # Errors
    /// As [`Plant::next_truth`].
    pub fn next_truth(&mut self) -> Result<Truth, PlantError> {
        let truth = *self.plant.next_truth()?;
        if let Some((observers, driver)) = &mut self.control {
            let (frame, estimates) = observers.observe(&truth);
            self.plant.command(driver.commands(&frame, estimates));
        }
        Ok(truth)
    }

    /// See [`Plant::balance`].
    pub fn balance(&self) -> Option<&Balance> {
        self.plant.balance()
    }
}

/// Sensors, the control's estimator and the control of a scene.
fn control(scene: &Scene) -> Result<Option<(Observers, Driver)>> {
    let mut scene = scene.clone();
    let chosen = scene.control_estimator();
    let mut place = 0..;
    scene.estimators.retain(|_| place.next() == chosen);
    let Some(driver) = Driver::of(&scene)? else {
        return Ok(None);
    };
    Ok(Some((Observers::new(&scene)?, driver)))
}

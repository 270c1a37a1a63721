//! A plant with the control of its scene, for those who need the truth alone.

use crate::driver::Driver;
use crate::error::RunError;
use crate::estimators::Observers;
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::{Balance, Plant, PlantError, PlantSetup, Truth};

/// A plant that its control drives: the same loop as [`crate::Run`], without sinks, and with the
/// one estimator that the control gets. The truth is the same to the bit.
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
    pub fn new(scene: &Scene, setup: &PlantSetup) -> Result<Self, RunError> {
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
            self.plant.command(driver.commands(frame, estimates));
        }
        Ok(truth)
    }

    /// See [`Plant::balance`].
    pub fn balance(&self) -> Option<&Balance> {
        self.plant.balance()
    }
}

/// Sensors, the control's estimator and the control of a scene.
fn control(scene: &Scene) -> Result<Option<(Observers, Driver)>, ModelErrorTooLarge> {
    let mut scene = scene.clone();
    let chosen = scene.control_estimator();
    let mut place = 0..;
    scene.estimators.retain(|_| place.next() == chosen);
    let Some(driver) = Driver::of(&scene)? else {
        return Ok(None);
    };
    Ok(Some((Observers::new(&scene)?, driver)))
}

//! Sources of readings.

use crate::error::{Result, RunError};
use crate::log_report::LogReport;
use crate::record::BothSides;
use robhaz_estimator::SensorFrame;
use robhaz_model::WheelCommand;
use robhaz_scene::{PlantFailure, Scene};
use robhaz_sim::sensors::Sensors;
use robhaz_sim::{Plant, Truth};
use std::sync::Arc;

/// One sample of a source.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Time since the start of the run, s.
    pub time: f64,
    /// The simulated truth. `None` for recorded readings.
    pub truth: Option<Truth>,
    /// The readings of the sensors.
    pub sensors: SensorFrame,
    /// Of a log of both sides, its readings and truth: `sensors` then has those of the left wheels.
    pub both: Option<Box<BothSides>>,
    /// Whether the sinks receive this sample; estimators see every sample. For recorded readings
    /// always true.
    pub is_record: bool,
}

/// A source of readings, in order of time.
pub trait Source {
    /// The next sample; `None` at the end.
    ///
    /// # Errors
    /// [`RunError`] where the source cannot go on.
    fn next_sample(&mut self) -> Result<Option<Sample>>;

    /// Takes the commands of the wheels, which act from the next sample on. Recorded readings
    /// ignore them.
    fn command(&mut self, _commands: [WheelCommand; 3]) {}

    /// Mean integration step so far, s. `None` where nothing is integrated.
    fn mean_step(&self) -> Option<f64>;

    /// What became of the rows of a recorded log so far. `None` for a simulation.
    fn log_report(&self) -> Option<LogReport> {
        None
    }
}

/// The simulation of a scene with its sensors.
pub struct Simulation {
    truth: Origin,
    sensors: Sensors,
    /// Samples taken so far.
    taken: u64,
    /// Samples of the whole scene.
    samples: u64,
    samples_per_record: u64,
}

/// Where its truth comes from.
enum Origin {
    /// It is simulated now.
    Plant(Box<Plant>),
    /// It was simulated before.
    Kept(Arc<[Truth]>),
}

impl Simulation {
    /// The simulation at time zero, with the sensor errors that the scene's seed draws.
    ///
    /// # Errors
    /// [`RunError::Start`] where the robot cannot stand on its ground.
    pub fn new(scene: &Scene) -> Result<Self> {
        let plant = Plant::new(&scene.plant_setup()).map_err(|e| RunError::Start(e.into()))?;
        let samples = (scene.record.count() - 1) * scene.samples_per_record() + 1;
        Ok(Self::of(scene, Origin::Plant(Box::new(plant)), samples))
    }

    /// A truth that was simulated before, read by the sensors of a scene.
    pub(crate) fn observing(scene: &Scene, truth: Arc<[Truth]>) -> Self {
        let samples = truth.len() as u64;
        Self::of(scene, Origin::Kept(truth), samples)
    }

    fn of(scene: &Scene, truth: Origin, samples: u64) -> Self {
        Self {
            truth,
            sensors: scene.sensors(),
            taken: 0,
            samples,
            samples_per_record: scene.samples_per_record(),
        }
    }
}

impl Source for Simulation {
    fn next_sample(&mut self) -> Result<Option<Sample>> {
        if self.taken == self.samples {
            return Ok(None);
        }
        let truth = match &mut self.truth {
            Origin::Plant(plant) => *plant.next_truth().map_err(PlantFailure::from)?,
            Origin::Kept(truth) => truth[self.taken as usize],
        };
        let is_record = self.taken.is_multiple_of(self.samples_per_record);
        self.taken += 1;
        Ok(Some(Sample {
            time: truth.time,
            truth: Some(truth),
            sensors: self.sensors.read(&truth),
            both: None,
            is_record,
        }))
    }

    fn command(&mut self, commands: [WheelCommand; 3]) {
        if let Origin::Plant(plant) = &mut self.truth {
            plant.command(commands);
        }
    }

    fn mean_step(&self) -> Option<f64> {
        match &self.truth {
            Origin::Plant(plant) => Some(plant.mean_step()),
            Origin::Kept(_) => None,
        }
    }
}

//! The loop that owns time. Data flows one way:
//!
//! ```text
//! plant -> Truth --------------------------------> sinks
//!              \-> SensorFrame -> estimators -> Estimate -^
//! ```
//!
//! Several estimators run side by side on the same readings. A [`Sink`] is told of every record and never calls back.

use robhaz_estimator::{Estimate, EstimateError, Estimator, LinkReading, SensorFrame};
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::sensors::{Readings, Sensors};
use robhaz_sim::{Plant, PlantError, Truth};

/// One record of a run.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// What truly happens.
    pub truth: &'a Truth,
    /// What the sensors read of it.
    pub sensors: &'a SensorFrame,
    /// What each estimator makes of the readings, in the scene's order.
    pub estimates: &'a [Result<Estimate, EstimateError>],
}

/// How a finished run went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunEnd {
    /// Simulated time, s.
    pub duration: f64,
    /// Time that simulation and estimation took, without the sinks, s.
    pub wall: f64,
    /// Mean integration step, s.
    pub step: f64,
}

impl RunEnd {
    /// Simulated seconds a second.
    pub fn real_time_factor(&self) -> f64 {
        self.duration / self.wall
    }
}

/// Why a sink cannot go on, in words for the user.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// Something that keeps or shows a run: tables, figures, a recording, a progress bar.
pub trait Sink {
    /// Before the first record.
    ///
    /// # Errors
    /// What the sink cannot do; the run does not start.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError>;

    /// At every record, in order of time.
    ///
    /// # Errors
    /// What the sink cannot do; the run stops.
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError>;

    /// After the last record. `None` when the run broke off: keep what there is.
    ///
    /// # Errors
    /// What the sink cannot do.
    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError>;
}

/// Why a run broke off.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The simulation left its range of validity.
    #[error("the simulation stopped")]
    Plant(#[from] PlantError),
    /// The estimators cannot be told of the robot.
    #[error("model_error")]
    ModelError(#[from] ModelErrorTooLarge),
    /// A sink failed.
    #[error(transparent)]
    Sink(SinkError),
}

/// Runs a scene from its start to its end and tells every sink of it.
///
/// When the run breaks off, the sinks are still told to end, so that what was recorded is kept.
///
/// # Errors
/// [`RunError`], after the sinks were told to end.
pub fn run(scene: &Scene, sinks: &mut [&mut dyn Sink]) -> Result<RunEnd, RunError> {
    for i in 0..sinks.len() {
        if let Err(error) = sinks[i].begin(scene) {
            // Those that have begun are told; the first failure is what counts.
            for sink in &mut sinks[..i] {
                let _ = sink.end(None);
            }
            return Err(RunError::Sink(error));
        }
    }
    let result = simulate(scene, sinks);
    let mut first_failure = None;
    for sink in sinks.iter_mut() {
        if let Err(error) = sink.end(result.as_ref().ok()) {
            first_failure.get_or_insert(error);
        }
    }
    match (result, first_failure) {
        (Ok(_), Some(error)) => Err(RunError::Sink(error)),
        (result, _) => result,
    }
}

fn simulate(scene: &Scene, sinks: &mut [&mut dyn Sink]) -> Result<RunEnd, RunError> {
    let mut wall = std::time::Duration::ZERO;
    let start = std::time::Instant::now();
    let mut plant = Plant::new(&scene.plant_setup());
    let mut observers = Observers::new(scene)?;
    wall += start.elapsed();
    for record in 0..scene.record_count() {
        let start = std::time::Instant::now();
        // Between records the sensors and estimators go on at their own rate.
        if record > 0 {
            for _ in 1..scene.samples_per_record() {
                observers.observe(&plant.next_truth()?);
            }
        }
        let truth = plant.next_truth()?;
        let (frame, estimates) = observers.observe(&truth);
        wall += start.elapsed();
        for sink in sinks.iter_mut() {
            sink.frame(&Frame {
                truth: &truth,
                sensors: frame,
                estimates,
            })
            .map_err(RunError::Sink)?;
        }
    }
    Ok(RunEnd {
        duration: scene.record.duration,
        wall: wall.as_secs_f64(),
        step: plant.mean_step(),
    })
}

/// The sensors of a scene, and its estimators behind them: what sees the truth through readings alone.
pub struct Observers {
    sensors: Sensors,
    estimators: Vec<Estimator>,
    frame: Option<SensorFrame>,
    estimates: Vec<Result<Estimate, EstimateError>>,
}

impl Observers {
    /// Those of a scene, with its seed.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the robot that the estimators would be told cannot be one.
    pub fn new(scene: &Scene) -> Result<Self, ModelErrorTooLarge> {
        let told = scene.nominal_robot()?;
        let estimator = |e| Estimator::new(&told, scene.nominal_settings(e));
        Ok(Self {
            sensors: scene.sensors(),
            estimators: scene.estimators.iter().map(estimator).collect(),
            frame: None,
            estimates: Vec::with_capacity(scene.estimators.len()),
        })
    }

    /// Reads the sensors at one instant and lets every estimator make of it what it can, in the scene's order.
    pub fn observe(&mut self, truth: &Truth) -> (&SensorFrame, &[Result<Estimate, EstimateError>]) {
        let frame = self.frame.insert(sensor_frame(&self.sensors.read(truth)));
        self.estimates.clear();
        let frame = &*frame;
        self.estimates
            .extend(self.estimators.iter_mut().map(|e| e.update(frame)));
        (frame, &self.estimates)
    }
}

/// The only bridge between simulator and estimator: readings, field by field.
pub fn sensor_frame(readings: &Readings) -> SensorFrame {
    let link = |i: usize| LinkReading {
        inclination: readings.inclination[i],
        rate: readings.rate[i],
    };
    SensorFrame {
        time: readings.time,
        wheel_angle: readings.wheel_angle,
        motor_torque: readings.motor_torque,
        link1: link(0),
        link2: link(1),
        contact_angle: readings.contact_angle,
    }
}

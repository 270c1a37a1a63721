//! The loop that owns time. Data flows one way:
//!
//! ```text
//! plant -> Truth --------------------------------> sinks
//!              \-> SensorFrame -> estimators -> Estimate -^
//! ```
//!
//! Several estimators run side by side on the same readings. A [`Sink`] receives every record and never calls back.

mod progress;

pub use progress::{Progress, ProgressMeter};

use robhaz_estimator::{Estimate, EstimateError, Estimator, LinkReading, SensorFrame};
use robhaz_scene::{ModelErrorTooLarge, Scene};
use robhaz_sim::sensors::{Readings, Sensors};
use robhaz_sim::{Plant, PlantError, Truth};
use std::error::Error as _;
use std::time::{Duration, Instant};

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

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEnd {
    /// Simulated time up to the last record, s.
    pub duration: f64,
    /// Time that simulation and estimation took, without the sinks, s.
    pub wall: f64,
    /// Mean integration step, s.
    pub step: f64,
    /// Why the run ended before the scene did, in words for the user. `None` for a complete run.
    pub broken_off: Option<String>,
}

impl RunEnd {
    /// Simulated seconds a second.
    pub fn real_time_factor(&self) -> f64 {
        self.duration / self.wall
    }

    /// Did the run reach the end of its scene?
    pub fn is_complete(&self) -> bool {
        self.broken_off.is_none()
    }
}

/// Asks whether the run has to stop: the cause in a few words, such as `Ctrl-C`, or `None` to go on. Asked once a sample.
pub type Stop<'a> = &'a dyn Fn() -> Option<&'static str>;

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

    /// After the last record, also of a run that broke off: [`RunEnd::broken_off`] tells. `None` when there is no record at
    /// all, because the run could not start.
    ///
    /// # Errors
    /// What the sink cannot do.
    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError>;
}

/// Why a run broke off.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The robot cannot stand at its start: nothing was simulated.
    #[error("the robot cannot stand at its start")]
    Start(#[source] PlantError),
    /// The simulation left its range of validity.
    #[error("the simulation stopped")]
    Plant(#[from] PlantError),
    /// The estimators cannot be told of the robot.
    #[error("model_error")]
    ModelError(#[from] ModelErrorTooLarge),
    /// A sink failed.
    #[error(transparent)]
    Sink(SinkError),
    /// The caller stopped the run.
    #[error("stopped by {cause}")]
    Stopped {
        /// What [`Stop`] answered.
        cause: &'static str,
    },
}

/// Runs a scene from its start to its end and hands every record to every sink.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::run`].
pub fn run(scene: &Scene, sinks: &mut [&mut dyn Sink]) -> Result<RunEnd, RunError> {
    run_until(scene, sinks, &|| None)
}

/// As [`run`], but ends early when `stop` names a cause.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::run`].
pub fn run_until(
    scene: &Scene,
    sinks: &mut [&mut dyn Sink],
    stop: Stop<'_>,
) -> Result<RunEnd, RunError> {
    Simulation::new(scene)?.run(sinks, stop)
}

/// A scene while it is simulated and estimated: from the start on the robot stands on its ground.
pub struct Simulation<'a> {
    scene: &'a Scene,
    plant: Plant,
    observers: Observers,
    /// Time spent without the sinks.
    wall: Duration,
    /// Simulated time of the last record, s. `None` before the first.
    time: Option<f64>,
}

impl<'a> Simulation<'a> {
    /// Puts the robot on its ground, and sensors and estimators beside it.
    ///
    /// # Errors
    /// [`RunError::Start`] and [`RunError::ModelError`].
    pub fn new(scene: &'a Scene) -> Result<Self, RunError> {
        let start = Instant::now();
        let plant = Plant::new(&scene.plant_setup()).map_err(RunError::Start)?;
        let observers = Observers::new(scene)?;
        Ok(Self {
            scene,
            plant,
            observers,
            wall: start.elapsed(),
            time: None,
        })
    }

    /// Runs to the end, or until `stop` names a cause.
    ///
    /// When the run breaks off, the sinks still end, so that what was recorded is kept.
    ///
    /// # Errors
    /// [`RunError`], after the sinks have ended; [`RunError::Stopped`] when `stop` ended the run.
    pub fn run(mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result<RunEnd, RunError> {
        for i in 0..sinks.len() {
            if let Err(error) = sinks[i].begin(self.scene) {
                // Those that have begun end; the first failure is what counts.
                for sink in &mut sinks[..i] {
                    let _ = sink.end(None);
                }
                return Err(RunError::Sink(error));
            }
        }
        let result = self.simulate(sinks, stop);
        let end = self.end(result.as_ref().err());
        let mut first_failure = None;
        for sink in sinks.iter_mut() {
            if let Err(error) = sink.end(end.as_ref()) {
                first_failure.get_or_insert(error);
            }
        }
        match (result, first_failure, end) {
            (Err(error), ..) => Err(error),
            (Ok(()), Some(error), _) => Err(RunError::Sink(error)),
            (Ok(()), None, Some(end)) => Ok(end),
            // A scene has at least the record at time zero.
            (Ok(()), None, None) => Err(RunError::Sink("the scene has no record".into())),
        }
    }

    fn simulate(&mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result<(), RunError> {
        for record in 0..self.scene.record_count() {
            let start = Instant::now();
            // Between records the sensors and estimators go on at their own rate.
            let samples = if record == 0 {
                1
            } else {
                self.scene.samples_per_record()
            };
            for _ in 1..samples {
                check(stop)?;
                self.observers.observe(&self.plant.next_truth()?);
            }
            check(stop)?;
            let truth = self.plant.next_truth()?;
            let (frame, estimates) = self.observers.observe(&truth);
            self.wall += start.elapsed();
            for sink in sinks.iter_mut() {
                sink.frame(&Frame {
                    truth: &truth,
                    sensors: frame,
                    estimates,
                })
                .map_err(RunError::Sink)?;
            }
            self.time = Some(truth.time);
        }
        Ok(())
    }

    /// How the run went. `None` without a record.
    fn end(&self, error: Option<&RunError>) -> Option<RunEnd> {
        let last = self.time?;
        Some(RunEnd {
            duration: match error {
                None => self.scene.record.duration,
                Some(_) => last,
            },
            wall: self.wall.as_secs_f64(),
            step: self.plant.mean_step(),
            broken_off: error.map(words),
        })
    }
}

fn check(stop: Stop<'_>) -> Result<(), RunError> {
    match stop() {
        None => Ok(()),
        Some(cause) => Err(RunError::Stopped { cause }),
    }
}

/// An error with all its causes, in one line.
fn words(error: &RunError) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
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

//! The loop that owns time. Within a sample data flows one way:
//!
//! ```text
//! source -> Truth -----------------------------> sinks
//!   ^   \-> SensorFrame -> estimators -> Estimate -^
//!   |              |                        |
//!   +- commands <- control <----------------+
//! ```
//!
//! A [`Source`] gives readings, sample by sample. [`Simulation`] is the source of a scene; a recorded log is a source
//! without truth. Several [`Estimators`] run side by side on the same readings. A [`Sink`] receives a
//! [`RunDescription`] and every record, and never calls back.
//!
//! Where the scene's control takes readings, a [`Driver`] hands its commands to the source; they act from the next sample
//! on. [`DrivenPlant`] is the same loop for those who need the truth alone.

mod clearance;
mod description;
mod driven_plant;
mod driver;
mod error;
mod estimators;
mod ground;
mod log_report;
mod pipeline;
mod sink;
mod source;

pub use clearance::TruthClearance;
pub use description::{ControlDescription, EstimatorDescription, RunDescription, World};
pub use driven_plant::{DrivenPlant, StartError};
pub use driver::Driver;
pub use error::RunError;
pub use estimators::{Estimators, Observers};
pub use ground::FeltGround;
pub use log_report::{ChannelReport, LogReport};
pub use sink::{Frame, RunEnd, Sink, SinkError};
pub use source::{Sample, Simulation, Source, sensor_frame};

use pipeline::Record;
use robhaz_scene::Scene;
use std::time::{Duration, Instant};
use tracing::debug;

/// Asks whether the run has to stop: a short cause such as `Ctrl-C`, or `None` to go on. Asked at every sample.
pub type Stop<'a> = &'a dyn Fn() -> Option<&'static str>;

/// Runs a scene from its start to its end and hands every record to every sink.
///
/// # Errors
/// As [`Run::new`] and [`Run::until`].
pub fn run(scene: &Scene, sinks: &mut [&mut dyn Sink]) -> Result<RunEnd, RunError> {
    run_until(scene, sinks, &|| None)
}

/// As [`run`], but ends early when `stop` names a cause.
///
/// # Errors
/// As [`Run::new`] and [`Run::until`].
pub fn run_until(
    scene: &Scene,
    sinks: &mut [&mut dyn Sink],
    stop: Stop<'_>,
) -> Result<RunEnd, RunError> {
    Run::new(scene)?.until(sinks, stop)
}

/// Where the readings of a run come from.
enum Readings {
    /// A simulation, which takes commands.
    Simulated(Box<dyn Source>),
    /// Readings that do not depend on the estimates.
    Recorded(Box<dyn Source + Send>),
}

/// A run that is ready to start.
pub struct Run {
    description: RunDescription,
    source: Readings,
    estimators: Estimators,
    /// The control, where it takes readings.
    driver: Option<Driver>,
    /// Off the hot path: at records alone. `None` for recorded readings.
    clearance: Option<TruthClearance>,
    /// Time spent without the sinks.
    wall: Duration,
    /// Time of the last record, s. `None` before the first.
    time: Option<f64>,
}

impl Run {
    /// The simulation of a scene: puts the robot on its ground and prepares its sensors and estimators.
    ///
    /// # Errors
    /// [`RunError::Start`] and [`RunError::ModelError`].
    pub fn new(scene: &Scene) -> Result<Self, RunError> {
        let start = Instant::now();
        let source = Readings::Simulated(Box::new(Simulation::new(scene)?));
        let mut run = Self::ready(RunDescription::of(scene)?, source);
        run.driver = Driver::of(scene)?;
        run.wall = start.elapsed();
        Ok(run)
    }

    /// A run on recorded readings, with the estimators of its description and without a control. Reading, estimators and sinks
    /// work on several threads; the estimates are those of one loop, to the bit.
    pub fn of(description: RunDescription, source: Box<dyn Source + Send>) -> Self {
        Self::ready(description, Readings::Recorded(source))
    }

    fn ready(description: RunDescription, source: Readings) -> Self {
        let start = Instant::now();
        let settings = description.estimators.iter().map(|e| e.settings);
        Self {
            estimators: Estimators::new(&description.nominal_robot, settings),
            clearance: TruthClearance::of_run(&description),
            description,
            source,
            driver: None,
            wall: start.elapsed(),
            time: None,
        }
    }

    /// Runs to the end of the source, or until `stop` names a cause. When the run breaks off, the sinks still end, so
    /// that what was recorded is kept.
    ///
    /// # Errors
    /// [`RunError`], after the sinks have ended; [`RunError::Stopped`] when `stop` ended the run.
    pub fn until(
        mut self,
        sinks: &mut [&mut dyn Sink],
        stop: Stop<'_>,
    ) -> Result<RunEnd, RunError> {
        begin(&self.description, sinks)?;
        let result = match self.source {
            Readings::Simulated(_) => self.simulated(sinks, stop),
            Readings::Recorded(_) => self.recorded(sinks, stop),
        };
        let end = self.end(result.as_ref().err());
        if let Some(end) = &end {
            debug!(
                name = self.description.name,
                simulated_s = end.duration,
                computing_s = end.wall,
                mean_step_s = end.step,
                broken_off = end.broken_off,
                "run ended"
            );
        }
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
            (Ok(()), None, None) => Err(RunError::Empty),
        }
    }

    fn recorded(&mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result<(), RunError> {
        let Readings::Recorded(source) = &mut self.source else {
            return Ok(());
        };
        let time = &mut self.time;
        let record = |(sample, estimates, completed): Record<'_>| {
            if let Some(cause) = stop() {
                return Err(RunError::Stopped { cause });
            }
            let frame = Frame {
                time: sample.time,
                clearances: None,
                truth: sample.truth.as_ref(),
                sensors: &sample.sensors,
                estimates,
                commands: None,
                ground: FeltGround::new(&[], completed),
            };
            for sink in sinks.iter_mut() {
                sink.frame(&frame).map_err(RunError::Sink)?;
            }
            *time = Some(sample.time);
            Ok(())
        };
        pipeline::run(
            source.as_mut(),
            &mut self.estimators,
            &mut self.wall,
            record,
        )
    }

    fn simulated(&mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result<(), RunError> {
        let Readings::Simulated(source) = &mut self.source else {
            return Ok(());
        };
        loop {
            if let Some(cause) = stop() {
                return Err(RunError::Stopped { cause });
            }
            let start = Instant::now();
            let Some(sample) = source.next_sample()? else {
                return Ok(());
            };
            let estimates = self.estimators.update(&sample.sensors);
            let driver = self.driver.as_mut();
            let commands = driver.map(|driver| driver.commands(&sample.sensors, estimates));
            if let Some(commands) = commands {
                source.command(commands);
            }
            self.wall += start.elapsed();
            if !sample.is_record {
                continue;
            }
            let truth = sample.truth.as_ref();
            let clearances = self.clearance.as_mut().zip(truth).map(|(c, t)| c.at(t));
            let frame = Frame {
                time: sample.time,
                clearances,
                truth: sample.truth.as_ref(),
                sensors: &sample.sensors,
                estimates: self.estimators.estimates(),
                commands,
                ground: self.estimators.ground(),
            };
            for sink in sinks.iter_mut() {
                sink.frame(&frame).map_err(RunError::Sink)?;
            }
            self.estimators.forget_completed();
            self.time = Some(sample.time);
        }
    }

    /// How the run ended. `None` without a record.
    fn end(&self, error: Option<&RunError>) -> Option<RunEnd> {
        let last = self.time?;
        let ground = self.estimators.ground();
        let remaining = |k: usize| {
            let completed = ground.completed(k).iter().copied();
            completed.chain(ground.in_memory(k)).collect()
        };
        let count = self.description.estimators.len();
        let source: &dyn Source = match &self.source {
            Readings::Simulated(source) => source.as_ref(),
            Readings::Recorded(source) => source.as_ref(),
        };
        Some(RunEnd {
            ground: (0..count).map(remaining).collect(),
            duration: match error {
                None => self.description.record.duration,
                Some(_) => last,
            },
            wall: self.wall.as_secs_f64(),
            step: source.mean_step(),
            broken_off: error.map(RunError::line),
            friction_tests: self
                .driver
                .iter()
                .flat_map(Driver::friction_tests)
                .collect(),
            log: source.log_report(),
        })
    }
}

/// Lets every sink begin. When one fails, those that have begun end.
fn begin(run: &RunDescription, sinks: &mut [&mut dyn Sink]) -> Result<(), RunError> {
    for i in 0..sinks.len() {
        if let Err(error) = sinks[i].begin(run) {
            for sink in &mut sinks[..i] {
                // The first failure is reported.
                let _ = sink.end(None);
            }
            return Err(RunError::Sink(error));
        }
    }
    Ok(())
}

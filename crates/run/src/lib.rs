//! The loop that owns time. Within a sample data flows one way:
//!
//! ```text
//! source -> Truth -----------------------------> sinks
//!   ^   \-> SensorFrame -> estimators -> Estimate -^
//!   |              |                        |
//!   +- commands <- control <----------------+
//! ```
//!
//! A [`Source`] gives readings, sample by sample. [`Simulation`] is the source of a scene; a
//! recorded log is a source without truth. Several [`Estimators`] run side by side on the same
//! readings. A [`Sink`] receives a [`RunDescription`] and every record, and never calls back.
//!
//! A run works in one loop, or on several threads ([`Run::on_threads`]): its records are the same,
//! to the bit.
//!
//! Where the scene's control takes readings, a [`Driver`] hands its commands to the source; they
//! act from the next sample on. [`DrivenPlant`] is the same loop for those who need the truth
//! alone, as the checks of [`verify`] do.

mod clearance;
mod description;
mod driver;
mod error;
mod estimators;
mod log_report;
mod pipeline;
mod record;
mod source;
mod ticker;
pub mod verify;

pub use clearance::TruthClearance;
pub use description::{BothDescription, EstimatorDescription, RunDescription};
pub use driver::{DrivenPlant, Driver};
pub use error::{MOST_KEPT, Result, RunError, in_one_line};
pub use estimators::{Estimators, Observers};
pub use log_report::{ChannelReport, LogReport};
pub use record::{
    BothFrame, BothSides, BothTruth, EstimatedTerrain, Frame, RunEnd, Sink, SinkError,
};
pub use source::{Sample, Simulation, Source};
pub use ticker::Ticker;

use pipeline::Work;
use robhaz_estimator::GroundPoint;
use robhaz_estimator::whole::WholeEstimator;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use std::sync::Arc;
use std::time::Instant;
use tracing::debug;

/// Asks whether the run has to stop: a short cause such as `Ctrl-C`, or `None` to go on. Asked before
/// records are handed on.
pub type Stop<'a> = &'a dyn Fn() -> Option<&'static str>;

/// Runs a scene from its start to its end and hands every record to every sink.
///
/// # Errors
/// As [`Run::new`] and [`Run::until`].
pub fn run(scene: &Scene, sinks: &mut [&mut dyn Sink]) -> Result<RunEnd> {
    Run::new(scene)?.until(sinks, &|| None)
}

/// A run that is ready to start.
pub struct Run {
    description: RunDescription,
    work: Work,
    /// Points of the ground that each estimator has completed, as far as records had them.
    ground: Vec<Vec<GroundPoint>>,
    /// Whether source, estimators and sinks have threads of their own.
    on_threads: bool,
    /// Truth of the first record, where it has one, and time of the last, s.
    records: Option<(Option<Truth>, f64)>,
}

impl Run {
    /// The simulation of a scene, in one loop: puts the robot on its ground and prepares its
    /// sensors and estimators.
    ///
    /// # Errors
    /// [`RunError::Start`] and [`RunError::ModelError`].
    pub fn new(scene: &Scene) -> Result<Self> {
        let start = Instant::now();
        let source = Box::new(Simulation::new(scene)?);
        let mut run = Self::ready(RunDescription::of(scene)?, source);
        run.work.driver = Driver::of(scene)?;
        run.work.wall = start.elapsed();
        Ok(run)
    }

    /// The sensors and estimators of a scene on a truth that was simulated before, one item a
    /// sample of the sensors, in one loop. Where the truth is that of the scene, all records are
    /// those of [`Run::new`], to the bit. No control drives.
    ///
    /// # Errors
    /// [`RunError::ModelError`].
    pub fn observing(scene: &Scene, truth: Arc<[Truth]>) -> Result<Self> {
        let source = Box::new(Simulation::observing(scene, truth));
        Ok(Self::ready(RunDescription::of(scene)?, source))
    }

    /// A run on recorded readings, with the estimators of its description and without a control, on
    /// several threads.
    pub fn of(description: RunDescription, source: Box<dyn Source + Send>) -> Self {
        Self::ready(description, source).on_threads()
    }

    /// The run of the estimator of both sides on recorded readings of both. The estimators of its
    /// description are the sides, left and right.
    pub fn of_both(
        description: RunDescription,
        source: Box<dyn Source + Send>,
        estimator: WholeEstimator,
    ) -> Self {
        let mut run = Self::of(description, source);
        run.work.estimators = Estimators::of_both(estimator);
        run
    }

    /// Source, estimators and sinks work on several threads, where no control needs the estimates:
    /// the run of one scene is faster, that of many scenes at once is not. The records are those of
    /// one loop, to the bit, but completed points of the ground may come with another record: see
    /// [`EstimatedTerrain`].
    #[must_use]
    pub fn on_threads(mut self) -> Self {
        self.on_threads = true;
        self
    }

    fn ready(description: RunDescription, source: Box<dyn Source + Send>) -> Self {
        let start = Instant::now();
        let settings = description.estimators.iter().map(|e| e.settings);
        Self {
            work: Work {
                estimators: Estimators::new(&description.nominal_robot, settings),
                clearance: description.world.as_deref().map(TruthClearance::of),
                source,
                driver: None,
                wall: start.elapsed(),
            },
            ground: vec![Vec::new(); description.estimators.len()],
            description,
            on_threads: false,
            records: None,
        }
    }

    /// Runs to the end of the source, or until `stop` names a cause. When the run breaks off, the
    /// sinks still end, so that what was recorded is kept.
    ///
    /// # Errors
    /// [`RunError`], after the sinks have ended; [`RunError::Stopped`] when `stop` ended the run.
    pub fn until(mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result<RunEnd> {
        begin(&self.description, sinks)?;
        let result = self.work(sinks, stop);
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

    /// Hands every record to every sink.
    fn work(&mut self, sinks: &mut [&mut dyn Sink], stop: Stop<'_>) -> Result {
        let (records, ground) = (&mut self.records, &mut self.ground);
        let hand_on = |frames: &[Frame<'_>]| {
            let stopped = (0..frames.len()).find_map(|k| stop().map(|cause| (k, cause)));
            let frames = stopped.map_or(frames, |(k, _)| &frames[..k]);
            for frame in frames {
                // The truth of the first record, and the time of the last.
                records.get_or_insert((frame.truth.copied(), 0.0)).1 = frame.time;
            }
            for sink in sinks.iter_mut() {
                sink.frames(frames).map_err(RunError::Sink)?;
            }
            for frame in frames {
                for (k, points) in ground.iter_mut().enumerate() {
                    points.extend_from_slice(frame.ground.completed(k));
                }
            }
            match stopped {
                Some((_, cause)) => Err(RunError::Stopped { cause }),
                None => Ok(()),
            }
        };
        match self.on_threads && self.work.driver.is_none() {
            true => self.work.on_threads(hand_on),
            false => self.work.in_one_loop(hand_on),
        }
    }

    /// How the run ended. `None` without a record.
    fn end(&mut self, error: Option<&RunError>) -> Option<RunEnd> {
        let (start, last) = self.records?;
        let ground = std::mem::take(&mut self.ground).into_iter();
        let estimators = &self.work.estimators;
        let rest = (estimators.completed.iter()).zip(estimators.memory());
        let whole = |(points, (completed, memory)): (Vec<GroundPoint>, _)| {
            [points, Vec::clone(completed), memory].concat().into()
        };
        let friction_tests = self.work.driver.iter().flat_map(Driver::friction_tests);
        Some(RunEnd {
            ground: ground.zip(rest).map(whole).collect(),
            start,
            duration: match error {
                None => self.description.record.duration,
                Some(_) => last,
            },
            wall: self.work.wall.as_secs_f64(),
            step: self.work.source.mean_step(),
            broken_off: error.map(|error| in_one_line(error)),
            friction_tests: friction_tests.collect(),
            log: self.work.source.log_report(),
        })
    }
}

/// Lets every sink begin. When one fails, those that have begun end.
fn begin(run: &RunDescription, sinks: &mut [&mut dyn Sink]) -> Result {
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

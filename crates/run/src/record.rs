//! The records of a run, and their receivers.

use crate::description::RunDescription;
use crate::log_report::LogReport;
use robhaz_control::FrictionTestResult;
use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_estimator::{Estimate, EstimateError, GroundPoint, SensorFrame};
use robhaz_model::WheelCommand;
use robhaz_sim::Truth;
use robhaz_sim::clearance::Clearances;
use std::sync::Arc;

/// One record of a run.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Time since the start of the run, s.
    pub time: f64,
    /// The simulated truth. `None` for recorded readings.
    pub truth: Option<&'a Truth>,
    /// Clearance of body and links to the ground, by the truth. `None` for recorded readings.
    pub clearances: Option<Clearances>,
    /// The readings of the sensors.
    pub sensors: &'a SensorFrame,
    /// Readings, truth and estimate of a log of both sides; `None` of other runs.
    pub both: Option<BothFrame<'a>>,
    /// The estimate of each estimator, in the order of [`RunDescription::estimators`].
    pub estimates: &'a [Result<Estimate, EstimateError>],
    /// The commands that the control derives from these readings and estimates; they act from the
    /// next sample on. `None` without a control that takes readings.
    pub commands: Option<[WheelCommand; 3]>,
    /// The ground as each estimator knows it, in the same order.
    pub ground: EstimatedTerrain<'a>,
}

impl<'a> Frame<'a> {
    /// The estimate of an estimator, by its place among [`Self::estimates`].
    pub fn estimate(&self, estimator: usize) -> Option<&'a Estimate> {
        self.estimates.get(estimator)?.as_ref().ok()
    }

    /// What the estimators are compared with: one truth for all of them, or, of a log of both sides,
    /// one a side. Empty where there is none.
    pub fn truths(&self) -> &'a [Truth] {
        match self.both {
            Some(both) => both.sides.truth.as_ref().map_or(&[], |t| &t.sides),
            None => self.truth.map_or(&[], std::slice::from_ref),
        }
    }
}

/// Readings of both sides at one instant.
#[derive(Clone, Debug)]
pub struct BothSides {
    /// The readings.
    pub readings: WholeFrame,
    /// The truth, where the log has a table of it.
    pub truth: Option<BothTruth>,
}

/// True forces of both sides, left and right.
#[derive(Clone, Copy, Debug)]
pub struct BothTruth {
    /// N and T of the wheels of each side; N in the wheels' planes where it is known, else along the
    /// ground's normal.
    pub sides: [Truth; 2],
    /// N along the ground's normal, N.
    pub normal_force: [f64; 6],
    /// N in the planes of the wheels, N, where it is known.
    pub in_plane: Option<[f64; 6]>,
}

/// What a record of a log of both sides has beside what its sides have. Their estimates are those
/// of the two estimators of the run, left and right.
#[derive(Clone, Copy, Debug)]
pub struct BothFrame<'a> {
    /// Readings and truth.
    pub sides: &'a BothSides,
    /// The estimate; `None` where there is none.
    pub estimate: Option<&'a WholeEstimate>,
}

/// The ground as the estimators of a run know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimatedTerrain<'a> {
    /// The points in the memory of each.
    pub(crate) memory: &'a [Vec<GroundPoint>],
    /// The points that each has completed.
    pub(crate) completed: &'a [Vec<GroundPoint>],
}

impl<'a> EstimatedTerrain<'a> {
    /// Points that left the memory of an estimator since the last record, in their final form: see
    /// [`robhaz_estimator::Estimator::completed_ground`]. Without a control some records share
    /// them: the last one has them.
    pub fn completed(&self, estimator: usize) -> &'a [GroundPoint] {
        self.completed.get(estimator).map_or(&[], Vec::as_slice)
    }

    /// Whether this record has the points in memory: one in 0.2 s has them.
    pub const fn has_memory(&self) -> bool {
        !self.memory.is_empty()
    }

    /// Points in the memory of an estimator: see [`robhaz_estimator::Estimator::ground`]. None where
    /// [`Self::has_memory`] is false.
    pub fn in_memory(&self, estimator: usize) -> &'a [GroundPoint] {
        self.memory.get(estimator).map_or(&[], Vec::as_slice)
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEnd {
    /// The truth of the first record; `None` for recorded readings.
    pub start: Option<Truth>,
    /// Time of the run up to its end, s.
    pub duration: f64,
    /// Time that source and estimators took, without the sinks, s; on several threads the time of
    /// the slower one.
    pub wall: f64,
    /// Mean integration step of the simulation, s. `None` for recorded readings.
    pub step: Option<f64>,
    /// The whole ground that each estimator has found, in the order of
    /// [`RunDescription::estimators`]: the points that the records have completed, and the rest.
    /// Sinks share it.
    pub ground: Vec<Arc<[GroundPoint]>>,
    /// Why the run ended before its source did, for the user. `None` for a complete run.
    pub broken_off: Option<String>,
    /// Results of the friction tests, in their order.
    pub friction_tests: Vec<FrictionTestResult>,
    /// What became of the rows of a recorded log. `None` for a simulation.
    pub log: Option<LogReport>,
}

impl RunEnd {
    /// Seconds of the run per second of computing.
    pub fn real_time_factor(&self) -> f64 {
        self.duration / self.wall
    }

    /// Whether the run reached the end of its source.
    pub fn is_complete(&self) -> bool {
        self.broken_off.is_none()
    }
}

/// Why a sink cannot go on, for the user.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// A receiver of records: tables, figures, a recording, a progress bar. It never calls back.
pub trait Sink {
    /// Called before the first record.
    ///
    /// # Errors
    /// The sink cannot start. The run does not start.
    fn begin(&mut self, _run: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    /// Called at every record, in order of time.
    ///
    /// # Errors
    /// The sink cannot go on. The run stops.
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError>;

    /// Called with records that follow each other, in place of [`Self::frame`], where the run has
    /// several at once.
    ///
    /// # Errors
    /// The sink cannot go on. The run stops.
    fn frames(&mut self, frames: &[Frame<'_>]) -> Result<(), SinkError> {
        frames.iter().try_for_each(|frame| self.frame(frame))
    }

    /// Called after the last record, also when the run broke off: see [`RunEnd::broken_off`].
    /// `None` when the run could not start and has no record.
    ///
    /// # Errors
    /// The sink cannot finish.
    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// A function of the records alone.
impl<F: FnMut(&Frame<'_>) -> Result<(), SinkError>> Sink for F {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self(frame)
    }
}

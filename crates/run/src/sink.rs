//! Receivers of a run's records.

use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_scene::Scene;
use robhaz_sim::Truth;

/// One record of a run.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The simulated truth.
    pub truth: &'a Truth,
    /// The readings of the sensors.
    pub sensors: &'a SensorFrame,
    /// The estimate of each estimator, in the scene's order.
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
    /// Why the run ended before the scene did, for the user. `None` for a complete run.
    pub broken_off: Option<String>,
}

impl RunEnd {
    /// Simulated seconds per second.
    pub fn real_time_factor(&self) -> f64 {
        self.duration / self.wall
    }

    /// Whether the run reached the end of its scene.
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
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError>;

    /// Called at every record, in order of time.
    ///
    /// # Errors
    /// The sink cannot go on. The run stops.
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError>;

    /// Called after the last record, also when the run broke off: see [`RunEnd::broken_off`]. `None` when the run could not start
    /// and has no record.
    ///
    /// # Errors
    /// The sink cannot finish.
    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError>;
}

//! `summary.json`: how a run went, and the errors of each estimator.

mod both;
mod means;
mod parts;
mod sink;

pub use both::BothSummary;
pub use means::MeanForces;
pub use parts::{
    BrokenOff, ClearanceSummary, ControlSummary, EstimatorSummary, Faulty, FrictionSummary,
    FrictionTestSummary, NominalRobot, SensorErrors,
};
pub use sink::SummarySink;

use crate::error::{RecordError, Result, io_error};
use indexmap::IndexMap;
use robhaz_run::LogReport;
use robhaz_score::Progress;
use robhaz_score::events::EventCounts;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// Name of the file in a run's folder.
const FILE: &str = "summary.json";

/// The course of a run and the errors of each estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scene or log.
    pub scene: String,
    /// Name of the engine that computed the truth; `None` for recorded readings.
    pub engine: Option<String>,
    /// Seed of everything random in the run; `None` for recorded readings.
    pub seed: Option<u64>,
    /// Time of the run, s.
    pub duration_s: f64,
    /// Time that simulation and estimation took, s.
    pub wall_s: f64,
    /// Seconds of the run per second of computing.
    pub real_time_factor: f64,
    /// Mean integration step, s; `None` for recorded readings.
    pub step_s: Option<f64>,
    /// Rate of the records, Hz.
    pub record_rate_hz: f64,
    /// Time from which on errors count, s.
    pub compare_from_s: f64,
    /// Version of robhaz.
    pub version: String,
    /// Why and when the run ended before its source did; `None` for a complete run. All else then
    /// holds up to that time.
    pub broken_off: Option<BrokenOff>,
    /// Travel of the robot; `None` for recorded readings.
    pub progress: Option<Progress>,
    /// Numbers of events of wheels, end stops and bars; `None` for recorded
    /// readings.
    pub events: Option<EventCounts>,
    /// Clearance of body and links to the ground; `None` for recorded readings.
    pub clearance: Option<ClearanceSummary>,
    /// The friction of the ground; `None` for recorded readings.
    pub friction: Option<FrictionSummary>,
    /// The control of the wheels; `None` for recorded readings.
    pub control: Option<ControlSummary>,
    /// Results of the friction tests, in their order.
    pub friction_tests: Vec<FrictionTestSummary>,
    /// Sensor errors that were drawn for the run; no estimator knows them. `None` for recorded
    /// readings.
    pub sensors: Option<SensorErrors>,
    /// What a recorded log held; `None` for simulations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<LogReport>,
    /// The rover of a log of both sides, as a whole; `None` for other runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub both: Option<BothSummary>,
    /// The nominal robot, which the estimators were given.
    pub nominal: NominalRobot,
    /// The estimators by their names, in the order of the run; of a log of both sides its sides.
    pub estimators: IndexMap<String, EstimatorSummary>,
}

impl Summary {
    /// The text of `summary.json`.
    ///
    /// # Errors
    /// [`RecordError::Refused`]: JSON has no numbers that are not finite, and none is put in their place.
    pub fn to_json(&self) -> Result<String> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        // A number that is not finite becomes null, and NaN does not equal itself.
        match serde_json::from_str::<Self>(&text) {
            Ok(read) if read == *self => Ok(text + "\n"),
            _ => Err(RecordError::Refused(
                "a number of the summary is not finite".to_owned(),
            )),
        }
    }

    /// Writes `summary.json` into the folder of a run, completely or not at all.
    ///
    /// # Errors
    /// [`RecordError`] with the file's path, or as [`Summary::to_json`].
    pub fn write(&self, folder: &Path) -> Result {
        let path = folder.join(FILE);
        let partial = folder.join(format!("{FILE}.partial"));
        std::fs::write(&partial, self.to_json()?).map_err(io_error("write", &path))?;
        std::fs::rename(&partial, &path).map_err(io_error("write", &path))
    }

    /// Reads `summary.json` from the folder of a run, complete or broken off.
    ///
    /// # Errors
    /// [`RecordError`]: there is no such folder, the run was killed or never started, or the file
    /// is no summary.
    pub fn read(folder: &Path) -> Result<Self> {
        if !folder.is_dir() {
            return Err(RecordError::Refused(format!(
                "there is no folder {}",
                folder.display()
            )));
        }
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => RecordError::Refused(format!(
                "{} holds no summary.json: the run in it was killed or has no record, or it is not the folder of a run",
                folder.display()
            )),
            _ => io_error("read", &path)(error),
        })?;
        serde_json::from_str(&text).map_err(|source| RecordError::NotASummary { path, source })
    }
}

//! Why a run stops early.

use crate::record::SinkError;
use robhaz_control::ControlSettingsError;
use robhaz_scene::{ModelErrorTooLarge, PlantFailure};
use std::error::Error;
use std::iter::successors;

/// Largest number of truths of a run that are kept in memory: some 0.5 GB.
pub const MOST_KEPT: u64 = 500_000;

/// What a function of this crate returns: nothing, where no other type is stated.
pub type Result<T = (), E = RunError> = std::result::Result<T, E>;

/// Why a run broke off, or cannot start.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The simulation left its range of validity.
    #[error("the simulation stopped")]
    Plant(#[from] PlantFailure),
    /// The robot cannot stand, or does not settle, at its start. Nothing was simulated.
    #[error("the robot cannot stand at its start")]
    Start(#[source] PlantFailure),
    /// The nominal robot is not a valid robot.
    #[error("model_error")]
    ModelError(#[from] ModelErrorTooLarge),
    /// The settings of the control.
    #[error("control")]
    Control(#[from] ControlSettingsError),
    /// The system has no more threads.
    #[error("cannot start the threads of the estimators")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The truth of a whole run is too long for the memory.
    #[error(
        "the run has {found} {of}; {who} keeps all in memory and takes at most {MOST_KEPT}: shorten it, as with --set record.duration=20"
    )]
    TooLong {
        /// How many there are.
        found: u64,
        /// What is kept, in the plural.
        of: &'static str,
        /// Who keeps it.
        who: &'static str,
    },
    /// The source has no record.
    #[error("the run has no record")]
    Empty,
    /// A sink failed.
    #[error(transparent)]
    Sink(SinkError),
    /// The caller stopped the run.
    #[error("stopped by {cause}")]
    Stopped {
        /// The answer of [`crate::Stop`].
        cause: &'static str,
    },
}

/// An error with all its causes, in one line.
pub fn in_one_line(error: &dyn Error) -> String {
    let causes = successors(Some(error), |error| (*error).source());
    let texts: Vec<String> = causes.map(ToString::to_string).collect();
    texts.join(": ")
}

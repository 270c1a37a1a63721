//! Why a study cannot go on.

use robhaz_record::RecordError;
use robhaz_scene::FileError;
use std::path::PathBuf;

/// What a function of this crate returns: nothing, where no other type is stated.
pub type Result<T = (), E = StudyError> = std::result::Result<T, E>;

/// Why a study cannot go on. A run that fails is no such error: it is a row of the dataset with its
/// reason.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StudyError {
    /// The study file, its base scene, or a value of an axis.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] FileError),
    /// A scene without estimators, or seeds that a study cannot count: in words.
    #[error("{0}")]
    Refused(String),
    /// A run of a scene failed: none of the others says more.
    #[error("cannot study {scene}: {reason}")]
    Failed {
        /// Its name.
        scene: String,
        /// The reason of the first run that failed.
        reason: String,
    },
    /// The folder holds something else, or another process is writing into it: in words, and what to do.
    #[error("{0}")]
    #[diagnostic(help("{1}"))]
    Folder(String, &'static str),
    /// A manifest of a study that cannot be read.
    #[error("{path} is no description of a study")]
    Manifest {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: serde_json::Error,
    },
    /// A file cannot be written or read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A signal stopped the study.
    #[error("stopped by {cause}; {done} of {runs} runs are done")]
    #[diagnostic(help("{after}"))]
    Stopped {
        /// The signal.
        cause: &'static str,
        /// Finished runs of this shard.
        done: u64,
        /// Runs of this shard.
        runs: u64,
        /// What became of the finished runs.
        after: &'static str,
    },
    /// The threads cannot be started.
    #[error("cannot start the threads")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

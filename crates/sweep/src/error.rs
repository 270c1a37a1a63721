//! Why a sweep cannot go on.

use arrow_schema::ArrowError;
use parquet::errors::ParquetError;
use robhaz_scene::SceneError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a sweep cannot go on. A run that fails is no such error: it is a row of the dataset with its reason.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SweepError {
    /// The study file, its base scene, or a value of an axis.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(#[from] SceneError),
    /// The folder holds the runs of another study, or of another version of this one.
    #[error("{folder} holds runs of another study: {difference}")]
    #[diagnostic(help(
        "write elsewhere with --out DIR, or remove the folder; runs of two studies never mix"
    ))]
    OtherStudy {
        /// The folder.
        folder: PathBuf,
        /// What differs, found and wanted.
        difference: String,
    },
    /// The folder holds something, but no sweep.
    #[error("{0} is not empty and holds no sweep: it is left alone")]
    #[diagnostic(help("write elsewhere with --out DIR"))]
    NotASweep(PathBuf),
    /// A folder to be merged holds no sweep.
    #[error("{0} holds no sweep")]
    #[diagnostic(help("a sweep writes its folder: robhaz sweep STUDY.toml --shard I/N --out DIR"))]
    NoSweep(PathBuf),
    /// Another process computes runs of this folder.
    #[error("another process is writing in {0}")]
    #[diagnostic(help("wait for its end, or give each shard a folder of its own"))]
    InUse(PathBuf),
    /// Runs are missing.
    #[error("{missing} of {runs} runs are missing, the first one is run {first}{}", damaged_lines(*damaged))]
    #[diagnostic(help("compute the missing shards again: finished runs are not repeated"))]
    Incomplete {
        /// Number of missing runs.
        missing: u64,
        /// Number of all runs.
        runs: u64,
        /// Index of the first missing run.
        first: u64,
        /// Damaged lines of the journals.
        damaged: u64,
    },
    /// An error of the file system.
    #[error("cannot {action} {path}")]
    Io {
        /// The failed action.
        action: &'static str,
        /// The path.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A manifest of a sweep that cannot be read.
    #[error("{path} is no description of a sweep")]
    Manifest {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: serde_json::Error,
    },
    /// The dataset cannot be made.
    #[error("cannot make rows of the dataset")]
    Rows(#[from] ArrowError),
    /// The dataset cannot be written.
    #[error("cannot write {path}")]
    Parquet {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: ParquetError,
    },
    /// A signal stopped the sweep.
    #[error("stopped by {cause}; {done} of {runs} runs are done")]
    #[diagnostic(help("the same command goes on where it stopped"))]
    Stopped {
        /// The signal.
        cause: &'static str,
        /// Finished runs of this shard.
        done: u64,
        /// Runs of this shard.
        runs: u64,
    },
    /// A thread cannot be started.
    #[error("cannot start a thread")]
    Thread(#[source] io::Error),
    /// A thread ended by a panic outside of a run.
    #[error("internal error: a worker thread panicked")]
    Panic,
}

/// What is said of damaged lines; nothing without any.
fn damaged_lines(count: u64) -> String {
    match count {
        0 => String::new(),
        n => format!("; lines of runs.jsonl with a wrong checksum: {n}"),
    }
}

/// An error of the file system at a path.
pub fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> SweepError {
    let path = path.to_path_buf();
    move |source| SweepError::Io {
        action,
        path,
        source,
    }
}

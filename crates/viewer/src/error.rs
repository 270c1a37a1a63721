//! What can go wrong with a recording.

use std::path::{Path, PathBuf};

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// The file cannot be created.
    #[error("cannot create the recording {}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Data cannot be encoded or written; what was written before stays readable.
    #[error("cannot write the recording {}", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the encoder or the system says.
        source: Cause,
    },
    /// A record came before the run began.
    #[error("the recording {} was given a record before its run began", path.display())]
    NotBegun {
        /// Which file.
        path: PathBuf,
    },
    /// A second run was given to the same file.
    #[error("the recording {} already holds a run", path.display())]
    Used {
        /// Which file.
        path: PathBuf,
    },
}

impl ViewerError {
    /// Turns a cause into [`ViewerError::Write`] for a file.
    pub(crate) fn write<E: Into<Cause>>(path: &Path) -> impl FnOnce(E) -> Self {
        move |cause| Self::Write {
            path: path.to_owned(),
            source: cause.into(),
        }
    }
}

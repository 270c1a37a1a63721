//! Why a log cannot be used: file, place, what was found, what is allowed.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Why a log cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// An error of the file system.
    #[error("cannot read {path}", path = .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is not what its name says, or is damaged.
    #[error("{path} cannot be read as {what}: {reason}", path = .path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The format, in words.
        what: &'static str,
        /// The cause, and what helps.
        reason: String,
    },
    /// A place in a file has a problem.
    #[error("{path}, {place}: {message}", path = .path.display())]
    Place {
        /// The file.
        path: PathBuf,
        /// Row, column, topic.
        place: String,
        /// What was found, what is allowed, what helps.
        message: String,
    },
    /// Problems of the file as a whole, one a line.
    #[error("{path}: {message}", path = .path.display())]
    Whole {
        /// The file or folder.
        path: PathBuf,
        /// What was found, what is allowed, what helps.
        message: String,
    },
}

impl LogError {
    /// An error of the file system.
    pub(crate) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    /// A problem of a file as a whole.
    pub(crate) fn whole(path: &Path, message: impl Into<String>) -> Self {
        Self::Whole {
            path: path.to_path_buf(),
            message: message.into(),
        }
    }

    /// A problem at a place of a file.
    pub(crate) fn place(path: &Path, place: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Place {
            path: path.to_path_buf(),
            place: place.into(),
            message: message.into(),
        }
    }
}

/// Opens a file of a log. A pipe or a device is refused before it is opened: a log is read several
/// times.
pub(crate) fn open_file(path: &Path) -> Result<File, LogError> {
    let metadata = std::fs::metadata(path).map_err(LogError::io(path))?;
    if !metadata.is_file() {
        let message = "found a folder, pipe or device, allowed: a file, since a log is read several \
                       times; write it to a file first";
        return Err(LogError::whole(path, message));
    }
    File::open(path).map_err(LogError::io(path))
}

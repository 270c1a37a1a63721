//! Why a log cannot be used or written: file, place, what was found, what is allowed.

use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Why a log cannot be used or written.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// An error of the file system while a log is read.
    #[error("cannot read {path}", path = .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// An error of the file system, or of the format's library, while a log is written.
    #[error("cannot write {path}", path = .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The caller stopped the work, for the cause that [`robhaz_run::Stop`] returned.
    #[error("stopped by {0}")]
    Stopped(&'static str),
    /// A problem of a file: where, what was found, what is allowed, what helps.
    #[error("{0}")]
    Problem(String),
}

impl LogError {
    /// An error of the file system while a log is read.
    pub(crate) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    /// An error while a file is written.
    pub(crate) fn write<E>(path: &Path) -> impl FnOnce(E) -> Self + use<E>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let path = path.to_path_buf();
        move |cause| Self::Write {
            path,
            source: cause.into(),
        }
    }

    /// A file that is not what its name says, or is damaged; `what` is the format, in words.
    pub(crate) fn format(path: &Path, what: &str, reason: impl fmt::Display) -> Self {
        let path = path.display();
        Self::Problem(format!("{path} cannot be read as {what}: {reason}"))
    }

    /// A problem of a file as a whole.
    pub(crate) fn whole(path: &Path, message: impl fmt::Display) -> Self {
        Self::Problem(format!("{}: {message}", path.display()))
    }

    /// A problem at a place of a file: row, column, topic.
    pub(crate) fn place(path: &Path, place: impl fmt::Display, message: impl fmt::Display) -> Self {
        Self::Problem(format!("{}, {place}: {message}", path.display()))
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

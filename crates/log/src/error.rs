//! Why a log cannot be used or written: file, place, what was found, what is allowed.

use std::fmt;
use std::fs::File;
use std::io::{self, Read as _, Seek as _};
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
    let mut file = File::open(path).map_err(LogError::io(path))?;
    check_start(path, &mut file)
        .map_err(LogError::io(path))?
        .map_or(Ok(file), Err)
}

/// The error of a file whose first bytes are not those of its ending.
fn check_start(path: &Path, file: &mut File) -> io::Result<Option<LogError>> {
    const STARTS: [(&[u8], &str, &str); 5] = [
        (b"PAR1", "Parquet", "parquet"),
        (b"\x89MCAP", "MCAP", "mcap"),
        (b"SQLite format 3", "SQLite, as of a bag of ROS 2", "db3"),
        (b"#ROSBAG", "a bag of ROS 1", "bag"),
        (b"\x1f\x8b", "gzip", "gz"),
    ];
    let mut start = Vec::new();
    file.take(16).read_to_end(&mut start)?;
    file.rewind()?;
    let is_of = |ending: &str| {
        path.extension()
            .is_some_and(|own| own.eq_ignore_ascii_case(ending))
    };
    let found = STARTS.iter().find(|(bytes, ..)| start.starts_with(bytes));
    let own = STARTS.iter().find(|(.., ending)| is_of(ending));
    if found == own {
        return Ok(None);
    }
    let own = own.map_or("text", |(_, name, _)| name);
    let message = match found {
        Some((_, name, ending)) => {
            format!("its first bytes are those of {name}; rename it to .{ending}")
        }
        None if start.is_empty() => "the file is empty".to_owned(),
        None => {
            format!("its first bytes are not those of {own}; a table of text has the ending .csv")
        }
    };
    Ok(Some(LogError::format(path, own, message)))
}

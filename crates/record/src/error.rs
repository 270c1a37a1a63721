//! Errors of files, with the path of the file.

use std::error::Error;
use std::path::{Path, PathBuf};

/// An error of the file system or of a library.
type Cause = Box<dyn Error + Send + Sync>;

/// What a function of this crate returns: nothing, where no other type is stated.
pub type Result<T = (), E = RecordError> = std::result::Result<T, E>;

/// Why a run cannot be recorded or read back.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A file or folder cannot be read or written.
    #[error("cannot {action} {path}", path = path.display())]
    Io {
        /// The action that failed: `create`, `write`, `draw`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: Cause,
    },
    /// Columns of a table do not go together: a mistake of the program.
    #[error("cannot make a table")]
    Batch(#[from] arrow_schema::ArrowError),
    /// A file that is no summary.
    #[error("{path} is not the summary of a run", path = path.display())]
    NotASummary {
        /// The file.
        path: PathBuf,
        /// The first difference.
        source: serde_json::Error,
    },
    /// A folder or file that is not what it is taken for, a summary that cannot be: in words.
    #[error("{0}")]
    Refused(String),
}

/// Adds the path to a failure of the file system, or of a library that makes the file.
pub fn io_error<E: Into<Cause>>(
    action: &'static str,
    path: &Path,
) -> impl FnOnce(E) -> RecordError + use<E> {
    let path = path.to_path_buf();
    move |source| RecordError::Io {
        action,
        path,
        source: source.into(),
    }
}

/// Creates a folder and those above it, where they do not exist.
///
/// # Errors
/// [`RecordError::Io`].
pub fn create_folder(folder: &Path) -> Result {
    std::fs::create_dir_all(folder).map_err(io_error("create", folder))
}

/// The names in a folder, sorted, so that what follows does not depend on the file system.
///
/// # Errors
/// [`RecordError::Io`].
pub fn names_in(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).map_err(io_error("read", folder))?;
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names: Vec<String> = names
        .collect::<Result<_, _>>()
        .map_err(io_error::<std::io::Error>("read", folder))?;
    names.sort();
    Ok(names)
}

//! The output folder of a run: complete or not there.
//!
//! A run is written into `FOLDER.partial` and renamed when it is finished, so that a folder under its own name is always
//! a whole run, and a run that broke off leaves what it had beside it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Marks a folder as one of ours: only such a folder is ever replaced.
const MARK: &str = "scene.toml";

/// Why a run cannot be written where the user wants it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputError {
    /// Something is there already.
    #[error("{0} exists")]
    #[diagnostic(help("--force replaces the run in it; --out DIR writes elsewhere"))]
    Exists(PathBuf),
    /// What is there is not a run: it is not replaced even when asked.
    #[error("{0} exists and is not the folder of a run (it holds no {MARK}); it is left alone")]
    #[diagnostic(help("--out DIR writes elsewhere"))]
    NotARun(PathBuf),
    /// The file system says no.
    #[error("{action} {path}: {source}")]
    Io {
        /// What was tried.
        action: &'static str,
        /// On which path.
        path: PathBuf,
        /// What came back.
        source: io::Error,
    },
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_path_buf();
    move |source| OutputError::Io {
        action,
        path,
        source,
    }
}

/// A folder being written.
pub struct OutputFolder {
    target: PathBuf,
    partial: PathBuf,
}

impl OutputFolder {
    /// Prepares `target` for a run. Nothing that is there is touched before [`OutputFolder::finish`].
    pub fn create(target: &Path, force: bool) -> Result<Self, OutputError> {
        if target.exists() {
            if !force {
                return Err(OutputError::Exists(target.to_path_buf()));
            }
            check_replaceable(target)?;
        }
        let mut name = target.as_os_str().to_owned();
        name.push(".partial");
        let partial = PathBuf::from(name);
        if partial.exists() {
            check_replaceable(&partial)?;
            fs::remove_dir_all(&partial).map_err(io_error("cannot remove", &partial))?;
        }
        fs::create_dir_all(&partial).map_err(io_error("cannot create", &partial))?;
        Ok(Self {
            target: target.to_path_buf(),
            partial,
        })
    }

    /// Where to write while the run goes on.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Writes a small text file into the folder.
    pub fn write(&self, name: &str, text: &str) -> Result<(), OutputError> {
        let path = self.partial.join(name);
        fs::write(&path, text).map_err(io_error("cannot write", &path))
    }

    /// Gives the finished run its name, in place of an older one where that was asked for.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        if self.target.exists() {
            check_replaceable(&self.target)?;
            fs::remove_dir_all(&self.target).map_err(io_error("cannot remove", &self.target))?;
        }
        fs::rename(&self.partial, &self.target)
            .map_err(io_error("cannot rename", &self.partial))?;
        Ok(self.target)
    }
}

/// Only an empty folder or one that a run has left may go.
fn check_replaceable(path: &Path) -> Result<(), OutputError> {
    let mut entries = fs::read_dir(path).map_err(io_error("cannot read", path))?;
    if path.join(MARK).is_file() || entries.next().is_none() {
        Ok(())
    } else {
        Err(OutputError::NotARun(path.to_path_buf()))
    }
}

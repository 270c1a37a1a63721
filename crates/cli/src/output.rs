//! The output folder of a run.
//!
//! A run is written into `FOLDER.partial` and renamed at its end. So a folder under its own name is always a complete
//! run, and a run that broke off leaves its files in `FOLDER.partial`. With `--force` files that a run wrote are
//! removed, and no others.

use robhaz_record::FigureSink;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Why a run cannot be written where the user wants it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputError {
    /// The folder exists already.
    #[error("{0} exists")]
    #[diagnostic(help("--force replaces the run in it; --out DIR writes elsewhere"))]
    Exists(PathBuf),
    /// The folder of an unfinished run exists.
    #[error("{0} exists: a run broke off there, or one is still writing")]
    #[diagnostic(help("--force replaces it; --out DIR writes elsewhere"))]
    Unfinished(PathBuf),
    /// Not a folder: never replaced.
    #[error("{0} is a file, not the folder of a run: it is left alone")]
    #[diagnostic(help("--out DIR writes elsewhere"))]
    NotAFolder(PathBuf),
    /// Not the folder of a run: never replaced.
    #[error("{0} has no scene.toml that a run has written: it is left alone")]
    #[diagnostic(help("--out DIR writes elsewhere"))]
    NotARun(PathBuf),
    /// A folder of a run with other files in it: never replaced.
    #[error("{path} holds {found}, which no run has written: it is left alone")]
    #[diagnostic(help("move {found} elsewhere, or write elsewhere with --out DIR"))]
    NotOfARun {
        /// The folder.
        path: PathBuf,
        /// A file in it that is not of a run, relative to the folder.
        found: String,
    },
    /// The path cannot name a folder.
    #[error("{0} is not the name of a folder to write into")]
    NoName(PathBuf),
    /// An error of the file system.
    #[error("{action} {path}")]
    Io {
        /// The failed action.
        action: &'static str,
        /// The path.
        path: PathBuf,
        /// The cause.
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
    /// Prepares `target` for a run. An existing folder of that name stays until [`OutputFolder::finish`].
    pub fn create(target: &Path, force: bool) -> Result<Self, OutputError> {
        // Without a slash at the end: with it the partial folder would be inside the target.
        let target: PathBuf = target.components().collect();
        let Some(name) = target.file_name() else {
            return Err(OutputError::NoName(target));
        };
        let mut name = name.to_owned();
        name.push(".partial");
        let partial = target.with_file_name(name);
        if is_there(&target) && !is_empty_folder(&target) {
            if !force {
                return Err(OutputError::Exists(target));
            }
            check_replaceable(&target)?;
        }
        if is_there(&partial) {
            if !force {
                return Err(OutputError::Unfinished(partial));
            }
            check_replaceable(&partial)?;
            fs::remove_dir_all(&partial).map_err(io_error("cannot remove", &partial))?;
        }
        if let Some(parent) = partial.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(io_error("cannot create", parent))?;
        }
        // Fails if another run has just created it.
        fs::create_dir(&partial).map_err(io_error("cannot create", &partial))?;
        Ok(Self { target, partial })
    }

    /// The folder to write into during the run.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), OutputError> {
        let path = self.partial.join(name);
        fs::write(&path, content).map_err(io_error("cannot write", &path))
    }

    /// Whether the folder has tables that are still streams.
    pub fn has_streams(&self) -> bool {
        names(&self.partial).is_ok_and(|names| names.iter().any(|n| n.ends_with(".arrows")))
    }

    /// Gives the finished run its name. Replaces an older run, which [`OutputFolder::create`] has checked.
    pub fn finish(self) -> Result<PathBuf, OutputError> {
        if is_there(&self.target) {
            if !is_empty_folder(&self.target) {
                check_replaceable(&self.target)?;
            }
            fs::remove_dir_all(&self.target).map_err(io_error("cannot remove", &self.target))?;
        }
        fs::rename(&self.partial, &self.target)
            .map_err(io_error("cannot rename", &self.partial))?;
        Ok(self.target)
    }
}

/// Whether something has this name, also a broken link.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Checks that a folder holds a run and nothing else: a resolved scene, and files that runs write.
fn check_replaceable(path: &Path) -> Result<(), OutputError> {
    if !path.is_dir() {
        return Err(OutputError::NotAFolder(path.to_path_buf()));
    }
    let names = names(path)?;
    let estimators: Vec<&str> = names.iter().filter_map(|n| estimator(n)).collect();
    let mut found = names.iter().find(|name| !is_of_a_run(name)).cloned();
    let figures = path.join(FIGURES);
    if found.is_none() && is_there(&figures) {
        // A link to a folder elsewhere is not of a run, nor are the files in that folder.
        let ours = figures.symlink_metadata().is_ok_and(|m| m.is_dir());
        let is_foreign = |name: &String| !FigureSink::can_write(name, &estimators);
        found = if ours {
            let foreign = self::names(&figures)?.into_iter().find(is_foreign);
            foreign.map(|name| format!("{FIGURES}/{name}"))
        } else {
            Some(FIGURES.to_owned())
        };
    }
    if let Some(found) = found {
        return Err(OutputError::NotOfARun {
            path: path.to_path_buf(),
            found,
        });
    }
    let scene = fs::read_to_string(path.join("scene.toml")).unwrap_or_default();
    if scene.lines().any(|line| line.starts_with("[resolved]")) {
        Ok(())
    } else {
        Err(OutputError::NotARun(path.to_path_buf()))
    }
}

/// Names in a folder, sorted, so that messages do not depend on the file system.
fn names(folder: &Path) -> Result<Vec<String>, OutputError> {
    let entries = fs::read_dir(folder).map_err(io_error("cannot read", folder))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(io_error("cannot read", folder))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Folder of the figures, in the folder of a run.
const FIGURES: &str = "figures";

/// Extensions of tables: finished ones, and those being written.
const TABLE_ENDS: [&str; 4] = [".parquet", ".csv", ".arrows", ".parquet.partial"];

/// Whether a run writes files of this name.
fn is_of_a_run(name: &str) -> bool {
    let fixed = [
        "scene.toml",
        "summary.json",
        "summary.json.partial",
        FIGURES,
        "run.rrd",
        "columns.csv",
    ];
    let is_table = TABLE_ENDS.iter().any(|end| name.ends_with(end));
    let tables = ["truth.", "sensors.", "terrain.", "estimate-"];
    // Copies of the files that the ground comes from.
    let track = name
        .strip_prefix("track")
        .and_then(|n| n.strip_suffix(".csv"));
    let is_track = track.is_some_and(|part| {
        part.is_empty()
            || part
                .strip_prefix('-')
                .is_some_and(|n| n.parse::<u8>().is_ok())
    });
    fixed.contains(&name) || is_track || (is_table && tables.iter().any(|t| name.starts_with(t)))
}

/// The estimator of a table.
fn estimator(table: &str) -> Option<&str> {
    let name = table.strip_prefix("estimate-")?;
    TABLE_ENDS.iter().find_map(|end| name.strip_suffix(end))
}

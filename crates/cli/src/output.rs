//! The output folder of a run.
//!
//! A run is written into `FOLDER.partial` and renamed at its end. So a folder under its own name is
//! always a complete run, and a run that broke off leaves its files in `FOLDER.partial`. With
//! `--force` files that a run wrote are removed, and no others.

use crate::output_file::io_error;
use miette::{IntoDiagnostic, Report, Result, bail, miette};
use robhaz_log::LogPlace;
use robhaz_record::{FigureSink, names_in};
use robhaz_scene::harmless;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

fn remove(folder: &Path) -> Result<()> {
    io_error("cannot remove", folder, fs::remove_dir_all(folder))
}

/// Something that is never replaced, not even with `--force`.
fn left_alone(what: String) -> Report {
    miette!(help = ELSEWHERE, "{what}: it is left alone")
}

const ELSEWHERE: &str = "--out DIR writes elsewhere";

/// Name of the lock file in a folder that a run is writing. The system releases the lock when the
/// process ends.
const LOCK: &str = "lock";

/// A folder being written.
pub struct OutputFolder {
    target: PathBuf,
    partial: PathBuf,
    /// Whether an older run may be replaced.
    force: bool,
    /// Held during the run.
    _lock: File,
}

impl OutputFolder {
    /// Prepares `target` for a run. An existing folder of that name stays until
    /// [`OutputFolder::finish`].
    pub fn create(target: &Path, force: bool) -> Result<Self> {
        // Without a slash at the end: with it the partial folder would be inside the target.
        let mut target: PathBuf = target.components().collect();
        if target.is_symlink() {
            // The results go where the link leads.
            target = io_error("cannot follow", &target, fs::canonicalize(&target))?;
        }
        if target.file_name().is_none() {
            let shown = target.display();
            bail!("{shown} is not the name of a folder to write into");
        }
        let partial = target.with_added_extension("partial");
        if is_there(&target) && !is_empty_folder(&target) {
            if !force {
                bail!(
                    help = "--force replaces the run in it; --out DIR writes elsewhere",
                    "{} exists",
                    target.display()
                );
            }
            check_replaceable(&target)?;
        }
        if is_there(&partial) {
            if force {
                check_replaceable(&partial)?;
            }
            if is_being_written(&partial) {
                bail!(
                    help = "wait for its end, or write elsewhere with --out DIR",
                    "another run is writing in {}",
                    partial.display()
                );
            }
            if !force {
                bail!(
                    help = "--force replaces it; --out DIR writes elsewhere",
                    "{} exists: a run broke off there",
                    partial.display()
                );
            }
            remove(&partial)?;
        }
        if let Some(parent) = partial.parent().filter(|p| !p.as_os_str().is_empty()) {
            io_error("cannot create", parent, fs::create_dir_all(parent))?;
        }
        // Fails if another run has just created it.
        io_error("cannot create", &partial, fs::create_dir(&partial))?;
        let path = partial.join(LOCK);
        let lock = io_error("cannot create", &path, File::create(&path))?;
        // A file system without locks: the run goes on without that protection.
        let _ = lock.try_lock();
        Ok(Self {
            target,
            partial,
            force,
            _lock: lock,
        })
    }

    /// The folder to write into during the run.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<()> {
        let path = self.partial.join(name);
        io_error("cannot write", &path, fs::write(&path, content))
    }

    /// Gives the finished run its name. Replaces an older run only with `--force`.
    pub fn finish(self) -> Result<PathBuf> {
        if is_there(&self.target) {
            if !is_empty_folder(&self.target) {
                if !self.force {
                    bail!(
                        help = "move it elsewhere, and rename the folder of the finished run",
                        "{} appeared during the run: it is left alone",
                        self.target.display()
                    );
                }
                check_replaceable(&self.target)?;
            }
            remove(&self.target)?;
        }
        self.release();
        let renamed = fs::rename(&self.partial, &self.target);
        io_error("cannot rename", &self.partial, renamed)?;
        Ok(self.target)
    }

    /// Removes the folder of a run that was stopped before its first record.
    pub fn discard(self) -> Result<()> {
        remove(&self.partial)
    }

    /// Removes the lock file: the folder is no longer being written. One that stays does no harm:
    /// the lock itself ends with the process.
    pub fn release(&self) {
        let _ = fs::remove_file(self.partial.join(LOCK));
    }
}

/// Whether a process is writing a run in this folder.
fn is_being_written(folder: &Path) -> bool {
    File::open(folder.join(LOCK))
        .is_ok_and(|lock| matches!(lock.try_lock(), Err(fs::TryLockError::WouldBlock)))
}

/// Whether something has this name, also a broken link.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Checks that a folder holds a run and nothing else: a resolved scene, and files that runs write.
fn check_replaceable(path: &Path) -> Result<()> {
    let shown = path.display();
    if !path.is_dir() {
        return Err(left_alone(format!(
            "{shown} is a file, not the folder of a run"
        )));
    }
    let read = |name| fs::read_to_string(path.join(name)).unwrap_or_default();
    let (scene, log) = (read("scene.toml"), read(LogPlace::DESCRIPTION));
    let mut files = names_in(path).into_diagnostic()?;
    // Figures of a log of both sides are those of each.
    let of_sides = |name: &str| ["", "-left", "-right"].map(|side| format!("{name}{side}"));
    let estimators = files.iter().filter_map(|n| estimator(n)).flat_map(of_sides);
    let estimators: Vec<String> = estimators.collect();
    let estimators: Vec<&str> = estimators.iter().map(String::as_str).collect();
    // A run writes files, and the folder of its figures. A link to a folder elsewhere is not of a
    // run.
    let kind = |name: &str| path.join(name).symlink_metadata().map(|m| m.file_type());
    if kind(FIGURES).is_ok_and(|kind| kind.is_dir()) {
        files.retain(|name| name != FIGURES);
        let figures = names_in(&path.join(FIGURES)).into_diagnostic()?;
        files.extend(figures.iter().map(|name| format!("{FIGURES}/{name}")));
    }
    let is_ours = |name: &String| match name.split_once('/') {
        Some((_, figure)) => FigureSink::can_write(figure, &estimators),
        None => is_of_a_run(name, &scene),
    };
    let is_file = |name: &String| kind(name).is_ok_and(|kind| kind.is_file());
    if let Some(found) = files.iter().find(|name| !is_file(name) || !is_ours(name)) {
        let found = harmless(found);
        bail!(
            help = format!("move {found} elsewhere, or write elsewhere with --out DIR"),
            "{shown} holds {found}, which no run has written: it is left alone"
        );
    }
    let mut lines = scene.lines().chain(log.lines());
    if lines.any(|line| line.starts_with("[resolved]")) {
        Ok(())
    } else {
        Err(left_alone(format!(
            "{shown} has no scene.toml or log.toml that a run has written"
        )))
    }
}

/// Folder of the figures, in the folder of a run.
const FIGURES: &str = "figures";

/// Extensions of tables: finished ones, and those being written.
const TABLE_ENDS: [&str; 4] = [".parquet.partial", ".parquet", ".csv.partial", ".csv"];

/// Whether the run of a resolved scene writes a file of this name.
fn is_of_a_run(name: &str, scene: &str) -> bool {
    let fixed = [
        "scene.toml",
        LogPlace::DESCRIPTION,
        LogPlace::SENSORS,
        "summary.json",
        "summary.json.partial",
        "run.rrd",
        "report.html",
        "columns.csv",
        LOCK,
    ];
    let table = TABLE_ENDS.iter().find_map(|end| name.strip_suffix(end));
    let is_table = table.is_some_and(|t| ["truth", "sensors", "terrain", "commands"].contains(&t));
    // Copies of the files that the ground comes from: the scene names them.
    let quoted = format!("\"{name}\"");
    let is_track = name.starts_with("track") && scene.lines().any(|line| line.contains(&quoted));
    fixed.contains(&name) || is_table || is_track || estimator(name).is_some()
}

/// The estimator of a table.
fn estimator(table: &str) -> Option<&str> {
    let name = ["estimate-", "ground-"]
        .into_iter()
        .find_map(|start| table.strip_prefix(start))?;
    let name = TABLE_ENDS.iter().find_map(|end| name.strip_suffix(end))?;
    // Labels have no dot.
    (!name.is_empty() && !name.contains('.')).then_some(name)
}

//! The folder of a sweep.
//!
//! | file | content |
//! |---|---|
//! | `sweep.json` | what the sweep is made from: [`Identity`] |
//! | `runs.jsonl` | journal of the finished runs, until all are done |
//! | `sweep.parquet` | the dataset, when all are done |
//! | `tables/run-N` | full tables of chosen runs |
//! | `lock` | held by the process that computes |

use crate::error::{SweepError, io_error};
use crate::files;
use crate::sweep::Identity;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Name of the dataset.
pub const DATASET: &str = "sweep.parquet";
/// Name of the journal.
pub const JOURNAL: &str = "runs.jsonl";
/// Name of the folder of tables.
pub const TABLES: &str = "tables";
const MANIFEST: &str = "sweep.json";
const LOCK: &str = "lock";

/// The folder of a sweep, locked for this process.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Held while runs are computed.
    _lock: File,
}

impl Folder {
    /// Opens a folder, or creates it, for the runs of a study.
    ///
    /// # Errors
    /// [`SweepError`]: it holds something else, or another process is using it.
    pub fn open(path: &Path, identity: &Identity) -> Result<Self, SweepError> {
        fs::create_dir_all(path).map_err(io_error("create", path))?;
        let manifest = path.join(MANIFEST);
        if !manifest.exists() && !is_only_begun(path)? {
            return Err(SweepError::NotASweep(path.to_path_buf()));
        }
        let at = path.join(LOCK);
        let lock = File::create(&at).map_err(io_error("create", &at))?;
        // A file system without locks: the sweep goes on without that protection.
        if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(SweepError::InUse(path.to_path_buf()));
        }
        match read_identity(path)? {
            Some(found) => check_same(path, &found, identity)?,
            None => {
                let text = serde_json::to_vec_pretty(identity).map_err(io::Error::from);
                files::write_whole(&manifest, &text.map_err(io_error("write", &manifest))?)?;
            }
        }
        Ok(Self {
            path: path.to_path_buf(),
            _lock: lock,
        })
    }

    /// The journal of the finished runs.
    pub fn journal(&self) -> PathBuf {
        self.path.join(JOURNAL)
    }

    /// The dataset.
    pub fn dataset(&self) -> PathBuf {
        self.path.join(DATASET)
    }

    /// The folder of the tables of a run.
    pub fn tables(&self, run: u64) -> PathBuf {
        self.path.join(TABLES).join(format!("run-{run:06}"))
    }

    /// The folder of all tables.
    pub fn all_tables(&self) -> PathBuf {
        self.path.join(TABLES)
    }

    /// Removes what a finished sweep does not need.
    pub fn tidy(self) -> Result<(), SweepError> {
        let journal = self.journal();
        if journal.exists() {
            fs::remove_file(&journal).map_err(io_error("remove", &journal))?;
        }
        // One that stays does no harm: the lock itself ends with the process.
        let _ = fs::remove_file(self.path.join(LOCK));
        Ok(())
    }
}

/// What the sweep in a folder is made from; `None` where there is none.
pub fn read_identity(folder: &Path) -> Result<Option<Identity>, SweepError> {
    let path = folder.join(MANIFEST);
    match fs::read(&path) {
        Ok(bytes) => match serde_json::from_slice(&bytes) {
            Ok(identity) => Ok(Some(identity)),
            Err(source) => Err(SweepError::Manifest { path, source }),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(io_error("read", &path)(error)),
    }
}

/// Checks that a folder holds runs of this study.
///
/// # Errors
/// [`SweepError::OtherStudy`]
pub fn check_same(folder: &Path, found: &Identity, wanted: &Identity) -> Result<(), SweepError> {
    if found == wanted {
        return Ok(());
    }
    let difference = if found.version != wanted.version {
        format!("computed by {}, not by {}", found.version, wanted.version)
    } else if found.study != wanted.study {
        "the study file has changed".to_owned()
    } else if found.scene != wanted.scene {
        "the base scene has changed".to_owned()
    } else {
        "the name of the study, or a file that the scenes name, has changed".to_owned()
    };
    let short = |identity: &Identity| identity.sha256.chars().take(12).collect::<String>();
    Err(SweepError::OtherStudy {
        folder: folder.to_path_buf(),
        difference: format!(
            "{difference} (SHA-256 {}..., now {}...)",
            short(found),
            short(wanted)
        ),
    })
}

/// Whether a folder has at most what a sweep leaves that was killed before its manifest was there.
fn is_only_begun(path: &Path) -> Result<bool, SweepError> {
    for entry in fs::read_dir(path).map_err(io_error("read", path))? {
        let name = entry.map_err(io_error("read", path))?.file_name();
        if name != LOCK && name != *files::partial(Path::new(MANIFEST)).as_os_str() {
            return Ok(false);
        }
    }
    Ok(true)
}

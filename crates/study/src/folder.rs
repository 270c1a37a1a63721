//! The folder of a study.
//!
//! | file | content |
//! |---|---|
//! | `study.json` | what the study is made from: [`Identity`] |
//! | `runs.jsonl`, `runs-I-of-N.jsonl` | journals of the finished runs, one a shard, until all runs are done |
//! | `study.parquet` | the dataset, when all are done |
//! | `tables/run-N` | full tables of chosen runs |

use crate::error::{StudyError, io_error};
use crate::files;
use crate::shard::Shard;
use crate::study::Identity;
use serde_json::Value;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the file of the dataset.
pub const DATASET: &str = "study.parquet";
/// Name of the dataset.
pub const TABLE: &str = "study";
const MANIFEST: &str = "study.json";
/// Manifest and dataset of the command `sweep` of earlier versions.
const EARLIER: [&str; 2] = ["sweep.json", "sweep.parquet"];

/// The folder of a study.
#[derive(Debug)]
pub struct Folder(pub PathBuf);

impl Folder {
    /// Opens a folder, or creates it, for the runs of a study.
    ///
    /// # Errors
    /// [`StudyError`]: it holds something else.
    pub fn open(path: &Path, identity: &Identity) -> Result<Self, StudyError> {
        fs::create_dir_all(path).map_err(io_error("create", path))?;
        let manifest = path.join(MANIFEST);
        match fs::read(&manifest) {
            Ok(bytes) => match serde_json::from_slice(&bytes) {
                Ok(found) => check_same(path, &found, identity)?,
                Err(source) => {
                    let path = manifest;
                    return Err(StudyError::Manifest { path, source });
                }
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                check_only_begun(path)?;
                let text = serde_json::to_vec_pretty(identity).map_err(io::Error::from);
                files::write_whole(&manifest, &text.map_err(io_error("write", &manifest))?)?;
            }
            Err(error) => return Err(io_error("read", &manifest)(error)),
        }
        Ok(Self(path.to_path_buf()))
    }

    /// The journal of a shard.
    pub fn journal(&self, shard: Shard) -> PathBuf {
        self.0.join(match shard {
            Shard::ALL => "runs.jsonl".to_owned(),
            part => format!("runs-{part}.jsonl"),
        })
    }

    /// All journals, in the order of their names.
    pub fn journals(&self) -> Result<Vec<PathBuf>, StudyError> {
        let is_journal = |name: &str| name.starts_with("runs") && name.ends_with(".jsonl");
        let names = names(&self.0)?;
        let journals = names.iter().filter(|name| is_journal(name));
        Ok(journals.map(|name| self.0.join(name)).collect())
    }

    /// The dataset.
    pub fn dataset(&self) -> PathBuf {
        self.0.join(DATASET)
    }

    /// The folder of the tables of a run.
    pub fn tables(&self, run: u64) -> PathBuf {
        self.0.join("tables").join(format!("run-{run:06}"))
    }

    /// Removes the journals, which a complete dataset does not need.
    pub fn tidy(&self) -> Result<(), StudyError> {
        for journal in self.journals()? {
            fs::remove_file(&journal).map_err(io_error("remove", &journal))?;
        }
        Ok(())
    }
}

/// Names in a folder, in their order.
fn names(path: &Path) -> Result<Vec<String>, StudyError> {
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(io_error("read", path))? {
        let name = entry.map_err(io_error("read", path))?.file_name();
        names.push(name.to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Checks that a folder without a manifest has at most what a study leaves that was killed before
/// its manifest was there.
fn check_only_begun(path: &Path) -> Result<(), StudyError> {
    let partial = format!("{MANIFEST}.partial");
    let names = names(path)?;
    if names.iter().any(|name| EARLIER.contains(&name.as_str())) {
        let text = fs::read(path.join(EARLIER[0])).unwrap_or_default();
        let manifest: Value = serde_json::from_slice(&text).unwrap_or_default();
        let version = manifest["version"].as_str().unwrap_or("a version unknown");
        return Err(StudyError::Earlier {
            folder: path.to_path_buf(),
            version: version.to_owned(),
        });
    }
    match names.iter().all(|name| name.starts_with(&partial)) {
        true => Ok(()),
        false => Err(StudyError::NotAStudy(path.to_path_buf())),
    }
}

/// Checks that a folder holds runs of this study.
fn check_same(folder: &Path, found: &Identity, wanted: &Identity) -> Result<(), StudyError> {
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
        "the name of the study, a file that the scenes name, or the columns of the dataset have changed".to_owned()
    };
    let short = |identity: &Identity| identity.sha256.chars().take(12).collect::<String>();
    let (found, wanted) = (short(found), short(wanted));
    Err(StudyError::OtherStudy {
        folder: folder.to_path_buf(),
        difference: format!("{difference} (SHA-256 {found}..., now {wanted}...)"),
    })
}

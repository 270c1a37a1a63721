//! The folder of a study; files and folders that are complete or not there; a part of the runs.
//!
//! | file | content |
//! |---|---|
//! | `study.json` | what the study is made from: [`Identity`] |
//! | `runs.jsonl`, `runs-I-of-N.jsonl` | journals of the finished runs, one a shard, until all runs are done |
//! | `study.parquet` | the dataset, when all are done |
//! | `tables/run-N` | full tables of chosen runs |

use crate::error::{Result, StudyError};
use crate::study::Identity;
use robhaz_record::{io_error, names_in};
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

/// A part of the runs, for one of several machines: every `of`-th run from the `part`-th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u64,
    of: NonZeroU64,
}

impl Shard {
    /// All runs.
    pub const ALL: Self = Self {
        part: 1,
        of: NonZeroU64::MIN,
    };

    /// Part `part` of `of`, from 1 on; `None` if there is no such part.
    pub fn new(part: u64, of: u64) -> Option<Self> {
        let of = NonZeroU64::new(of)?;
        (1..=of.get()).contains(&part).then_some(Self { part, of })
    }

    /// Whether a run belongs to it.
    pub fn has(&self, run: u64) -> bool {
        run % self.of == self.part - 1
    }

    /// How many of `runs` runs belong to it.
    pub fn count(&self, runs: u64) -> u64 {
        (runs + self.of.get() - self.part) / self.of
    }
}

/// `2-of-8`
impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-of-{}", self.part, self.of)
    }
}

/// Name of the file of the dataset.
pub const DATASET: &str = "study.parquet";
/// Name of the dataset.
pub const TABLE: &str = "study";
const MANIFEST: &str = "study.json";

/// The folder of a study.
#[derive(Debug)]
pub struct Folder(pub PathBuf);

impl Folder {
    /// Opens a folder, or creates it, for the runs of a study.
    ///
    /// # Errors
    /// [`StudyError`]: it holds something else.
    pub fn open(path: &Path, identity: &Identity) -> Result<Self> {
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
                write_whole(&manifest, &text.map_err(io_error("write", &manifest))?)?;
            }
            Err(error) => Err(io_error("read", &manifest)(error))?,
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
    pub fn journals(&self) -> Result<Vec<PathBuf>> {
        let is_journal = |name: &str| name.starts_with("runs") && name.ends_with(".jsonl");
        let names = names_in(&self.0)?;
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
    pub fn tidy(&self) -> Result {
        for journal in self.journals()? {
            fs::remove_file(&journal).map_err(io_error("remove", &journal))?;
        }
        Ok(())
    }
}

/// Checks that a folder without a manifest has at most what a study leaves that was killed before
/// its manifest was there.
fn check_only_begun(path: &Path) -> Result {
    let partial = format!("{MANIFEST}.partial");
    let names = names_in(path)?;
    match names.iter().all(|name| name.starts_with(&partial)) {
        true => Ok(()),
        false => Err(StudyError::Folder(
            format!(
                "{} is not empty and holds no study: it is left alone",
                path.display()
            ),
            "write elsewhere with --out DIR",
        )),
    }
}

/// Checks that a folder holds runs of this study.
fn check_same(folder: &Path, found: &Identity, wanted: &Identity) -> Result {
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
    let shown = folder.display();
    Err(StudyError::Folder(
        format!(
            "{shown} holds runs of another study: {difference} (SHA-256 {found}..., now {wanted}...)"
        ),
        "write elsewhere with --out DIR, or remove the folder; runs of two studies never mix",
    ))
}

/// Writes a small file. It has its name only when all of it is on the disk. Several processes may
/// write the same content.
pub fn write_whole(path: &Path, content: &[u8]) -> Result {
    let temporary = path.with_added_extension(format!("partial-{}", std::process::id()));
    let mut file = File::create(&temporary).map_err(io_error("create", &temporary))?;
    file.write_all(content)
        .and_then(|()| file.sync_all())
        .map_err(io_error("write", &temporary))?;
    settle(&temporary, path)
}

/// Gives a complete file or folder its name, and waits until the disk has the name, too.
pub fn settle(temporary: &Path, path: &Path) -> Result {
    fs::rename(temporary, path).map_err(io_error("rename", temporary))?;
    sync_parent(path);
    Ok(())
}

/// Waits until the disk has the name of a file or folder. Some file systems cannot; the content is
/// there in any case.
pub fn sync_parent(path: &Path) {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: every run belongs to one shard, and the shards count right.
    #[test]
    fn shards_share_all_runs() {
        for (runs, of) in [(0, 1), (1, 3), (10, 3), (12, 4), (5, 7)] {
            let shards: Vec<Shard> = (1..=of).filter_map(|part| Shard::new(part, of)).collect();
            assert_eq!(shards.len() as u64, of);
            for shard in &shards {
                let count = (0..runs).filter(|run| shard.has(*run)).count() as u64;
                assert_eq!(count, shard.count(runs), "{shard:?} of {runs}");
            }
            for run in 0..runs {
                assert_eq!(shards.iter().filter(|shard| shard.has(run)).count(), 1);
            }
        }
        assert_eq!((Shard::new(0, 3), Shard::new(4, 3)), (None, None));
        assert_eq!(Shard::new(1, 0), None);
    }
}

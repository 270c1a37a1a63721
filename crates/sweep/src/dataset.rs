//! The dataset of one or several journals, in the order of the runs.

use crate::columns::RowBuilder;
use crate::error::{SweepError, io_error};
use crate::files;
use crate::folder::{Folder, JOURNAL, TABLES, check_same, read_identity};
use crate::journal::{JournalReader, Place, scan};
use crate::plan::Plan;
use crate::sweep::Identity;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows of a batch: with 40 columns about 2 MB.
const BATCH_ROWS: usize = 8 * 1024;
/// Rows in a row group.
const GROUP_ROWS: usize = 64 * 1024;

/// Where the line of each run is: 24 bytes a run.
pub struct Finished {
    /// Number of the journal and place in it, by the index of the run.
    places: Vec<Option<(u32, u64, u32)>>,
}

impl Finished {
    /// None of `runs` runs.
    pub fn new(runs: u64) -> Self {
        Self {
            places: vec![None; usize::try_from(runs).unwrap_or(usize::MAX)],
        }
    }

    /// Adds the runs of a journal. A run that is there twice is the same twice: the first counts.
    pub fn add(&mut self, journal: u32, places: &[Place]) {
        for place in places {
            let run = usize::try_from(place.run).ok();
            if let Some(slot) = run.and_then(|run| self.places.get_mut(run)) {
                slot.get_or_insert((journal, place.offset, place.length));
            }
        }
    }

    /// Whether a run is done.
    pub fn has(&self, run: u64) -> bool {
        let run = usize::try_from(run).ok();
        run.and_then(|run| self.places.get(run))
            .is_some_and(Option::is_some)
    }

    /// [`SweepError::Incomplete`] if a run is missing.
    fn check_complete(&self) -> Result<(), SweepError> {
        let missing = self.places.iter().filter(|p| p.is_none()).count() as u64;
        let first = self.places.iter().position(Option::is_none);
        match first {
            None => Ok(()),
            Some(first) => Err(SweepError::Incomplete {
                missing,
                runs: self.places.len() as u64,
                first: first as u64,
            }),
        }
    }
}

/// Makes the dataset of the journal in a folder. Returns its path.
///
/// # Errors
/// [`SweepError::Incomplete`] where runs are missing; nothing is written then.
pub fn merge(identity: &Identity, plan: &Plan, folder: &Folder) -> Result<PathBuf, SweepError> {
    write(identity, plan, &[folder.journal()], &folder.dataset())?;
    Ok(folder.dataset())
}

/// Makes the dataset of several shards, each in the folder that a sweep wrote, in the folder `out`: the bytes that one machine
/// would have written. Copies their tables. Returns the dataset's path and the number of runs.
///
/// # Errors
/// [`SweepError`]: folders of different studies, missing runs, or files that cannot be read or written.
pub fn merge_shards(shards: &[PathBuf], out: &Path) -> Result<(PathBuf, u64), SweepError> {
    let mut identity: Option<Identity> = None;
    for shard in shards {
        let Some(found) = read_identity(shard)? else {
            return Err(SweepError::NoSweep(shard.clone()));
        };
        match &identity {
            Some(wanted) => check_same(shard, &found, wanted)?,
            None => identity = Some(found),
        }
    }
    let Some(identity) = identity else {
        return Err(SweepError::NoSweep(PathBuf::from(
            "an empty list of folders",
        )));
    };
    let plan = identity.plan("the study of these shards")?;
    let journals: Vec<PathBuf> = shards.iter().map(|shard| shard.join(JOURNAL)).collect();
    // Before anything is written.
    finished(&journals, plan.runs())?.check_complete()?;
    let folder = Folder::open(out, &identity)?;
    for shard in shards {
        copy_tables(&shard.join(TABLES), &folder.all_tables())?;
    }
    write(&identity, &plan, &journals, &folder.dataset())?;
    let dataset = folder.dataset();
    folder.tidy()?;
    Ok((dataset, plan.runs()))
}

/// Copies the complete tables of all runs of a shard.
fn copy_tables(from: &Path, to: &Path) -> Result<(), SweepError> {
    if !from.is_dir() {
        return Ok(());
    }
    for entry in fs::read_dir(from).map_err(io_error("read", from))? {
        let entry = entry.map_err(io_error("read", from))?;
        let is_complete = entry.path().extension().is_none();
        if is_complete && entry.path() != to.join(entry.file_name()) {
            files::copy_folder(&entry.path(), &to.join(entry.file_name()))?;
        }
    }
    Ok(())
}

fn finished(journals: &[PathBuf], runs: u64) -> Result<Finished, SweepError> {
    let mut finished = Finished::new(runs);
    for (number, journal) in (0_u32..).zip(journals) {
        finished.add(number, &scan(journal)?.0);
    }
    Ok(finished)
}

fn write(
    identity: &Identity,
    plan: &Plan,
    journals: &[PathBuf],
    path: &Path,
) -> Result<(), SweepError> {
    let finished = finished(journals, plan.runs())?;
    finished.check_complete()?;
    // A shard without runs has no journal.
    let open = |journal: &PathBuf| {
        journal
            .exists()
            .then(|| JournalReader::open(journal))
            .transpose()
    };
    let mut readers: Vec<Option<JournalReader>> =
        journals.iter().map(open).collect::<Result<_, _>>()?;
    let temporary = files::partial(path);
    let failed = |source: ParquetError| SweepError::Parquet {
        path: path.to_path_buf(),
        source,
    };
    let file = File::create(&temporary).map_err(io_error("create", &temporary))?;
    let mut rows = RowBuilder::new(plan);
    let mut writer =
        ArrowWriter::try_new(file, Arc::clone(rows.schema()), Some(properties(identity)))
            .map_err(failed)?;
    for (run, place) in (0_u64..).zip(&finished.places) {
        let Some((journal, offset, length)) = *place else {
            continue;
        };
        if let Some(Some(reader)) = readers.get_mut(journal as usize) {
            let record = reader.read(&Place {
                run,
                offset,
                length,
            })?;
            rows.push(&record, &plan.settings(run));
        }
        if rows.rows() >= BATCH_ROWS {
            writer.write(&rows.take()?).map_err(failed)?;
        }
    }
    writer.write(&rows.take()?).map_err(failed)?;
    let file = writer.into_inner().map_err(failed)?;
    file.sync_all().map_err(io_error("write", &temporary))?;
    files::settle(&temporary, path)
}

fn properties(identity: &Identity) -> WriterProperties {
    let entry = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    let metadata = vec![
        entry("robhaz.name", &identity.name),
        entry("robhaz.version", &identity.version),
        entry("robhaz.runs", &identity.runs.to_string()),
        entry("robhaz.sha256", &identity.sha256),
        entry("robhaz.study", &identity.study),
        entry("robhaz.scene", &identity.scene),
    ];
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(metadata))
        .build()
}

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
    /// Damaged lines of all journals.
    damaged: u64,
}

impl Finished {
    /// None of `runs` runs.
    pub fn new(runs: u64) -> Self {
        Self {
            places: vec![None; usize::try_from(runs).unwrap_or(usize::MAX)],
            damaged: 0,
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
                damaged: self.damaged,
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
        let scanned = scan(journal)?;
        finished.add(number, &scanned.places);
        finished.damaged += scanned.damaged;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Job, ScoreColumn, Shard, Sweep, Watch, compute};
    use arrow_array::cast::AsArray as _;
    use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
    use arrow_array::{Array as _, RecordBatch};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_record::SummarySink;

    const SCENE: &str = "[terrain]\nkind = \"flat\"\n[sensors]\ngrade = \"typical\"\n[record]\nduration = 0.1\n\
        compare_from = 0.05\n[[estimator]]\nname = \"paper-wheels\"\n[[estimator]]\nname = \"best\"\n";
    const STUDY: &str = "scene = \"scene.toml\"\n[[axis]]\nkey = \"record.duration\"\nvalues = [0.1, 0.04]\n\
        [[axis]]\nkeys = [\"drive.speed\", \"drive.kp\"]\nvalues = [[\"20 cm/s\", 2], [0.3, 2.5]]\n\
        [[axis]]\nkey = \"seed\"\nfirst = 4\ncount = 2\n";

    /// Equivalence: a row holds the scores of its run, to the bit, with the types and units of its columns; a run that
    /// cannot be holds its reason alone; the metadata hold the texts.
    #[test]
    fn rows_are_the_scores_of_single_runs() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        fs::write(dir.path().join("scene.toml"), SCENE)?;
        fs::write(dir.path().join("study.toml"), STUDY)?;
        let sweep = Sweep::load(&dir.path().join("study.toml"))?;
        let job = Job {
            folder: &dir.path().join("out"),
            shard: Shard::ALL,
            jobs: 2,
        };
        let watch = Watch {
            begin: &|_, _| {},
            finished: &|_| {},
            stop: &|| None,
        };
        let done = compute(&sweep, &job, &watch)?;
        let file = File::open(done.dataset.ok_or("no dataset")?)?;
        let reader = ParquetRecordBatchReaderBuilder::try_new(file)?;
        let metadata = reader.metadata().file_metadata().key_value_metadata();
        let metadata = metadata.ok_or("no metadata")?;
        let text = |key: &str| metadata.iter().find(|e| e.key == key)?.value.clone();
        assert_eq!(text("robhaz.study").as_deref(), Some(STUDY));
        assert_eq!(text("robhaz.scene").as_deref(), Some(SCENE));
        assert_eq!(text("robhaz.runs").as_deref(), Some("8"));
        let batch: RecordBatch = reader.build()?.next().ok_or("no rows")??;
        // Four runs of two estimators, and four that end before `compare_from`.
        assert_eq!(batch.num_rows(), 4 * 2 + 4);
        let schema = batch.schema();
        let unit = |name: &str| {
            schema
                .field_with_name(name)
                .map(|f| f.metadata()["unit"].clone())
        };
        assert_eq!(unit("record.duration")?, "s");
        assert_eq!(unit("rmse")?, "N");
        let column = |name: &str| batch.column_by_name(name).ok_or(format!("no {name}"));
        let index = column("index")?.as_primitive::<UInt64Type>();
        assert_eq!(index.values()[..], [0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7]);
        // A text and a number make texts, numbers and whole numbers make numbers.
        let speeds = column("drive.speed")?.as_string::<i32>();
        assert_eq!((speeds.value(0), speeds.value(4)), ("20 cm/s", "0.3"));
        let gains = column("drive.kp")?.as_primitive::<Float64Type>();
        assert_eq!((gains.value(0), gains.value(4)), (2.0, 2.5));
        let seeds = column("seed")?.as_primitive::<Int64Type>();
        assert_eq!((seeds.value(0), seeds.value(2)), (4, 5));
        let (estimators, errors) = (column("estimator")?.as_string::<i32>(), column("error")?);
        let errors = errors.as_string::<i32>();
        for row in 0..8 {
            let mut summary = SummarySink::new();
            robhaz_run::run(&sweep.scene(index.value(row))?, &mut [&mut summary])?;
            let summary = summary.summary()?;
            let estimator = &summary.estimators[row % 2];
            assert_eq!(estimators.value(row), estimator.name);
            for score in ScoreColumn::all() {
                let expected = score.value(&summary, Some(estimator));
                let found = column(score.name)?;
                let found = match found.as_primitive_opt::<Float64Type>() {
                    Some(numbers) => numbers.is_valid(row).then(|| numbers.value(row)),
                    None => {
                        let counts = found.as_primitive::<UInt64Type>();
                        counts.is_valid(row).then(|| counts.value(row) as f64)
                    }
                };
                assert_eq!(
                    found.map(f64::to_bits),
                    expected.map(f64::to_bits),
                    "{}",
                    score.name
                );
            }
            assert!(errors.is_null(row));
        }
        for row in 8..12 {
            assert!(estimators.is_null(row) && column("nrmse")?.is_null(row));
            assert!(
                errors.value(row).contains("below record.duration"),
                "{}",
                errors.value(row)
            );
        }
        Ok(())
    }
}

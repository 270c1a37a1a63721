//! The dataset of all runs, in their order: the same bytes for any number of threads, shards and
//! interruptions.

use crate::columns::RowBuilder;
use crate::error::StudyError;
use crate::files;
use crate::folder::{Folder, TABLE};
use crate::journal::scan;
use crate::study::{Identity, Study};
use robhaz_record::{GROUP_ROWS, TableFile, TableFormat};
use std::collections::BTreeMap;

/// Most runs that are in memory at once: some 200 MB. A larger study reads its journals several
/// times.
const RUNS_AT_ONCE: usize = 50_000;

/// Writes the dataset of the runs in the journals of a folder, which must be all runs. A run that
/// is there twice is the same twice: the first counts.
pub fn write(study: &Study, folder: &Folder) -> Result<(), StudyError> {
    let (hash, journals) = (&study.identity().sha256, folder.journals()?);
    let mut rows = RowBuilder::new(study.plan(), &notes(study.identity()));
    let mut file = TableFile::create(&folder.0, TableFormat::Parquet, TABLE, rows.schema(), true)?;
    for first in (0..study.runs()).step_by(RUNS_AT_ONCE) {
        let range = first..first + RUNS_AT_ONCE as u64;
        let mut records = BTreeMap::new();
        for journal in &journals {
            scan(journal, hash, &mut |record| {
                if range.contains(&record.run) {
                    records.entry(record.run).or_insert(record);
                }
            })?;
        }
        for (run, record) in records {
            rows.push(&record, &study.settings(run));
            if rows.rows() >= GROUP_ROWS {
                file.write(&rows.take()?)?;
            }
        }
    }
    file.write(&rows.take()?)?;
    // The journals go next.
    file.finish(true)?;
    files::sync_parent(&folder.dataset());
    Ok(())
}

/// What a dataset says of itself.
fn notes(identity: &Identity) -> [(&'static str, String); 6] {
    [
        ("robhaz.name", identity.name.clone()),
        ("robhaz.version", identity.version.clone()),
        ("robhaz.runs", identity.runs.to_string()),
        ("robhaz.sha256", identity.sha256.clone()),
        ("robhaz.study", identity.study.clone()),
        ("robhaz.scene", identity.scene.clone()),
    ]
}

#[cfg(test)]
mod tests {
    use crate::single::BoundSink;
    use crate::{Job, Shard, Study, Watch, compute};
    use arrow_array::cast::AsArray as _;
    use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
    use arrow_array::{Array as _, RecordBatch};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_record::{ScoreColumn, SummarySink};
    use std::fs::{self, File};

    const SCENE: &str = "[terrain]\nkind = \"flat\"\n[sensors]\ngrade = \"typical\"\n[record]\nduration = 0.1\n\
        compare_from = 0.05\n[[estimator]]\nname = \"paper-wheels\"\n[[estimator]]\nname = \"best\"\n";
    const STUDY: &str = "scene = \"scene.toml\"\n[[axis]]\nkey = \"record.duration\"\nvalues = [0.1, 0.04]\n\
        [[axis]]\nkeys = [\"drive.speed\", \"drive.kp\"]\nvalues = [[\"20 cm/s\", 2], [0.3, 2.5]]\n\
        [[axis]]\nkey = \"seed\"\nfirst = 4\ncount = 2\n";

    /// Equivalence: a row holds the scores of its run, to the bit, with the types and units of its
    /// columns; a run that cannot be holds its reason alone; the metadata hold the texts.
    #[test]
    fn rows_are_the_scores_of_single_runs() -> Result<(), Box<dyn std::error::Error>> {
        let dir = tempfile::tempdir()?;
        fs::write(dir.path().join("scene.toml"), SCENE)?;
        fs::write(dir.path().join("study.toml"), STUDY)?;
        let study = Study::load(&dir.path().join("study.toml"))?;
        let job = Job {
            folder: &dir.path().join("out"),
            shard: Shard::ALL,
            jobs: 2,
        };
        let done = compute(&study, &job, &Watch::SILENT)?;
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
            let scene = study.scene(index.value(row))?;
            let mut bound = BoundSink::new(&scene);
            robhaz_run::run(&scene, &mut [&mut summary, &mut bound])?;
            let (summary, bound) = (summary.summary()?, bound.0.nrmse());
            let estimator = &summary.estimators[row % 2];
            assert_eq!(estimators.value(row), estimator.name);
            for score in ScoreColumn::all() {
                let expected = score.value(&summary, bound, Some(estimator));
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

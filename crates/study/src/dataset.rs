//! The dataset of all runs, in their order: the same bytes for any number of threads, shards and
//! interruptions. Its columns: index, varied keys, estimator, scores, error.

use crate::error::Result;
use crate::folder::{Folder, TABLE, sync_parent};
use crate::journal::{RunRecord, scan};
use crate::plan::Plan;
use crate::study::{Identity, Study};
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray, UInt64Array,
};
use arrow_schema::{DataType, SchemaRef};
use robhaz_record::{GROUP_ROWS, RecordError, ScoreColumn, TableFile, TableFormat, field, schema};
use robhaz_scene::{Axis, AxisItem, AxisValue, AxisValues, Distribution, Setting};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most runs that are in memory at once: some 200 MB. A larger study reads its journals several
/// times.
const RUNS_AT_ONCE: usize = 50_000;

/// Writes the dataset of the runs in the journals of a folder, which must be all runs. A run that
/// is there twice is the same twice: the first counts.
pub fn write(study: &Study, folder: &Folder) -> Result {
    let (hash, journals) = (&study.identity.sha256, folder.journals()?);
    let mut rows = RowBuilder::new(&study.plan, &notes(&study.identity));
    let mut file = TableFile::create(&folder.0, TableFormat::Parquet, TABLE, &rows.schema, true)?;
    for first in (0..study.plan.runs()).step_by(RUNS_AT_ONCE) {
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
            rows.push(&record, &study.plan.settings(run));
            if rows.columns[0].len() >= GROUP_ROWS {
                file.write(&rows.take()?)?;
            }
        }
    }
    file.write(&rows.take()?)?;
    // The journals go next.
    file.finish(true)?;
    sync_parent(&folder.dataset());
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

/// A value that waits for its batch.
type Cell = Option<AxisValue>;

/// The narrowest type that takes all values of the `i`-th key of an axis, or their names.
fn type_of(axis: &Axis, i: usize) -> DataType {
    let named = |items: &[AxisItem]| items.iter().any(|item| item.name.is_some());
    if matches!(&axis.values, AxisValues::List(items) if i == 0 && named(items)) {
        return DataType::Utf8;
    }
    let all = |is_it: fn(&AxisValue) -> bool| match &axis.values {
        AxisValues::List(items) => items.iter().filter_map(|v| v.values.get(i)).all(is_it),
        AxisValues::Whole { .. } | AxisValues::Drawn(Distribution::Whole(..)) => {
            is_it(&AxisValue::Whole(0))
        }
        AxisValues::Drawn(_) => is_it(&AxisValue::Number(0.0)),
    };
    if all(|v| matches!(v, AxisValue::Whole(_))) {
        DataType::Int64
    } else if all(|v| matches!(v, AxisValue::Whole(_) | AxisValue::Number(_))) {
        DataType::Float64
    } else if all(|v| matches!(v, AxisValue::Boolean(_))) {
        DataType::Boolean
    } else {
        DataType::Utf8
    }
}

/// The values of a column. One of another kind is null, which the column of a key refuses.
fn array(kind: &DataType, cells: &[Cell]) -> ArrayRef {
    fn all<T, A: FromIterator<Option<T>>>(
        cells: &[Cell],
        of: impl Fn(&AxisValue) -> Option<T>,
    ) -> Arc<A> {
        let values = cells.iter().map(|cell| cell.as_ref().and_then(&of));
        Arc::new(values.collect())
    }
    let whole = |value: &AxisValue| match value {
        AxisValue::Whole(whole) => Some(*whole),
        _ => None,
    };
    match kind {
        DataType::UInt64 => all::<_, UInt64Array>(cells, |v| whole(v)?.try_into().ok()),
        DataType::Int64 => all::<_, Int64Array>(cells, whole),
        DataType::Float64 => all::<_, Float64Array>(cells, |value| match value {
            AxisValue::Number(number) => Some(*number),
            // A whole number among others.
            other => whole(other).map(|whole| whole as f64),
        }),
        DataType::Boolean => all::<_, BooleanArray>(cells, |value| match value {
            AxisValue::Boolean(flag) => Some(*flag),
            _ => None,
        }),
        _ => all::<_, StringArray>(cells, |value| match value {
            AxisValue::Text(text) => Some(text.clone()),
            other => Some(other.to_string()),
        }),
    }
}

/// Collects rows of the dataset and makes Arrow batches of them.
struct RowBuilder {
    schema: SchemaRef,
    /// The cells of each column.
    columns: Vec<Vec<Cell>>,
}

impl RowBuilder {
    /// The rows of a study. `notes` are keys and values of the dataset as a whole.
    fn new(plan: &Plan, notes: &[(&str, String)]) -> Self {
        let index = (DataType::UInt64, false);
        let mut fields = vec![field("index", "", "index of the run", index)];
        for axis in &plan.axes {
            for (i, key) in axis.keys.iter().enumerate() {
                let kind = type_of(axis, i);
                let unit = match kind {
                    DataType::Int64 | DataType::Float64 => Axis::unit(key),
                    _ => "",
                };
                fields.push(field(key, unit, "key of the scene, varied", (kind, false)));
            }
        }
        let text = "label of the estimator; null for a run that failed";
        fields.push(field("estimator", "", text, (DataType::Utf8, true)));
        fields.extend(ScoreColumn::all().iter().map(|c| {
            let kind = match c.is_count {
                true => DataType::UInt64,
                false => DataType::Float64,
            };
            field(c.name, c.unit, c.description, (kind, true))
        }));
        let text = "why the run failed; null for a complete run";
        fields.push(field("error", "", text, (DataType::Utf8, true)));
        Self {
            columns: vec![Vec::new(); fields.len()],
            schema: schema(fields, notes),
        }
    }

    /// Adds the rows of a run with its settings.
    fn push(&mut self, record: &RunRecord, settings: &[Setting]) {
        let text = |text: &Option<String>| text.clone().map(AxisValue::Text);
        let setting = |s: &Setting| text(&s.name).unwrap_or_else(|| s.value.clone());
        for row in &record.rows {
            let index = i64::try_from(record.run).ok().map(AxisValue::Whole);
            let scores = ScoreColumn::all().iter().enumerate().map(|(i, column)| {
                let score = row.scores.get(i).copied().flatten()?;
                Some(match column.is_count {
                    // A count, written as a number.
                    true => AxisValue::Whole(score as i64),
                    false => AxisValue::Number(score),
                })
            });
            let cells = std::iter::once(index)
                .chain(settings.iter().map(setting).map(Some))
                .chain([text(&row.estimator)])
                .chain(scores)
                .chain([text(&record.error)]);
            for (column, cell) in self.columns.iter_mut().zip(cells) {
                column.push(cell);
            }
        }
    }

    /// The rows since the last batch.
    ///
    /// # Errors
    /// [`RecordError::Batch`] where columns have different lengths.
    fn take(&mut self) -> Result<RecordBatch, RecordError> {
        let fields = self.schema.fields().iter();
        let arrays = fields.zip(&self.columns);
        let arrays = arrays.map(|(field, cells)| array(field.data_type(), cells));
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays.collect());
        self.columns.iter_mut().for_each(Vec::clear);
        Ok(batch?)
    }
}

#[cfg(test)]
mod tests {
    use crate::single::BoundSink;
    use crate::{Shard, Study, Watch, compute};
    use arrow_array::cast::AsArray as _;
    use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
    use arrow_array::{Array as _, RecordBatch};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_record::{ScoreColumn, SummarySink};
    use std::fs::{self, File};

    const SCENE: &str = "[terrain]\nkind = \"flat\"\n[sensors]\ngrade = \"typical\"\n[record]\nduration = 0.1\n\
        compare_from = 0.05\n[[estimator]]\nname = \"paper-wheels\"\n[[estimator]]\nname = \"kalman\"\n";
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
        let out = dir.path().join("out");
        let done = compute(&study, &out, Shard::ALL, 2, &Watch::SILENT)?;
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
            let estimator = summary.estimators.get_index(row % 2);
            let (name, estimator) = estimator.ok_or("no estimator")?;
            assert_eq!(estimators.value(row), name);
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

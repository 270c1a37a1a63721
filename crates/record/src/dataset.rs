//! The dataset of a study, read back: one row a run and estimator.

use crate::error::{RecordError, Result, io_error};
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::DataType;
use indexmap::IndexSet;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use robhaz_scene::StudyChoice;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::path::Path;

/// The dataset of a study, in memory: 8 bytes a number.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// All rows. Unit and description of a column are in the metadata of its field.
    pub rows: Vec<RecordBatch>,
    /// The study that it was made from.
    pub study: StudyChoice,
    /// Number of runs.
    pub runs: u64,
    /// The program and its engines.
    pub version: String,
    /// Text of the base scene.
    pub scene: String,
}

impl Dataset {
    /// Reads the Parquet file of a finished study.
    ///
    /// # Errors
    /// [`RecordError`] if it cannot be read or is no dataset of a study.
    pub fn read(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(io_error("read", path))?;
        let shown = path.display();
        let not = |reason: &dyn Display| {
            RecordError::Refused(format!("{shown} is not the dataset of a study: {reason}"))
        };
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| not(&e))?;
        let schema = reader.schema().clone();
        if let Some(field) = schema.fields().iter().find(|f| !is_known(f.data_type())) {
            let (name, other) = (field.name(), field.data_type());
            return Err(not(&format!("column {name} has the type {other}")));
        }
        let rows = reader.build().map_err(|e| not(&e))?;
        let text = |key: &str| {
            let note = schema.metadata().get(key).cloned();
            note.ok_or_else(|| not(&format!("its metadata have no {key}")))
        };
        let study = text("robhaz.study")?;
        let mut study = StudyChoice::parse(&study, "its study file").map_err(|e| not(&e))?;
        study.name = text("robhaz.name")?;
        Ok(Self {
            rows: rows.collect::<Result<_, _>>().map_err(|e| not(&e))?,
            study,
            runs: text("robhaz.runs")?.parse().map_err(|e| not(&e))?,
            version: text("robhaz.version")?,
            scene: text("robhaz.scene")?,
        })
    }

    fn arrays(&self, name: &str) -> impl Iterator<Item = &ArrayRef> {
        self.rows
            .iter()
            .filter_map(move |rows| rows.column_by_name(name))
    }

    /// The numbers of a column, one a row; none if it holds words or does not exist.
    pub fn numbers(&self, name: &str) -> Vec<Option<f64>> {
        // Whole numbers up to 2^53 are exact: seeds of scenes are smaller.
        let of = |array: &ArrayRef| -> Vec<Option<f64>> {
            if let Some(array) = array.as_primitive_opt::<Float64Type>() {
                array.iter().collect()
            } else if let Some(array) = array.as_primitive_opt::<Int64Type>() {
                array.iter().map(|n| n.map(|n| n as f64)).collect()
            } else if let Some(array) = array.as_primitive_opt::<UInt64Type>() {
                array.iter().map(|n| n.map(|n| n as f64)).collect()
            } else {
                Vec::new()
            }
        };
        self.arrays(name).flat_map(of).collect()
    }

    /// The words of a column of texts, one a row; none if it holds others or does not exist.
    pub fn words(&self, name: &str) -> impl Iterator<Item = Option<&str>> {
        let texts = self
            .arrays(name)
            .filter_map(|array| array.as_string_opt::<i32>());
        texts.flat_map(|array| array.iter())
    }

    /// The numbers of a column in the rows of an estimator, in the order of the runs.
    pub fn of_estimator(&self, label: &str, column: &str) -> Vec<f64> {
        let rows = self.words("estimator").zip(self.numbers(column));
        let own = rows.filter(|(estimator, _)| *estimator == Some(label));
        own.filter_map(|(_, value)| value).collect()
    }

    /// Labels of the estimators, in the order of the rows.
    pub fn estimators(&self) -> Vec<&str> {
        let distinct: IndexSet<&str> = self.words("estimator").flatten().collect();
        distinct.into_iter().collect()
    }

    /// Reasons of failed runs, each with the number of its runs and the first of them, the most
    /// frequent first.
    pub fn failures(&self) -> Vec<(&str, u64, u64)> {
        let mut found: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
        for (error, index) in self.words("error").zip(self.numbers("index")) {
            if let (Some(error), Some(index)) = (error, index) {
                found.entry(error).or_insert((0, index as u64)).0 += 1;
            }
        }
        let mut list: Vec<_> = found.into_iter().map(|(e, (n, i))| (e, n, i)).collect();
        list.sort_by_key(|(_, count, first)| (u64::MAX - count, *first));
        list
    }
}

/// The types of columns that datasets have.
fn is_known(kind: &DataType) -> bool {
    use DataType::{Boolean, Float64, Int64, UInt64, Utf8};
    matches!(kind, Float64 | Int64 | UInt64 | Boolean | Utf8)
}

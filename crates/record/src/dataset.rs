//! The dataset of a study, read back: one row a run and estimator.

use crate::error::{RecordError, io_error};
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
use arrow_array::{Array, RecordBatch};
use arrow_schema::{DataType, Field, SchemaRef};
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
    /// All columns, each with one value a row.
    pub columns: Vec<DatasetColumn>,
    /// The study that it was made from.
    pub study: StudyChoice,
    /// Number of runs.
    pub runs: u64,
    /// The program and its engines.
    pub version: String,
    /// Text of the base scene.
    pub scene: String,
}

/// A column of a dataset.
#[derive(Clone, Debug)]
pub struct DatasetColumn {
    /// Its name: that of a score, or a key of the scene.
    pub name: String,
    /// SI unit; empty for counts, shares and words.
    pub unit: String,
    /// Its meaning.
    pub description: String,
    /// One value a row.
    pub values: DatasetValues,
}

/// The values of a column; `None` where a row has none.
#[derive(Clone, Debug)]
pub enum DatasetValues {
    /// Numbers, in the unit of the column.
    Numbers(Vec<Option<f64>>),
    /// Texts; true and false, too.
    Words(Vec<Option<String>>),
}

impl Dataset {
    /// Reads the Parquet file of a finished study.
    ///
    /// # Errors
    /// [`RecordError`] if it cannot be read or is no dataset of a study.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let file = File::open(path).map_err(io_error("read", path))?;
        let not = |reason: &dyn Display| RecordError::NotADataset {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        };
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| not(&e))?;
        let schema = reader.schema().clone();
        let batches = reader.build().map_err(|e| not(&e))?;
        let batches: Vec<RecordBatch> = batches.collect::<Result<_, _>>().map_err(|e| not(&e))?;
        let text = |key: &str| {
            let note = schema.metadata().get(key).cloned();
            note.ok_or_else(|| not(&format!("its metadata have no {key}")))
        };
        let study = text("robhaz.study")?;
        let mut study = StudyChoice::parse(&study, "its study file").map_err(|e| not(&e))?;
        study.name = text("robhaz.name")?;
        Ok(Self {
            columns: columns(&schema, &batches).map_err(|e| not(&e))?,
            study,
            runs: text("robhaz.runs")?.parse().map_err(|e| not(&e))?,
            version: text("robhaz.version")?,
            scene: text("robhaz.scene")?,
        })
    }

    /// A column by its name.
    pub fn column(&self, name: &str) -> Option<&DatasetColumn> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The numbers of a column; none if it holds words or does not exist.
    pub fn numbers(&self, name: &str) -> &[Option<f64>] {
        match self.column(name).map(|column| &column.values) {
            Some(DatasetValues::Numbers(values)) => values,
            _ => &[],
        }
    }

    /// The words of a column; none if it holds numbers or does not exist.
    pub fn words(&self, name: &str) -> &[Option<String>] {
        match self.column(name).map(|column| &column.values) {
            Some(DatasetValues::Words(values)) => values,
            _ => &[],
        }
    }

    /// Labels of the estimators, in the order of the rows.
    pub fn estimators(&self) -> Vec<&str> {
        let labels = self.words("estimator").iter().flatten();
        let distinct: IndexSet<&str> = labels.map(String::as_str).collect();
        distinct.into_iter().collect()
    }

    /// Reasons of failed runs, each with the number of its runs and the first of them, the most
    /// frequent first.
    pub fn failures(&self) -> Vec<(&str, u64, u64)> {
        let mut found: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
        for (error, index) in self.words("error").iter().zip(self.numbers("index")) {
            if let (Some(error), Some(index)) = (error, index) {
                found.entry(error).or_insert((0, *index as u64)).0 += 1;
            }
        }
        let mut list: Vec<_> = found.into_iter().map(|(e, (n, i))| (e, n, i)).collect();
        list.sort_by_key(|(_, count, first)| (u64::MAX - count, *first));
        list
    }
}

fn columns(schema: &SchemaRef, batches: &[RecordBatch]) -> Result<Vec<DatasetColumn>, String> {
    let column = |(place, field): (usize, &std::sync::Arc<Field>)| {
        let note = |key: &str| field.metadata().get(key).cloned().unwrap_or_default();
        let arrays = batches.iter().filter_map(|b| b.columns().get(place));
        Ok(DatasetColumn {
            name: field.name().clone(),
            unit: note("unit"),
            description: note("description"),
            values: values(field, arrays.map(AsRef::as_ref))?,
        })
    };
    schema.fields().iter().enumerate().map(column).collect()
}

fn values<'a>(
    field: &Field,
    arrays: impl Iterator<Item = &'a dyn Array>,
) -> Result<DatasetValues, String> {
    use DatasetValues::{Numbers, Words};
    // Whole numbers up to 2^53 are exact: seeds of scenes are smaller.
    Ok(match field.data_type() {
        DataType::Float64 => {
            let numbers = arrays.flat_map(|a| a.as_primitive::<Float64Type>());
            Numbers(numbers.collect())
        }
        DataType::Int64 => {
            let numbers = arrays.flat_map(|a| a.as_primitive::<Int64Type>());
            Numbers(numbers.map(|n| n.map(|n| n as f64)).collect())
        }
        DataType::UInt64 => {
            let numbers = arrays.flat_map(|a| a.as_primitive::<UInt64Type>());
            Numbers(numbers.map(|n| n.map(|n| n as f64)).collect())
        }
        DataType::Boolean => {
            let flags = arrays.flat_map(|a| a.as_boolean());
            Words(flags.map(|f| f.map(|f| f.to_string())).collect())
        }
        DataType::Utf8 => {
            let words = arrays.flat_map(|a| a.as_string::<i32>());
            Words(words.map(|w| w.map(str::to_owned)).collect())
        }
        other => return Err(format!("column {} has the type {other}", field.name())),
    })
}

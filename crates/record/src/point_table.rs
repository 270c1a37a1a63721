//! Tables of points, which are written at once: the ground and the ground that was found.

use crate::error::{RecordError, io_error, parquet_error};
use crate::format::TableFormat;
use crate::parquet_table::write_batch;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

/// A column of a table of points.
pub struct PointColumn<T> {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` where it has none.
    pub unit: &'static str,
    /// Its content.
    pub description: &'static str,
    /// Whether a value can be missing.
    pub nullable: bool,
    /// Its value at a point.
    pub get: fn(&T) -> Option<f64>,
}

impl<T> PointColumn<T> {
    /// A column in which no value is missing by its nature.
    pub const fn always(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        get: fn(&T) -> Option<f64>,
    ) -> Self {
        Self {
            name,
            unit,
            description,
            nullable: false,
            get,
        }
    }
}

/// Writes the table `name` into a folder, and with CSV its lines of `columns.csv`, which is there already.
pub fn write_points<T>(
    folder: &Path,
    format: TableFormat,
    name: &str,
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result<(), RecordError> {
    match format {
        TableFormat::Parquet => {
            let batch = batch_of_points(columns, points, metadata);
            let path = || folder.join(format!("{name}.parquet"));
            let batch = batch.map_err(|e| parquet_error(&path())(e.into()))?;
            write_batch(folder, name, &batch)
        }
        TableFormat::Csv => {
            let path = folder.join(format!("{name}.csv"));
            write_csv(&path, columns, points).map_err(io_error("write", &path))?;
            let path = folder.join("columns.csv");
            add_columns(&path, name, columns).map_err(io_error("write", &path))
        }
    }
}

/// The table as an Arrow batch. `metadata` are keys and values of the table as a whole.
pub fn batch_of_points<T>(
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result<RecordBatch, ArrowError> {
    let field = |column: &PointColumn<T>| {
        Field::new(column.name, DataType::Float64, column.nullable).with_metadata(HashMap::from([
            ("unit".to_owned(), column.unit.to_owned()),
            ("description".to_owned(), column.description.to_owned()),
        ]))
    };
    let fields: Vec<_> = columns.iter().map(field).collect();
    let metadata = metadata.iter().map(|(k, v)| ((*k).to_owned(), v.clone()));
    let schema = Schema::new_with_metadata(fields, metadata.collect());
    let array = |column: &PointColumn<T>| -> ArrayRef {
        Arc::new(points.iter().map(column.get).collect::<Float64Array>())
    };
    RecordBatch::try_new(Arc::new(schema), columns.iter().map(array).collect())
}

fn write_csv<T>(path: &Path, columns: &[PointColumn<T>], points: &[T]) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    let names: Vec<_> = columns.iter().map(|column| column.name).collect();
    writeln!(out, "{}", names.join(","))?;
    for point in points {
        let cell = |column: &PointColumn<T>| {
            let value = (column.get)(point);
            value.map_or(String::new(), |value| format!("{value:?}"))
        };
        let cells: Vec<_> = columns.iter().map(cell).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    out.flush()
}

fn add_columns<T>(path: &Path, name: &str, columns: &[PointColumn<T>]) -> io::Result<()> {
    let mut out = OpenOptions::new().append(true).open(path)?;
    for column in columns {
        let (unit, description) = (column.unit, column.description);
        writeln!(out, "{name},{},{unit},\"{description}\"", column.name)?;
    }
    Ok(())
}

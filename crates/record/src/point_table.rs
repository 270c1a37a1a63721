//! Tables of points, which are made at once: the ground, the ground that was found, a judged path.

use crate::batch::{array, field, schema};
use crate::columns::Kind;
use crate::error::RecordError;
use crate::format::TableFormat;
use crate::table_file::{start_columns, write_table};
use arrow_array::RecordBatch;
use std::path::Path;

/// A column of a table of points.
pub struct PointColumn<T> {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` where it has none.
    pub unit: &'static str,
    /// Its content.
    pub description: &'static str,
    /// The kind of its values.
    pub kind: Kind,
    /// Its value at a point.
    pub get: fn(&T) -> Option<f64>,
}

/// Columns of points, a line each: kind, name, unit, meaning, value.
#[macro_export]
macro_rules! point_columns {
    ($($kind:ident $name:literal, $unit:literal, $description:literal => $get:expr;)*) => {
        &[$($crate::PointColumn {
            name: $name,
            unit: $unit,
            description: $description,
            kind: $crate::Kind::$kind,
            get: $get,
        }),*]
    };
}

/// The table as an Arrow batch. `metadata` are keys and values of the table as a whole.
///
/// # Errors
/// [`RecordError::Batch`] where columns have different lengths.
pub fn batch_of_points<T>(
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result<RecordBatch, RecordError> {
    let fields = columns.iter();
    let fields = fields.map(|c| field(c.name, c.unit, c.description, c.kind.values()));
    let values = |column: &PointColumn<T>| {
        let values = points.iter().map(column.get);
        values.map(|v| v.unwrap_or(f64::NAN)).collect()
    };
    let arrays = columns.iter().map(|c| array(values(c), c.kind));
    let batch = RecordBatch::try_new(schema(fields.collect(), metadata), arrays.collect());
    Ok(batch?)
}

/// Writes the table `name` into a folder that has no other; with CSV also `columns.csv`. `metadata`
/// are keys and values of the table as a whole.
///
/// # Errors
/// [`RecordError`] of the file system.
pub fn write_points<T>(
    folder: &Path,
    format: TableFormat,
    name: &str,
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result<(), RecordError> {
    start_columns(folder, format)?;
    let batch = batch_of_points(columns, points, metadata)?;
    write_table(folder, format, name, &batch)
}

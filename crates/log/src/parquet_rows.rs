//! Parquet files.

use crate::csv_table::BEYOND;
use crate::error::open_file;
use crate::rows::{finite, repeated};
use crate::{AddRow, ColumnInfo, LogError, Place, Row, Stamp, TimeColumn, TimeUnit, iso8601};
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float32Type, Float64Type};
use arrow_array::{Array, ArrayRef, Int64Array, downcast_integer};
use arrow_schema::{DataType, Field, TimeUnit as ArrowTimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::metadata::ParquetMetaData;
use std::fs::File;
use std::path::Path;

/// Rows that are decoded at once.
const BATCH: usize = 4096;

/// The columns of a file.
pub fn columns(path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
    let schema = parquet(path)?.schema().clone();
    let column = |field: &std::sync::Arc<Field>| ColumnInfo {
        name: field.name().clone(),
        unit: ["unit", "units"]
            .iter()
            .find_map(|key| field.metadata().get(*key).cloned()),
        is_time_stamp: whole_unit(field.data_type(), TimeUnit::SECOND)
            .is_some_and(|_| !field.data_type().is_integer()),
    };
    if let Some((again, message)) = repeated(schema.fields().iter().map(|field| field.name())) {
        return Err(LogError::place(path, format!("column {again}"), message));
    }
    Ok(schema.fields().iter().map(column).collect())
}

fn parquet(path: &Path) -> Result<ParquetRecordBatchReaderBuilder<File>, LogError> {
    let file = open_file(path)?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| {
        let hint = "a Parquet file whose recording was killed has no footer and cannot be read: \
                    record as CSV or MCAP, or use what the recorder keeps beside it";
        not_parquet(path, format!("{error}; {hint}"))
    })?;
    check_codecs(path, builder.metadata())?;
    Ok(builder)
}

/// Refuses a file whose columns are compressed with a codec that is not built in.
fn check_codecs(path: &Path, metadata: &ParquetMetaData) -> Result<(), LogError> {
    let is_readable = |codec| !matches!(codec, Compression::BROTLI(_) | Compression::LZO);
    let groups = metadata.row_groups().iter();
    let columns = groups.flat_map(|group| group.columns());
    let mut codecs = columns.map(|column| column.compression());
    let Some(codec) = codecs.find(|codec| !is_readable(*codec)) else {
        return Ok(());
    };
    // The variant's name, without a level.
    let name = codec.to_string().to_lowercase();
    let name = name.split('(').next().unwrap_or_default();
    let file = path.display();
    let message = format!(
        "found the compression {name}, allowed: none, snappy, gzip, lz4, zstd; rewrite the file, in Python \
         `import polars; polars.read_parquet(\"{file}\").write_parquet(\"snappy.parquet\", compression=\"snappy\")`"
    );
    Err(LogError::whole(path, message))
}

fn not_parquet(path: &Path, reason: impl std::fmt::Display) -> LogError {
    LogError::format(path, "Parquet", reason)
}

/// Hands the rows of a file to `add`, with the cells of chosen columns. Every name is the name of a
/// column.
pub fn read(
    path: &Path,
    time: &TimeColumn,
    chosen: &[String],
    add: &mut AddRow<'_>,
) -> Result<(), LogError> {
    let builder = parquet(path)?;
    let has_no = |name: &String| LogError::whole(path, format!("has no column {name}"));
    let index = |name: &String| builder.schema().index_of(name).map_err(|_| has_no(name));
    let wanted = time.columns().chain(chosen).map(index);
    let wanted: Vec<usize> = wanted.collect::<Result<_, _>>()?;
    let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
    let batches = builder.with_projection(mask).with_batch_size(BATCH).build();
    let mut row = 0;
    for batch in batches.map_err(|error| not_parquet(path, error))? {
        let batch = batch.map_err(|error| not_parquet(path, error))?;
        let column = |name: &String| batch.column_by_name(name).ok_or_else(|| has_no(name));
        let seconds = column(&time.name)?;
        let stamps = match &time.nanoseconds {
            None => stamps(path, time, seconds, row)?,
            Some(name) => {
                let parts = [(&time.name, seconds), (name, column(name)?)];
                parts_of_stamps(path, parts, row)?
            }
        };
        let cells = chosen
            .iter()
            .map(|name| numbers(path, name, column(name)?, ""));
        let cells: Vec<_> = cells.collect::<Result<_, _>>()?;
        for (i, stamp) in stamps.into_iter().enumerate() {
            row += 1;
            add(Row {
                place: Place("row", row),
                stamp,
                cells: cells.iter().map(|column| column[i]).collect(),
            })?;
        }
    }
    Ok(())
}

/// The stamps of rows behind the first `before` ones.
fn stamps(
    path: &Path,
    time: &TimeColumn,
    column: &ArrayRef,
    before: u64,
) -> Result<Vec<Stamp>, LogError> {
    let whole = whole_unit(column.data_type(), time.unit);
    let stamps: Vec<Option<Stamp>> = if let Some(unit) = whole {
        // A time stamp of Arrow is a whole number.
        let numbers = column.to_data().into_builder().data_type(DataType::Int64);
        let numbers = numbers.build().map_err(|error| not_parquet(path, error))?;
        let numbers = Int64Array::from(numbers);
        numbers.iter().map(|v| unit.of_whole(v?)).collect()
    } else if let Some(texts) = texts(column) {
        let texts = texts.into_iter();
        texts.map(|text| iso8601::parse(&text?)).collect()
    } else {
        let also = ", a time stamp, a duration, or text in ISO 8601";
        let numbers = numbers(path, &time.name, column, also)?;
        numbers.into_iter().map(|v| time.unit.of_float(v)).collect()
    };
    let check = |(i, stamp): (usize, Option<Stamp>)| {
        stamp.ok_or_else(|| {
            let message = match whole.is_some() && column.is_valid(i) {
                true => format!("found a number that is too large, allowed: {BEYOND}"),
                false => "found no finite number and no date and time such as 2024-05-01T12:00:00.010Z, allowed: every row has a time".to_owned(),
            };
            let row = before + 1 + i as u64;
            LogError::place(path, format!("row {row}, column {}", time.name), message)
        })
    };
    stamps.into_iter().enumerate().map(check).collect()
}

/// The unit of a column of whole numbers, `of_integers` if it has none of its own; `None` of another column.
fn whole_unit(of: &DataType, of_integers: TimeUnit) -> Option<TimeUnit> {
    match of {
        DataType::Int64 => Some(of_integers),
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(match unit {
            ArrowTimeUnit::Second => TimeUnit::SECOND,
            ArrowTimeUnit::Millisecond => TimeUnit::MILLISECOND,
            ArrowTimeUnit::Microsecond => TimeUnit::MICROSECOND,
            ArrowTimeUnit::Nanosecond => TimeUnit::NANOSECOND,
        }),
        _ => None,
    }
}

/// The texts of a column of texts.
fn texts(column: &ArrayRef) -> Option<Vec<Option<String>>> {
    let owned = |text: Option<&str>| text.map(str::to_owned);
    let short = || Some(column.as_string_opt::<i32>()?.iter().map(owned).collect());
    let long = || Some(column.as_string_opt::<i64>()?.iter().map(owned).collect());
    let view = || Some(column.as_string_view_opt()?.iter().map(owned).collect());
    short().or_else(long).or_else(view)
}

/// The stamps of rows behind the first `before` ones, of whole seconds and nanoseconds.
fn parts_of_stamps(
    path: &Path,
    [(seconds_name, seconds), (name, nanoseconds)]: [(&String, &ArrayRef); 2],
    before: u64,
) -> Result<Vec<Stamp>, LogError> {
    let seconds = numbers(path, seconds_name, seconds, "")?;
    let nanoseconds = numbers(path, name, nanoseconds, "")?;
    let rows = (before + 1..).zip(seconds.into_iter().zip(nanoseconds));
    let stamp = |(row, (seconds, nanoseconds)): (u64, (f64, f64))| {
        Stamp::of_parts(seconds, nanoseconds).ok_or_else(|| {
            let place = format!("row {row}, columns {seconds_name} and {name}");
            let message = format!("found {seconds} and {nanoseconds}, allowed: whole seconds, and whole nanoseconds from 0 to 999999999");
            LogError::place(path, place, message)
        })
    };
    rows.map(stamp).collect()
}

/// The values of a column of numbers; not a number where one is missing or not finite. `also` says what else is allowed.
fn numbers(path: &Path, name: &str, column: &ArrayRef, also: &str) -> Result<Vec<f64>, LogError> {
    macro_rules! values {
        ($kind:ty) => {{
            let values = column.as_primitive::<$kind>().iter();
            Ok(values
                .map(|v| v.map_or(f64::NAN, |v| finite(v as f64)))
                .collect())
        }};
    }
    downcast_integer! {
        column.data_type() => (values),
        DataType::Float64 => values!(Float64Type),
        DataType::Float32 => values!(Float32Type),
        found => {
            let message = format!(
                "found the type {found}, allowed: whole numbers of 8 to 64 bits, Float32, Float64{also}"
            );
            Err(LogError::place(path, format!("column {name}"), message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A file in a folder of its own.
    fn written(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.parquet");
        std::fs::write(&path, bytes).expect("written");
        (folder, path)
    }

    /// Files of another writer (pyarrow 26) with the columns time and x, 0.0, 0.001, 0.002 and 1,
    /// 2, 3.
    #[test]
    fn compressed_files_are_read() -> Result<(), LogError> {
        for bytes in [
            include_bytes!("testing/zstd.parquet").as_slice(),
            include_bytes!("testing/gzip.parquet"),
            include_bytes!("testing/lz4.parquet"),
        ] {
            let (_folder, path) = written(bytes);
            let time = TimeColumn {
                name: "time".to_owned(),
                unit: TimeUnit::SECOND,
                nanoseconds: None,
            };
            let mut rows = Vec::new();
            read(&path, &time, &["x".to_owned()], &mut |row| {
                rows.push((row.stamp, row.cells));
                Ok(())
            })?;
            let row = |(time, x)| (Stamp::Seconds(time), vec![x]);
            assert_eq!(rows, [(0.0, 1.0), (0.001, 2.0), (0.002, 3.0)].map(row));
        }
        Ok(())
    }

    /// A codec that is not built in is refused before a row is read, with what helps.
    #[test]
    fn another_compression_says_how_to_rewrite_the_file() {
        let (_folder, path) = written(include_bytes!("testing/brotli.parquet"));
        let error = columns(&path).expect_err("brotli");
        let text = error.to_string();
        for part in [
            "log.parquet: found the compression brotli, allowed: none, snappy",
            "write_parquet(\"snappy.parquet\", compression=\"snappy\")",
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}

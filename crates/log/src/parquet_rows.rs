//! Parquet files.

use crate::error::{LogError, open_file};
use crate::rows::{ColumnInfo, Place, Row, Rows, TimeColumn, repeated};
use crate::stamp::{Stamp, TimeUnit};
use arrow_array::cast::AsArray as _;
use arrow_array::types::{
    Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, TimestampMicrosecondType,
    TimestampMillisecondType, TimestampNanosecondType, TimestampSecondType, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, Field, Schema, TimeUnit as ArrowTimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::basic::Compression;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, RowGroupMetaData};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Rows that are decoded at once.
const BATCH: usize = 4096;

/// The columns of a file.
pub fn columns(path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
    let schema = parquet(path)?.schema().clone();
    let column = |field: &std::sync::Arc<Field>| ColumnInfo {
        name: field.name().clone(),
        unit: field.metadata().get("unit").cloned(),
    };
    let found: Vec<ColumnInfo> = schema.fields().iter().map(column).collect();
    let names: Vec<String> = found.iter().map(|column| column.name.clone()).collect();
    if let Some((first, again)) = repeated(&names) {
        let message = format!(
            "found the name {} again, allowed: each name once; column {} has it, too",
            names[again],
            first + 1
        );
        return Err(LogError::place(
            path,
            format!("column {}", again + 1),
            message,
        ));
    }
    Ok(found)
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
    let columns = metadata
        .row_groups()
        .iter()
        .flat_map(RowGroupMetaData::columns);
    let mut codecs = columns.map(ColumnChunkMetaData::compression);
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

fn not_parquet(path: &Path, reason: String) -> LogError {
    LogError::Format {
        path: path.to_path_buf(),
        what: "Parquet",
        reason,
    }
}

/// The rows of a Parquet file.
pub struct ParquetRows {
    path: PathBuf,
    batches: ParquetRecordBatchReader,
    time: TimeColumn,
    chosen: Vec<String>,
    stamps: Vec<Stamp>,
    cells: Vec<Vec<Option<f64>>>,
    /// Next row of the batch.
    next: usize,
    /// Rows of earlier batches.
    before: u64,
}

impl ParquetRows {
    /// Opens a file. Every name is the name of a column.
    pub fn open(path: &Path, time: &TimeColumn, chosen: &[String]) -> Result<Self, LogError> {
        let builder = parquet(path)?;
        let wanted = indices(path, builder.schema(), time, chosen)?;
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
        let reader = builder.with_projection(mask).with_batch_size(BATCH).build();
        let batches = reader.map_err(|error| not_parquet(path, error.to_string()))?;
        Ok(Self {
            path: path.to_path_buf(),
            batches,
            time: time.clone(),
            chosen: chosen.to_vec(),
            stamps: Vec::new(),
            cells: Vec::new(),
            next: 0,
            before: 0,
        })
    }

    /// Decodes the next batch; false at the end.
    fn load(&mut self) -> Result<bool, LogError> {
        self.before += self.stamps.len() as u64;
        self.next = 0;
        self.stamps.clear();
        let Some(batch) = self.batches.next() else {
            return Ok(false);
        };
        let batch = batch.map_err(|error| not_parquet(&self.path, error.to_string()))?;
        let time = self.column(&batch, &self.time.name)?;
        self.stamps = self.stamps_of(time)?;
        let cells = self.chosen.iter().map(|name| {
            let column = self.column(&batch, name)?;
            numbers(column).ok_or_else(|| self.not_numeric(name, column.data_type()))
        });
        self.cells = cells.collect::<Result<_, _>>()?;
        Ok(true)
    }

    fn column<'a>(&self, batch: &'a RecordBatch, name: &str) -> Result<&'a ArrayRef, LogError> {
        let column = batch.column_by_name(name);
        column.ok_or_else(|| LogError::whole(&self.path, format!("has no column {name}")))
    }

    fn not_numeric(&self, name: &str, found: &DataType) -> LogError {
        let message = format!("found the type {found}, allowed: a number");
        LogError::place(&self.path, format!("column {name}"), message)
    }

    fn stamps_of(&self, column: &ArrayRef) -> Result<Vec<Stamp>, LogError> {
        let unit = self.time.unit;
        let whole = |values: Option<Vec<Option<i64>>>, unit: TimeUnit| -> Vec<Option<Stamp>> {
            let values = values.unwrap_or_default().into_iter();
            values.map(|v| unit.of_whole(v?)).collect()
        };
        let stamps = match column.data_type() {
            DataType::Timestamp(of, _) => {
                let (values, unit) = timestamps(column, *of);
                whole(values, unit)
            }
            DataType::Int64 => {
                let values = column.as_primitive_opt::<Int64Type>();
                whole(values.map(|v| v.iter().collect()), unit)
            }
            other => {
                let values = numbers(column);
                let values = values.ok_or_else(|| self.not_numeric(&self.time.name, other))?;
                values.into_iter().map(|v| unit.of_float(v?)).collect()
            }
        };
        let check = |(i, stamp): (usize, Option<Stamp>)| {
            stamp.ok_or_else(|| {
                let row = self.before + i as u64 + 1;
                let place = format!("row {row}, column {}", self.time.name);
                let message = "found no finite number, allowed: every row has a time";
                LogError::place(&self.path, place, message)
            })
        };
        stamps.into_iter().enumerate().map(check).collect()
    }
}

impl Rows for ParquetRows {
    fn next_row(&mut self) -> Result<Option<Row>, LogError> {
        while self.next >= self.stamps.len() {
            if !self.load()? {
                return Ok(None);
            }
        }
        let i = self.next;
        self.next += 1;
        Ok(Some(Row {
            place: Place::Row(self.before + i as u64 + 1),
            stamp: self.stamps[i],
            cells: self.cells.iter().map(|column| column[i]).collect(),
        }))
    }

    /// Without its end a Parquet file cannot be read at all.
    fn cut_off(&self) -> Option<&str> {
        None
    }
}

/// Indices of the time and of the chosen columns.
fn indices(
    path: &Path,
    schema: &Schema,
    time: &TimeColumn,
    chosen: &[String],
) -> Result<Vec<usize>, LogError> {
    let index = |name: &String| {
        let found = schema.index_of(name);
        found.map_err(|_| LogError::whole(path, format!("has no column {name}")))
    };
    std::iter::once(&time.name)
        .chain(chosen)
        .map(index)
        .collect()
}

fn timestamps(column: &ArrayRef, of: ArrowTimeUnit) -> (Option<Vec<Option<i64>>>, TimeUnit) {
    macro_rules! values {
        ($kind:ty) => {
            column
                .as_primitive_opt::<$kind>()
                .map(|values| values.iter().collect())
        };
    }
    match of {
        ArrowTimeUnit::Second => (values!(TimestampSecondType), TimeUnit::SECOND),
        ArrowTimeUnit::Millisecond => (values!(TimestampMillisecondType), TimeUnit::MILLISECOND),
        ArrowTimeUnit::Microsecond => (values!(TimestampMicrosecondType), TimeUnit::MICROSECOND),
        ArrowTimeUnit::Nanosecond => (values!(TimestampNanosecondType), TimeUnit::NANOSECOND),
    }
}

/// The values of a column of numbers; `None` for another type.
fn numbers(column: &ArrayRef) -> Option<Vec<Option<f64>>> {
    macro_rules! values {
        ($kind:ty) => {
            column.as_primitive_opt::<$kind>().map(|values| {
                let values = values.iter();
                #[expect(clippy::allow_attributes, reason = "the lint depends on the type")]
                #[allow(clippy::cast_precision_loss, clippy::cast_lossless)]
                values.map(|v| v.map(|v| v as f64)).collect()
            })
        };
    }
    let values: Option<Vec<Option<f64>>> = match column.data_type() {
        DataType::Float64 => values!(Float64Type),
        DataType::Float32 => values!(Float32Type),
        DataType::Int8 => values!(Int8Type),
        DataType::Int16 => values!(Int16Type),
        DataType::Int32 => values!(Int32Type),
        DataType::Int64 => values!(Int64Type),
        DataType::UInt8 => values!(UInt8Type),
        DataType::UInt16 => values!(UInt16Type),
        DataType::UInt32 => values!(UInt32Type),
        DataType::UInt64 => values!(UInt64Type),
        _ => None,
    };
    let finite = |v: Option<f64>| v.filter(|v| v.is_finite());
    values.map(|values| values.into_iter().map(finite).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

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
            };
            let mut rows = ParquetRows::open(&path, &time, &["x".to_owned()])?;
            for (time, x) in [(0.0, 1.0), (0.001, 2.0), (0.002, 3.0)] {
                let row = rows.next_row()?.expect("a row");
                assert_eq!(
                    (row.stamp, row.cells),
                    (Stamp::Seconds(time), vec![Some(x)])
                );
            }
            assert_eq!(rows.next_row()?, None);
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

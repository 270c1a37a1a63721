//! Parquet files from the streams of a run: units and descriptions in the field metadata.

use crate::error::{RecordError, io_error, parquet_error, stream_error};
use crate::stream_table;
use arrow_array::RecordBatch;
use arrow_array::cast::AsArray as _;
use arrow_array::types::Float64Type;
use arrow_ipc::reader::StreamReader;
use arrow_schema::{ArrowError, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows in a row group: 16 s at 1 kHz, some 10 MB of memory a table.
const GROUP_ROWS: usize = 16 * 1024;
/// Bytes in a call of the system: the library copies 8 kB at a time.
const WRITTEN_AT_ONCE: usize = 256 * 1024;
/// File name extension of a Parquet file that is not complete.
pub const PARTIAL: &str = "parquet.partial";

/// A Parquet file while it is written.
pub type ParquetFile = ArrowWriter<BufWriter<File>>;

/// A table made of the rows that a run had written when it was killed.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoveredTable {
    /// The Parquet file.
    pub path: PathBuf,
    /// Number of its rows.
    pub rows: u64,
    /// Time of its last row, s. `None` without rows.
    pub end: Option<f64>,
}

/// How a stream is treated that does not end like a complete one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TornEnd {
    /// As an error.
    Refuse,
    /// The rows before the damage are used.
    LeaveOut,
}

/// Makes a Parquet file in the folder `out` of every stream (`.arrows`) that a killed run left in `run`; the streams stay.
///
/// # Errors
/// [`RecordError`]: no such folder, no streams, a Parquet file that is there already and may not be replaced (`replace`), or a
/// file that cannot be read or written.
pub fn recover(run: &Path, out: &Path, replace: bool) -> Result<Vec<RecoveredTable>, RecordError> {
    let streams = streams(run)?;
    if streams.is_empty() {
        return Err(RecordError::NoStreams {
            path: run.to_path_buf(),
        });
    }
    std::fs::create_dir_all(out).map_err(io_error("create", out))?;
    let mut tables = streams.iter().map(|stream| table_of(stream, out));
    if let Some(path) = tables.find(|table| !replace && table.exists()) {
        return Err(RecordError::Exists { path });
    }
    streams
        .iter()
        .map(|stream| write_parquet(stream, out, TornEnd::LeaveOut))
        .collect()
}

/// The streams in a folder, in order of their names.
fn streams(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    if !folder.is_dir() {
        return Err(RecordError::NoFolder {
            path: folder.to_path_buf(),
        });
    }
    let mut streams = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io_error("read", folder))? {
        let path = entry.map_err(io_error("read", folder))?.path();
        if path
            .extension()
            .is_some_and(|e| e == stream_table::EXTENSION)
        {
            streams.push(path);
        }
    }
    streams.sort();
    Ok(streams)
}

/// The Parquet file of a stream.
fn table_of(stream: &Path, folder: &Path) -> PathBuf {
    let name = stream.with_extension("parquet");
    folder.join(name.file_name().unwrap_or_default())
}

/// Makes the Parquet file of a stream in a folder. The file has its name only when it is complete.
pub fn write_parquet(
    stream: &Path,
    folder: &Path,
    torn: TornEnd,
) -> Result<RecoveredTable, RecordError> {
    let path = table_of(stream, folder);
    let partial = path.with_extension(PARTIAL);
    let done = convert(stream, &partial, torn).and_then(|(rows, end)| {
        std::fs::rename(&partial, &path).map_err(io_error("rename", &partial))?;
        Ok(RecoveredTable { path, rows, end })
    });
    if done.is_err() {
        // The file may not exist. The first error is reported.
        let _ = std::fs::remove_file(&partial);
    }
    done
}

/// Number of rows and time of the last, s.
fn convert(stream: &Path, out: &Path, torn: TornEnd) -> Result<(u64, Option<f64>), RecordError> {
    let file = File::open(stream).map_err(io_error("read", stream))?;
    let reader = StreamReader::try_new(BufReader::new(file), None).map_err(stream_error(stream))?;
    let (mut writer, schema) = writer(out, &reader.schema())?;
    let (mut rows, mut end) = (0, None);
    for batch in reader {
        let batch = match batch {
            Ok(batch) => batch,
            Err(error) if torn == TornEnd::LeaveOut && is_torn(&error) => break,
            Err(error) => return Err(stream_error(stream)(error)),
        };
        let batch = RecordBatch::try_new(Arc::clone(&schema), batch.columns().to_vec())
            .map_err(stream_error(stream))?;
        writer.write(&batch).map_err(parquet_error(out))?;
        rows += batch.num_rows() as u64;
        end = last_time(&batch).or(end);
    }
    writer.close().map_err(parquet_error(out))?;
    Ok((rows, end))
}

/// Creates a Parquet file for batches of a schema. Returns the schema of its batches, too: metadata of the table as a whole
/// belong to the file, not to Arrow's schema.
pub fn writer(path: &Path, schema: &SchemaRef) -> Result<(ParquetFile, SchemaRef), RecordError> {
    let metadata = schema.metadata().iter();
    let mut metadata: Vec<KeyValue> = metadata
        .map(|(k, v)| KeyValue::new(k.clone(), v.clone()))
        .collect();
    metadata.sort_by(|a, b| a.key.cmp(&b.key));
    let schema: SchemaRef = Arc::new(Schema::new(schema.fields().clone()));
    let file = File::create(path).map_err(io_error("create", path))?;
    let file = BufWriter::with_capacity(WRITTEN_AT_ONCE, file);
    let writer = ArrowWriter::try_new(file, Arc::clone(&schema), Some(properties(metadata)));
    Ok((writer.map_err(parquet_error(path))?, schema))
}

/// Whether a stream ends in the middle of a batch, and not because the disk cannot be read.
fn is_torn(error: &ArrowError) -> bool {
    match error {
        ArrowError::IoError(_, cause) => cause.kind() == std::io::ErrorKind::UnexpectedEof,
        _ => true,
    }
}

/// The first column of every table is the time, s.
fn last_time(batch: &RecordBatch) -> Option<f64> {
    let times = batch.columns().first()?.as_primitive_opt::<Float64Type>()?;
    let last = times.len().checked_sub(1)?;
    Some(times.value(last))
}

fn properties(metadata: Vec<KeyValue>) -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        // Measured values hardly ever repeat: a dictionary would only cost time.
        .set_dictionary_enabled(false)
        // Readers skip row groups by their times. Those of hundreds of other columns would be kept in memory to the end.
        .set_statistics_enabled(EnabledStatistics::None)
        .set_column_statistics_enabled("time".into(), EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(metadata))
        .build()
}

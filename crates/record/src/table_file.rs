//! Files of tables: the one way from Arrow batches to Parquet or comma-separated text.

use crate::error::{Result, io_error};
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float64Type, Int64Type, UInt32Type, UInt64Type};
use arrow_array::{Array, RecordBatch};
use arrow_schema::{DataType, Schema, SchemaRef};
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::basic::Compression;
use parquet::data_type as stored;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{FileMetaData, KeyValue, ParquetMetaData, ParquetMetaDataWriter};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows in a row group: 16 s at 1 kHz, some 10 MB of memory a table.
pub const GROUP_ROWS: usize = 16 * 1024;
/// Bytes in a call of the system: the library copies 8 kB at a time.
const WRITTEN_AT_ONCE: usize = 256 * 1024;

/// Format of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Apache Parquet; unit and description of a column stand in its field metadata.
    Parquet,
    /// Comma-separated text; units and descriptions stand in `columns.csv` beside it.
    Csv,
}

impl TableFormat {
    /// Extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }
}

/// A table while it is written. It gets its name when it is complete; until then, and after a kill,
/// it has that of an incomplete one.
pub struct TableFile {
    path: PathBuf,
    partial: PathBuf,
    out: Out,
    /// Rows that are written, and the size of the file with them alone, bytes.
    rows: usize,
    whole: u64,
}

type Buffer = BufWriter<UntilError>;

enum Out {
    /// With the metadata of the file.
    Parquet(Box<SerializedFileWriter<Buffer>>, Vec<KeyValue>),
    Csv(Buffer),
}

impl Out {
    fn buffer(&mut self) -> &mut Buffer {
        match self {
            Self::Parquet(writer, _) => writer.inner_mut(),
            Self::Csv(out) => out,
        }
    }
}

/// A file into which nothing more goes after an error: buffers write the rest when they are
/// dropped.
struct UntilError {
    file: File,
    has_failed: bool,
}

impl Write for UntilError {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.has_failed {
            return Err(io::Error::other("an earlier write failed"));
        }
        let written = self.file.write(bytes);
        let is_error = |e: &io::Error| e.kind() != io::ErrorKind::Interrupted;
        self.has_failed = written.as_ref().is_err_and(is_error);
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl TableFile {
    /// Creates the file. With CSV its columns are added to `columns.csv`, which `start_columns` has
    /// begun. Parquet makes it small if `values_repeat` from row to row.
    ///
    /// # Errors
    /// [`RecordError`](crate::RecordError) of the file system.
    pub fn create(
        folder: &Path,
        format: TableFormat,
        name: &str,
        schema: &SchemaRef,
        values_repeat: bool,
    ) -> Result<Self> {
        let path = folder.join(format!("{name}.{}", format.extension()));
        let partial = path.with_added_extension("partial");
        let file = File::create(&partial).map_err(io_error("create", &partial))?;
        let file = UntilError {
            file,
            has_failed: false,
        };
        let mut file = BufWriter::with_capacity(WRITTEN_AT_ONCE, file);
        let out = match format {
            TableFormat::Parquet => {
                let writer = writer(file, schema, values_repeat);
                let (writer, metadata) = writer.map_err(io_error("write", &path))?;
                Out::Parquet(Box::new(writer), metadata)
            }
            TableFormat::Csv => {
                let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
                writeln!(file, "{}", names.join(",")).map_err(io_error("write", &path))?;
                add_columns(folder, name, schema)?;
                Out::Csv(file)
            }
        };
        Ok(Self {
            path,
            partial,
            out,
            rows: 0,
            whole: 0,
        })
    }

    /// Writes rows; of Parquet they are a row group. Of CSV they are numbers alone.
    ///
    /// # Errors
    /// [`RecordError`](crate::RecordError) of the file system, or for values of another type.
    pub fn write(&mut self, batch: &RecordBatch) -> Result {
        let path = &self.path;
        match &mut self.out {
            _ if batch.num_rows() == 0 => return Ok(()),
            Out::Parquet(writer, _) => {
                write_group(writer, batch).map_err(io_error("write", path))?;
            }
            Out::Csv(out) => write_lines(out, batch).map_err(io_error("write", path))?,
        }
        let buffer = self.out.buffer();
        let size = buffer
            .flush()
            .and_then(|()| buffer.get_mut().file.stream_position());
        self.whole = size.map_err(io_error("write", path))?;
        self.rows += batch.num_rows();
        Ok(())
    }

    /// Completes the file and gives it its name; `on_disk`: when all of it is on the disk.
    ///
    /// # Errors
    /// [`RecordError`](crate::RecordError) of the file system.
    pub fn finish(mut self, on_disk: bool) -> Result {
        if let Out::Parquet(writer, _) = &mut self.out {
            writer.finish().map_err(io_error("write", &self.path))?;
        }
        let buffer = self.out.buffer();
        let written = buffer.flush().and_then(|()| match on_disk {
            true => buffer.get_mut().file.sync_all(),
            false => Ok(()),
        });
        written.map_err(io_error("write", &self.path))?;
        std::fs::rename(&self.partial, &self.path).map_err(io_error("rename", &self.partial))
    }

    /// Completes the file after an error of [`TableFile::write`], with the rows before it: what it
    /// has of the failed ones is removed, so that a full disk has room for the end of the file.
    /// Without rows it keeps the name of an incomplete file.
    ///
    /// # Errors
    /// [`RecordError`](crate::RecordError) of the file system.
    pub fn cut_off(mut self) -> Result {
        self.out.buffer().get_mut().has_failed = true;
        let file = OpenOptions::new().write(true).open(&self.partial);
        let mut file = file.map_err(io_error("open", &self.partial))?;
        let cut = file.set_len(self.whole);
        cut.and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(io_error("write", &self.path))?;
        if self.rows == 0 {
            return Ok(());
        }
        if let Out::Parquet(writer, metadata) = &self.out {
            let schema = Arc::new(writer.schema_descr().clone());
            let rows = i64::try_from(self.rows).unwrap_or(i64::MAX);
            let head = FileMetaData::new(1, rows, None, Some(metadata.clone()), schema, None);
            let end = ParquetMetaData::new(head, writer.flushed_row_groups().to_vec());
            let written = ParquetMetaDataWriter::new(&mut file, &end).finish();
            written.map_err(io_error("write", &self.path))?;
        }
        std::fs::rename(&self.partial, &self.path).map_err(io_error("rename", &self.partial))
    }
}

/// Writes a table of one batch into a folder.
pub fn write_table(folder: &Path, format: TableFormat, name: &str, batch: &RecordBatch) -> Result {
    let mut file = TableFile::create(folder, format, name, batch.schema_ref(), false)?;
    file.write(batch)?;
    file.finish(false)
}

/// Begins `columns.csv`: table, column, unit and description, for which CSV has no place. Parquet
/// has none.
pub fn start_columns(folder: &Path, format: TableFormat) -> Result {
    if format == TableFormat::Parquet {
        return Ok(());
    }
    let path = folder.join(COLUMNS);
    std::fs::write(&path, "table,column,unit,description\n").map_err(io_error("write", &path))
}

const COLUMNS: &str = "columns.csv";

fn add_columns(folder: &Path, table: &str, schema: &SchemaRef) -> Result {
    let line = |field: &Arc<arrow_schema::Field>| {
        let note = |key: &str| field.metadata().get(key).cloned().unwrap_or_default();
        let (name, unit) = (field.name(), note("unit"));
        let description = note("description").replace('"', "\"\"");
        format!("{table},{name},{unit},\"{description}\"\n")
    };
    let text: String = schema.fields().iter().map(line).collect();
    let path = folder.join(COLUMNS);
    let file = OpenOptions::new().append(true).open(&path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(io_error("write", &path))
}

/// Comma-separated text. A number is the shortest text that reads back as the same number, with an
/// exponent where that is shorter; one that is missing is empty.
fn write_lines(out: &mut impl Write, batch: &RecordBatch) -> io::Result<()> {
    let columns = batch.columns().iter().map(|array| {
        let counts = array.as_primitive_opt::<UInt32Type>();
        (array.as_primitive_opt::<Float64Type>(), counts)
    });
    let columns: Vec<_> = columns.collect();
    for row in 0..batch.num_rows() {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                write!(out, ",")?;
            }
            match column {
                (Some(floats), _) if floats.is_valid(row) => {
                    write!(out, "{:?}", floats.value(row))?
                }
                (_, Some(counts)) => write!(out, "{}", counts.value(row))?,
                (Some(_), None) => {}
                (None, None) => return Err(io::Error::other("a column holds no numbers")),
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_group(
    writer: &mut SerializedFileWriter<Buffer>,
    batch: &RecordBatch,
) -> ParquetResult<()> {
    let mut group = writer.next_row_group()?;
    for (field, array) in batch.schema_ref().fields().iter().zip(batch.columns()) {
        if let Some(mut column) = group.next_column()? {
            write_column(&mut column, array.as_ref(), field.is_nullable())?;
            column.close()?;
        }
    }
    group.close().map(|_| ())
}

/// A file without rows, and its metadata. Metadata of the table as a whole belong to the file, those of the columns
/// to Arrow's schema, which the file has, too.
fn writer(
    file: Buffer,
    schema: &SchemaRef,
    values_repeat: bool,
) -> ParquetResult<(SerializedFileWriter<Buffer>, Vec<KeyValue>)> {
    let metadata = schema.metadata().iter();
    let mut metadata: Vec<KeyValue> = metadata
        .map(|(k, v)| KeyValue::new(k.clone(), v.clone()))
        .collect();
    metadata.sort_by(|a, b| a.key.cmp(&b.key));
    // Measured values hardly ever do: compression takes a tenth of a run's work for a twentieth of
    // its size, and a dictionary would only cost time.
    let compression = match values_repeat {
        true => Compression::SNAPPY,
        false => Compression::UNCOMPRESSED,
    };
    let mut properties = WriterProperties::builder()
        .set_compression(compression)
        .set_dictionary_enabled(values_repeat)
        // Readers skip row groups by their times. Those of hundreds of other columns would be kept
        // in memory to the end.
        .set_statistics_enabled(EnabledStatistics::None)
        .set_column_statistics_enabled("time".into(), EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(metadata))
        .build();
    let schema = Schema::new(schema.fields().clone());
    add_encoded_arrow_schema_to_metadata(&schema, &mut properties);
    let metadata = properties.key_value_metadata().cloned();
    let columns = ArrowSchemaConverter::new().convert(&schema)?;
    let writer = SerializedFileWriter::new(file, columns.root_schema_ptr(), Arc::new(properties))?;
    Ok((writer, metadata.unwrap_or_default()))
}

/// Writes the values of one column. The library's writer of whole batches looks up each value by an
/// index, which takes several times as long.
fn write_column(
    to: &mut SerializedColumnWriter<'_>,
    array: &dyn Array,
    has_gaps: bool,
) -> ParquetResult<()> {
    // Of a column with gaps: 1 where a row has a value, else 0.
    let levels: Option<Vec<i16>> = has_gaps.then(|| match array.nulls() {
        Some(validity) => validity.iter().map(i16::from).collect(),
        None => vec![1; array.len()],
    });
    let levels = levels.as_deref();
    match array.data_type() {
        DataType::Float64 => {
            let floats = array.as_primitive::<Float64Type>().values();
            let column = to.typed::<stored::DoubleType>();
            if array.null_count() == 0 {
                return column.write_batch(floats, levels, None).map(|_| ());
            }
            // Not by an iterator of options: it adds 4 % to the work of a run.
            let floats = floats.iter().zip(levels.unwrap_or_default());
            let floats: Vec<f64> = floats.filter(|(_, l)| **l == 1).map(|(v, _)| *v).collect();
            column.write_batch(&floats, levels, None).map(|_| ())
        }
        // Parquet keeps unsigned numbers in signed ones of the same bits.
        DataType::UInt32 => {
            let counts = array.as_primitive::<UInt32Type>().iter();
            put::<stored::Int32Type>(to, levels, counts.map(|c| c.map(u32::cast_signed)))
        }
        DataType::UInt64 => {
            let counts = array.as_primitive::<UInt64Type>().iter();
            put::<stored::Int64Type>(to, levels, counts.map(|c| c.map(u64::cast_signed)))
        }
        DataType::Int64 => put::<stored::Int64Type>(to, levels, array.as_primitive::<Int64Type>()),
        DataType::Boolean => put::<stored::BoolType>(to, levels, array.as_boolean()),
        DataType::Utf8 => put::<stored::ByteArrayType>(to, levels, array.as_string::<i32>()),
        other => Err(ParquetError::NYI(other.to_string())),
    }
}

fn put<T: stored::DataType>(
    to: &mut SerializedColumnWriter<'_>,
    levels: Option<&[i16]>,
    values: impl IntoIterator<Item = Option<impl Into<T::T>>>,
) -> ParquetResult<()> {
    let values: Vec<T::T> = values.into_iter().flatten().map(Into::into).collect();
    let column = to.typed::<T>();
    column.write_batch(&values, levels, None).map(|_| ())
}

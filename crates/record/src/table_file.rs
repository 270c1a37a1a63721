//! Files of tables: the one way from Arrow batches to Parquet or comma-separated text.

use crate::error::{RecordError, io_error, parquet_error};
use crate::format::TableFormat;
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Float64Type, UInt32Type};
use arrow_array::{Array, RecordBatch};
use arrow_schema::{Schema, SchemaRef};
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::basic::Compression;
use parquet::data_type::{DataType, DoubleType, Int32Type};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows in a row group: 16 s at 1 kHz, some 10 MB of memory a table.
pub const GROUP_ROWS: usize = 16 * 1024;
/// Bytes in a call of the system: the library copies 8 kB at a time.
const WRITTEN_AT_ONCE: usize = 256 * 1024;

/// A table while it is written. It gets its name when it is complete; until then, and after a kill, it has that of an
/// incomplete one.
pub struct TableFile {
    path: PathBuf,
    partial: PathBuf,
    out: Out,
}

enum Out {
    Parquet(Box<SerializedFileWriter<BufWriter<File>>>),
    Csv(BufWriter<File>),
}

impl TableFile {
    /// Creates the file. With CSV its columns are added to `columns.csv`, which [`start_columns`] has begun.
    pub fn create(
        folder: &Path,
        format: TableFormat,
        name: &str,
        schema: &SchemaRef,
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{name}.{}", format.extension()));
        let partial = path.with_added_extension("partial");
        let file = File::create(&partial).map_err(io_error("create", &partial))?;
        let mut file = BufWriter::with_capacity(WRITTEN_AT_ONCE, file);
        let out = match format {
            TableFormat::Parquet => {
                let writer = writer(file, schema).map_err(parquet_error(&path))?;
                Out::Parquet(Box::new(writer))
            }
            TableFormat::Csv => {
                let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
                writeln!(file, "{}", names.join(",")).map_err(io_error("write", &path))?;
                add_columns(folder, name, schema)?;
                Out::Csv(file)
            }
        };
        Ok(Self { path, partial, out })
    }

    /// Writes rows; of Parquet they are a row group.
    pub fn write(&mut self, batch: &RecordBatch) -> Result<(), RecordError> {
        match &mut self.out {
            Out::Parquet(writer) => write_group(writer, batch).map_err(parquet_error(&self.path)),
            Out::Csv(out) => write_lines(out, batch).map_err(io_error("write", &self.path)),
        }
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<(), RecordError> {
        match self.out {
            Out::Parquet(mut writer) => {
                writer.finish().map_err(parquet_error(&self.path))?;
            }
            Out::Csv(mut out) => out.flush().map_err(io_error("write", &self.path))?,
        }
        std::fs::rename(&self.partial, &self.path).map_err(io_error("rename", &self.partial))
    }
}

/// Writes a table of one batch into a folder.
pub fn write_table(
    folder: &Path,
    format: TableFormat,
    name: &str,
    batch: &RecordBatch,
) -> Result<(), RecordError> {
    let mut file = TableFile::create(folder, format, name, batch.schema_ref())?;
    file.write(batch)?;
    file.finish()
}

/// Begins `columns.csv`: table, column, unit and description, for which CSV has no place. Parquet has none.
pub fn start_columns(folder: &Path, format: TableFormat) -> Result<(), RecordError> {
    if format == TableFormat::Parquet {
        return Ok(());
    }
    let path = folder.join(COLUMNS);
    std::fs::write(&path, "table,column,unit,description\n").map_err(io_error("write", &path))
}

const COLUMNS: &str = "columns.csv";

fn add_columns(folder: &Path, table: &str, schema: &SchemaRef) -> Result<(), RecordError> {
    let line = |field: &Arc<arrow_schema::Field>| {
        let note = |key: &str| field.metadata().get(key).cloned().unwrap_or_default();
        let description = note("description").replace('"', "\"\"");
        format!(
            "{table},{},{},\"{description}\"\n",
            field.name(),
            note("unit")
        )
    };
    let text: String = schema.fields().iter().map(line).collect();
    let path = folder.join(COLUMNS);
    let file = OpenOptions::new().append(true).open(&path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(io_error("write", &path))
}

/// Comma-separated text. A number is the shortest text that reads back as the same number, with an exponent where that is
/// shorter; one that is missing is empty.
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
                _ => {}
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_group(
    writer: &mut SerializedFileWriter<BufWriter<File>>,
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

/// A file without rows. Metadata of the table as a whole belong to the file, those of the columns to
/// Arrow's schema, which the file has, too.
fn writer(
    file: BufWriter<File>,
    schema: &SchemaRef,
) -> ParquetResult<SerializedFileWriter<BufWriter<File>>> {
    let metadata = schema.metadata().iter();
    let mut metadata: Vec<KeyValue> = metadata
        .map(|(k, v)| KeyValue::new(k.clone(), v.clone()))
        .collect();
    metadata.sort_by(|a, b| a.key.cmp(&b.key));
    let mut properties = properties(metadata);
    let schema = Schema::new(schema.fields().clone());
    add_encoded_arrow_schema_to_metadata(&schema, &mut properties);
    let columns = ArrowSchemaConverter::new().convert(&schema)?;
    SerializedFileWriter::new(file, columns.root_schema_ptr(), Arc::new(properties))
}

/// Writes the values of one column. The library's writer of whole batches looks up each value by an index, which
/// takes several times as long.
fn write_column(
    column: &mut SerializedColumnWriter<'_>,
    array: &dyn Array,
    has_gaps: bool,
) -> ParquetResult<()> {
    if let Some(counts) = array.as_primitive_opt::<UInt32Type>() {
        // Parquet keeps unsigned numbers in signed ones of the same bits.
        let counts: Vec<i32> = counts.values().iter().map(|c| c.cast_signed()).collect();
        return write_values::<Int32Type>(column, &counts, None);
    }
    let floats = array.as_primitive_opt::<Float64Type>();
    let floats = floats.ok_or_else(|| ParquetError::NYI(array.data_type().to_string()))?;
    if !has_gaps {
        return write_values::<DoubleType>(column, floats.values(), None);
    }
    let Some(validity) = floats.nulls() else {
        let levels = vec![1; floats.len()];
        return write_values::<DoubleType>(column, floats.values(), Some(&levels));
    };
    let levels: Vec<i16> = validity.iter().map(i16::from).collect();
    let values = floats.values().iter().zip(&levels);
    let values: Vec<f64> = values.filter(|(_, l)| **l == 1).map(|(v, _)| *v).collect();
    write_values::<DoubleType>(column, &values, Some(&levels))
}

/// `levels` of a column with gaps: 1 where a row has a value, else 0.
fn write_values<T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> ParquetResult<()> {
    column.typed::<T>().write_batch(values, levels, None)?;
    Ok(())
}

fn properties(metadata: Vec<KeyValue>) -> WriterProperties {
    WriterProperties::builder()
        // Compression takes a tenth of a run's work for a twentieth of its size.
        .set_compression(Compression::UNCOMPRESSED)
        // Measured values hardly ever repeat: a dictionary would only cost time.
        .set_dictionary_enabled(false)
        // Readers skip row groups by their times. Those of hundreds of other columns would be kept
        // in memory to the end.
        .set_statistics_enabled(EnabledStatistics::None)
        .set_column_statistics_enabled("time".into(), EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(metadata))
        .build()
}

//! Parquet tables, written while the run goes on: units and descriptions are in the field metadata.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, io_error, parquet_error};
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
use rayon::prelude::*;
use robhaz_run::Frame;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows in a row group: 16 s at 1 kHz, some 10 MB of memory a table.
const GROUP_ROWS: usize = 16 * 1024;
/// Bytes in a call of the system: the library copies 8 kB at a time.
const WRITTEN_AT_ONCE: usize = 256 * 1024;
/// File name extension of a Parquet file that is not complete.
const PARTIAL: &str = "parquet.partial";

/// The Parquet tables of a run while they are written, side by side on all cores.
#[derive(Default)]
pub struct ParquetTables(Vec<RowTable>);

impl ParquetTables {
    /// Creates the file of a table. `metadata` are keys and values of the table as a whole.
    pub fn add(
        &mut self,
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<(), RecordError> {
        let rows = BatchBuilder::new(table, metadata);
        let file = TableFile::create(folder, rows.name(), rows.schema())?;
        self.0.push(RowTable { rows, file });
        Ok(())
    }

    /// Adds the rows of records. A table that cannot be written is left out from then on.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        let written = self.0.par_iter_mut().map(|t| t.push_all(frames));
        let written: Vec<_> = written.collect();
        let mut is_whole = written.iter().map(Result::is_ok);
        self.0.retain(|_| is_whole.next().unwrap_or(true));
        written.into_iter().collect()
    }

    /// Writes the last rows and the footers, of all tables even if one fails.
    pub fn close(&mut self) -> Result<(), RecordError> {
        let tables = std::mem::take(&mut self.0);
        let closed: Vec<_> = tables.into_par_iter().map(RowTable::finish).collect();
        closed.into_iter().collect()
    }
}

/// Writes a table of one batch into a folder.
pub fn write_batch(folder: &Path, name: &str, batch: &RecordBatch) -> Result<(), RecordError> {
    let mut file = TableFile::create(folder, name, batch.schema_ref())?;
    file.write(batch)?;
    file.finish()
}

/// A table whose rows come record by record.
struct RowTable {
    rows: BatchBuilder,
    file: TableFile,
}

impl RowTable {
    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        self.rows.push_all(frames);
        if self.rows.rows() < GROUP_ROWS {
            return Ok(());
        }
        self.write_rows()
    }

    fn write_rows(&mut self) -> Result<(), RecordError> {
        let batch = self.rows.take();
        self.file
            .write(&batch.map_err(|e| self.file.error(e.into()))?)
    }

    fn finish(mut self) -> Result<(), RecordError> {
        if self.rows.rows() > 0 {
            self.write_rows()?;
        }
        self.file.finish()
    }
}

/// A file while it is written. It gets its name when it is complete; until then, and after a kill,
/// it has that of an incomplete one.
struct TableFile {
    path: PathBuf,
    writer: SerializedFileWriter<BufWriter<File>>,
}

impl TableFile {
    fn create(folder: &Path, name: &str, schema: &SchemaRef) -> Result<Self, RecordError> {
        let path = folder.join(format!("{name}.parquet"));
        let partial = path.with_extension(PARTIAL);
        let file = File::create(&partial).map_err(io_error("create", &partial))?;
        let file = BufWriter::with_capacity(WRITTEN_AT_ONCE, file);
        let writer = writer(file, schema).map_err(parquet_error(&path))?;
        Ok(Self { path, writer })
    }

    /// Writes a row group.
    fn write(&mut self, batch: &RecordBatch) -> Result<(), RecordError> {
        let mut write = || {
            let mut group = self.writer.next_row_group()?;
            for (field, array) in batch.schema_ref().fields().iter().zip(batch.columns()) {
                if let Some(mut column) = group.next_column()? {
                    write_column(&mut column, array.as_ref(), field.is_nullable())?;
                    column.close()?;
                }
            }
            group.close().map(|_| ())
        };
        write().map_err(|e| self.error(e))
    }

    fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(parquet_error(&self.path))?;
        let partial = self.path.with_extension(PARTIAL);
        std::fs::rename(&partial, &self.path).map_err(io_error("rename", &partial))
    }

    fn error(&self, source: ParquetError) -> RecordError {
        parquet_error(&self.path)(source)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::records;
    use std::fs;

    /// The bytes of a table do not depend on how its rows come, one by one or many at once, over
    /// several batches and row groups.
    #[test]
    fn a_table_does_not_depend_on_how_its_rows_come() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let metadata = [("scene", "trial".to_owned())];
        let records = records();
        let rows = records.iter().cycle().take(40_001);
        let rows: Vec<_> = rows.map(|record| record.without_truth()).collect();
        // 1024 is a multiple of 1 and of 256: batches end at the same rows.
        for (folder, at_once) in folders.iter().zip([1, 256]) {
            let mut tables = ParquetTables::default();
            for table in [Table::estimate(1, "trial"), Table::sensors()] {
                tables
                    .add(folder.path(), table, &metadata)
                    .expect("a table");
            }
            for some in rows.chunks(at_once) {
                tables.push_all(some).expect("rows");
            }
            tables.close().expect("closed");
        }
        for name in ["estimate-trial.parquet", "sensors.parquet"] {
            let [a, b] = [0, 1].map(|i| fs::read(folders[i].path().join(name)).expect("a table"));
            assert!(a == b, "{name}");
        }
        assert_eq!(fs::read_dir(folders[0].path()).expect("files").count(), 2);
    }

    /// A sink that goes without an end leaves no table that looks complete; a folder that has gone is an error.
    #[test]
    fn an_incomplete_table_has_no_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let create = || {
            let mut tables = ParquetTables::default();
            let added = tables.add(folder.path(), Table::estimate(1, "trial"), &[]);
            added.expect("a table");
            tables
        };
        let mut tables = create();
        let rows = &records()[0];
        tables.push_all(&[rows.without_truth()]).expect("a row");
        drop(tables);
        let file = |extension| folder.path().join(format!("estimate-trial.{extension}"));
        assert!(file(PARTIAL).is_file() && !file("parquet").exists());
        let mut tables = create();
        fs::remove_dir_all(folder.path()).expect("removed");
        let error = tables.close().expect_err("nowhere to put it");
        assert!(
            error.to_string().contains("estimate-trial.parquet"),
            "{error}"
        );
    }
}

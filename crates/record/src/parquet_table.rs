//! Parquet tables, written while the run goes on: units and descriptions are in the field metadata.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, io_error, parquet_error};
use arrow_array::RecordBatch;
use arrow_schema::{Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use rayon::prelude::*;
use robhaz_run::Frame;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows of a batch: about half a MB of an estimate.
const BATCH_ROWS: usize = 1024;
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
        if self.rows.rows() < BATCH_ROWS {
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
    writer: ArrowWriter<BufWriter<File>>,
    /// Metadata of the table as a whole belong to the file, not to Arrow's schema.
    schema: SchemaRef,
}

impl TableFile {
    fn create(folder: &Path, name: &str, schema: &SchemaRef) -> Result<Self, RecordError> {
        let path = folder.join(format!("{name}.parquet"));
        let partial = path.with_extension(PARTIAL);
        let metadata = schema.metadata().iter();
        let mut metadata: Vec<KeyValue> = metadata
            .map(|(k, v)| KeyValue::new(k.clone(), v.clone()))
            .collect();
        metadata.sort_by(|a, b| a.key.cmp(&b.key));
        let schema: SchemaRef = Arc::new(Schema::new(schema.fields().clone()));
        let file = File::create(&partial).map_err(io_error("create", &partial))?;
        let file = BufWriter::with_capacity(WRITTEN_AT_ONCE, file);
        let writer = ArrowWriter::try_new(file, Arc::clone(&schema), Some(properties(metadata)));
        Ok(Self {
            writer: writer.map_err(parquet_error(&path))?,
            path,
            schema,
        })
    }

    fn write(&mut self, batch: &RecordBatch) -> Result<(), RecordError> {
        let columns = batch.columns().to_vec();
        let written: ParquetResult<()> = RecordBatch::try_new(Arc::clone(&self.schema), columns)
            .map_err(Into::into)
            .and_then(|batch| self.writer.write(&batch));
        written.map_err(|e| self.error(e))
    }

    fn finish(mut self) -> Result<(), RecordError> {
        self.writer.finish().map_err(parquet_error(&self.path))?;
        let partial = self.path.with_extension(PARTIAL);
        std::fs::rename(&partial, &self.path).map_err(io_error("rename", &partial))
    }

    fn error(&self, source: parquet::errors::ParquetError) -> RecordError {
        parquet_error(&self.path)(source)
    }
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

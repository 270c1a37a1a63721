//! The Parquet tables of recorded readings: written once, while the readings are estimated, side by side on all cores.
//!
//! Rows of a simulation go to a stream first, because a killed run would leave no table ([`crate::stream_table`]). What
//! follows from recorded readings can be computed again in seconds.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, io_error, parquet_error, stream_error};
use crate::parquet_table::{PARTIAL, ParquetFile, writer};
use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use rayon::prelude::*;
use robhaz_run::Frame;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows of a batch: about half a MB of an estimate.
const BATCH_ROWS: usize = 1024;

/// The tables of recorded readings while they are written. A file has its name only when it is complete.
#[derive(Default)]
pub struct DirectTables {
    tables: Vec<TableFile>,
}

impl DirectTables {
    /// Creates the file of a table. `metadata` are keys and values of the table as a whole.
    pub fn add(
        &mut self,
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<(), RecordError> {
        self.tables
            .push(TableFile::create(folder, table, metadata)?);
        Ok(())
    }

    /// Adds the rows of records. A table that cannot be written is left out from then on.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        let written = self.tables.par_iter_mut().map(|t| t.push_all(frames));
        let written: Vec<_> = written.collect();
        let mut is_whole = written.iter().map(Result::is_ok);
        self.tables.retain(|_| is_whole.next().unwrap_or(true));
        written.into_iter().collect()
    }

    /// Writes the last rows and the footers, of all tables even if one fails.
    pub fn close(&mut self) -> Result<(), RecordError> {
        let tables = std::mem::take(&mut self.tables);
        let closed: Vec<_> = tables.into_par_iter().map(TableFile::finish).collect();
        closed.into_iter().collect()
    }
}

/// A file while it is written. One that is not finished keeps the name of an incomplete one, as after a kill.
struct TableFile {
    rows: BatchBuilder,
    path: PathBuf,
    file: ParquetFile,
    schema: SchemaRef,
}

impl TableFile {
    fn create(
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.parquet", table.name));
        let rows = BatchBuilder::new(table, metadata);
        let (file, schema) = writer(&path.with_extension(PARTIAL), rows.schema())?;
        Ok(Self {
            rows,
            path,
            file,
            schema,
        })
    }

    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        self.rows.push_all(frames);
        if self.rows.rows() < BATCH_ROWS {
            return Ok(());
        }
        self.write_rows()
    }

    fn write_rows(&mut self) -> Result<(), RecordError> {
        let batch = self.rows.take().map_err(stream_error(&self.path))?;
        // The same columns without the table's metadata.
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), batch.columns().to_vec())
            .map_err(stream_error(&self.path))?;
        self.file.write(&batch).map_err(parquet_error(&self.path))
    }

    fn finish(mut self) -> Result<(), RecordError> {
        if self.rows.rows() > 0 {
            self.write_rows()?;
        }
        self.file.finish().map_err(parquet_error(&self.path))?;
        let partial = self.path.with_extension(PARTIAL);
        std::fs::rename(&partial, &self.path).map_err(io_error("rename", &partial))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parquet_table::{TornEnd, write_parquet};
    use crate::stream_table::StreamTable;
    use crate::testing::records;
    use std::fs;

    /// The bytes of a table do not depend on the way in which it was written, row by row or
    /// many at once, over several batches and row groups.
    #[test]
    fn a_direct_table_is_that_of_a_stream() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let [direct_folder, stream_folder] = [0, 1].map(|i| folders[i].path());
        let metadata = [("scene", "trial".to_owned())];
        let tables = || [Table::estimate(1, "trial"), Table::sensors()];
        let mut direct = DirectTables::default();
        let mut streams = Vec::new();
        for table in tables() {
            direct
                .add(direct_folder, table, &metadata)
                .expect("a table");
        }
        for table in tables() {
            streams.push(StreamTable::create(stream_folder, table, &metadata).expect("a table"));
        }
        let records = records();
        let rows = records.iter().cycle().take(40_001);
        let rows: Vec<_> = rows.map(|record| record.without_truth()).collect();
        for some in rows.chunks(300) {
            direct.push_all(some).expect("rows");
        }
        for row in rows.chunks(1) {
            for stream in &mut streams {
                stream.push_all(row).expect("a row");
            }
        }
        direct.close().expect("closed");
        let bytes = |path: &Path| fs::read(path).expect("a table");
        for mut stream in streams {
            stream.close().expect("closed");
            let made = write_parquet(stream.path(), stream_folder, TornEnd::Refuse);
            let made = made.expect("a table");
            assert_eq!(made.rows, 40_001);
            let name = made.path.file_name().expect("a name");
            assert!(
                bytes(&made.path) == bytes(&direct_folder.join(name)),
                "{name:?}"
            );
        }
        assert_eq!(fs::read_dir(direct_folder).expect("files").count(), 2);
    }

    /// A sink that goes without an end leaves no table that looks complete; a folder that has gone is an error.
    #[test]
    fn an_incomplete_table_has_no_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let create = || {
            let mut tables = DirectTables::default();
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

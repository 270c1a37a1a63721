//! The sink that makes the tables.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{Result, create_folder};
use crate::point_table::ground_tables;
use crate::table_file::{GROUP_ROWS, TableFile, TableFormat, start_columns, write_table};
use arrow_array::RecordBatch;
use rayon::prelude::*;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::path::{Path, PathBuf};
use std::slice;

/// Makes the tables `truth`, `sensors`, `commands`, `estimate-NAME`, `ground-NAME` and `terrain` of
/// a run, in a folder or in memory. Recorded readings have neither `truth` nor `terrain`; only a
/// control that takes readings has `commands`. An estimator that finds no ground has no table
/// `ground-NAME`; it is made at the end of the run, because points change until the robot has left
/// them.
///
/// A file that is not complete has another name; a run that breaks off closes its tables. A table
/// that cannot be written, on a full disk, ends with its last complete group of rows.
#[derive(Default)]
pub struct TableSink {
    /// Where the files are; `None` in memory.
    folder: Option<(PathBuf, TableFormat)>,
    tables: Vec<RowTable>,
    /// The run, from its start to its end.
    run: Option<RunDescription>,
    /// A row could not be written.
    failed: bool,
    in_memory: Vec<(String, RecordBatch)>,
}

/// A table whose rows come record by record.
struct RowTable {
    rows: BatchBuilder,
    /// `None` in memory.
    file: Option<TableFile>,
}

impl RowTable {
    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result {
        self.rows.push_all(frames);
        match self.rows.rows() >= GROUP_ROWS {
            true => self.write(),
            false => Ok(()),
        }
    }

    /// Writes the rows so far into its file. One that does not take them is completed with those
    /// before.
    fn write(&mut self) -> Result {
        let Some(mut file) = self.file.take() else {
            return Ok(());
        };
        let written = self.rows.take().and_then(|rows| file.write(&rows));
        match written {
            Ok(()) => self.file = Some(file),
            // The error of the rows is the one to report.
            Err(_) => drop(file.cut_off()),
        }
        written
    }

    /// Completes its file, or returns what is in memory.
    fn finish(mut self) -> Result<Option<(String, RecordBatch)>> {
        if self.file.is_none() {
            let batch = self.rows.take()?;
            return Ok(Some((self.rows.table.name, batch)));
        }
        self.write()?;
        self.file
            .map_or(Ok(None), |file| file.finish(false).map(|()| None))
    }
}

impl TableSink {
    /// A sink for a folder, which is made if need be.
    pub fn new(folder: &Path, format: TableFormat) -> Self {
        Self {
            folder: Some((folder.to_path_buf(), format)),
            ..Self::default()
        }
    }

    /// A sink that keeps the tables as Arrow batches, with the same names, columns and metadata.
    pub fn in_memory() -> Self {
        Self::default()
    }

    /// Name and content of each table in memory: `truth`, `sensors`, `estimate-NAME`, then
    /// `terrain` and `ground-NAME`. Empty before the end of the run.
    pub fn into_tables(self) -> Vec<(String, RecordBatch)> {
        self.in_memory
    }
}

/// What a file says of its run.
fn metadata(run: &RunDescription) -> [(&'static str, String); 2] {
    [
        ("scene", run.name.clone()),
        ("robhaz_version", env!("CARGO_PKG_VERSION").to_owned()),
    ]
}

impl Sink for TableSink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        if let Some((folder, format)) = &self.folder {
            create_folder(folder)?;
            start_columns(folder, *format)?;
        }
        self.run = Some(run.clone());
        let metadata = metadata(run);
        for table in Table::all(run) {
            let rows = BatchBuilder::new(table, &metadata);
            let create = |(folder, format): &(PathBuf, TableFormat)| {
                TableFile::create(folder, *format, &rows.table.name, &rows.schema, false)
            };
            let file = self.folder.as_ref().map(create).transpose()?;
            self.tables.push(RowTable { rows, file });
        }
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.frames(slice::from_ref(frame))
    }

    fn frames(&mut self, frames: &[Frame<'_>]) -> Result<(), SinkError> {
        // On all cores: all tables, and the first failure.
        let written = self.tables.par_iter_mut().map(|t| t.push_all(frames));
        let written: Vec<_> = written.collect();
        let written: Result = written.into_iter().collect();
        self.failed |= written.is_err();
        Ok(written?)
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // All tables are closed, even if one fails.
        let tables = std::mem::take(&mut self.tables);
        let closed: Vec<_> = tables.into_par_iter().map(RowTable::finish).collect();
        for table in closed {
            self.in_memory.extend(table?);
        }
        let Some(run) = self.run.take().filter(|_| !self.failed) else {
            return Ok(());
        };
        for (name, batch) in ground_tables(&run, end, &metadata(&run))? {
            match &self.folder {
                Some((folder, format)) => write_table(folder, *format, &name, &batch)?,
                None => self.in_memory.push((name, batch)),
            }
        }
        Ok(())
    }
}

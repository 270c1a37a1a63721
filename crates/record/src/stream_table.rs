//! A table as a stream of Arrow batches. A run writes this form because it can be read at any time.
//!
//! A Parquet file cannot be read without its footer, which is written last: a killed run would leave no table. A
//! stream (`.arrows`, the Arrow IPC streaming format) has no footer: each batch can be read on its own.
//! [`crate::parquet_table`] makes the Parquet file of it at the end of the run.

use crate::append::{Appender, FlushClock};
use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, stream_error};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::ArrowError;
use robhaz_run::Frame;
use std::path::Path;

/// File name extension of a stream.
pub const EXTENSION: &str = "arrows";
/// Largest number of rows that wait for the file, whatever the rate of the records.
const MOST_ROWS: usize = 16 * 1024;

/// A table being written. Rows go to the file at least every simulated second.
pub struct StreamTable {
    rows: BatchBuilder,
    encoder: StreamWriter<Vec<u8>>,
    out: Appender,
    clock: FlushClock,
}

impl StreamTable {
    /// Creates the file. `metadata` are keys and values of the table as a whole.
    pub fn create(
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.{EXTENSION}", table.name));
        let rows = BatchBuilder::new(table, metadata);
        let out = Appender::create(&path)?;
        let encoder = StreamWriter::try_new(Vec::new(), rows.schema());
        let encoder = encoder.map_err(stream_error(&path))?;
        let mut table = Self {
            rows,
            encoder,
            out,
            clock: FlushClock::default(),
        };
        table.append()?;
        Ok(table)
    }

    /// Adds the rows of records.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        let mut rest = frames;
        while let Some(due) = rest.iter().position(|f| self.clock.is_due(f.time)) {
            let (now, later) = rest.split_at(due + 1);
            self.rows.push_all(now);
            self.flush()?;
            rest = later;
        }
        self.rows.push_all(rest);
        if self.rows.rows() >= MOST_ROWS {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the last rows and the end mark of a complete stream.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.flush()?;
        let finished = self.encoder.finish();
        finished.map_err(stream_error(self.out.path()))?;
        self.append()
    }

    /// Path of the stream.
    pub fn path(&self) -> &Path {
        self.out.path()
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        if self.rows.rows() == 0 {
            return Ok(());
        }
        self.encode().map_err(stream_error(self.out.path()))?;
        self.append()
    }

    fn encode(&mut self) -> Result<(), ArrowError> {
        let batch = self.rows.take()?;
        self.encoder.write(&batch)
    }

    /// Writes the encoded bytes to the file.
    fn append(&mut self) -> Result<(), RecordError> {
        let encoded = self.encoder.get_mut();
        let appended = self.out.append(encoded);
        // Rows that cannot be written are dropped: written later they would follow a gap.
        encoded.clear();
        appended
    }
}

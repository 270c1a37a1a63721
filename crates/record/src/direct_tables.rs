//! The Parquet tables of recorded readings: written once, while the readings are estimated, each on a thread of its own.
//!
//! Rows of a simulation go to a stream first, because a killed run would leave no table ([`crate::stream_table`]). What
//! follows from recorded readings can be computed again in seconds.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, io_error, parquet_error, stream_error};
use crate::parquet_table::{PARTIAL, writer};
use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use parquet::arrow::ArrowWriter;
use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_run::{FeltGround, Frame};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

/// Records of a chunk: their estimates stay in a core's cache while a table takes column after column of them.
const CHUNK: usize = 64;
/// Rows of a batch: about half a MB of an estimate.
const BATCH_ROWS: usize = 1024;
/// Chunks that wait for each thread.
const WAITING: usize = 8;

/// Records in a row, which own what a [`Frame`] borrows.
#[derive(Default)]
struct Chunk {
    /// Times (s) and readings.
    readings: Vec<(f64, SensorFrame)>,
    /// Estimates of one record after the other.
    estimates: Vec<Result<Estimate, EstimateError>>,
}

impl Chunk {
    fn push(&mut self, frame: &Frame<'_>) {
        self.readings.push((frame.time, *frame.sensors));
        self.estimates.extend_from_slice(frame.estimates);
    }

    fn clear(&mut self) {
        self.readings.clear();
        self.estimates.clear();
    }

    /// The records, which have no truth and no commands.
    fn frames(&self) -> Vec<Frame<'_>> {
        let count = self.estimates.len() / self.readings.len().max(1);
        let readings = self.readings.iter().enumerate();
        let frames = readings.map(|(k, (time, sensors))| Frame {
            time: *time,
            truth: None,
            clearances: None,
            sensors,
            estimates: &self.estimates[k * count..(k + 1) * count],
            commands: None,
            ground: FeltGround::default(),
        });
        frames.collect()
    }
}

/// Records for a table, or its end.
enum Piece {
    Rows(Arc<Chunk>),
    End,
}

/// The thread of a table.
struct Writing {
    pieces: SyncSender<Piece>,
    thread: JoinHandle<Result<(), RecordError>>,
}

impl Writing {
    fn start(
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.parquet", table.name));
        let rows = BatchBuilder::new(table, metadata);
        let (file, schema) = writer(&path.with_extension(PARTIAL), rows.schema())?;
        let (pieces, received) = sync_channel(WAITING);
        let name = rows.name().to_owned();
        let table = TableFile {
            rows,
            path: path.clone(),
            file,
            schema,
        };
        let spawned = thread::Builder::new()
            .name(name)
            .spawn(move || table.write(&received));
        let thread = spawned.map_err(io_error("start a thread for", &path))?;
        Ok(Self { pieces, thread })
    }

    /// Waits for the end of the thread, and says why it failed.
    fn join(self) -> Result<(), RecordError> {
        drop(self.pieces);
        match self.thread.join() {
            Ok(written) => written,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// The tables of recorded readings while they are written. A file has its name only when it is complete.
#[derive(Default)]
pub struct DirectTables {
    chunk: Chunk,
    /// Chunks that the threads have got, to be used again.
    sent: Vec<Arc<Chunk>>,
    threads: Vec<Writing>,
}

impl DirectTables {
    /// Creates the file of a table. `metadata` are keys and values of the table as a whole.
    pub fn add(
        &mut self,
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<(), RecordError> {
        self.threads.push(Writing::start(folder, table, metadata)?);
        Ok(())
    }

    /// Adds the rows of a record.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        if self.threads.is_empty() {
            return Ok(());
        }
        self.chunk.push(frame);
        if self.chunk.readings.len() == CHUNK {
            self.send()?;
        }
        Ok(())
    }

    /// Writes the last rows and the footers, of all tables even if one fails.
    pub fn close(&mut self) -> Result<(), RecordError> {
        let mut closed = self.send();
        for writing in self.threads.drain(..) {
            // A thread that does not take its end has failed, and says why.
            let _ = writing.pieces.send(Piece::End);
            closed = closed.and(writing.join());
        }
        closed
    }

    /// Hands the chunk to all threads. A table that has failed is reported once.
    fn send(&mut self) -> Result<(), RecordError> {
        let next = self.unused();
        let chunk = Arc::new(std::mem::replace(&mut self.chunk, next));
        let mut failed = None;
        for (k, writing) in self.threads.iter().enumerate() {
            if writing
                .pieces
                .send(Piece::Rows(Arc::clone(&chunk)))
                .is_err()
            {
                failed = Some(k);
            }
        }
        self.sent.push(chunk);
        failed.map_or(Ok(()), |k| self.threads.remove(k).join())
    }

    /// A chunk that no thread needs any more: memory that is used again need not be cleared by the system.
    fn unused(&mut self) -> Chunk {
        let is_free = |chunk: &Arc<Chunk>| Arc::strong_count(chunk) == 1;
        let free = self.sent.iter().position(is_free);
        let chunk = free.and_then(|k| Arc::into_inner(self.sent.swap_remove(k)));
        let mut chunk = chunk.unwrap_or_default();
        chunk.clear();
        chunk
    }
}

/// A file while it is written.
struct TableFile {
    rows: BatchBuilder,
    path: PathBuf,
    file: ArrowWriter<File>,
    schema: SchemaRef,
}

impl TableFile {
    /// Writes all pieces. Without an end, or after an error, the file keeps the name of an incomplete one, as after a kill.
    fn write(mut self, pieces: &Receiver<Piece>) -> Result<(), RecordError> {
        for piece in pieces {
            match piece {
                Piece::Rows(chunk) => {
                    self.rows.push_all(&chunk.frames());
                    if self.rows.rows() >= BATCH_ROWS {
                        self.write_rows()?;
                    }
                }
                Piece::End => return self.finish(),
            }
        }
        Ok(())
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

    /// The bytes of a table do not depend on the way in which it was written, over several chunks, batches and row groups.
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
        for record in records.iter().cycle().take(40_001) {
            direct.push(&record.without_truth()).expect("a row");
            for stream in &mut streams {
                stream.push_all(&[record.without_truth()]).expect("a row");
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
        tables.push(&records()[0].without_truth()).expect("a row");
        for writing in tables.threads.drain(..) {
            writing.join().expect("no error");
        }
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

//! A Parquet table of recorded readings, written while they are read, on a thread of its own.
//!
//! Rows of a simulation go to a stream first, because a killed run would leave no table ([`crate::stream_table`]). What
//! follows from recorded readings can be computed again in seconds: its tables are written once.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, io_error, parquet_error, stream_error};
use crate::parquet_table::{PARTIAL, writer};
use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use parquet::arrow::ArrowWriter;
use robhaz_run::Frame;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

/// Rows of a batch: about half a MB of an estimate.
const BATCH_ROWS: usize = 1024;
/// Batches that wait for the thread.
const WAITING: usize = 2;

/// Rows for the file, or its end.
enum Piece {
    Rows(RecordBatch),
    End,
}

/// The thread that writes, and what becomes of it.
type Written = JoinHandle<Result<(), RecordError>>;

/// A table being written. Its file has its name only when it is complete.
pub struct DirectTable {
    rows: BatchBuilder,
    path: PathBuf,
    /// The thread that writes, until it ends.
    thread: Option<(SyncSender<Piece>, Written)>,
}

impl DirectTable {
    /// Creates the file. `metadata` are keys and values of the table as a whole.
    pub fn create(
        folder: &Path,
        table: Table,
        metadata: &[(&str, String)],
    ) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.parquet", table.name));
        let rows = BatchBuilder::new(table, metadata);
        let (writer, schema) = writer(&path.with_extension(PARTIAL), rows.schema())?;
        let (pieces, received) = sync_channel(WAITING);
        let target = path.clone();
        let spawned = thread::Builder::new()
            .name(rows.name().to_owned())
            .spawn(move || write(&target, writer, &schema, &received));
        let thread = spawned.map_err(io_error("start a thread for", &path))?;
        Ok(Self {
            rows,
            path,
            thread: Some((pieces, thread)),
        })
    }

    /// Adds the row of a record, if it has one.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        if self.rows.push(frame) && self.rows.rows() == BATCH_ROWS {
            self.send_rows()?;
        }
        Ok(())
    }

    /// Writes the last rows and the footer.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.send_rows()?;
        self.send(Piece::End)?;
        self.join()
    }

    fn send_rows(&mut self) -> Result<(), RecordError> {
        if self.rows.rows() == 0 {
            return Ok(());
        }
        let batch = self.rows.take().map_err(stream_error(&self.path))?;
        self.rows.reserve(BATCH_ROWS);
        self.send(Piece::Rows(batch))
    }

    fn send(&mut self, piece: Piece) -> Result<(), RecordError> {
        let taken = self.thread.as_ref().map(|(pieces, _)| pieces.send(piece));
        match taken {
            Some(Ok(())) => Ok(()),
            // The thread ended early: it says why.
            _ => self.join(),
        }
    }

    /// Waits for the end of the thread. Nothing to wait for after its first failure, which was reported.
    fn join(&mut self) -> Result<(), RecordError> {
        let Some((pieces, thread)) = self.thread.take() else {
            return Ok(());
        };
        drop(pieces);
        match thread.join() {
            Ok(written) => written,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

/// Writes all pieces. Without an end, or after an error, the file keeps the name of an incomplete one, as after a kill.
fn write(
    path: &Path,
    mut writer: ArrowWriter<File>,
    schema: &SchemaRef,
    pieces: &Receiver<Piece>,
) -> Result<(), RecordError> {
    for piece in pieces {
        let Piece::Rows(batch) = piece else {
            writer.finish().map_err(parquet_error(path))?;
            let partial = path.with_extension(PARTIAL);
            return std::fs::rename(&partial, path).map_err(io_error("rename", &partial));
        };
        // The same columns without the table's metadata.
        let batch = RecordBatch::try_new(SchemaRef::clone(schema), batch.columns().to_vec())
            .map_err(stream_error(path))?;
        writer.write(&batch).map_err(parquet_error(path))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parquet_table::{TornEnd, write_parquet};
    use crate::stream_table::StreamTable;
    use crate::testing::records;
    use std::fs;

    /// The bytes of a table do not depend on the way in which it was written, over several batches and row groups.
    #[test]
    fn a_direct_table_is_that_of_a_stream() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let [direct_folder, stream_folder] = [0, 1].map(|i| folders[i].path());
        let table = || Table::estimate(1, "trial");
        let metadata = [("scene", "trial".to_owned())];
        let mut direct = DirectTable::create(direct_folder, table(), &metadata).expect("a table");
        let mut stream = StreamTable::create(stream_folder, table(), &metadata).expect("a table");
        let records = records();
        for record in records.iter().cycle().take(40_000) {
            direct.push(&record.frame()).expect("a row");
            stream.push(&record.frame()).expect("a row");
        }
        direct.close().expect("closed");
        stream.close().expect("closed");
        let made = write_parquet(stream.path(), stream_folder, TornEnd::Refuse).expect("a table");
        assert_eq!(made.rows, 40_000);
        let bytes = |path: &Path| fs::read(path).expect("a table");
        assert!(bytes(&made.path) == bytes(&direct_folder.join("estimate-trial.parquet")));
        assert_eq!(fs::read_dir(direct_folder).expect("files").count(), 1);
    }

    /// A sink that goes without an end leaves no table that looks complete; a folder that has gone is an error.
    #[test]
    fn an_incomplete_table_has_no_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let create = || DirectTable::create(folder.path(), Table::estimate(1, "trial"), &[]);
        let mut table = create().expect("a table");
        table.push(&records()[0].frame()).expect("a row");
        let (pieces, thread) = table.thread.take().expect("a thread");
        drop(pieces);
        thread.join().expect("no panic").expect("no error");
        let file = |extension| folder.path().join(format!("estimate-trial.{extension}"));
        assert!(file(PARTIAL).is_file() && !file("parquet").exists());
        let mut table = create().expect("a table");
        fs::remove_dir_all(folder.path()).expect("removed");
        let error = table.close().expect_err("nowhere to put it");
        assert!(
            error.to_string().contains("estimate-trial.parquet"),
            "{error}"
        );
    }
}

//! A table as a stream of Arrow batches. A run writes this form because it can be read at any time.
//!
//! A Parquet file cannot be read without its footer, which is written last: a killed run would leave no table. A
//! stream (`.arrows`, the Arrow IPC streaming format) has no footer: each batch can be read on its own.
//! [`crate::parquet_table`] makes the Parquet file of it at the end of the run.

use crate::append::{Appender, FlushClock};
use crate::columns::{Column, Kind, Table, Value};
use crate::error::{RecordError, stream_error};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use robhaz_run::Frame;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// File name extension of a stream.
pub const EXTENSION: &str = "arrows";
/// Largest number of rows that wait for the file, whatever the rate of the records.
const MOST_ROWS: usize = 16 * 1024;

/// Values of one column that wait for the file.
enum Buffer {
    Float(Vec<f64>),
    Optional(Vec<Option<f64>>),
    Count(Vec<u32>),
}

impl Buffer {
    fn new(column: &Column) -> Self {
        match column.kind() {
            Kind::Float => Self::Float(Vec::new()),
            Kind::Optional => Self::Optional(Vec::new()),
            Kind::Count => Self::Count(Vec::new()),
        }
    }

    fn push(&mut self, value: Value) {
        match (self, value) {
            (Self::Float(buffer), Value::Float(value)) => buffer.push(value),
            (Self::Optional(buffer), Value::Optional(value)) => buffer.push(value),
            (Self::Count(buffer), Value::Count(value)) => buffer.push(value),
            // A column has one kind. A value of another kind would make the lengths differ, and the batch an error.
            _ => {}
        }
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Self::Float(buffer) => Arc::new(Float64Array::from(std::mem::take(buffer))),
            Self::Optional(buffer) => Arc::new(buffer.drain(..).collect::<Float64Array>()),
            Self::Count(buffer) => Arc::new(UInt32Array::from(std::mem::take(buffer))),
        }
    }
}

/// A table being written. Rows go to the file at least every simulated second.
pub struct StreamTable {
    table: Table,
    buffers: Vec<Buffer>,
    buffered: usize,
    schema: SchemaRef,
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
        let fields: Vec<Field> = table.columns.iter().map(field).collect();
        let metadata = metadata.iter().map(|(k, v)| ((*k).to_owned(), v.clone()));
        let schema = Arc::new(Schema::new_with_metadata(fields, metadata.collect()));
        let out = Appender::create(&path)?;
        let encoder = StreamWriter::try_new(Vec::new(), &schema).map_err(stream_error(&path))?;
        let mut table = Self {
            buffers: table.columns.iter().map(Buffer::new).collect(),
            table,
            buffered: 0,
            schema,
            encoder,
            out,
            clock: FlushClock::default(),
        };
        table.append()?;
        Ok(table)
    }

    /// Adds the row of a record, if it has one.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        if !self.table.has_row(frame) {
            return Ok(());
        }
        for (buffer, column) in self.buffers.iter_mut().zip(&self.table.columns) {
            buffer.push(column.value(frame));
        }
        self.buffered += 1;
        if self.clock.is_due(frame.time) || self.buffered == MOST_ROWS {
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
        if self.buffered == 0 {
            return Ok(());
        }
        self.buffered = 0;
        self.encode().map_err(stream_error(self.out.path()))?;
        self.append()
    }

    fn encode(&mut self) -> Result<(), ArrowError> {
        let arrays = self.buffers.iter_mut().map(Buffer::take).collect();
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays)?;
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

fn field(column: &Column) -> Field {
    let (kind, nullable) = match column.kind() {
        // Only columns with gaps are nullable: validity bits cost time.
        Kind::Float => (DataType::Float64, false),
        Kind::Optional => (DataType::Float64, true),
        Kind::Count => (DataType::UInt32, false),
    };
    Field::new(&column.name, kind, nullable).with_metadata(HashMap::from([
        ("unit".to_owned(), column.unit.to_owned()),
        ("description".to_owned(), column.description.clone()),
    ]))
}

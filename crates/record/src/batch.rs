//! Rows of a table as Arrow batches.

use crate::columns::{Cells, Column, Kind, Table};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array};
use arrow_buffer::NullBufferBuilder;
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use robhaz_run::Frame;
use std::collections::HashMap;
use std::sync::Arc;

/// Values of one column that wait for their batch.
enum Buffer {
    Float(Vec<f64>),
    Optional(Gappy),
    Count(Vec<u32>),
}

/// Numbers with gaps. Validity bits are only made from the first gap on.
struct Gappy {
    values: Vec<f64>,
    valid: NullBufferBuilder,
}

impl Gappy {
    fn new() -> Self {
        Self {
            values: Vec::new(),
            valid: NullBufferBuilder::new(0),
        }
    }

    #[inline]
    fn push(&mut self, value: Option<f64>) {
        self.valid.append(value.is_some());
        self.values.push(value.unwrap_or_default());
    }

    fn take(&mut self) -> Float64Array {
        Float64Array::new(emptied(&mut self.values).into(), self.valid.finish())
    }
}

/// The values of a buffer, which keeps room for as many: the next batch is about as long.
fn emptied<T>(buffer: &mut Vec<T>) -> Vec<T> {
    let next = Vec::with_capacity(buffer.len());
    std::mem::replace(buffer, next)
}

impl Buffer {
    fn new(column: &Column) -> Self {
        match column.kind() {
            Kind::Float => Self::Float(Vec::new()),
            Kind::Optional => Self::Optional(Gappy::new()),
            Kind::Count => Self::Count(Vec::new()),
        }
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Self::Float(buffer) => Arc::new(Float64Array::from(emptied(buffer))),
            Self::Optional(buffer) => Arc::new(buffer.take()),
            Self::Count(buffer) => Arc::new(UInt32Array::from(emptied(buffer))),
        }
    }
}

/// A column has one kind. A value of another kind would make the lengths differ, and the batch an error.
impl Cells for Buffer {
    #[inline]
    fn float(&mut self, value: f64) {
        if let Self::Float(buffer) = self {
            buffer.push(value);
        }
    }

    #[inline]
    fn optional(&mut self, value: Option<f64>) {
        if let Self::Optional(buffer) = self {
            buffer.push(value);
        }
    }

    #[inline]
    fn count(&mut self, value: u32) {
        if let Self::Count(buffer) = self {
            buffer.push(value);
        }
    }
}

/// Collects rows of a table and makes Arrow batches of them. Unit and description of a column are in the metadata of its
/// field.
pub struct BatchBuilder {
    table: Table,
    buffers: Vec<Buffer>,
    rows: usize,
    schema: SchemaRef,
}

impl BatchBuilder {
    /// A table without rows. `metadata` are keys and values of the table as a whole.
    pub fn new(table: Table, metadata: &[(&str, String)]) -> Self {
        let fields: Vec<Field> = table.columns.iter().map(field).collect();
        let metadata = metadata.iter().map(|(k, v)| ((*k).to_owned(), v.clone()));
        Self {
            buffers: table.columns.iter().map(Buffer::new).collect(),
            table,
            rows: 0,
            schema: Arc::new(Schema::new_with_metadata(fields, metadata.collect())),
        }
    }

    /// Adds the row of a record. Returns whether the table has one for it.
    pub fn push(&mut self, frame: &Frame<'_>) -> bool {
        if !self.table.has_row(frame) {
            return false;
        }
        for (buffer, column) in self.buffers.iter_mut().zip(&self.table.columns) {
            column.pass(frame, buffer);
        }
        self.rows += 1;
        true
    }

    /// Adds the rows of several records, column after column: faster than row after row.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) {
        let frames: Vec<_> = frames.iter().filter(|f| self.table.has_row(f)).collect();
        for (buffer, column) in self.buffers.iter_mut().zip(&self.table.columns) {
            for frame in &frames {
                column.pass(frame, buffer);
            }
        }
        self.rows += frames.len();
    }

    /// Makes room for more rows, where their number is known.
    pub fn reserve(&mut self, rows: usize) {
        for buffer in &mut self.buffers {
            match buffer {
                Buffer::Float(values) => values.reserve(rows),
                Buffer::Optional(gappy) => gappy.values.reserve(rows),
                Buffer::Count(counts) => counts.reserve(rows),
            }
        }
    }

    /// Number of rows since the last batch.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Name of the table.
    pub fn name(&self) -> &str {
        &self.table.name
    }

    /// Names, types and metadata of the columns.
    pub fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// The rows since the last batch.
    ///
    /// # Errors
    /// [`ArrowError`] where a column gave a value of another kind than its own.
    pub fn take(&mut self) -> Result<RecordBatch, ArrowError> {
        self.rows = 0;
        let arrays = self.buffers.iter_mut().map(Buffer::take).collect();
        RecordBatch::try_new(Arc::clone(&self.schema), arrays)
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

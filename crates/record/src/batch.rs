//! Rows of a table as Arrow batches.

use crate::columns::{Column, Kind, Table};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array};
use arrow_buffer::NullBufferBuilder;
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use robhaz_run::Frame;
use std::collections::HashMap;
use std::slice;
use std::sync::Arc;

/// Records that stay in the fast cache of a core while column after column takes its values.
const ROWS_AT_ONCE: usize = 32;

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

    /// Notes which values from `first` on are there: those that are finite.
    fn mark(&mut self, first: usize) {
        let added = &mut self.values[first..];
        // Without a way out of the loop, so that it takes several values at once.
        if added
            .iter()
            .fold(true, |all, value| all & value.is_finite())
        {
            self.valid.append_n_non_nulls(added.len());
            return;
        }
        for value in added {
            self.valid.append(value.is_finite());
            if !value.is_finite() {
                *value = 0.0;
            }
        }
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

    /// Adds the values of the buffer's column.
    fn add(&mut self, column: &Column, frames: &[Frame<'_>]) {
        match self {
            Self::Float(buffer) => column.add_floats(frames, buffer),
            Self::Optional(buffer) => {
                let first = buffer.values.len();
                column.add_floats(frames, &mut buffer.values);
                buffer.mark(first);
            }
            Self::Count(buffer) => column.add_counts(frames, buffer),
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

    /// Adds the rows of records, column after column. A record for which the table has no row is left out.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) {
        if frames.iter().all(|frame| self.table.has_row(frame)) {
            return frames.chunks(ROWS_AT_ONCE).for_each(|some| self.add(some));
        }
        for frame in frames {
            if self.table.has_row(frame) {
                self.add(slice::from_ref(frame));
            }
        }
    }

    fn add(&mut self, frames: &[Frame<'_>]) {
        for (buffer, column) in self.buffers.iter_mut().zip(&self.table.columns) {
            buffer.add(column, frames);
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

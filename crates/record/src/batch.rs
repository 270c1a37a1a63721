//! Rows of a table as Arrow batches.

use crate::columns::{Kind, Table};
use crate::error::Result;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array};
use arrow_buffer::{BooleanBuffer, NullBuffer};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use robhaz_run::Frame;
use std::collections::HashMap;
use std::sync::Arc;

/// Records that stay in the fast cache of a core while column after column takes its values.
const ROWS_AT_ONCE: usize = 32;

/// Collects rows of a table and makes Arrow batches of them. Unit and description of a column are
/// in the metadata of its field.
pub struct BatchBuilder {
    pub(crate) table: Table,
    /// The values of each column.
    values: Vec<Vec<f64>>,
    /// Names, types and metadata of the columns.
    pub(crate) schema: SchemaRef,
}

impl BatchBuilder {
    /// A table without rows. `metadata` are keys and values of the table as a whole.
    pub fn new(table: Table, metadata: &[(&str, String)]) -> Self {
        let fields = table.columns.iter();
        let fields = fields.map(|c| field(&c.name, c.unit, &c.description, c.kind.values()));
        Self {
            values: vec![Vec::new(); table.columns.len()],
            schema: schema(fields.collect(), metadata),
            table,
        }
    }

    /// Adds the rows of records, column after column.
    pub fn push_all(&mut self, frames: &[Frame<'_>]) {
        for some in frames.chunks(ROWS_AT_ONCE) {
            for (values, column) in self.values.iter_mut().zip(&self.table.columns) {
                column.add(some, values);
            }
        }
    }

    /// Number of rows since the last batch.
    pub(crate) fn rows(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// The rows since the last batch.
    ///
    /// # Errors
    /// [`RecordError::Batch`](crate::RecordError::Batch) where columns have different lengths.
    pub fn take(&mut self) -> Result<RecordBatch> {
        let rows = self.rows();
        let columns = self.values.iter_mut().zip(&self.table.columns);
        // The next batch is about as long.
        let arrays = columns.map(|(values, column)| {
            let values = std::mem::replace(values, Vec::with_capacity(rows));
            array(values, column.kind)
        });
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays.collect());
        Ok(batch?)
    }
}

impl Kind {
    /// Type of its values, and whether there are gaps. Only columns with gaps are nullable:
    /// validity bits cost time.
    pub(crate) fn values(self) -> (DataType, bool) {
        match self {
            Self::Float => (DataType::Float64, false),
            Self::Optional => (DataType::Float64, true),
            Self::Count => (DataType::UInt32, false),
        }
    }
}

/// A column of Arrow, with what a table says of it: type of its values, and whether there are gaps.
pub fn field(
    name: &str,
    unit: &str,
    description: &str,
    (values, has_gaps): (DataType, bool),
) -> Field {
    Field::new(name, values, has_gaps).with_metadata(HashMap::from([
        ("unit".to_owned(), unit.to_owned()),
        ("description".to_owned(), description.to_owned()),
    ]))
}

/// Columns, with keys and values of the table as a whole.
pub fn schema(fields: Vec<Field>, metadata: &[(&str, String)]) -> SchemaRef {
    let metadata = metadata.iter().map(|(k, v)| ((*k).to_owned(), v.clone()));
    Arc::new(Schema::new_with_metadata(fields, metadata.collect()))
}

/// The values of a column.
pub fn array(mut values: Vec<f64>, kind: Kind) -> ArrayRef {
    let all_finite = |values: &[f64]| values.iter().fold(true, |all, v| all & v.is_finite());
    match kind {
        Kind::Optional if !all_finite(&values) => {
            let valid = BooleanBuffer::collect_bool(values.len(), |i| values[i].is_finite());
            // Defined bytes in the gaps.
            let gaps = values.iter_mut().filter(|v| !v.is_finite());
            gaps.for_each(|v| *v = 0.0);
            let valid = Some(NullBuffer::new(valid));
            Arc::new(Float64Array::new(values.into(), valid))
        }
        Kind::Float | Kind::Optional => Arc::new(Float64Array::from(values)),
        // Small counts, kept as numbers.
        Kind::Count => Arc::new(values.iter().map(|v| *v as u32).collect::<UInt32Array>()),
    }
}

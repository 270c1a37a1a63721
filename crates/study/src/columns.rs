//! Columns of the dataset: index, varied keys, estimator, scores, error.

use crate::journal::RunRecord;
use crate::plan::Plan;
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray, UInt64Array,
};
use arrow_schema::{DataType, SchemaRef};
use robhaz_record::{RecordError, ScoreColumn, field, schema};
use robhaz_scene::{Axis, AxisItem, AxisValue, AxisValues, Distribution, Setting};
use std::sync::Arc;

/// A value that waits for its batch.
type Cell = Option<AxisValue>;

/// The narrowest type that takes all values of the `i`-th key of an axis, or their names.
fn type_of(axis: &Axis, i: usize) -> DataType {
    let named = |items: &[AxisItem]| items.iter().any(|item| item.name.is_some());
    if matches!(&axis.values, AxisValues::List(items) if i == 0 && named(items)) {
        return DataType::Utf8;
    }
    let all = |is_it: fn(&AxisValue) -> bool| match &axis.values {
        AxisValues::List(items) => items.iter().filter_map(|v| v.values.get(i)).all(is_it),
        AxisValues::Whole { .. } | AxisValues::Drawn(Distribution::Whole(..)) => {
            is_it(&AxisValue::Whole(0))
        }
        AxisValues::Drawn(_) => is_it(&AxisValue::Number(0.0)),
    };
    if all(|v| matches!(v, AxisValue::Whole(_))) {
        DataType::Int64
    } else if all(|v| matches!(v, AxisValue::Whole(_) | AxisValue::Number(_))) {
        DataType::Float64
    } else if all(|v| matches!(v, AxisValue::Boolean(_))) {
        DataType::Boolean
    } else {
        DataType::Utf8
    }
}

/// The values of a column. One of another kind is null, which the column of a key refuses.
fn array(kind: &DataType, cells: &[Cell]) -> ArrayRef {
    fn all<T, A: FromIterator<Option<T>>>(
        cells: &[Cell],
        of: impl Fn(&AxisValue) -> Option<T>,
    ) -> Arc<A> {
        let values = cells.iter().map(|cell| cell.as_ref().and_then(&of));
        Arc::new(values.collect())
    }
    let whole = |value: &AxisValue| match value {
        AxisValue::Whole(whole) => Some(*whole),
        _ => None,
    };
    match kind {
        DataType::UInt64 => all::<_, UInt64Array>(cells, |v| whole(v)?.try_into().ok()),
        DataType::Int64 => all::<_, Int64Array>(cells, whole),
        DataType::Float64 => all::<_, Float64Array>(cells, |value| match value {
            AxisValue::Number(number) => Some(*number),
            // A whole number among others.
            other => whole(other).map(|whole| whole as f64),
        }),
        DataType::Boolean => all::<_, BooleanArray>(cells, |value| match value {
            AxisValue::Boolean(flag) => Some(*flag),
            _ => None,
        }),
        _ => all::<_, StringArray>(cells, |value| match value {
            AxisValue::Text(text) => Some(text.clone()),
            other => Some(other.to_string()),
        }),
    }
}

/// Collects rows of the dataset and makes Arrow batches of them.
pub struct RowBuilder {
    schema: SchemaRef,
    /// The cells of each column.
    columns: Vec<Vec<Cell>>,
}

impl RowBuilder {
    /// The rows of a study. `notes` are keys and values of the dataset as a whole.
    pub fn new(plan: &Plan, notes: &[(&str, String)]) -> Self {
        let index = (DataType::UInt64, false);
        let mut fields = vec![field("index", "", "index of the run", index)];
        for axis in plan.axes() {
            for (i, key) in axis.keys.iter().enumerate() {
                let kind = type_of(axis, i);
                let unit = match kind {
                    DataType::Int64 | DataType::Float64 => Axis::unit(key),
                    _ => "",
                };
                fields.push(field(key, unit, "key of the scene, varied", (kind, false)));
            }
        }
        let text = "label of the estimator; null for a run that failed";
        fields.push(field("estimator", "", text, (DataType::Utf8, true)));
        fields.extend(ScoreColumn::all().iter().map(|c| {
            let kind = match c.is_count {
                true => DataType::UInt64,
                false => DataType::Float64,
            };
            field(c.name, c.unit, c.description, (kind, true))
        }));
        let text = "why the run failed; null for a complete run";
        fields.push(field("error", "", text, (DataType::Utf8, true)));
        Self {
            columns: vec![Vec::new(); fields.len()],
            schema: schema(fields, notes),
        }
    }

    /// Names, types and metadata of the columns.
    pub fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// Number of rows since the last batch.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Adds the rows of a run with its settings.
    pub fn push(&mut self, record: &RunRecord, settings: &[Setting]) {
        let text = |text: &Option<String>| text.clone().map(AxisValue::Text);
        let setting = |s: &Setting| text(&s.name).unwrap_or_else(|| s.value.clone());
        for row in &record.rows {
            let index = i64::try_from(record.run).ok().map(AxisValue::Whole);
            let scores = ScoreColumn::all().iter().enumerate().map(|(i, column)| {
                let score = row.scores.get(i).copied().flatten()?;
                Some(match column.is_count {
                    // A count, written as a number.
                    true => AxisValue::Whole(score as i64),
                    false => AxisValue::Number(score),
                })
            });
            let cells = std::iter::once(index)
                .chain(settings.iter().map(setting).map(Some))
                .chain([text(&row.estimator)])
                .chain(scores)
                .chain([text(&record.error)]);
            for (column, cell) in self.columns.iter_mut().zip(cells) {
                column.push(cell);
            }
        }
    }

    /// The rows since the last batch.
    ///
    /// # Errors
    /// [`RecordError::Batch`] where columns have different lengths.
    pub fn take(&mut self) -> Result<RecordBatch, RecordError> {
        let fields = self.schema.fields().iter();
        let arrays = fields.zip(&self.columns);
        let arrays = arrays.map(|(field, cells)| array(field.data_type(), cells));
        let batch = RecordBatch::try_new(Arc::clone(&self.schema), arrays.collect());
        self.columns.iter_mut().for_each(Vec::clear);
        Ok(batch?)
    }
}

//! Columns of the dataset: index, varied keys, estimator, scores, error.

use crate::journal::RunRecord;
use crate::plan::Plan;
use crate::scores::ScoreColumn;
use arrow_array::builder::{
    BooleanBuilder, Float64Builder, Int64Builder, StringBuilder, UInt64Builder,
};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use robhaz_scene::{Axis, AxisItem, AxisValue, AxisValues, Distribution, Setting};
use std::collections::HashMap;
use std::sync::Arc;

/// Values of a varied key that wait for their batch.
enum Varied {
    Whole(Int64Builder),
    Number(Float64Builder),
    Boolean(BooleanBuilder),
    Text(StringBuilder),
}

impl Varied {
    /// The narrowest type that takes all values of the `i`-th key of an axis, or their names.
    fn of(axis: &Axis, i: usize) -> Self {
        let named = |items: &[AxisItem]| items.iter().any(|item| item.name.is_some());
        if matches!(&axis.values, AxisValues::List(items) if i == 0 && named(items)) {
            return Self::Text(StringBuilder::new());
        }
        let all = |is_it: fn(&AxisValue) -> bool| match &axis.values {
            AxisValues::List(items) => items.iter().filter_map(|v| v.values.get(i)).all(is_it),
            AxisValues::Whole { .. } | AxisValues::Drawn(Distribution::Whole(..)) => {
                is_it(&AxisValue::Whole(0))
            }
            AxisValues::Drawn(_) => is_it(&AxisValue::Number(0.0)),
        };
        if all(|v| matches!(v, AxisValue::Whole(_))) {
            Self::Whole(Int64Builder::new())
        } else if all(|v| matches!(v, AxisValue::Whole(_) | AxisValue::Number(_))) {
            Self::Number(Float64Builder::new())
        } else if all(|v| matches!(v, AxisValue::Boolean(_))) {
            Self::Boolean(BooleanBuilder::new())
        } else {
            Self::Text(StringBuilder::new())
        }
    }

    fn data_type(&self) -> DataType {
        match self {
            Self::Whole(_) => DataType::Int64,
            Self::Number(_) => DataType::Float64,
            Self::Boolean(_) => DataType::Boolean,
            Self::Text(_) => DataType::Utf8,
        }
    }

    fn push(&mut self, value: &AxisValue) {
        match (self, value) {
            (Self::Whole(builder), AxisValue::Whole(whole)) => builder.append_value(*whole),
            (Self::Number(builder), AxisValue::Number(number)) => builder.append_value(*number),
            #[expect(clippy::cast_precision_loss, reason = "a whole number among others")]
            (Self::Number(builder), AxisValue::Whole(whole)) => builder.append_value(*whole as f64),
            (Self::Boolean(builder), AxisValue::Boolean(value)) => builder.append_value(*value),
            (Self::Text(builder), AxisValue::Text(text)) => builder.append_value(text),
            (Self::Text(builder), value) => builder.append_value(value.to_string()),
            // The type was chosen to take all values. Otherwise lengths differ, and the batch is an error.
            _ => {}
        }
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Self::Whole(builder) => Arc::new(builder.finish()),
            Self::Number(builder) => Arc::new(builder.finish()),
            Self::Boolean(builder) => Arc::new(builder.finish()),
            Self::Text(builder) => Arc::new(builder.finish()),
        }
    }
}

/// Scores of one column that wait for their batch.
enum Scores {
    Count(UInt64Builder),
    Number(Float64Builder),
}

impl Scores {
    fn push(&mut self, value: Option<f64>) {
        match self {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "counts, written as numbers"
            )]
            Self::Count(builder) => builder.append_option(value.map(|v| v as u64)),
            Self::Number(builder) => builder.append_option(value),
        }
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Self::Count(builder) => Arc::new(builder.finish()),
            Self::Number(builder) => Arc::new(builder.finish()),
        }
    }
}

/// Collects rows of the dataset and makes Arrow batches of them.
pub struct RowBuilder {
    schema: SchemaRef,
    index: UInt64Builder,
    varied: Vec<Varied>,
    estimator: StringBuilder,
    scores: Vec<Scores>,
    error: StringBuilder,
    rows: usize,
}

impl RowBuilder {
    /// The rows of a study.
    pub fn new(plan: &Plan) -> Self {
        let keys = plan.axes().iter().flat_map(|axis| {
            let keys = axis.keys.iter().enumerate();
            keys.map(move |(i, key)| (key, Varied::of(axis, i)))
        });
        let (names, varied): (Vec<&String>, Vec<Varied>) = keys.unzip();
        let mut fields = vec![field(
            "index",
            DataType::UInt64,
            false,
            "",
            "index of the run",
        )];
        fields.extend(names.iter().zip(&varied).map(|(key, column)| {
            let unit = match column {
                Varied::Whole(_) | Varied::Number(_) => Axis::unit(key),
                _ => "",
            };
            field(
                key,
                column.data_type(),
                false,
                unit,
                "key of the scene, varied",
            )
        }));
        let text = "label of the estimator; null for a run that failed";
        fields.push(field("estimator", DataType::Utf8, true, "", text));
        fields.extend(ScoreColumn::all().iter().map(|c| {
            let kind = match c.is_count {
                true => DataType::UInt64,
                false => DataType::Float64,
            };
            field(c.name, kind, true, c.unit, c.description)
        }));
        let text = "why the run failed; null for a complete run";
        fields.push(field("error", DataType::Utf8, true, "", text));
        let scores = ScoreColumn::all().iter().map(|c| match c.is_count {
            true => Scores::Count(UInt64Builder::new()),
            false => Scores::Number(Float64Builder::new()),
        });
        Self {
            schema: Arc::new(Schema::new(fields)),
            index: UInt64Builder::new(),
            varied,
            estimator: StringBuilder::new(),
            scores: scores.collect(),
            error: StringBuilder::new(),
            rows: 0,
        }
    }

    /// Names, types and metadata of the columns.
    pub fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// Number of rows since the last batch.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds the rows of a run with its settings.
    pub fn push(&mut self, record: &RunRecord, settings: &[Setting]) {
        for row in &record.rows {
            self.index.append_value(record.run);
            for (column, setting) in self.varied.iter_mut().zip(settings) {
                match (column, &setting.name) {
                    (Varied::Text(builder), Some(name)) => builder.append_value(name),
                    (column, _) => column.push(&setting.value),
                }
            }
            self.estimator.append_option(row.estimator.as_ref());
            for (i, column) in self.scores.iter_mut().enumerate() {
                column.push(row.scores.get(i).copied().flatten());
            }
            self.error.append_option(record.error.as_ref());
            self.rows += 1;
        }
    }

    /// The rows since the last batch.
    ///
    /// # Errors
    /// [`ArrowError`] where columns have different lengths.
    pub fn take(&mut self) -> Result<RecordBatch, ArrowError> {
        self.rows = 0;
        let mut arrays: Vec<ArrayRef> = vec![Arc::new(self.index.finish())];
        arrays.extend(self.varied.iter_mut().map(Varied::take));
        arrays.push(Arc::new(self.estimator.finish()));
        arrays.extend(self.scores.iter_mut().map(Scores::take));
        arrays.push(Arc::new(self.error.finish()));
        RecordBatch::try_new(Arc::clone(&self.schema), arrays)
    }
}

fn field(name: &str, kind: DataType, nullable: bool, unit: &str, description: &str) -> Field {
    Field::new(name, kind, nullable).with_metadata(HashMap::from([
        ("unit".to_owned(), unit.to_owned()),
        ("description".to_owned(), description.to_owned()),
    ]))
}

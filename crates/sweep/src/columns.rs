//! Columns of the dataset: index, varied keys, estimator, scores, error.

use crate::journal::RunRecord;
use crate::plan::Plan;
use arrow_array::builder::{
    BooleanBuilder, Float64Builder, Int64Builder, StringBuilder, UInt64Builder,
};
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use robhaz_record::{EstimatorSummary, Summary};
use robhaz_scene::{Axis, AxisValue, AxisValues, Distribution, Setting};
use std::collections::HashMap;
use std::sync::Arc;

/// A column of scores or events.
#[derive(Clone, Copy, Debug)]
pub struct ScoreColumn {
    /// Its name.
    pub name: &'static str,
    /// SI unit; empty for counts and shares.
    pub unit: &'static str,
    /// Its meaning.
    pub description: &'static str,
    /// Whether it holds counts.
    is_count: bool,
    of: fn(&Summary, Option<&EstimatorSummary>) -> Option<f64>,
}

/// A score of the estimator.
macro_rules! score {
    ($name:literal, $unit:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: $unit,
            description: $description,
            is_count: false,
            of: |_, estimator| {
                let of: fn(&EstimatorSummary) -> Option<f64> = $of;
                of(estimator?)
            },
        }
    };
}

/// A count of samples of the estimator.
macro_rules! count {
    ($name:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: "",
            description: $description,
            is_count: true,
            of: |_, estimator| {
                let of: fn(&EstimatorSummary) -> u64 = $of;
                Some(number(of(estimator?)))
            },
        }
    };
}

/// A value of the run, the same for all its estimators.
macro_rules! of_run {
    ($name:literal, $unit:literal, $count:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: $unit,
            description: $description,
            is_count: $count,
            of: |summary, _| {
                let of: fn(&Summary) -> Option<f64> = $of;
                of(summary)
            },
        }
    };
}

static COLUMNS: [ScoreColumn; 40] = [
    score!(
        "nrmse",
        "",
        "RMS error of N over wheels and samples, over the mean of N",
        |e| e.normal_force?.nrmse
    ),
    score!(
        "nrmse_at_one_contact",
        "",
        "the same over the samples at which no wheel has two contacts",
        |e| e.normal_force_at_one_contact?.nrmse
    ),
    score!("rmse", "N", "RMS error of N over wheels and samples", |e| {
        Some(e.normal_force?.rmse_all)
    }),
    score!(
        "rmse_front",
        "N",
        "RMS error of N of the front wheel",
        |e| Some(e.normal_force?.rmse[0])
    ),
    score!(
        "rmse_middle",
        "N",
        "RMS error of N of the middle wheel",
        |e| Some(e.normal_force?.rmse[1])
    ),
    score!("rmse_rear", "N", "RMS error of N of the rear wheel", |e| {
        Some(e.normal_force?.rmse[2])
    }),
    score!(
        "max_error",
        "N",
        "largest absolute error of N of any wheel",
        |e| Some(e.normal_force?.max_abs)
    ),
    score!(
        "max_error_time",
        "s",
        "time of the largest error of N",
        |e| e.normal_force?.max_abs_time_s
    ),
    score!(
        "bias_front",
        "N",
        "mean error of N of the front wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[0])
    ),
    score!(
        "bias_middle",
        "N",
        "mean error of N of the middle wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[1])
    ),
    score!(
        "bias_rear",
        "N",
        "mean error of N of the rear wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[2])
    ),
    score!(
        "traction_rmse",
        "N",
        "RMS error of T over wheels and samples",
        |e| Some(e.traction?.rmse_all)
    ),
    score!(
        "traction_max_error",
        "N",
        "largest absolute error of T of any wheel",
        |e| Some(e.traction?.max_abs)
    ),
    score!(
        "mean_normal_force",
        "N",
        "mean of the true N over wheels and samples",
        |e| Some(e.mean_normal_force?.iter().sum::<f64>() / 3.0)
    ),
    score!(
        "stated",
        "",
        "geometric mean of the stated standard deviations of N, over the mean of N",
        |e| e.stated
    ),
    score!(
        "coverage",
        "",
        "share of errors of N within two stated standard deviations",
        |e| e.coverage
    ),
    score!(
        "nees",
        "",
        "mean NEES of the three N: 3 if the stated covariance is right",
        |e| e.nees
    ),
    score!(
        "lag",
        "s",
        "time by which the estimated N follow the true ones; null where the truth hardly changes",
        |e| e.lag_s
    ),
    score!(
        "ground_height_rmse",
        "m",
        "RMS error of the height of the ground that was found",
        |e| Some(e.ground?.height_rmse_m)
    ),
    score!(
        "ground_slope_rmse",
        "rad",
        "RMS error of the slope of the ground that was found",
        |e| e.ground?.slope_rmse_rad
    ),
    count!("samples", "records compared", |e| e.samples),
    count!("missing", "records that count but have no estimate", |e| e
        .missing),
    count!(
        "two_contacts",
        "records compared at which a wheel has two contacts",
        |e| e.two_contacts
    ),
    count!(
        "no_equivalent",
        "records left out: no single contact is equivalent to those of a wheel",
        |e| e.no_equivalent
    ),
    of_run!("duration", "s", false, "simulated time", |s| Some(
        s.duration_s
    )),
    of_run!(
        "distance",
        "m",
        false,
        "travel of the body along x, positive in the direction of drive.speed",
        |s| Some(s.progress?.distance_m)
    ),
    of_run!(
        "asked_distance",
        "m",
        false,
        "integral of the set speed of travel",
        |s| Some(s.progress?.asked_m)
    ),
    of_run!(
        "stuck_since",
        "s",
        false,
        "time since which the robot has not advanced; null where it advanced to the end",
        |s| s.progress?.stuck_since_s
    ),
    of_run!(
        "spinning_front",
        "s",
        false,
        "time for which the front wheel spun",
        |s| Some(s.progress?.spinning_s[0])
    ),
    of_run!(
        "spinning_middle",
        "s",
        false,
        "time for which the middle wheel spun",
        |s| Some(s.progress?.spinning_s[1])
    ),
    of_run!(
        "spinning_rear",
        "s",
        false,
        "time for which the rear wheel spun",
        |s| Some(s.progress?.spinning_s[2])
    ),
    of_run!(
        "contact_lost_events",
        "",
        true,
        "how often a wheel lost its contact",
        |s| Some(number(s.events?.contact_lost))
    ),
    of_run!(
        "two_contact_events",
        "",
        true,
        "how often a wheel with one contact got a second one",
        |s| Some(number(s.events?.two_contacts))
    ),
    of_run!(
        "slip_events",
        "",
        true,
        "how often a wheel began to slip",
        |s| Some(number(s.events?.slips))
    ),
    of_run!(
        "end_stop_events",
        "",
        true,
        "how often pin Q reached an end stop",
        |s| Some(number(s.events?.end_stops))
    ),
    of_run!(
        "least_clearance",
        "m",
        false,
        "least distance of body and links to the ground",
        |s| Some(s.clearance.as_ref()?.least_m)
    ),
    of_run!(
        "touch_events",
        "",
        true,
        "how often body or links began to touch the ground, whose force is not modelled",
        |s| Some(number(s.clearance.as_ref()?.touches))
    ),
    of_run!(
        "friction_tests",
        "",
        true,
        "friction tests that were made",
        |s| Some(number(s.friction_tests.len() as u64))
    ),
    of_run!(
        "friction_tests_slipped",
        "",
        true,
        "friction tests that ended in slip, so that mu_max was found",
        |s| {
            let slipped = s.friction_tests.iter().filter(|t| t.ramps > 0);
            Some(number(slipped.count() as u64))
        }
    ),
    of_run!(
        "friction_test_mu_max",
        "",
        false,
        "mean of mu_max over the friction tests that ended in slip; null without one",
        |s| {
            let found = s.friction_tests.iter().filter(|t| t.ramps > 0);
            let found: Vec<f64> = found.map(|t| t.mu_max).collect();
            (!found.is_empty()).then(|| found.iter().sum::<f64>() / number(found.len() as u64))
        }
    ),
];

#[expect(clippy::cast_precision_loss, reason = "counts of samples and events")]
fn number(count: u64) -> f64 {
    count as f64
}

impl ScoreColumn {
    /// All columns of scores and events, in their order.
    pub fn all() -> &'static [Self] {
        &COLUMNS
    }

    /// The value for one estimator of a run; `None` where there is none, or it is not finite.
    pub fn value(&self, summary: &Summary, estimator: Option<&EstimatorSummary>) -> Option<f64> {
        (self.of)(summary, estimator).filter(|value| value.is_finite())
    }
}

/// Values of a varied key that wait for their batch.
enum Varied {
    Whole(Int64Builder),
    Number(Float64Builder),
    Boolean(BooleanBuilder),
    Text(StringBuilder),
}

impl Varied {
    /// The narrowest type that takes all values of the `i`-th key of an axis.
    fn of(axis: &Axis, i: usize) -> Self {
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
                column.push(&setting.value);
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

//! The comparison of runs for other programs and for documents: a row for each run and estimator.

use crate::scores::ScoreColumn;
use crate::summary::{EstimatorSummary, Summary};
use indexmap::IndexMap;
use serde_json::Value;

/// The scores of a row, in the order of the columns: their names here and in the list of scores.
const SCORES: [(&str, &str); 18] = [
    ("rmse_wheel1", "rmse_front"),
    ("rmse_wheel2", "rmse_middle"),
    ("rmse_wheel3", "rmse_rear"),
    ("rmse", "rmse"),
    ("nrmse", "nrmse"),
    ("bias_wheel1", "bias_front"),
    ("bias_wheel2", "bias_middle"),
    ("bias_wheel3", "bias_rear"),
    ("largest_error", "max_error"),
    ("largest_error_time", "max_error_time"),
    ("lag", "lag"),
    ("stated_sigma", "stated"),
    ("coverage", "coverage"),
    ("nees", "nees"),
    ("traction_rmse", "traction_rmse"),
    ("traction_largest_error", "traction_max_error"),
    ("samples", "samples"),
    ("missing", "missing"),
];

/// Columns before the scores.
const NAMES: [&str; 3] = ["run", "scene", "estimator"];

/// The scores with their names here.
fn scores() -> impl Iterator<Item = (&'static str, &'static ScoreColumn)> {
    let score = |(here, name): (&'static str, &str)| {
        let found = ScoreColumn::all().iter().find(|score| score.name == name);
        found.map(|score| (here, score))
    };
    SCORES.into_iter().filter_map(score)
}

/// A score, and whether it is a count.
type Score = (Option<f64>, bool);

/// The runs with their labels as rows: the texts of [`NAMES`], and each score.
fn rows(runs: &[(&str, &Summary)]) -> Vec<([String; 3], Vec<Score>)> {
    let row = |label: &str, run: &Summary, estimator: &EstimatorSummary| {
        let names = [label, &run.scene, &estimator.name].map(str::to_owned);
        let value =
            |(_, s): (&str, &ScoreColumn)| (s.value(run, None, Some(estimator)), s.is_count);
        (names, scores().map(value).collect())
    };
    let of_run = |(label, run): &(&str, &Summary)| {
        let estimators = run.estimators.iter();
        estimators.map(|e| row(label, run, e)).collect::<Vec<_>>()
    };
    runs.iter().flat_map(of_run).collect()
}

/// A JSON array with an object for each run and estimator: `run`, `scene`, `estimator`, and the
/// scores by name, all digits; null where there is none.
///
/// # Errors
/// Those of the writer; in memory there is none to expect.
pub fn comparison_json(runs: &[(&str, &Summary)]) -> Result<String, serde_json::Error> {
    let number = |(value, is_count): Score| match value {
        // A count, kept as a number.
        Some(count) if is_count => Value::from(count as u64),
        value => Value::from(value),
    };
    let object = |(names, scores_of): ([String; 3], Vec<_>)| {
        let names = NAMES.into_iter().zip(names.map(Value::from));
        let values = scores_of.into_iter().map(number);
        let values = scores().map(|(name, _)| name).zip(values);
        names.chain(values).collect::<IndexMap<_, _>>()
    };
    let array: Vec<_> = rows(runs).into_iter().map(object).collect();
    serde_json::to_string_pretty(&array)
}

/// Titles with units, and the cells of each row with four significant digits.
pub(crate) fn comparison_cells(runs: &[(&str, &Summary)]) -> (Vec<String>, Vec<Vec<String>>) {
    let title = |(name, score): (&str, &ScoreColumn)| match score.unit {
        "" => name.to_owned(),
        unit => format!("{name}, {unit}"),
    };
    let titles = NAMES.map(str::to_owned).into_iter();
    let cell = |(value, _): Score| value.map_or_else(String::new, significant);
    let row = |(names, values): ([String; 3], Vec<_>)| {
        let values = values.into_iter().map(cell);
        names.into_iter().chain(values).collect()
    };
    let rows = rows(runs).into_iter().map(row);
    (titles.chain(scores().map(title)).collect(), rows.collect())
}

/// Four significant digits; whole numbers with all of theirs.
fn significant(value: f64) -> String {
    if value.fract().abs() > 0.0 && value.is_finite() {
        let digits = 3 - value.abs().log10().floor() as i32;
        format!("{value:.*}", digits.clamp(0, 12) as usize)
    } else {
        value.to_string()
    }
}

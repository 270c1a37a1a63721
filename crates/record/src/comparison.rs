//! The comparison of runs for other programs and for documents: a row for each run and estimator.

use crate::summary::{EstimatorSummary, Summary};
use indexmap::IndexMap;
use serde_json::Value;

/// A number of a row: its name, its unit, and where it is found.
struct Figure {
    name: &'static str,
    unit: &'static str,
    of: fn(&EstimatorSummary) -> Option<f64>,
}

/// All numbers, in the order of the columns.
const FIGURES: [Figure; 16] = [
    figure("rmse_wheel1", "N", |e| Some(e.normal_force?.rmse[0])),
    figure("rmse_wheel2", "N", |e| Some(e.normal_force?.rmse[1])),
    figure("rmse_wheel3", "N", |e| Some(e.normal_force?.rmse[2])),
    figure("rmse", "N", |e| Some(e.normal_force?.rmse_all)),
    figure("nrmse", "-", |e| e.normal_force?.nrmse),
    figure("bias_wheel1", "N", |e| Some(e.normal_force?.bias?[0])),
    figure("bias_wheel2", "N", |e| Some(e.normal_force?.bias?[1])),
    figure("bias_wheel3", "N", |e| Some(e.normal_force?.bias?[2])),
    figure("largest_error", "N", |e| Some(e.normal_force?.max_abs)),
    figure("largest_error_time", "s", |e| {
        e.normal_force?.max_abs_time_s
    }),
    figure("lag", "s", |e| e.lag_s),
    figure("stated_sigma", "-", |e| e.stated),
    figure("coverage", "-", |e| e.coverage),
    figure("nees", "-", |e| e.nees),
    figure("traction_rmse", "N", |e| Some(e.traction?.rmse_all)),
    figure("traction_largest_error", "N", |e| Some(e.traction?.max_abs)),
];

const fn figure(
    name: &'static str,
    unit: &'static str,
    of: fn(&EstimatorSummary) -> Option<f64>,
) -> Figure {
    Figure { name, unit, of }
}

/// Where a count is found.
type CountOf = fn(&EstimatorSummary) -> u64;

/// Counts of records after the numbers.
const COUNTS: [(&str, CountOf); 2] = [("samples", |e| e.samples), ("missing", |e| e.missing)];

/// Columns before the numbers.
const NAMES: [&str; 3] = ["run", "scene", "estimator"];

/// The runs with their labels as rows: the texts of [`NAMES`], and the estimator.
fn rows<'a>(
    runs: &'a [(&str, &Summary)],
) -> impl Iterator<Item = ([&'a str; 3], &'a EstimatorSummary)> {
    runs.iter().flat_map(|(label, summary)| {
        let names = move |e: &'a EstimatorSummary| [*label, &summary.scene, &e.name];
        summary.estimators.iter().map(move |e| (names(e), e))
    })
}

/// A JSON array with an object for each run and estimator: `run`, `scene`, `estimator`, and the numbers by name, all digits;
/// null where there is none.
///
/// # Errors
/// Those of the writer; in memory there is none to expect.
pub fn comparison_json(runs: &[(&str, &Summary)]) -> Result<String, serde_json::Error> {
    let object = |(names, estimator): ([&str; 3], &EstimatorSummary)| {
        let names = NAMES.into_iter().zip(names.map(Value::from));
        let numbers = FIGURES
            .iter()
            .map(|f| (f.name, (f.of)(estimator).map_or(Value::Null, Value::from)));
        let counts = COUNTS.map(|(name, of)| (name, Value::from(of(estimator))));
        names
            .chain(numbers)
            .chain(counts)
            .collect::<IndexMap<_, _>>()
    };
    let array: Vec<_> = rows(runs).map(object).collect();
    serde_json::to_string_pretty(&array)
}

/// Comma-separated text, a line for each run and estimator after the header, all digits; empty where there is no number.
///
/// # Errors
/// Those of the writer; in memory there is none to expect.
pub fn comparison_csv(runs: &[(&str, &Summary)]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let figures = FIGURES.iter().map(|f| f.name);
    let counts = COUNTS.iter().map(|(name, _)| *name);
    writer.write_record(NAMES.into_iter().chain(figures).chain(counts))?;
    for (names, estimator) in rows(runs) {
        let numbers = FIGURES.iter().map(|figure| {
            let value = (figure.of)(estimator);
            value.map_or_else(String::new, |v| v.to_string())
        });
        let counts = COUNTS.iter().map(|(_, of)| of(estimator).to_string());
        let names = names.map(str::to_owned);
        writer.write_record(names.into_iter().chain(numbers).chain(counts))?;
    }
    let bytes = writer
        .into_inner()
        .map_err(csv::IntoInnerError::into_error)?;
    Ok(String::from_utf8_lossy(&bytes).trim_end().to_owned())
}

/// Titles with units, and the cells of each row with four significant digits.
pub(crate) fn comparison_cells(runs: &[(&str, &Summary)]) -> (Vec<String>, Vec<Vec<String>>) {
    let title = |figure: &Figure| match figure.unit {
        "-" => figure.name.to_owned(),
        unit => format!("{}, {unit}", figure.name),
    };
    let names = NAMES.map(str::to_owned).into_iter();
    let counts = COUNTS.map(|(name, _)| name.to_owned());
    let titles = names.chain(FIGURES.iter().map(title)).chain(counts);
    let row = |(names, estimator): ([&str; 3], &EstimatorSummary)| {
        let number = |f: &Figure| (f.of)(estimator).map_or_else(String::new, significant);
        let counts = COUNTS.map(|(_, of)| of(estimator).to_string());
        let names = names.map(str::to_owned).into_iter();
        names
            .chain(FIGURES.iter().map(number))
            .chain(counts)
            .collect()
    };
    (titles.collect(), rows(runs).map(row).collect())
}

/// A table in Markdown, four significant digits, with units in its header.
pub fn comparison_markdown(runs: &[(&str, &Summary)]) -> String {
    let (titles, rows) = comparison_cells(runs);
    let rule = |k: usize| if k < NAMES.len() { "---" } else { "---:" };
    let rules = (0..titles.len()).map(|k| rule(k).to_owned()).collect();
    let line = |cells: Vec<String>| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |", cells.join(" | "))
    };
    let lines: Vec<String> = [titles, rules].into_iter().chain(rows).map(line).collect();
    lines.join("\n")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0123456, "0.01235"),
            (-1.23456, "-1.235"),
            (98.765432, "98.77"),
            (12345.6, "12346"),
            (18001.0, "18001"),
            (0.0, "0"),
        ];
        for (value, expected) in cases {
            assert_eq!(significant(value), expected);
        }
    }
}

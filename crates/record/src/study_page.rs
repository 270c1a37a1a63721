//! The results of a study as one page of HTML that needs no other file.

use crate::dataset::Dataset;
use crate::grid::wide;
use crate::page::document;
use arrow_schema::Field;
use maud::{Markup, html};

/// The page of a study: scores of each estimator, failures with their reasons, study file and base
/// scene.
pub fn study_page(dataset: &Dataset) -> String {
    let study = &dataset.study;
    let body = html! {
        h1 { (study.name) }
        p class="by" { (runs_in_words(dataset)) }
        h2 { "Scores of the estimators" }
        p { "Median of the runs, and their 5 and 95 % quantiles. Scores of the run, such as distances and events, are the same for all \
             its estimators." }
        (scores(dataset))
        h2 { "Failed runs" }
        (failures(dataset))
        h2 { "How it was made" }
        p { "By " (dataset.version) ", " code { "robhaz study" } ", from this study file and base scene." }
        pre { (study.text) }
        pre { (dataset.scene) }
    };
    document(&study.name, &body)
}

/// Study, scene, numbers of runs and failures, and version.
fn runs_in_words(dataset: &Dataset) -> String {
    let failures = match dataset.failures().iter().map(|f| f.1).sum::<u64>() {
        0 => "none failed".to_owned(),
        failed => format!("{failed} of them failed"),
    };
    let (study, runs, version) = (&dataset.study, dataset.runs, &dataset.version);
    let (name, scene) = (&study.name, study.scene().display());
    format!("Study {name}, scene {scene}: {runs} runs; {failures}. Made by {version}.")
}

/// A number with four digits.
fn number(value: f64) -> String {
    if !(1e-4..1e6).contains(&value.abs()) {
        return if value.abs() < f64::MIN_POSITIVE {
            "0".to_owned()
        } else {
            format!("{value:.3e}")
        };
    }
    let decimals = (3.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// A row for each score with a value, a column for each estimator.
fn scores(dataset: &Dataset) -> Markup {
    let fields = dataset.rows.first().map(|rows| rows.schema_ref().fields());
    let scores = fields.into_iter().flatten();
    let scores = scores.skip_while(|field| field.name() != "estimator");
    let scores: Vec<_> = scores
        .filter_map(|field| Some((field, of_estimators(dataset, field.name())?)))
        .collect();
    let note = |field: &Field, key: &str| field.metadata().get(key).cloned().unwrap_or_default();
    html! {
        @if scores.is_empty() { p { "No run has scores." } }
        @else {
            (wide(&html! {
                tr { th { "score" } @for label in dataset.estimators() { th { (label) } } th { "meaning" } }
                @for (field, cells) in &scores {
                    @let unit = note(field, "unit");
                    tr {
                        td { code { (field.name()) } @if !unit.is_empty() { ", " (unit) } }
                        @for cell in cells {
                            td { @if let Some([low, median, high]) = cell { (number(*median)) " (" (number(*low)) " to " (number(*high)) ")" } }
                        }
                        td style="text-align: left; white-space: normal; min-width: 16rem" { (note(field, "description")) }
                    }
                }
            }))
        }
    }
}

/// 5 %, median and 95 % of values in any order, linear between neighbours: type 7 of Hyndman and
/// Fan (1996), as R and NumPy have it by default. `None` of no values.
fn quantiles(mut values: Vec<f64>) -> Option<[f64; 3]> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some([0.05, 0.5, 0.95].map(|share| {
        let place = share * last as f64;
        let below = place.floor() as usize;
        let (low, high) = (values[below], values[(below + 1).min(last)]);
        low + (place - place.floor()) * (high - low)
    }))
}

/// [`quantiles`] of a column for each estimator; `None` of words, or where none has a value.
fn of_estimators(dataset: &Dataset, column: &str) -> Option<Vec<Option<[f64; 3]>>> {
    let of = |label| quantiles(dataset.of_estimator(label, column));
    let cells: Vec<_> = dataset.estimators().into_iter().map(of).collect();
    cells.iter().any(Option::is_some).then_some(cells)
}

fn failures(dataset: &Dataset) -> Markup {
    let failures = dataset.failures();
    html! {
        @if failures.is_empty() { p { "No run failed." } }
        @else {
            (wide(&html! {
                tr { th { "reason" } th { "runs" } th { "first run" } }
                @for (reason, count, first) in &failures {
                    tr { td style="white-space: normal" { (reason) } td { (count) } td { (first) } }
                }
            }))
        }
    }
}

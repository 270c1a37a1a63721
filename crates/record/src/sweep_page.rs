//! The results of a sweep as one page of HTML that needs no other file.

use crate::dataset::{Dataset, DatasetColumn, DatasetValues};
use crate::figures::{FigureFormat, PlotError, number_label, overview, plot, runs_in_words};
use crate::page::{document, image};
use crate::quantile::quantiles;
use maud::{Markup, html};

/// The page of a sweep: scores of each estimator, failures with their reasons, figures, study file and base scene.
///
/// # Errors
/// [`PlotError`] if a figure cannot be drawn.
pub fn sweep_page(dataset: &Dataset) -> Result<String, PlotError> {
    let mut figures = Vec::new();
    for request in overview(dataset) {
        let svg = plot(dataset, &request, FigureFormat::Svg)?;
        figures.push((request.kind.name(), image(&svg)));
    }
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
        @if !figures.is_empty() {
            h2 { "Figures" }
            @for (name, image) in &figures { figure { img alt=(name) src=(image); } }
        }
        h2 { "How it was made" }
        p { "By " (dataset.version) ", " code { "robhaz sweep" } ", from this study file and base scene." }
        pre { (study.text) }
        pre { (dataset.scene) }
    };
    Ok(document(&study.name, &body))
}

/// A row for each score with a value, a column for each estimator.
fn scores(dataset: &Dataset) -> Markup {
    let columns = dataset.columns.iter();
    let scores = columns.skip_while(|c| c.name != "estimator");
    let scores: Vec<(&DatasetColumn, Vec<Option<[f64; 3]>>)> = scores
        .filter_map(|column| Some((column, of_estimators(dataset, column)?)))
        .collect();
    let number = |v: f64| number_label(v, 0.0);
    html! {
        @if scores.is_empty() { p { "No run has scores." } }
        @else {
            div class="wide" {
                table {
                    tr { th { "score" } @for label in dataset.estimators() { th { (label) } } th { "meaning" } }
                    @for (column, cells) in &scores {
                        tr {
                            td { code { (column.name) } @if !column.unit.is_empty() { ", " (column.unit) } }
                            @for cell in cells {
                                td { @if let Some([low, median, high]) = cell { (number(*median)) " (" (number(*low)) " to " (number(*high)) ")" } }
                            }
                            td style="text-align: left" { (column.description) }
                        }
                    }
                }
            }
        }
    }
}

/// 5 %, median and 95 % of a column for each estimator; `None` of words, or where none has a value.
fn of_estimators(dataset: &Dataset, column: &DatasetColumn) -> Option<Vec<Option<[f64; 3]>>> {
    let DatasetValues::Numbers(values) = &column.values else {
        return None;
    };
    let rows = || dataset.words("estimator").iter().zip(values);
    let of = |label: &str| {
        let own = rows().filter(|(estimator, _)| estimator.as_deref() == Some(label));
        quantiles(own.filter_map(|(_, value)| *value), [0.05, 0.5, 0.95])
    };
    let cells: Vec<_> = dataset.estimators().into_iter().map(of).collect();
    cells.iter().any(Option::is_some).then_some(cells)
}

fn failures(dataset: &Dataset) -> Markup {
    let failures = dataset.failures();
    html! {
        @if failures.is_empty() { p { "No run failed." } }
        @else {
            div class="wide" {
                table {
                    tr { th { "reason" } th { "runs" } th { "first run" } }
                    @for (reason, count, first) in &failures {
                        tr { td style="white-space: normal" { (reason) } td { (count) } td { (first) } }
                    }
                }
            }
        }
    }
}

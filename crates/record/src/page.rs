//! The results of a run as one page of HTML that needs no other file.

use crate::error::{Result, io_error, names_in};
use crate::figures::NAMES;
use crate::grid::Grid;
use crate::log_lines::{MEANS, health, means};
use crate::report::{comparison_cells, remarks};
use crate::summary::{EstimatorSummary, Summary};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use robhaz_score::contact::{FlagScore, FlagScores};
use std::io;
use std::path::Path;

/// Screen and print: system fonts, tables that scroll by themselves, no scripts.
const STYLE: &str = include_str!("page.css");

/// The page of a run, complete or broken off, or of an estimate, from its folder: what happened,
/// errors of the estimators, all figures within the page, and the scene or description from which
/// it was made.
///
/// # Errors
/// [`RecordError`](crate::RecordError) if the summary or a figure cannot be read.
pub fn page(folder: &Path) -> Result<String> {
    let summary = Summary::read(folder)?;
    let figures = figures(&folder.join("figures"))?;
    let [scene, log] = ["scene.toml", "log.toml"].map(|name| text_if_any(&folder.join(name)));
    let (scene, log) = (scene?, log?);
    let title = &summary.scene;
    let runs = [(title.as_str(), &summary)];
    let body = html! {
        h1 { (title) }
        p class="by" { (made_by(&summary)) }
        @for remark in remarks(title, &summary) { p { (remark) } }
        @if summary.estimators.values().any(|e| e.means.is_some()) {
            h2 { "Means of the estimates" }
            p { (MEANS) }
            (means(&runs, false).html())
            h2 { "Needed friction, flags and health" }
            p { "T/N: mean, and largest size. Flags: shares of the records. Contradictions: channels whose readings contradict others, \
                 with the time of the first record." }
            (health(&runs).html())
        }
        @if summary.estimators.values().any(|e| e.normal_force.is_some()) {
            h2 { "Errors of the estimators" }
            p { "Estimate minus truth. " code { "rmse" } ", " code { "bias" } " and " code { "max_error" } " are of the normal force N; "
                code { "nrmse" } " and " code { "stated" } " are relative to the mean N; " code { "lag" } " is the time by which the \
                 estimate follows the truth; " code { "coverage" } " is the share within two stated standard deviations (0.95 is right), "
                code { "nees" } " is 3 for a right covariance." }
            (errors(&runs))
        }
        @if summary.estimators.values().any(|e| e.contacts.is_some()) {
            h2 { "Contact states" }
            p { "Events found within 20 ms, and shares of the samples with a false and with a missed flag." }
            (contacts(&runs))
        }
        @if !summary.friction_tests.is_empty() {
            h2 { "Friction tests" }
            @for test in &summary.friction_tests { p { (test.in_words()) } }
        }
        @if !figures.is_empty() {
            h2 { "Figures" }
            @for (name, image) in &figures {
                figure {
                    img alt=(name) src=(image);
                    figcaption { code { (name) } }
                }
            }
        }
        (how_it_was_made(&summary, scene, log))
    };
    Ok(document(title, &body))
}

/// The scene of a run or the description of a log, if there is one.
fn how_it_was_made(summary: &Summary, scene: Option<String>, log: Option<String>) -> Markup {
    html! {
        @if let Some(scene) = scene {
            h2 { "How it was made" }
            p { "By robhaz " (summary.version) ", from this scene with every choice written out. Saved as " code { "scene.toml" }
                ", " code { "robhaz run scene.toml" } " makes the same run." }
            pre { (scene) }
        }
        @if let Some((log, read)) = log.zip(summary.log.as_ref()) {
            h2 { "How it was made" }
            p { "By robhaz " (summary.version) ", from the log " code { (read.source) } " with this description, every choice \
                 written out. Saved as " code { "log.toml" } " beside the readings, " code { "robhaz estimate" } " of this folder \
                 makes the same estimate. Which column of the log was which reading is not in it: the readings are saved \
                 under their own names." }
            pre { (log) }
        }
    }
}

/// A page of HTML with this body, which is complete in itself.
pub(crate) fn document(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " - robhaz" }
                style { "\n" (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// An SVG as the source of an image within the page.
pub(crate) fn image(svg: &[u8]) -> String {
    format!("data:image/svg+xml;base64,{}", STANDARD.encode(svg))
}

fn made_by(summary: &Summary) -> String {
    let source = match (&summary.engine, summary.seed) {
        (Some(engine), Some(seed)) => format!("simulated by the engine {engine}, seed {seed}"),
        _ => "recorded readings".to_owned(),
    };
    format!(
        "{:.1} s at {} Hz, {source}; robhaz {}",
        summary.duration_s, summary.record_rate_hz, summary.version
    )
}

/// The comparison as a table with a column for each estimator.
fn errors(runs: &[(&str, &Summary)]) -> Markup {
    // Run and scene are the same in all columns.
    const SAME: usize = 2;
    let (titles, rows) = comparison_cells(runs);
    let line = |(k, title): (usize, String)| {
        let cells = rows.iter().filter_map(|row| row.get(k).cloned());
        std::iter::once(title).chain(cells).collect()
    };
    let mut lines = titles.into_iter().enumerate().skip(SAME).map(line);
    let grid = Grid {
        header: lines.next().unwrap_or_default(),
        rows: lines.collect(),
        words: &[],
    };
    grid.html()
}

/// How well contact states were found.
fn contacts(runs: &[(&str, &Summary)]) -> Markup {
    let names = [
        "state",
        "events",
        "found",
        "delay, ms",
        "false, %",
        "missed, %",
    ];
    let number = |value: Option<f64>, factor: f64, digits: usize| {
        value.map_or(String::new(), |v| format!("{:.digits$}", factor * v))
    };
    let row = |state: &str, score: FlagScore| {
        vec![
            state.to_owned(),
            score.events.to_string(),
            score.found.to_string(),
            number(score.delay_s, 1e3, 1),
            number(score.false_share, 100.0, 2),
            number(score.missed_share, 100.0, 2),
        ]
    };
    let rows = |found: FlagScores| {
        let (air, two) = (row("in the air", found.air), found.two_contacts);
        vec![air, row("two contacts", two), row("sliding", found.sliding)]
    };
    let cells = |e: &EstimatorSummary| e.contacts.map_or(Vec::new(), rows);
    Grid::of_estimators(runs, false, &names, cells).html()
}

/// Name and picture of each SVG in a folder, in the order of the page; none where there is no
/// folder.
fn figures(folder: &Path) -> Result<Vec<(String, String)>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let names = names_in(folder)?;
    let mut stems: Vec<&str> = names
        .iter()
        .filter_map(|n| n.strip_suffix(".svg"))
        .collect();
    let place = |stem: &str| NAMES.iter().position(|start| stem.starts_with(start));
    stems.sort_by_key(|stem| (place(stem).unwrap_or(NAMES.len()), *stem));
    let figure = |stem: &str| {
        let path = folder.join(format!("{stem}.svg"));
        let bytes = std::fs::read(&path).map_err(io_error("read", &path))?;
        Ok((stem.to_owned(), image(&bytes)))
    };
    stems.into_iter().map(figure).collect()
}

/// The text of a file, `None` where it does not exist.
fn text_if_any(path: &Path) -> Result<Option<String>> {
    match std::fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        text => text.map(Some).map_err(io_error("read", path)),
    }
}

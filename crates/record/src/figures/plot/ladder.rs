//! Rungs one below the other, estimators or the values of a column: the spread of the score over all runs, and the median at each
//! place of an axis.

use super::bands::SHARES;
use super::caption::caption;
use super::chart::{Chart, Shape, Sheet};
use super::request::{PlotError, PlotRequest};
use super::scale::{Scale, Spacing, label};
use super::selection::{Axis, Row, SEEDS, Selection, varying};
use crate::figures::header::{Entry, Header, Mark};
use crate::figures::style::{estimator as color_of, line, spread_color};
use crate::quantile::quantiles;
use plotters::style::RGBColor;

/// Height of a rung, px.
const RUNG: f64 = 30.0;
/// Half of the thickness of a box, as a share of a rung.
const HALF: f64 = 0.3;
/// Most places of an axis whose medians are dots.
const MOST_DOTS: usize = 40;
/// The rungs if no others are asked for.
const ESTIMATOR: &str = "estimator";
/// The colour of all rungs: the place tells them apart.
const NUMBER: usize = 0;

/// The scores of a rung.
struct Rung {
    label: String,
    quantiles: [f64; 5],
    /// Median at each place of the axis.
    medians: Vec<f64>,
}

/// The figure: a chart whose rungs are the estimators, or with other rungs a chart for each estimator.
///
/// # Errors
/// [`PlotError`]
pub fn ladder(selection: &Selection<'_>, request: &PlotRequest) -> Result<Sheet, PlotError> {
    let name = request.x2.as_deref().unwrap_or(ESTIMATOR);
    let rows = Axis::new(selection, name, None)?;
    let dots = dots(selection, request, name)?;
    let estimators: Vec<Option<usize>> = match name {
        ESTIMATOR => vec![None],
        _ => (0..selection.estimators.len()).map(Some).collect(),
    };
    let charts = estimators.into_iter();
    let charts: Vec<(Option<usize>, Vec<Rung>)> = charts
        .map(|estimator| (estimator, rungs(selection, &rows, estimator, dots.as_ref())))
        .collect();
    let all = charts.iter().flat_map(|(_, rungs)| rungs);
    let values = all.flat_map(|r| r.quantiles.iter().chain(&r.medians).copied());
    let values: Vec<f64> = values.collect();
    let wish = request.y_spacing;
    let wish = wish.unwrap_or_else(|| Spacing::of(values.iter().copied()));
    let spacing = selection.score_spacing(Some(wish))?;
    let score = Scale::around_errors(values, spacing);
    let sheet_row = charts
        .iter()
        .map(|(estimator, rungs)| chart(selection, *estimator, rungs, &score));
    let in_all = selection.rows.len() / rows.places().len().max(1) / charts.len().max(1);
    let points = dots.as_ref();
    let points = points.map(|axis| format!("; points: its median at each value of {}", axis.name));
    let drawn = format!(
        "Beside each name its median. Bar: median; box: 25 to 75 %; line: 5 to 95 % of {in_all} runs{}.",
        points.unwrap_or_default()
    );
    Ok(Sheet {
        header: Header {
            title: format!("{} by {name}", selection.score.name),
            subtitle: String::new(),
            key: key(dots.as_ref()),
        },
        rows: vec![sheet_row.collect()],
        caption: caption(selection, drawn),
    })
}

fn chart(
    selection: &Selection<'_>,
    estimator: Option<usize>,
    rungs: &[Rung],
    score: &Scale,
) -> Chart {
    let label_of = |r: &Rung| format!("{}  {}", r.label, three_digits(r.quantiles[2]));
    let name = estimator.and_then(|e| selection.estimators.get(e));
    Chart {
        title: name.map_or(String::new(), |(_, name)| (*name).to_owned()),
        x_label: selection.score_label(),
        y_label: String::new(),
        x: score.clone(),
        // The first rung is the top one.
        y: Scale::of_words(rungs.iter().rev().map(label_of).collect()),
        width: 1.0,
        height: RUNG * rungs.len() as f64,
        grid: true,
        shapes: shapes(rungs),
    }
}

/// The axis whose places have medians of their own: the one asked for, else the first key that varies and has few values.
fn dots(
    selection: &Selection<'_>,
    request: &PlotRequest,
    rows: &str,
) -> Result<Option<Axis>, PlotError> {
    if let Some(name) = &request.x {
        return Axis::new(selection, name, request.x_spacing).map(Some);
    }
    let varying = varying(selection);
    let first = varying.first();
    let Some(name) = first.filter(|k| !SEEDS.contains(&k.as_str()) && *k != rows) else {
        return Ok(None);
    };
    let axis = Axis::new(selection, name, request.x_spacing)?;
    Ok((axis.places().len() <= MOST_DOTS).then_some(axis))
}

/// The rungs from the top down, of one estimator or of all rows.
fn rungs(
    selection: &Selection<'_>,
    rows: &Axis,
    estimator: Option<usize>,
    dots: Option<&Axis>,
) -> Vec<Rung> {
    let names: Vec<(f64, String)> = match &rows.words {
        Some(words) => (0..).map(f64::from).zip(words.iter().cloned()).collect(),
        None => rows
            .places()
            .into_iter()
            .map(|v| (v, label(v, 0.0)))
            .collect(),
    };
    let places = dots.map(Axis::places).unwrap_or_default();
    let rung = |(value, label): (f64, String)| {
        let of_rung = |(i, row): (usize, &Row)| {
            let is_it = rows.values.get(i).copied().flatten() == Some(value)
                && estimator.is_none_or(|e| row.estimator == e);
            is_it.then_some((i, row.value))
        };
        let own: Vec<(usize, f64)> = selection
            .rows
            .iter()
            .enumerate()
            .filter_map(of_rung)
            .collect();
        let median_at = |place: &f64| {
            let at = |i: usize| dots.and_then(|axis| axis.values.get(i).copied().flatten());
            let here = own.iter().filter(|(i, _)| at(*i) == Some(*place));
            quantiles(here.map(|(_, value)| *value), [0.5]).map(|[median]| median)
        };
        Some(Rung {
            label,
            quantiles: quantiles(own.iter().map(|(_, value)| *value), SHARES)?,
            medians: places.iter().filter_map(median_at).collect(),
        })
    };
    names.into_iter().filter_map(rung).collect()
}

/// A number in short, with three significant digits.
fn three_digits(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    label(rounded, 0.0)
}

fn colors() -> (RGBColor, RGBColor) {
    let (color, _) = color_of(NUMBER);
    (color, spread_color(color))
}

fn shapes(rungs: &[Rung]) -> Vec<Shape> {
    let (color, pale) = colors();
    let mut shapes = Vec::new();
    for (k, rung) in rungs.iter().rev().enumerate() {
        let y = k as f64;
        let [low, first, median, third, high] = rung.quantiles;
        shapes.push(Shape::Line(vec![(low, y), (high, y)], color, 1.2));
        shapes.push(Shape::Cell([(first, y + HALF), (third, y - HALF)], pale));
        let bar = vec![(median, y - HALF), (median, y + HALF)];
        shapes.push(Shape::Line(bar, color, 2.4));
        let dots = rung.medians.iter();
        shapes.extend(dots.map(|m| Shape::Dot((*m, y), color, 2.4)));
    }
    shapes
}

fn key(axis: Option<&Axis>) -> Vec<Entry> {
    let (color, pale) = colors();
    let entry = |mark, label: &str| Entry::new(mark, label);
    let mut key = vec![
        entry(Mark::Line(line(color, 2.4)), "median"),
        entry(Mark::Area(pale), "25 to 75 %"),
        entry(Mark::Line(line(color, 1.2)), "5 to 95 %"),
    ];
    key.extend(axis.map(|axis| {
        entry(
            Mark::Dot(color),
            &format!("median at each value of {}", axis.name),
        )
    }));
    key
}

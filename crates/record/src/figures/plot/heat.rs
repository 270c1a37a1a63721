//! The median of a score over two axes: a map for each estimator, with one scale of colours.

use super::caption::caption;
use super::chart::{Chart, Shape, Sheet};
use super::request::{PlotError, PlotRequest};
use super::scale::{Scale, Spacing, label};
use super::selection::{Axis, Selection, varying_apart};
use crate::figures::header::Header;
use crate::quantile::quantiles;
use plotters::style::RGBColor;

/// Most values of an axis that are columns of their own.
const MOST_PLACES: usize = 40;
/// Least and largest number of equal intervals of drawn values.
const INTERVALS: (f64, f64) = (3.0, 12.0);
/// Runs in a cell that the number of intervals aims at.
const IN_A_CELL: f64 = 4.0;
/// Colours in the bar.
const SHADES: u32 = 64;
const HEIGHT: f64 = 250.0;

/// An axis in cells.
struct Cells {
    scale: Scale,
    /// Cell of each row of the selection.
    of_rows: Vec<Option<usize>>,
    /// First and last value of each cell on the scale.
    ends: Vec<(f64, f64)>,
}

/// The figure.
///
/// # Errors
/// [`PlotError`]
pub fn heat(selection: &Selection<'_>, request: &PlotRequest) -> Result<Sheet, PlotError> {
    let (x_name, y_name) = axes(selection, request)?;
    let x_axis = Axis::new(selection, &x_name, request.x_spacing)?;
    let y_axis = Axis::new(selection, &y_name, None)?;
    let (x, y) = (cells(&x_axis, selection), cells(&y_axis, selection));
    let maps: Vec<Vec<(usize, usize, f64)>> = (0..selection.estimators.len())
        .map(|estimator| medians(selection, estimator, &x, &y))
        .collect();
    let values = || maps.iter().flatten().map(|cell| cell.2);
    let wish = request.y_spacing.unwrap_or_else(|| Spacing::of(values()));
    let spacing = selection.score_spacing(Some(wish))?;
    let scale = color_scale(values(), spacing);
    let charts = selection
        .estimators
        .iter()
        .zip(&maps)
        .map(|((_, name), map)| Chart {
            title: (*name).to_owned(),
            x_label: x_axis.label.clone(),
            y_label: y_axis.label.clone(),
            x: x.scale.clone(),
            y: y.scale.clone(),
            width: 1.0,
            height: HEIGHT,
            grid: false,
            shapes: map
                .iter()
                .filter_map(|cell| shape(*cell, &x, &y, &scale))
                .collect(),
        });
    let mut charts: Vec<Chart> = charts.collect();
    let mut rows = Vec::new();
    while !charts.is_empty() {
        let rest = charts.split_off(charts.len().min(2));
        let mut row = std::mem::replace(&mut charts, rest);
        row.push(bar(&scale, selection.score_label()));
        rows.push(row);
    }
    let all = maps.len() * x.ends.len() * y.ends.len();
    let empty = all - values().count();
    let drawn = format!(
        "Median of the runs in each cell{}.",
        match empty {
            0 => String::new(),
            n => format!("; white: no run, {n} of {all} cells"),
        }
    );
    Ok(Sheet {
        header: Header {
            title: format!("Median {} over {x_name} and {y_name}", selection.score.name),
            subtitle: String::new(),
            key: Vec::new(),
        },
        rows,
        caption: caption(selection, drawn),
    })
}

/// The two columns: those asked for, else the first keys that vary.
fn axes(selection: &Selection<'_>, request: &PlotRequest) -> Result<(String, String), PlotError> {
    let varying = varying_apart(selection);
    let asked = [&request.x, &request.x2];
    let mut free = varying
        .iter()
        .filter(|key| !asked.contains(&&Some((*key).clone())));
    let mut next = |asked: &Option<String>| asked.clone().or_else(|| free.next().cloned());
    match (next(&request.x), next(&request.x2)) {
        (Some(x), Some(y)) => Ok((x, y)),
        _ => Err(PlotError::Axes { needed: 2, varying }),
    }
}

/// A cell for each value, or equal intervals where there are many values or the study drew them.
fn cells(axis: &Axis, selection: &Selection<'_>) -> Cells {
    let places = axis.places();
    let runs = selection.rows.len() as f64 / selection.estimators.len().max(1) as f64;
    let own = axis.words.is_some() || axis.listed || (places.len() as f64) * IN_A_CELL <= runs;
    if own && (places.len() <= MOST_PLACES || axis.words.is_some()) {
        let words = match &axis.words {
            Some(words) => words.clone(),
            None => places.iter().map(|v| label(*v, 0.0)).collect(),
        };
        let cell = |v: &Option<f64>| v.map(|v| places.partition_point(|place| *place < v));
        let ends = (0..places.len()).map(|i| (i as f64 - 0.5, i as f64 + 0.5));
        return Cells {
            scale: Scale::of_words(words),
            of_rows: axis.values.iter().map(cell).collect(),
            ends: ends.collect(),
        };
    }
    let count = (runs / IN_A_CELL)
        .sqrt()
        .floor()
        .clamp(INTERVALS.0, INTERVALS.1);
    let at = |v: f64| axis.spacing.coordinate(v);
    let low = places.first().map_or(0.0, |v| at(*v));
    let width = (places.last().map_or(1.0, |v| at(*v)) - low) / count;
    let cell = |v: &Option<f64>| {
        v.map(|v| ((at(v) - low) / width).floor().clamp(0.0, count - 1.0) as usize)
    };
    let end = |i: usize| axis.spacing.value(low + i as f64 * width);
    Cells {
        scale: Scale::between(low, low + count * width, axis.spacing),
        of_rows: axis.values.iter().map(cell).collect(),
        ends: (0..count as usize).map(|i| (end(i), end(i + 1))).collect(),
    }
}

/// Column, row and median of each cell with a run.
fn medians(
    selection: &Selection<'_>,
    estimator: usize,
    x: &Cells,
    y: &Cells,
) -> Vec<(usize, usize, f64)> {
    let mut members = vec![Vec::new(); x.ends.len() * y.ends.len()];
    let places = x.of_rows.iter().zip(&y.of_rows);
    for (row, (i, j)) in selection.rows.iter().zip(places) {
        if let (Some(i), Some(j), true) = (i, j, row.estimator == estimator)
            && let Some(cell) = members.get_mut(j * x.ends.len() + i)
        {
            cell.push(row.value);
        }
    }
    let medians = members.into_iter().enumerate().filter_map(|(k, values)| {
        let [median] = quantiles(values, [0.5])?;
        Some((k % x.ends.len(), k / x.ends.len(), median))
    });
    medians.collect()
}

fn shape(
    (i, j, median): (usize, usize, f64),
    x: &Cells,
    y: &Cells,
    scale: &Scale,
) -> Option<Shape> {
    let ((left, right), (bottom, top)) = (*x.ends.get(i)?, *y.ends.get(j)?);
    Some(Shape::Cell(
        [(left, top), (right, bottom)],
        color(scale.share(median)),
    ))
}

/// Colours from the least to the largest value.
fn color_scale(values: impl Iterator<Item = f64>, spacing: Spacing) -> Scale {
    match super::scale::extremes(values.map(|v| spacing.coordinate(v))) {
        Some((low, high)) if high > low => Scale::between(low, high, spacing),
        Some((low, _)) => Scale::around([spacing.value(low)], spacing),
        None => Scale::between(0.0, 1.0, spacing),
    }
}

/// Viridis (Smith and van der Walt, 2015) at nine evenly spaced places: its lightness grows evenly, so that it is read in
/// grey and by the colour-blind.
const VIRIDIS: [RGBColor; 9] = [
    RGBColor(0x44, 0x01, 0x54),
    RGBColor(0x47, 0x2D, 0x7B),
    RGBColor(0x3B, 0x52, 0x8B),
    RGBColor(0x2C, 0x72, 0x8E),
    RGBColor(0x21, 0x90, 0x8C),
    RGBColor(0x27, 0xAD, 0x81),
    RGBColor(0x5D, 0xC8, 0x63),
    RGBColor(0xAA, 0xDC, 0x32),
    RGBColor(0xFD, 0xE7, 0x25),
];

/// The colour at a share of the scale, linear between the places of [`VIRIDIS`].
fn color(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (place.floor() as usize).min(VIRIDIS.len() - 2);
    let part = place - below as f64;
    let (RGBColor(r, g, b), RGBColor(s, h, c)) = (VIRIDIS[below], VIRIDIS[below + 1]);
    let mixed = |low: u8, high: u8| {
        let value = f64::from(low) + part * (f64::from(high) - f64::from(low));
        value.round() as u8
    };
    RGBColor(mixed(r, s), mixed(g, h), mixed(b, c))
}

/// The scale of colours.
fn bar(scale: &Scale, name: String) -> Chart {
    let (low, high) = scale.ends();
    let spacing = scale.spacing();
    let (low, high) = (spacing.coordinate(low), spacing.coordinate(high));
    let at = |k: u32| spacing.value(low + (high - low) * f64::from(k) / f64::from(SHADES));
    let shades = (0..SHADES).map(|k| {
        let middle = (f64::from(k) + 0.5) / f64::from(SHADES);
        Shape::Cell([(-0.5, at(k + 1)), (0.5, at(k))], color(middle))
    });
    Chart {
        title: String::new(),
        x_label: String::new(),
        y_label: name,
        x: Scale::of_words(vec![String::new()]),
        y: scale.clone(),
        width: 0.28,
        height: HEIGHT,
        grid: false,
        shapes: shades.collect(),
    }
}

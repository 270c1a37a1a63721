//! A score against an axis: median and quantile bands of each estimator.

use super::caption::caption;
use super::chart::{Chart, Point, Shape, Sheet};
use super::request::{PlotError, PlotRequest};
use super::scale::{Scale, Spacing};
use super::selection::{Axis, SEEDS, Selection, varying};
use crate::figures::header::{Entry, Header, Mark};
use crate::figures::style::{band_color, estimator as color_of, line, spread_color};
use crate::quantile::quantiles;
use plotters::style::RGBColor;

/// Shares of the bands' ends and of the median.
pub const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// Most values of an axis that are places of their own.
const MOST_PLACES: usize = 60;
/// Runs at a place that make it a place of its own though its value was drawn.
const REPEATED: usize = 3;
/// Values in a group, at least, and largest number of groups.
const GROUP: usize = 10;
const MOST_GROUPS: usize = 12;
/// Estimators whose bands can be read in one chart.
const TOGETHER: usize = 3;
const HEIGHT: f64 = 330.0;
const SMALL_HEIGHT: f64 = 190.0;

/// The scores of an estimator at a place of the axis.
struct Place {
    at: f64,
    quantiles: [f64; 5],
    count: usize,
}

/// Places of an estimator.
struct Series<'a> {
    label: &'a str,
    /// Place among all estimators of the dataset.
    number: usize,
    places: Vec<Place>,
    /// All scores over the axis.
    points: Vec<Point>,
}

impl Series<'_> {
    fn color(&self) -> RGBColor {
        color_of(self.number).0
    }
}

/// The figure.
///
/// # Errors
/// [`PlotError`]
pub fn bands(selection: &Selection<'_>, request: &PlotRequest) -> Result<Sheet, PlotError> {
    let name = match &request.x {
        Some(name) => name.clone(),
        None => default_axis(selection)?,
    };
    let axis = Axis::new(selection, &name, request.x_spacing)?;
    let groups = groups(&axis, selection);
    let series = series(selection, &axis, &groups);
    let y = request_scale(selection, request, &series)?;
    let x = match &axis.words {
        Some(words) => Scale::of_words(words.clone()),
        None => Scale::around(axis.places(), axis.spacing),
    };
    let together = axis.words.is_some() || series.len() <= TOGETHER;
    let charts: Vec<Vec<&Series<'_>>> = match together {
        true => vec![series.iter().collect()],
        false => series.iter().map(|s| vec![s]).collect(),
    };
    let charts = charts.iter().map(|shown| Chart {
        title: match together {
            true => String::new(),
            false => shown.iter().map(|s| s.label).collect(),
        },
        x_label: axis.label.clone(),
        y_label: selection.score_label(),
        x: x.clone(),
        y: y.clone(),
        width: 1.0,
        height: if together { HEIGHT } else { SMALL_HEIGHT },
        grid: true,
        shapes: match axis.words {
            Some(_) => boxes(shown, axis.name == "estimator"),
            None => lines(shown, groups.is_some()),
        },
    });
    let mut charts: Vec<Chart> = charts.collect();
    let mut rows = Vec::new();
    while !charts.is_empty() {
        let rest = charts.split_off(charts.len().min(2));
        rows.push(std::mem::replace(&mut charts, rest));
    }
    Ok(Sheet {
        header: Header {
            title: format!("{} against {}", selection.score.name, axis.name),
            subtitle: String::new(),
            key: series.iter().map(|s| entry(s, &axis)).collect(),
        },
        rows,
        caption: caption(selection, drawn(&series, &axis, groups.is_some())),
    })
}

/// The first key that varies; the estimators where only seeds vary.
fn default_axis(selection: &Selection<'_>) -> Result<String, PlotError> {
    let varying = varying(selection);
    let is_seed = |key: &String| SEEDS.contains(&key.as_str());
    match varying.first() {
        Some(key) if !is_seed(key) => Ok(key.clone()),
        _ if selection.estimators.len() > 1 => Ok("estimator".to_owned()),
        Some(key) => Ok(key.clone()),
        None => Err(PlotError::Axes { needed: 1, varying }),
    }
}

/// The values of an axis in groups of neighbours, each by its last value; `None` where each value is a place of its own.
fn groups(axis: &Axis, selection: &Selection<'_>) -> Option<Vec<f64>> {
    let places = axis.places();
    let estimators = selection.estimators.len().max(1);
    let repeated = selection.rows.len() >= REPEATED * estimators * places.len();
    let own = places.len() <= MOST_PLACES && (axis.listed || repeated || places.len() < GROUP);
    if axis.words.is_some() || own {
        return None;
    }
    let count = (places.len() / GROUP).clamp(1, MOST_GROUPS);
    let last = |group: usize| places.get((group + 1) * places.len() / count - 1).copied();
    Some((0..count).filter_map(last).collect())
}

fn series<'a>(
    selection: &Selection<'a>,
    axis: &Axis,
    groups: &Option<Vec<f64>>,
) -> Vec<Series<'a>> {
    let ends = groups.clone().unwrap_or_else(|| axis.places());
    let mut series: Vec<Series<'a>> = Vec::new();
    let mut members: Vec<Vec<Vec<Point>>> = Vec::new();
    for (number, label) in &selection.estimators {
        let (places, points) = (Vec::new(), Vec::new());
        series.push(Series {
            label,
            number: *number,
            places,
            points,
        });
        members.push(vec![Vec::new(); ends.len()]);
    }
    for (row, at) in selection.rows.iter().zip(&axis.values) {
        let Some(at) = *at else { continue };
        let group = ends.partition_point(|end| *end < at);
        let places = members.get_mut(row.estimator);
        if let Some(place) = places.and_then(|places| places.get_mut(group)) {
            place.push((at, row.value));
        }
    }
    for (series, places) in series.iter_mut().zip(members) {
        for points in places {
            let middle = quantiles(points.iter().map(|p| p.0), [0.5]);
            let scores = quantiles(points.iter().map(|p| p.1), SHARES);
            if let (Some([at]), Some(quantiles)) = (middle, scores) {
                let count = points.len();
                series.places.push(Place {
                    at,
                    quantiles,
                    count,
                });
            }
            series.points.extend(points);
        }
    }
    series
}

/// The vertical axis: it holds all bands.
fn request_scale(
    selection: &Selection<'_>,
    request: &PlotRequest,
    series: &[Series<'_>],
) -> Result<Scale, PlotError> {
    let bands = series.iter().flat_map(|s| &s.places);
    let values: Vec<f64> = bands.flat_map(|place| place.quantiles).collect();
    // A single outlier does not make the axis logarithmic: its bands do.
    let wish = request
        .y_spacing
        .unwrap_or_else(|| Spacing::of(values.iter().copied()));
    let spacing = selection.score_spacing(Some(wish))?;
    Ok(Scale::around_errors(values, spacing))
}

/// Bands below, then medians; of grouped values also each run as a point.
fn lines(series: &[&Series<'_>], grouped: bool) -> Vec<Shape> {
    let band = |s: &Series<'_>, low: usize, high: usize| -> Vec<Point> {
        let edge = |k: usize| {
            let at = move |p: &Place| Some((p.at, *p.quantiles.get(k)?));
            s.places.iter().filter_map(at)
        };
        edge(low).chain(edge(high).rev()).collect()
    };
    let mut shapes = Vec::new();
    for s in series.iter().filter(|s| s.places.len() > 1) {
        shapes.push(Shape::Area(band(s, 0, 4), band_color(s.color())));
    }
    for s in series.iter().filter(|s| s.places.len() > 1) {
        shapes.push(Shape::Area(band(s, 1, 3), spread_color(s.color())));
    }
    for s in series {
        // Where bands of several estimators overlap, their outlines tell them apart.
        let mut outline = band(s, 0, 4);
        outline.extend(outline.first().copied());
        shapes.push(Shape::Line(outline, spread_color(s.color()), 0.7));
        if grouped {
            let points = s.points.iter();
            shapes.extend(points.map(|p| Shape::Dot(*p, s.color(), 1.0)));
        }
    }
    for s in series {
        let medians: Vec<Point> = s.places.iter().map(|p| (p.at, p.quantiles[2])).collect();
        shapes.push(match color_of(s.number).1 {
            true => Shape::Dashed(medians.clone(), s.color(), 1.8),
            false => Shape::Line(medians.clone(), s.color(), 1.8),
        });
        shapes.extend(medians.into_iter().map(|p| Shape::Dot(p, s.color(), 2.6)));
    }
    shapes
}

/// For each word and estimator a box of the inner band, a line of the outer one, a bar at the median. `own`: each estimator
/// has a word of its own.
fn boxes(series: &[&Series<'_>], own: bool) -> Vec<Shape> {
    let beside = if own { 1.0 } else { series.len().max(1) as f64 };
    let half = 0.36 / beside;
    let mut shapes = Vec::new();
    for (k, s) in series.iter().enumerate() {
        let shift = match own {
            true => 0.0,
            false => (k as f64 + 0.5 - 0.5 * beside) * 0.8 / beside,
        };
        for place in &s.places {
            let x = place.at + shift;
            let [low, first, median, third, high] = place.quantiles;
            shapes.push(Shape::Line(vec![(x, low), (x, high)], s.color(), 1.2));
            shapes.push(Shape::Cell(
                [(x - half, third), (x + half, first)],
                spread_color(s.color()),
            ));
            let bar = vec![(x - half, median), (x + half, median)];
            shapes.push(Shape::Line(bar, s.color(), 2.2));
        }
    }
    shapes
}

fn entry(series: &Series<'_>, axis: &Axis) -> Entry {
    let (color, dashes) = color_of(series.number);
    let style = line(color, 1.8);
    let middle = match dashes && axis.words.is_none() {
        true => Mark::Dashed(style),
        false => Mark::Line(style),
    };
    Entry {
        marks: vec![
            middle,
            Mark::Area(spread_color(color)),
            Mark::Area(band_color(color)),
        ],
        label: series.label.to_owned(),
    }
}

fn drawn(series: &[Series<'_>], axis: &Axis, grouped: bool) -> String {
    let counts = series.iter().flat_map(|s| s.places.iter().map(|p| p.count));
    let least = counts.clone().min().unwrap_or(0);
    let most = counts.max().unwrap_or(0);
    let counts = match least == most {
        true => format!("{least}"),
        false => format!("{least} to {most}"),
    };
    let places = match grouped {
        true => format!(
            "each group of neighbouring {}; points: single runs",
            axis.name
        ),
        false => format!("each {}", axis.name),
    };
    let bands = match axis.words {
        Some(_) => "Bar: median; box: 25 to 75 %; line: 5 to 95 %",
        None => "Line: median; dark band: 25 to 75 %, light band: 5 to 95 %",
    };
    format!("{bands} of {counts} runs of {places}.")
}

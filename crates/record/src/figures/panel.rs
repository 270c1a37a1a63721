//! One panel: lines and areas over time, or over the position on the ground.

use super::style::{
    Area, Drawn, GRID, SCALE, START, band_color, estimate_line, frame_line, line, path, text,
    truth_line, units, upward_text, write,
};
use super::trace::{Estimated, Point, Trace};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use robhaz_score::extremes;
use std::ops::Range;

/// Height of the title over a panel, px.
pub const PANEL_TITLE: f64 = 22.0;
/// Width of the labels left of it, px.
pub const Y_LABELS: f64 = 58.0;
/// Height of the labels below it, px.
pub const X_LABELS: f64 = 40.0;
/// Share of the values on each side that may lie outside of the bulk.
pub const TAIL: f64 = 0.005;
/// Largest distance of the range from the bulk, in heights of the bulk.
const REACH: f64 = 0.5;
/// Margin above and below the values, as a share of the range.
const MARGIN: f64 = 0.06;

/// A layer of a panel: a line, and areas below the lines of all layers. Lines are drawn in the
/// order of the layers.
pub struct Layer {
    /// Pieces of the line.
    lines: Vec<Vec<Point>>,
    style: ShapeStyle,
    is_dashed: bool,
    /// Closed outlines of the areas, and their colour.
    areas: Vec<Vec<Point>>,
    area_color: RGBColor,
    /// Words above a place.
    label: Option<(String, Point)>,
    /// Whether its values before the comparison set the range of the vertical axis.
    counts_early: bool,
}

impl Layer {
    /// Pieces of a line.
    pub fn line(lines: Vec<Vec<Point>>, style: ShapeStyle) -> Self {
        Self {
            lines,
            style,
            is_dashed: false,
            areas: Vec::new(),
            area_color: START,
            label: None,
            counts_early: false,
        }
    }

    /// A line with every peak, of values that set the range from the start: true ones, or those of
    /// a judged path.
    pub fn peaks(trace: &Trace, style: ShapeStyle) -> Self {
        Self {
            counts_early: true,
            ..Self::line(trace.extremes(), style)
        }
    }

    /// An estimate, with every peak, and its two standard deviations.
    pub fn estimate(estimate: &Estimated, color: RGBColor) -> Self {
        Self {
            areas: estimate.band(),
            area_color: band_color(color),
            ..Self::line(estimate.line.extremes(), estimate_line(color))
        }
    }

    /// Means alone, dashed.
    pub fn dashed(trace: &Trace, color: RGBColor) -> Self {
        Self {
            is_dashed: true,
            ..Self::line(trace.means(), line(color, 1.2))
        }
    }

    /// A horizontal line over a range of the axis, such as zero error.
    pub fn level(value: f64, range: &Range<f64>) -> Self {
        let ends = vec![(range.start, value), (range.end, value)];
        Self::line(vec![ends], truth_line())
    }

    /// An area within its corners.
    pub fn area(corners: Vec<Point>, color: RGBColor) -> Self {
        Self {
            areas: vec![corners],
            area_color: color,
            ..Self::line(Vec::new(), frame_line())
        }
    }

    /// A circle around a centre, as a line of a width in px.
    pub fn circle((x, y): Point, radius: f64, color: RGBColor, px: f64) -> Self {
        let at = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
            (x + radius * cos, y + radius * sin)
        };
        Self::line(vec![(0..=64).map(at).collect()], line(color, px))
    }

    /// Words above a place.
    pub fn label(words: String, place: Point) -> Self {
        Self {
            label: Some((words, place)),
            ..Self::line(Vec::new(), frame_line())
        }
    }

    /// The values that set the range of the vertical axis: all true values, and estimates from a
    /// time on.
    fn values(&self, from: f64) -> impl Iterator<Item = f64> {
        let points = self.lines.iter().chain(&self.areas).flatten();
        let counts = move |p: &&Point| self.counts_early || p.0 >= from;
        points.filter(counts).map(|p| p.1)
    }
}

/// One quantity, true and estimated.
pub struct Panel {
    /// Title, over its left corner.
    pub title: String,
    /// Error of the estimate, over its right corner.
    pub note: String,
    /// Quantity and unit.
    pub y_label: &'static str,
    /// Least height of the range, in the unit of the data.
    pub least_span: f64,
    /// The range of the vertical axis, if the values do not set it.
    pub range: Option<Range<f64>>,
    /// Height of the plot, px.
    pub height: f64,
    /// Lines and areas.
    pub layers: Vec<Layer>,
}

/// The horizontal axis that panels share.
#[derive(Clone)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// First and last value.
    pub range: Range<f64>,
    /// Before this value estimates are not compared and do not set the range of the vertical axis.
    pub compare_from: f64,
}

impl Axis {
    /// An axis of places, at which all estimates count.
    pub fn of_places(label: &'static str, range: Range<f64>) -> Self {
        Self {
            label,
            compare_from: range.start,
            range,
        }
    }
}

/// A chart over the horizontal axis.
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Panel {
    /// A panel with a linear axis and without a note. `least_span` in the unit of the data,
    /// `height` in px.
    pub fn new(
        title: &str,
        y_label: &'static str,
        (least_span, height): (f64, f64),
        layers: Vec<Layer>,
    ) -> Self {
        Self {
            title: title.to_owned(),
            note: String::new(),
            y_label,
            least_span,
            range: None,
            height,
            layers,
        }
    }

    /// The range of the vertical axis that several panels share. A share `tail` of the values on
    /// each side can be cut.
    ///
    /// It holds the truth of the whole run and the estimates from `compare_from` on: an estimator's
    /// first samples, before its filters have settled, do not set it. Where nothing is compared,
    /// all estimates count.
    pub fn shared_range(panels: &[Self], axis: &Axis, tail: f64) -> Range<f64> {
        let from = Some(axis.compare_from).filter(|from| *from < axis.range.end);
        let from = from.unwrap_or(f64::NEG_INFINITY);
        let layers = panels.iter().flat_map(|panel| &panel.layers);
        let values: Vec<f64> = layers.flat_map(|layer| layer.values(from)).collect();
        let least_span = panels.iter().map(|p| p.least_span).fold(0.0, f64::max);
        range(values, least_span, tail)
    }

    /// Draws the panel; `labelled` when it is the last of its column.
    ///
    /// # Errors
    /// The error of the drawing library.
    pub fn draw(&self, area: &Area<'_>, axis: &Axis, y: &Range<f64>, labelled: bool) -> Drawn {
        let width = f64::from(area.dim_in_pixel().0) / f64::from(SCALE);
        self.texts(area, axis, width, y)?;
        let below = if labelled { units(X_LABELS) } else { 0 };
        let mut builder = ChartBuilder::on(area);
        builder
            .margin_top(units(PANEL_TITLE))
            .margin_right(units(2.0))
            .set_label_area_size(LabelAreaPosition::Left, units(Y_LABELS))
            .set_label_area_size(LabelAreaPosition::Bottom, below);
        let x = axis.range.clone();
        self.draw_on(builder.build_cartesian_2d(x, y.clone())?, axis, y)?;
        if labelled {
            let middle = Y_LABELS + 0.5 * (width - Y_LABELS);
            let bottom = PANEL_TITLE + self.height + X_LABELS - 4.0;
            let style = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
            write(area, axis.label, (middle, bottom), style)?;
        }
        Ok(())
    }

    fn draw_on(&self, mut chart: Chart<'_>, axis: &Axis, y: &Range<f64>) -> Drawn {
        let (left, right) = (axis.range.start, axis.range.end);
        let start = axis.compare_from.clamp(left, right);
        let not_compared = [(left, y.start), (start, y.end)];
        chart.draw_series([Rectangle::new(not_compared, START.filled())])?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(line(GRID, 0.7))
            .axis_style(frame_line())
            .x_labels(11)
            .y_labels(6)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
            .set_all_tick_mark_size(units(4.0))
            .draw()?;
        for layer in &self.layers {
            let filled = layer.area_color.filled();
            let area = |area: &Vec<Point>| Polygon::new(clamp(area, y), filled);
            chart.draw_series(layer.areas.iter().map(area))?;
        }
        for layer in &self.layers {
            let lines = layer.lines.iter().map(|line| clamp(line, y));
            chart.draw_series(lines.map(|line| path(line, layer.style, layer.is_dashed)))?;
        }
        for (words, place) in self.layers.iter().filter_map(|layer| layer.label.clone()) {
            let style = text(11.0, FontStyle::Normal, HPos::Center, VPos::Bottom);
            chart.draw_series([Text::new(words, place, style)])?;
        }
        let corners = [
            (left, y.start),
            (right, y.start),
            (right, y.end),
            (left, y.end),
            (left, y.start),
        ];
        chart.draw_series([PathElement::new(corners, frame_line())])?;
        Ok(())
    }

    /// Title, note and name of the vertical axis.
    fn texts(&self, area: &Area<'_>, axis: &Axis, width: f64, y: &Range<f64>) -> Drawn {
        let middle = 0.55 * PANEL_TITLE;
        let bold = text(12.5, FontStyle::Bold, HPos::Left, VPos::Center);
        write(area, &self.title, (Y_LABELS, middle), bold)?;
        let values = self.layers.iter().flat_map(|l| l.values(axis.compare_from));
        let mut notes = vec![self.note.clone()];
        if self.range.is_none() {
            notes.extend(cut(values, y));
        }
        notes.retain(|note| !note.is_empty());
        let right = text(12.0, FontStyle::Normal, HPos::Right, VPos::Center);
        write(area, &notes.join(", "), (width - 2.0, middle), right)?;
        let label = (9.0, PANEL_TITLE + 0.5 * self.height);
        write(area, self.y_label, label, upward_text(12.0))
    }
}

/// The label of a tick, without the rounding error of binary fractions.
fn tick(value: &f64) -> String {
    tidy(*value).to_string()
}

/// Range of a panel with these values, least first or not: all of them, unless a share `tail` on
/// each side is far beyond the bulk. At least `least_span` high, so that noise does not fill a
/// panel.
fn range(mut values: Vec<f64>, least_span: f64, tail: f64) -> Range<f64> {
    values.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (values.first().copied(), values.last().copied()) else {
        return 0.0..least_span;
    };
    // An index into some thousand values.
    let tail = (values.len() as f64 * tail) as usize;
    let (low, high) = (values[tail], values[values.len() - 1 - tail]);
    let bulk = (high - low).max(least_span);
    let low = first.max(low - REACH * bulk);
    let high = last.min(high + REACH * bulk);
    let middle = 0.5 * (low + high);
    let half = (0.5 + MARGIN) * (high - low).max(least_span);
    middle - half..middle + half
}

/// A note where a panel does not show all values.
fn cut(values: impl Iterator<Item = f64>, range: &Range<f64>) -> Option<String> {
    let (low, high) = extremes(values);
    let below = low < range.start;
    let above = high > range.end;
    let height = range.end - range.start;
    let (low, high) = (rounded(low, height), rounded(high, height));
    match (below, above) {
        (true, true) => Some(format!("cut: {low} to {high}")),
        (true, false) => Some(format!("cut: down to {low}")),
        (false, true) => Some(format!("cut: up to {high}")),
        (false, false) => None,
    }
}

/// A value with two digits of the height of its axis, at most with units: 4.26 on an axis of 0.5 is
/// not rounded to 4.
fn rounded(value: f64, height: f64) -> f64 {
    let unit = 10f64.powf((height.log10().floor() - 1.0).min(0.0));
    tidy((value / unit).round() * unit)
}

/// A value without the rounding error of binary fractions.
fn tidy(value: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    (value * 1e6).round() / 1e6 + 0.0
}

/// The points of a line or corners of an area, with those outside of the range moved to its edge.
fn clamp(corners: &[Point], range: &Range<f64>) -> Vec<Point> {
    let inside = |p: &Point| (p.0, p.1.clamp(range.start, range.end));
    corners.iter().map(inside).collect()
}

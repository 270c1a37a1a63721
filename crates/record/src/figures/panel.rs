//! One panel: lines and areas over time, or over the position on the ground.

use super::area::{Area, Drawn, write};
use super::clip::{clamp, cut, range, tidy};
use super::header::dashed;
use super::style::{
    SCALE, START, band_color, estimate_line, frame_line, grid_line, line, text, truth_line, units,
    upward_text,
};
use super::trace::{Estimated, Point, Trace};
use crate::quantile::extremes;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Height of the title over a panel, px.
pub const PANEL_TITLE: f64 = 22.0;
/// Width of the labels left of it, px.
pub const Y_LABELS: f64 = 58.0;
/// Height of the labels below it, px.
pub const X_LABELS: f64 = 40.0;

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

    /// True values, with every peak.
    pub fn truth(trace: &Trace) -> Self {
        Self {
            counts_early: true,
            ..Self::line(trace.extremes(), truth_line())
        }
    }

    /// True values in a colour, with every peak.
    pub fn colored(trace: &Trace, color: RGBColor) -> Self {
        Self {
            counts_early: true,
            ..Self::line(trace.extremes(), line(color, 1.4))
        }
    }

    /// An estimate, with every peak, and its two standard deviations.
    pub fn estimate(estimate: &Estimated, color: RGBColor) -> Self {
        Self::banded(estimate.line.extremes(), estimate.band(), color)
    }

    /// Pieces of the line of an estimate, and outlines of its two standard deviations.
    pub fn banded(lines: Vec<Vec<Point>>, areas: Vec<Vec<Point>>, color: RGBColor) -> Self {
        Self {
            areas,
            area_color: band_color(color),
            ..Self::line(lines, estimate_line(color))
        }
    }

    /// Means alone, dashed or not: many estimates in one panel.
    pub fn mean(trace: &Trace, color: RGBColor, is_dashed: bool) -> Self {
        Self {
            is_dashed,
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
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
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
        let compare_from = range.start;
        Self {
            label,
            range,
            compare_from,
        }
    }
}

/// A chart over the horizontal axis.
type Chart<'a, Y> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, Y>>;

/// Grid, axes and their labels.
fn mesh<Y>(chart: &mut Chart<'_, Y>) -> Drawn
where
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(grid_line())
        .axis_style(frame_line())
        .x_labels(11)
        .y_labels(6)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
        .set_all_tick_mark_size(units(4.0))
        .draw()?;
    Ok(())
}

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
            logarithmic: false,
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
        let compared = axis.compare_from < axis.range.end;
        let from = if compared {
            axis.compare_from
        } else {
            f64::NEG_INFINITY
        };
        let layers = panels.iter().flat_map(|panel| &panel.layers);
        let values: Vec<f64> = layers.flat_map(|layer| layer.values(from)).collect();
        let least_span = panels.iter().map(|p| p.least_span).fold(0.0, f64::max);
        if panels.iter().all(|p| p.logarithmic) {
            decades(&values)
        } else {
            range(values, least_span, tail)
        }
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
        if self.logarithmic {
            let y_axis = (y.start..y.end).log_scale();
            self.draw_on(
                builder.build_cartesian_2d(axis.range.clone(), y_axis)?,
                axis,
                y,
            )?;
        } else {
            self.draw_on(
                builder.build_cartesian_2d(axis.range.clone(), y.clone())?,
                axis,
                y,
            )?;
        }
        if labelled {
            let middle = Y_LABELS + 0.5 * (width - Y_LABELS);
            let bottom = PANEL_TITLE + self.height + X_LABELS - 4.0;
            let style = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
            write(area, axis.label, (middle, bottom), style)?;
        }
        Ok(())
    }

    fn draw_on<Y>(&self, mut chart: Chart<'_, Y>, axis: &Axis, y: &Range<f64>) -> Drawn
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let (left, right) = (axis.range.start, axis.range.end);
        let start = axis.compare_from.clamp(left, right);
        let not_compared = [(left, y.start), (start, y.end)];
        chart.draw_series([Rectangle::new(not_compared, START.filled())])?;
        mesh(&mut chart)?;
        for layer in &self.layers {
            let filled = layer.area_color.filled();
            let area = |area: &Vec<Point>| Polygon::new(clamp(area, y), filled);
            chart.draw_series(layer.areas.iter().map(area))?;
        }
        for layer in &self.layers {
            let lines = layer.lines.iter().map(|line| clamp(line, y));
            if layer.is_dashed {
                chart.draw_series(lines.map(|line| dashed(line, layer.style)))?;
            } else {
                chart.draw_series(lines.map(|line| PathElement::new(line, layer.style)))?;
            }
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
        if !self.logarithmic && self.range.is_none() {
            notes.extend(cut(values, y));
        }
        notes.retain(|note| !note.is_empty());
        let right = text(12.0, FontStyle::Normal, HPos::Right, VPos::Center);
        write(area, &notes.join(", "), (width - 2.0, middle), right)?;
        let label = (9.0, PANEL_TITLE + 0.5 * self.height);
        write(area, self.y_label, label, upward_text(12.0))
    }
}

/// Decades that hold all values, at most six.
fn decades(values: &[f64]) -> Range<f64> {
    let values = values.iter().copied().filter(|v| *v > 0.0);
    let (low, high) = extremes(values.map(f64::log10));
    let (low, high) = if low > high { (-1.0, 1.0) } else { (low, high) };
    let high = high.ceil().max(low.floor() + 1.0);
    // A little lower, so that rounding does not drop the label of the lowest decade.
    0.999 * 10f64.powf(low.floor().max(high - 6.0))..10f64.powf(high)
}

/// The label of a tick, without the rounding error of binary fractions.
fn tick(value: &f64) -> String {
    tidy(*value).to_string()
}

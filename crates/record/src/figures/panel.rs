//! One panel: lines and areas over time, or over the position on the ground.

use super::area::{Area, Drawn, write};
use super::clip::{clamp, clip, cut, range, tidy, whole};
use super::header::dashed;
use super::style::{
    SCALE, START, band_color, estimate_line, frame_line, grid_line, line, spread_color, text,
    truth_line, units, upward_text,
};
use super::trace::{Estimated, Point, Trace, outlines};
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

/// A layer of a panel. Layers are drawn in the order of the variants: areas below lines.
pub enum Layer<'a> {
    /// An estimate: its two standard deviations, the area of its values in each interval of time, and the line of their means.
    Estimate(&'a Estimated, RGBColor),
    /// True values, with every peak.
    Truth(&'a Trace),
    /// True values in a colour, with every peak.
    Colored(&'a Trace, RGBColor),
    /// Means alone, dashed or not: many estimates in one panel.
    Mean(&'a Trace, RGBColor, bool),
    /// A horizontal line, such as zero error.
    Level(f64),
}

impl Layer<'_> {
    /// The values that set the range of the vertical axis: all true values, and estimates from a time on.
    fn points(&self, from: f64) -> Vec<Point> {
        let late = |pieces: Vec<Vec<Point>>| {
            let points = pieces.into_iter().flatten();
            points.filter(|p| p.0 >= from).collect()
        };
        match self {
            Self::Estimate(estimate, _) => {
                late([estimate.band(), estimate.line.extremes()].concat())
            }
            Self::Mean(trace, _, _) => late(trace.means()),
            Self::Truth(trace) | Self::Colored(trace, _) => {
                trace.extremes().into_iter().flatten().collect()
            }
            Self::Level(value) => vec![(from, *value)],
        }
    }
}

/// One quantity, true and estimated.
pub struct Panel<'a> {
    /// Title, over its left corner.
    pub title: String,
    /// Error of the estimate, over its right corner.
    pub note: String,
    /// Quantity and unit.
    pub y_label: &'static str,
    /// Least height of the range, in the unit of the data.
    pub least_span: f64,
    /// Whether the vertical axis is logarithmic.
    pub logarithmic: bool,
    /// Height of the plot, px.
    pub height: f64,
    /// Lines and areas.
    pub layers: Vec<Layer<'a>>,
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

/// Grid, axes and their labels, about `y_labels` of them at the vertical axis.
pub fn mesh<Y>(chart: &mut Chart<'_, Y>, y_labels: usize) -> Drawn
where
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(grid_line())
        .axis_style(frame_line())
        .x_labels(11)
        .y_labels(y_labels)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
        .set_all_tick_mark_size(units(4.0))
        .draw()?;
    Ok(())
}

impl<'a> Panel<'a> {
    /// A panel with a linear axis and without a note. `least_span` in the unit of the data, `height` in px.
    pub fn new(
        title: &str,
        y_label: &'static str,
        (least_span, height): (f64, f64),
        layers: Vec<Layer<'a>>,
    ) -> Self {
        Self {
            title: title.to_owned(),
            note: String::new(),
            y_label,
            least_span,
            logarithmic: false,
            height,
            layers,
        }
    }

    /// The range of the vertical axis that several panels share.
    ///
    /// It holds the truth of the whole run and the estimates from `compare_from` on: an estimator's first samples, before
    /// its filters have settled, do not set it. Where nothing is compared, all estimates count.
    pub fn shared_range(panels: &[Self], axis: &Axis) -> Range<f64> {
        let of = |from: f64| -> Vec<Point> {
            let layers = panels.iter().flat_map(|panel| &panel.layers);
            layers.flat_map(|layer| layer.points(from)).collect()
        };
        let compared = axis.compare_from < axis.range.end;
        let points = of(if compared {
            axis.compare_from
        } else {
            f64::NEG_INFINITY
        });
        let least_span = panels.iter().map(|p| p.least_span).fold(0.0, f64::max);
        if panels.iter().all(|p| p.logarithmic) {
            decades(&points)
        } else {
            range(points.iter(), least_span)
        }
    }

    /// The range of the vertical axis that holds every value, single peaks included: for a panel whose extremes decide.
    pub fn whole_range(&self) -> Range<f64> {
        let layers = self.layers.iter();
        let points: Vec<Point> = layers.flat_map(|l| l.points(f64::NEG_INFINITY)).collect();
        whole(points.iter(), self.least_span)
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
        mesh(&mut chart, 6)?;
        for (area, color) in self.areas() {
            chart.draw_series([Polygon::new(clamp(&area, y), color.filled())])?;
        }
        for (piece, style, dashes) in self.lines(axis) {
            for part in clip(&piece, y) {
                if dashes {
                    chart.draw_series([dashed(part, style)])?;
                } else {
                    chart.draw_series([PathElement::new(part, style)])?;
                }
            }
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

    /// Outlines of the areas, with their colours.
    fn areas(&self) -> Vec<(Vec<Point>, RGBColor)> {
        let mut areas = Vec::new();
        for layer in &self.layers {
            if let Layer::Estimate(estimate, color) = layer {
                let with = |color: RGBColor| move |area| (area, color);
                areas.extend(estimate.band().into_iter().map(with(band_color(*color))));
                if estimate.line.stride() > 1 {
                    let spread = outlines(&estimate.line.lows(), &estimate.line.highs());
                    areas.extend(spread.into_iter().map(with(spread_color(*color))));
                }
            }
        }
        areas
    }

    /// Pieces of the lines, with their looks and whether they are dashed: wide ones first, below narrow ones.
    fn lines(&self, axis: &Axis) -> Vec<(Vec<Point>, ShapeStyle, bool)> {
        let (mut wide, mut narrow) = (Vec::new(), Vec::new());
        for layer in &self.layers {
            let (to, pieces, style, dashes) = match layer {
                Layer::Truth(trace) => (&mut wide, trace.extremes(), truth_line(), false),
                Layer::Level(value) => {
                    let ends = vec![(axis.range.start, *value), (axis.range.end, *value)];
                    (&mut wide, vec![ends], truth_line(), false)
                }
                Layer::Colored(trace, color) => {
                    (&mut narrow, trace.extremes(), line(*color, 1.4), false)
                }
                Layer::Estimate(estimate, color) => (
                    &mut narrow,
                    estimate.line.means(),
                    estimate_line(*color),
                    false,
                ),

                Layer::Mean(trace, color, dashes) => {
                    (&mut narrow, trace.means(), line(*color, 1.2), *dashes)
                }
            };
            to.extend(pieces.into_iter().map(|piece| (piece, style, dashes)));
        }
        wide.append(&mut narrow);
        wide
    }

    /// Title, note and name of the vertical axis.
    fn texts(&self, area: &Area<'_>, axis: &Axis, width: f64, y: &Range<f64>) -> Drawn {
        let middle = 0.55 * PANEL_TITLE;
        let bold = text(12.5, FontStyle::Bold, HPos::Left, VPos::Center);
        write(area, &self.title, (Y_LABELS, middle), bold)?;
        let points = self.layers.iter().flat_map(|l| l.points(axis.compare_from));
        let mut notes = vec![self.note.clone()];
        if !self.logarithmic {
            notes.extend(cut(points, y));
        }
        notes.retain(|note| !note.is_empty());
        let right = text(12.0, FontStyle::Normal, HPos::Right, VPos::Center);
        write(area, &notes.join(", "), (width - 2.0, middle), right)?;
        let label = (9.0, PANEL_TITLE + 0.5 * self.height);
        write(area, self.y_label, label, upward_text(12.0))
    }
}

/// Decades that hold all values, at most six.
fn decades(points: &[Point]) -> Range<f64> {
    let values = points.iter().map(|p| p.1).filter(|v| *v > 0.0);
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

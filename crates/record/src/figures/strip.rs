//! A part of the ground at equal scales of x and y, and what is drawn on it.

use super::area::{Area, Drawn, write};
use super::header::{MARGIN, WIDTH};
use super::panel::{Y_LABELS, mesh};
use super::style::{GROUND, SURFACE, line, text, units, upward_text};
use super::trace::{Point, Trace};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use robhaz_model::Vec2;
use robhaz_terrain::Terrain;
use std::ops::Range;

/// Spacing of the ground's points, m.
pub const SPACING: f64 = 0.005;
/// Room for the labels below a strip, px.
const LABELS: f64 = 38.0;
/// Width of a strip's plot, px.
pub const PLOT_WIDTH: f64 = WIDTH as f64 - 2.0 * MARGIN - Y_LABELS - 2.0;

/// What is drawn on the ground, in the order of drawing; coordinates in m.
pub enum Shape {
    /// A line.
    Line(Vec<Point>, ShapeStyle),
    /// An area within its corners.
    Area(Vec<Point>, RGBColor),
    /// Words above a place.
    Label(String, Point),
}

impl Shape {
    /// A circle around a centre, m, as a line of a width in px.
    pub fn circle(centre: Vec2, radius: f64, color: RGBColor, px: f64) -> Self {
        let at = |k: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
            pair(&(centre + Vec2::new(cos, sin) * radius))
        };
        Self::Line((0..=64).map(at).collect(), line(color, px))
    }
}

/// A part of the ground.
pub struct Strip {
    /// Positions along the ground, m.
    pub x: Range<f64>,
    /// Heights, m.
    pub y: Range<f64>,
    /// px in a metre.
    scale: f64,
    /// About how many labels the vertical axis has.
    y_labels: usize,
    /// The ground, and what stands on it.
    pub shapes: Vec<Shape>,
}

impl Strip {
    /// A part of the ground without anything on it. `scale` in px per m.
    pub fn new(
        ground: &Terrain,
        x: Range<f64>,
        y: Range<f64>,
        scale: f64,
        y_labels: usize,
    ) -> Self {
        let surface = reduced(&ground.outline(x.start, x.end, SPACING));
        let mut below = surface.clone();
        below.extend([(x.end, y.start), (x.start, y.start)]);
        let shapes = vec![
            Shape::Area(below, GROUND),
            Shape::Line(surface, line(SURFACE, 1.6)),
        ];
        Self {
            x,
            y,
            scale,
            y_labels,
            shapes,
        }
    }

    /// Height of the plot, px.
    fn plot(&self) -> f64 {
        self.scale * (self.y.end - self.y.start)
    }

    /// Height with the labels, px.
    pub fn height(&self) -> f64 {
        self.plot() + LABELS
    }

    /// Draws it.
    ///
    /// # Errors
    /// The error of the drawing library.
    pub fn draw(&self, area: &Area<'_>) -> Drawn {
        let mut chart = ChartBuilder::on(area)
            .margin_right(units(2.0))
            .set_label_area_size(LabelAreaPosition::Left, units(Y_LABELS))
            .set_label_area_size(LabelAreaPosition::Bottom, units(LABELS))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        mesh(&mut chart, self.y_labels)?;
        for shape in &self.shapes {
            match shape {
                Shape::Line(points, style) => {
                    chart.draw_series([PathElement::new(points.clone(), *style)])?;
                }
                Shape::Area(corners, color) => {
                    chart.draw_series([Polygon::new(corners.clone(), color.filled())])?;
                }
                Shape::Label(words, place) => {
                    let style = text(11.0, FontStyle::Normal, HPos::Center, VPos::Bottom);
                    chart.draw_series([Text::new(words.clone(), *place, style)])?;
                }
            }
        }
        let name = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
        let below = (Y_LABELS + 0.5 * PLOT_WIDTH, self.height() - 3.0);
        write(area, "x (m)", below, name)?;
        write(area, "y (m)", (9.0, 0.5 * self.plot()), upward_text(12.0))
    }
}

/// A line over x at the resolution of a figure: its ends, and the extremes between. A short one is kept whole.
pub fn reduced(line: &[Vec2]) -> Vec<Point> {
    let mut trace = Trace::new(line.len() as u64);
    for point in line {
        trace.add(point.x, Some(point.y));
    }
    let mut points = trace.extremes().concat();
    if let (Some(first), Some(last)) = (line.first().map(pair), line.last().map(pair)) {
        if points.first() != Some(&first) {
            points.insert(0, first);
        }
        if points.last() != Some(&last) {
            points.push(last);
        }
    }
    points
}

/// A vector as a point.
pub fn pair(point: &Vec2) -> Point {
    (point.x, point.y)
}

//! A panel of the ground at equal scales of x and y, and what is drawn on it.

use super::header::{MARGIN, WIDTH};
use super::panel::{Layer, Panel, Y_LABELS};
use super::style::{GROUND, SURFACE, line};
use super::trace::{Point, Trace};
use robhaz_model::Vec2;
use robhaz_terrain::Terrain;
use std::ops::Range;

/// Spacing of the ground's points, m.
pub const SPACING: f64 = 0.005;
/// Width of the plot, px.
const PLOT_WIDTH: f64 = WIDTH as f64 - 2.0 * MARGIN - Y_LABELS - 2.0;

/// The ground that is shown.
pub struct Strip {
    /// Places along the ground, m.
    pub x: Range<f64>,
    /// Heights, m.
    y: Range<f64>,
    /// px in a metre.
    pub scale: f64,
    /// The ground, and what stands on it.
    pub layers: Vec<Layer>,
}

impl Strip {
    /// Ground without anything on it: places and heights (m), at most `tallest` px high. Where the
    /// height limits the scale, more ground is shown on both sides.
    pub fn new(ground: &Terrain, shown: &Range<f64>, y: Range<f64>, tallest: f64) -> Self {
        let length = shown.end - shown.start;
        let scale = (PLOT_WIDTH / length).min(tallest / (y.end - y.start));
        let more = 0.5 * (PLOT_WIDTH / scale - length);
        let x = shown.start - more..shown.end + more;
        let surface = reduced(&ground.outline(x.start, x.end, SPACING));
        let mut below = surface.clone();
        below.extend([(x.end, y.start), (x.start, y.start)]);
        let surface = Layer::line(vec![surface], line(SURFACE, 1.6));
        Self {
            x,
            y,
            scale,
            layers: vec![Layer::area(below, GROUND), surface],
        }
    }

    /// The panel.
    pub fn panel(self) -> Panel {
        let height = self.scale * (self.y.end - self.y.start);
        let title = "Ground, equal scales of x and y";
        Panel {
            range: Some(self.y),
            ..Panel::new(title, "y (m)", (0.0, height), self.layers)
        }
    }
}

/// A line over x at the resolution of a figure: its ends, and the extremes between. A short one is
/// kept whole.
fn reduced(line: &[Vec2]) -> Vec<Point> {
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

//! The path that is judged before it is driven: ground, needed against available friction, margin.

use super::files::{Drawn, Picture};
use super::header::{Entry, Header, MARGIN, Mark, WIDTH, write};
use super::page::whole;
use super::panel::{Axis, Layer, PANEL_TITLE, Panel, X_LABELS, Y_LABELS, tick};
use super::strips::{SPACING, Strip};
use super::style::{
    GROUND, LINKAGE, SURFACE, TRUTH, WHEELS, frame_line, grid_line, line, text, units, upward_text,
};
use super::trace::{Point, Trace};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use robhaz_path::{PathReport, PathSetup, Place};
use robhaz_terrain::Terrain;
use std::ops::Range;

/// Longest part of the path that is shown, m. Of a longer one it is the part around the marked place.
const LONGEST: f64 = 8.0;
/// Ground shown beside the wheels, above them and below, m.
const BESIDE: f64 = 0.15;
/// Greatest height of the ground's plot, px.
const TALLEST: f64 = 320.0;
/// Room for the labels below the ground, px.
const LABELS: f64 = 38.0;
/// Height of a panel, px.
const PANEL: f64 = 130.0;

/// The figure of a judged path.
pub struct NeededFriction<'a> {
    header: Header,
    ground: &'a Terrain,
    radius: f64,
    /// The start, and the first failure or the place with the least margin.
    marked: Vec<&'a Place>,
    strip: Strip,
    /// px in a metre.
    scale: f64,
    axis: Axis,
    needed: Trace,
    available: Trace,
    margin: Trace,
}

impl<'a> NeededFriction<'a> {
    /// The figure of a report on a path; `None` without a place.
    pub fn new(setup: &'a PathSetup, report: &'a PathReport) -> Option<Self> {
        let places = &report.places;
        let (first, last) = (places.first()?, places.last()?);
        let decisive = decisive(report).unwrap_or(last);
        let shown = shown(first, last, decisive);
        let radius = setup.robot.geometry.wheel_radius;
        let (strip, scale) = strip(&setup.terrain, places, &shown, radius);
        let count = places.len() as u64;
        let range = strip.x.clone();
        let trace = |value: fn(&Place) -> Option<f64>| {
            let mut trace = Trace::new(count);
            for place in places {
                if range.contains(&place.x()) {
                    trace.add(place.x(), value(place));
                }
            }
            trace
        };
        let verdict = match &report.first_failure {
            Some(failure) => format!(
                "no-go at x = {:.3} m: {}",
                failure.x,
                failure.reason.words()
            ),
            None => "go".to_owned(),
        };
        let circles = if std::ptr::eq(first, decisive) {
            "wheels at the start"
        } else {
            "wheels (front, middle, rear) at the start, and at the decisive place"
        };
        Some(Self {
            header: Header {
                title: format!("Needed friction along the path, drive {}", report.drive),
                subtitle: format!("{verdict}; equal scales of x and y"),
                key: vec![
                    Entry::new(
                        Mark::Line(line(LINKAGE, 1.4)),
                        "needed friction mu_n, margin",
                    ),
                    Entry::new(Mark::Dashed(line(SURFACE, 1.2)), "available friction mu"),
                    Entry::new(Mark::Line(line(TRUTH, 3.2)), "margin zero"),
                    Entry {
                        marks: WHEELS.map(|c| Mark::Line(line(c, 1.6))).to_vec(),
                        label: circles.to_owned(),
                    },
                ],
            },
            ground: &setup.terrain,
            radius,
            marked: vec![first, decisive],
            axis: Axis {
                label: "x of the middle wheel (m)",
                range: range.clone(),
                compare_from: range.start,
            },
            strip,
            scale,
            needed: trace(|p| p.needed_mu),
            available: trace(Place::available_mu),
            margin: trace(|p| p.margin),
        })
    }

    fn panels(&self) -> [Panel<'_>; 2] {
        let panel = |title: &str, y_label, least_span, layers| Panel {
            title: title.to_owned(),
            note: String::new(),
            y_label,
            least_span,
            logarithmic: false,
            height: PANEL,
            layers,
        };
        let friction = vec![
            Layer::Mean(&self.available, SURFACE, true),
            Layer::Colored(&self.needed, LINKAGE),
        ];
        let margin = vec![Layer::Level(0.0), Layer::Colored(&self.margin, LINKAGE)];
        [
            panel(
                "Needed and available friction",
                "mu_n, mu (1)",
                0.1,
                friction,
            ),
            panel(
                "Margin: how far all friction coefficients can fall",
                "margin (1)",
                0.1,
                margin,
            ),
        ]
    }

    /// Height of the ground's plot with its labels, px.
    fn strip_height(&self) -> f64 {
        self.scale * (self.strip.y.end - self.strip.y.start) + LABELS
    }

    fn draw_strip<DB>(&self, area: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let Strip { x, y } = &self.strip;
        let mut chart = ChartBuilder::on(area)
            .margin_right(units(2.0))
            .set_label_area_size(LabelAreaPosition::Left, units(Y_LABELS))
            .set_label_area_size(LabelAreaPosition::Bottom, units(LABELS))
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(grid_line())
            .axis_style(frame_line())
            .x_labels(11)
            .y_labels(4)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
            .set_all_tick_mark_size(units(4.0))
            .draw()?;
        let surface = self.ground.outline(x.start, x.end, SPACING);
        let surface: Vec<Point> = surface.iter().map(|p| (p.x, p.y)).collect();
        let mut below = surface.clone();
        below.extend([(x.end, y.start), (x.start, y.start)]);
        chart.draw_series([Polygon::new(below, GROUND.filled())])?;
        chart.draw_series([PathElement::new(surface, line(SURFACE, 1.6))])?;
        for place in &self.marked {
            for (i, color) in WHEELS.into_iter().enumerate() {
                let circle = circle(place, i, self.radius);
                if circle.iter().all(|p| x.contains(&p.0)) {
                    chart.draw_series([PathElement::new(circle, line(color, 1.6))])?;
                }
            }
        }
        let plot = self.strip_height() - LABELS;
        let name = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
        let middle = Y_LABELS + 0.5 * plot_width();
        write(area, "x (m)", (middle, plot + LABELS - 3.0), name)?;
        write(area, "y (m)", (9.0, 0.5 * plot), upward_text(12.0))
    }
}

impl Picture for NeededFriction<'_> {
    fn size(&self) -> (u32, u32) {
        let panels = 2.0 * (PANEL_TITLE + PANEL) + X_LABELS;
        let height = self.header.bottom() + self.strip_height() + panels + 0.5 * MARGIN;
        (WIDTH, whole(height))
    }

    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        self.header.draw(page)?;
        let width = units(f64::from(WIDTH) - 2.0 * MARGIN);
        let mut top = self.header.bottom();
        let mut part = |height: f64| {
            let corner = (units(MARGIN), units(top));
            top += height;
            page.clone().shrink(corner, (width, units(height)))
        };
        self.draw_strip(&part(self.strip_height()))?;
        for (k, panel) in self.panels().iter().enumerate() {
            let last = k == 1;
            let labels = if last { X_LABELS } else { 0.0 };
            let area = part(PANEL_TITLE + PANEL + labels);
            // A single place decides: its peak is not cut.
            panel.draw(&area, &self.axis, &panel.whole_range(), last)?;
        }
        Ok(())
    }
}

/// The place of the first failure, otherwise that of the least margin.
fn decisive(report: &PathReport) -> Option<&Place> {
    let failing = report.places.iter().find(|p| p.failure.is_some());
    failing.or_else(|| {
        let with_margin = report.places.iter().filter(|p| p.margin.is_some());
        with_margin.min_by(|a, b| a.margin.unwrap_or(0.0).total_cmp(&b.margin.unwrap_or(0.0)))
    })
}

fn plot_width() -> f64 {
    f64::from(WIDTH) - 2.0 * MARGIN - Y_LABELS - 2.0
}

/// The part of the ground that is shown, m.
fn shown(first: &Place, last: &Place, decisive: &Place) -> Range<f64> {
    let (from, to) = (first.wheel_x[2] - BESIDE, last.wheel_x[0] + BESIDE);
    if to - from <= LONGEST {
        return from..to;
    }
    let from = (decisive.x() - 0.5 * LONGEST).clamp(from, to - LONGEST);
    from..from + LONGEST
}

/// Ranges of x and y with one scale, and that scale, px per m.
fn strip(ground: &Terrain, places: &[Place], shown: &Range<f64>, radius: f64) -> (Strip, f64) {
    let surface = ground.outline(shown.start, shown.end, SPACING);
    let wheels = places
        .iter()
        .flat_map(|p| p.wheel_x.into_iter().zip(p.wheel_y));
    let tops = wheels
        .filter(|(x, _)| shown.contains(x))
        .map(|(_, y)| y + radius);
    let heights = surface.iter().map(|p| p.y).chain(tops);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| {
        (a.min(y), b.max(y))
    });
    let y = low - 0.3 * BESIDE..high + 0.3 * BESIDE;
    let scale = (plot_width() / (shown.end - shown.start)).min(TALLEST / (y.end - y.start));
    // Where the height limits the scale, more ground is shown on both sides.
    let more = 0.5 * (plot_width() / scale - (shown.end - shown.start));
    let x = shown.start - more..shown.end + more;
    (Strip { x, y }, scale)
}

fn circle(place: &Place, wheel: usize, radius: f64) -> Vec<Point> {
    let (x, y) = (place.wheel_x[wheel], place.wheel_y[wheel]);
    let at = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
        (x + radius * cos, y + radius * sin)
    };
    (0..=64).map(at).collect()
}

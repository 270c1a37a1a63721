//! A panel of the ground at equal scales of x and y; and the figure with the robot on it, and N
//! over the position of the wheels.

use super::page::{Entry, MARGIN, Mark, Page, Scale, WIDTH};
use super::panel::{Axis, Layer, Panel, Y_LABELS};
use super::run::RunTraces;
use super::style::{GROUND, ROBOT, SURFACE, WHEELS, line};
use super::trace::{Point, Trace};
use robhaz_model::{Bar, Geometry, Pin, Vec2, rotate};
use robhaz_score::extremes;
use robhaz_sim::{ContactTruth, Truth};
use robhaz_terrain::Terrain;
use std::ops::Range;

/// Spacing of the ground's points, m.
pub const SPACING: f64 = 0.005;
/// Width of the plot, px.
const PLOT_WIDTH: f64 = WIDTH as f64 - 2.0 * MARGIN - Y_LABELS - 2.0;
// Lengths of robot A; those of others are in proportion to their size.
/// Least distance of two robots that are drawn, m.
const DISTANCE: f64 = 0.85;
/// Length of the arrow of a mean static wheel load, m.
const MEAN_LOAD_LENGTH: f64 = 0.12;
/// Ground shown beside the wheels, m.
const BESIDE: f64 = 0.15;
/// Distance of the time above a robot, and height that is shown above it, m.
const ABOVE: [f64; 2] = [0.05, 0.13];

/// Longest arrow over that of the mean load: the arrow of an impact must stay in the picture.
const LONGEST: f64 = 3.0;
/// Largest number of robots drawn; on a long path they stand farther apart.
const MOST: f64 = 12.0;
/// Greatest height of the ground's plot, px.
const TALLEST: f64 = 520.0;

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
fn pair(point: &Vec2) -> Point {
    (point.x, point.y)
}

/// The figure of the path of a run, which has a pose.
pub fn path(run: &RunTraces, ground: &Terrain) -> Page {
    let wheels = run.poses.iter().flat_map(|pose| &pose.wheels);
    let (first, last) = extremes(wheels.map(|w| w.position.x));
    let beside = BESIDE * run.geometry.size();
    let reach = first - beside..last + beside;
    let strip = strip(run, ground, &reach);
    let wheels = ["front wheel", "middle wheel", "rear wheel"];
    let mut key: Vec<Entry> = (wheels.into_iter().zip(WHEELS))
        .map(|(name, color)| Entry::new(Mark::line(line(color, 1.8)), name))
        .collect();
    let length = mean_load_length(&run.geometry);
    let label = format!("arrows: N, {length} m are {:.0} N", run.mean_load);
    let marks = Vec::new();
    key.push(Entry { marks, label });
    let lines = run.normal_force_at.iter().zip(WHEELS);
    let lines = lines.map(|(trace, color)| Layer::peaks(trace, line(color, 1.4)));
    let panel = Panel::new(
        "Normal force over the place of each wheel",
        "normal force N (N)",
        (2.0, 190.0),
        lines.collect(),
    );
    let subtitle = "lines through the robots: paths of the wheels' centres";
    Page {
        title: "The robot on the ground, and its true normal forces".to_owned(),
        subtitle: subtitle.to_owned(),
        key,
        axis: Axis::of_places("place, x (m)", strip.x.clone()),
        scale: Scale::Own,
        columns: vec![vec![strip.panel(), panel]],
    }
}

/// Length of the arrow of the mean static wheel load, m: whole millimetres.
fn mean_load_length(geometry: &Geometry) -> f64 {
    (MEAN_LOAD_LENGTH * geometry.size() * 1e3).round() / 1e3
}

/// The ground that is shown, m, with robots and paths.
fn strip(run: &RunTraces, ground: &Terrain, reach: &Range<f64>) -> Strip {
    let y = heights(run, ground, reach);
    let mut strip = Strip::new(ground, reach, y, TALLEST);
    // The paths of the three centres nearly coincide: the later ones are thinner.
    for (i, width) in [3.0, 1.8, 0.8].into_iter().enumerate() {
        let centres = run.poses.iter().map(|pose| pair(&pose.wheels[i].position));
        let path = Layer::line(vec![centres.collect()], line(WHEELS[i], width));
        strip.layers.push(path);
    }
    let head = 7.0 / strip.scale;
    for robot in robots(run, reach.end - reach.start) {
        add_robot(&mut strip.layers, run, robot, head);
    }
    strip
}

/// The heights that are shown, m: arrows below the ground, robots above it.
fn heights(run: &RunTraces, ground: &Terrain, x: &Range<f64>) -> Range<f64> {
    let ground = ground.outline(x.start, x.end, SPACING);
    let (low, high) = extremes(ground.iter().map(|p| p.y));
    let parts = run.poses.iter().flat_map(|pose| {
        let wheels = pose.wheels.iter().map(|w| w.position);
        let pins = pose.pins.iter().map(|p| p.position);
        wheels.chain(pins).chain([pose.body.position])
    });
    let top = parts.map(|p| p.y).fold(high, f64::max);
    let size = run.geometry.size();
    low - 1.6 * MEAN_LOAD_LENGTH * size..top + ABOVE[1] * size
}

/// The poses to draw on a path of a length (m): the first, and each that is far enough from the
/// last one drawn.
fn robots(run: &RunTraces, length: f64) -> Vec<&Truth> {
    let distance = (DISTANCE * run.geometry.size()).max(length / MOST);
    let mut chosen: Vec<&Truth> = Vec::new();
    for pose in &run.poses {
        let far = |last: &&Truth| (pose.body.position - last.body.position).norm() >= distance;
        if chosen.last().is_none_or(far) {
            chosen.push(pose);
        }
    }
    chosen
}

/// A robot with the arrows of its N, whose heads have a length in m, and the time above it.
fn add_robot(layers: &mut Vec<Layer>, run: &RunTraces, robot: &Truth, head: f64) {
    let unit = mean_load_length(&run.geometry);
    let body = body(&run.geometry, robot);
    layers.push(Layer::line(vec![body], line(ROBOT, 1.0)));
    let links = [Bar::Link1, Bar::Link2, Bar::Link3].map(|bar| link(run, robot, bar));
    for (wheel, color) in robot.wheels.iter().zip(WHEELS) {
        let (centre, radius) = (pair(&wheel.position), run.geometry.wheel_radius);
        layers.push(Layer::circle(centre, radius, color, 1.6));
        for contact in wheel.contact_list.iter() {
            let length = (contact.normal_force / run.mean_load).min(LONGEST) * unit;
            let (shaft, head) = arrow(contact, length, head);
            layers.push(Layer::line(vec![shaft.to_vec()], line(color, 1.6)));
            layers.push(Layer::area(head, color));
        }
    }
    layers.push(Layer::line(links.to_vec(), line(ROBOT, 2.0)));
    let parts = robot.pins.iter().map(|p| p.position.y);
    let top = parts.fold(robot.body.position.y, f64::max);
    let place = (robot.body.position.x, top + ABOVE[0] * run.geometry.size());
    layers.push(Layer::label(format!("{:.1} s", robot.time), place));
}

/// The closed outline of the body: its pins and its centre of mass; of a bogie the line from Q to
/// its centre of mass.
fn body(geometry: &Geometry, robot: &Truth) -> Vec<Point> {
    let pins = (geometry.suspension.pins().iter())
        .filter(|pin| pin.bars().0 == Bar::Body || pin.bars().1 == Bar::Body)
        .map(|pin| robot.pin(*pin).position);
    let mut corners: Vec<_> = pins.chain([robot.body.position]).collect();
    if corners.len() == 1 {
        corners.push(robot.pin(Pin::Q).position);
    }
    corners.extend(corners.first().copied());
    corners.iter().map(pair).collect()
}

/// A link as a line through the points of its outline, from rear to front of the nominal pose.
fn link(run: &RunTraces, robot: &Truth, bar: Bar) -> Vec<Point> {
    let geometry = &run.geometry;
    let (pose, cg) = (robot.bar(bar), geometry.cg(bar));
    let mut points: Vec<Vec2> = geometry.outline_points(bar).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    let placed = points
        .iter()
        .map(|point| pose.position + rotate(point - cg, pose.angle));
    placed.map(|position| pair(&position)).collect()
}

/// Shaft and head of an arrow along a contact's normal whose tip is at the contact, m.
fn arrow(contact: &ContactTruth, length: f64, head: f64) -> ([Point; 2], Vec<Point>) {
    let (tip, normal) = (contact.point, contact.normal);
    let tangent = Vec2::new(normal.y, -normal.x);
    let foot = tip - normal * length;
    let neck = tip - normal * head;
    let corners = [
        tip,
        neck + tangent * (0.5 * head),
        neck - tangent * (0.5 * head),
    ];
    (
        [pair(&foot), pair(&neck)],
        corners.iter().map(pair).collect(),
    )
}

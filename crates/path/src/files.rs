//! The files of a judged path: its table and its figure.

use crate::report::{PathReport, Place};
use crate::setup::PathSetup;
use robhaz_record::figures::style::{LINKAGE, SURFACE, TRUTH, WHEELS, line};
use robhaz_record::figures::{
    Axis, Entry, Layer, Mark, Page, Panel, SPACING, Scale, Strip, Trace, extremes, write_figure,
};
use robhaz_record::{PointColumn, RecordError, TableFormat, create_folder, write_points};
use robhaz_terrain::Terrain;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Name of the table.
const NAME: &str = "path";

const COLUMNS: &[PointColumn<Place>] = robhaz_record::point_columns! {
    Float "x", "m", "centre of the middle wheel" => |p| Some(p.wheel_x[1]);
    Float "y", "m", "centre of the middle wheel" => |p| Some(p.wheel_y[1]);
    Float "wheel1_x", "m", "centre of the front wheel" => |p| Some(p.wheel_x[0]);
    Float "wheel1_y", "m", "centre of the front wheel" => |p| Some(p.wheel_y[0]);
    Float "wheel3_x", "m", "centre of the rear wheel" => |p| Some(p.wheel_x[2]);
    Float "wheel3_y", "m", "centre of the rear wheel" => |p| Some(p.wheel_y[2]);
    Float "opening", "rad", "angle of pin Q, theta_1 - theta_2" => |p| Some(p.opening);
    Float "wheel1_contacts", "1", "contacts of the front wheel" => |p| Some(p.contacts[0] as f64);
    Float "wheel2_contacts", "1", "contacts of the middle wheel" => |p| Some(p.contacts[1] as f64);
    Float "wheel3_contacts", "1", "contacts of the rear wheel" => |p| Some(p.contacts[2] as f64);
    Optional "needed_mu", "1", "needed friction mu_n; empty where no allowed forces balance the robot" => |p| p.needed_mu;
    Optional "available_mu", "1", "available friction: mu_n plus margin" => Place::available_mu;
    Optional "margin", "1", "how far all friction coefficients can fall" => |p| p.margin;
    Optional "speed", "m/s",
        "mean speed of the wheels' centres of the driven robot; empty with the drive ideal and where it is stuck" => |p| p.speed;
    Float "clearance", "m", "least clearance of body and links to the ground; at 0 or below one touches it" =>
        |p| Some(p.clearance);
    Optional "wheel1_normal_force", "N", "sum of N of the front wheel" => |p| Some(p.normal_force?[0]);
    Optional "wheel2_normal_force", "N", "sum of N of the middle wheel" => |p| Some(p.normal_force?[1]);
    Optional "wheel3_normal_force", "N", "sum of N of the rear wheel" => |p| Some(p.normal_force?[2]);
    Optional "wheel1_traction", "N", "sum of T of the front wheel" => |p| Some(p.traction?[0]);
    Optional "wheel2_traction", "N", "sum of T of the middle wheel" => |p| Some(p.traction?[1]);
    Optional "wheel3_traction", "N", "sum of T of the rear wheel" => |p| Some(p.traction?[2]);
};

/// Files of a judged path below a folder, in one format of the table.
pub fn path_files(folder: &Path, format: TableFormat) -> Vec<PathBuf> {
    let names: &[&str] = match format {
        TableFormat::Parquet => &["path.parquet"],
        TableFormat::Csv => &["path.csv", "columns.csv"],
    };
    let names = names.iter().chain(&["figures/needed_friction.svg"]);
    names.map(|name| folder.join(name)).collect()
}

/// Writes the table `path` and the figure `needed_friction` into a folder, which is created where
/// it does not exist.
///
/// # Errors
/// [`RecordError`] of the file system and of the drawing library.
pub fn write_path(
    folder: &Path,
    format: TableFormat,
    setup: &PathSetup,
    report: &PathReport,
) -> Result<(), RecordError> {
    let figures = folder.join("figures");
    create_folder(&figures)?;
    let metadata = [
        ("scene", report.scene.clone()),
        ("drive", report.drive.to_owned()),
    ];
    write_points(folder, format, NAME, COLUMNS, &report.places, &metadata)?;
    write_needed_friction(&figures, setup, report)
}

/// Longest part of the path that is shown, m. Of a longer one it is the part around the marked
/// place.
const LONGEST: f64 = 8.0;
/// Ground shown beside the wheels, above them and below, m.
const BESIDE: f64 = 0.15;
/// Greatest height of the ground's plot, px.
const TALLEST: f64 = 320.0;
/// Height of a panel, px.
const PANEL: f64 = 130.0;

/// Writes the figure `needed_friction` into an existing folder: ground, needed against available
/// friction, margin. Without a place there is none.
fn write_needed_friction(
    folder: &Path,
    setup: &PathSetup,
    report: &PathReport,
) -> Result<(), RecordError> {
    let places = &report.places;
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return Ok(());
    };
    let decisive = decisive(report).unwrap_or(last);
    let radius = setup.robot().geometry.wheel_radius;
    let shown = shown(first, last, decisive);
    let mut strip = strip(&setup.terrain, places, &shown, radius);
    for place in [first, decisive] {
        for (i, color) in WHEELS.into_iter().enumerate() {
            let (x, y) = (place.wheel_x[i], place.wheel_y[i]);
            if strip.x.start <= x - radius && x + radius < strip.x.end {
                strip.layers.push(Layer::circle((x, y), radius, color, 1.6));
            }
        }
    }
    let range = strip.x.clone();
    let trace = |value: fn(&Place) -> Option<f64>| {
        let mut trace = Trace::new(places.len() as u64);
        for place in places.iter().filter(|p| range.contains(&p.x())) {
            trace.add(place.x(), value(place));
        }
        trace
    };
    let (needed, available) = (trace(|p| p.needed_mu), trace(Place::available_mu));
    let margin = trace(|p| p.margin);
    let friction = vec![
        Layer::dashed(&available, SURFACE),
        Layer::peaks(&needed, line(LINKAGE, 1.4)),
    ];
    let margin = vec![
        Layer::level(0.0, &range),
        Layer::peaks(&margin, line(LINKAGE, 1.4)),
    ];
    let panel = |title: &str, y_label, layers| Panel::new(title, y_label, (0.1, PANEL), layers);
    let page = Page {
        title: format!("Needed friction along the path, drive {}", report.drive),
        subtitle: verdict(report),
        key: key(std::ptr::eq(first, decisive)),
        axis: Axis::of_places("x of the middle wheel (m)", strip.x.clone()),
        // A single place decides: its peak is not cut.
        scale: Scale::Whole,
        columns: vec![vec![
            strip.panel(),
            panel("Needed and available friction", "mu_n, mu (1)", friction),
            panel(
                "Margin: how far all friction coefficients can fall",
                "margin (1)",
                margin,
            ),
        ]],
    };
    write_figure(folder, "needed_friction", &page)
}

/// The verdict in words.
fn verdict(report: &PathReport) -> String {
    match &report.first_failure {
        Some(failure) => {
            let (x, reason) = (failure.x, failure.reason.words());
            format!("no-go at x = {x:.3} m: {reason}")
        }
        None => "go".to_owned(),
    }
}

/// The key to the lines; whether the start is the decisive place.
fn key(at_start: bool) -> Vec<Entry> {
    let circles = if at_start {
        "wheels at the start"
    } else {
        "wheels (front, middle, rear) at the start, and at the decisive place"
    };
    let needed = Mark::line(line(LINKAGE, 1.4));
    let available = Mark::dashed(line(SURFACE, 1.2));
    vec![
        Entry::new(needed, "needed friction mu_n, margin"),
        Entry::new(available, "available friction mu"),
        Entry::new(Mark::line(line(TRUTH, 3.2)), "margin zero"),
        Entry {
            marks: WHEELS.map(|c| Mark::line(line(c, 1.6))).to_vec(),
            label: circles.to_owned(),
        },
    ]
}

/// The place of the first failure, otherwise that of the least margin.
fn decisive(report: &PathReport) -> Option<&Place> {
    let failing = report.places.iter().find(|p| p.failure.is_some());
    failing.or_else(|| {
        let with_margin = report.places.iter().filter(|p| p.margin.is_some());
        with_margin.min_by(|a, b| a.margin.unwrap_or(0.0).total_cmp(&b.margin.unwrap_or(0.0)))
    })
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

/// The ground that is shown, m.
fn strip(ground: &Terrain, places: &[Place], shown: &Range<f64>, radius: f64) -> Strip {
    let surface = ground.outline(shown.start, shown.end, SPACING);
    let wheels = places.iter();
    let wheels = wheels.flat_map(|p| p.wheel_x.into_iter().zip(p.wheel_y));
    let tops = wheels.filter(|(x, _)| shown.contains(x));
    let tops = tops.map(|(_, y)| y + radius);
    let heights = surface.iter().map(|p| p.y).chain(tops);
    let (low, high) = extremes(heights);
    let y = low - 0.3 * BESIDE..high + 0.3 * BESIDE;
    Strip::new(ground, shown, y, TALLEST)
}

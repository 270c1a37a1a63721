//! A judged path as a recording: the wheels along the ground, needed and available friction, margin.
//!
//! A path has places and no times. On the timeline a second stands for a metre that the middle wheel has travelled.

use crate::ViewerError;
use crate::colours::{self, NEUTRAL, WHEELS, by_index};
use crate::convert::{flat, narrow};
use crate::layout;
use crate::plot::{Line, Plot};
use crate::writer::{RrdFile, Writer};
use rerun::EntityPath;
use rerun::archetypes::{
    Ellipses2D, LineStrips2D, Points2D, RecordingInfo, TextDocument, Transform3D,
};
use rerun::components::{MediaType, Radius};
use robhaz_model::Vec2;
use robhaz_terrain::Terrain;
use std::path::Path;

/// Distance between points of the ground, m.
const SPACING: f64 = 0.005;
/// Length of drawn ground beyond the axles, m.
const BESIDE: f64 = 0.4;

/// A path that was judged before it is driven.
#[derive(Clone, Copy)]
pub struct JudgedPath<'a> {
    /// Its name.
    pub name: &'a str,
    /// The ground.
    pub terrain: &'a Terrain,
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
    /// Its places from the start on.
    pub places: &'a [PathPlace],
    /// The first place that the robot cannot pass: x of the middle wheel's centre, m, and the reason.
    pub failure: Option<(f64, &'a str)>,
    /// The result in words.
    pub text: &'a str,
}

/// A place of a judged path.
#[derive(Clone, Copy, Debug)]
pub struct PathPlace {
    /// Centres of the front, middle and rear wheel, m.
    pub wheels: [Vec2; 3],
    /// Needed friction, -; `None` where no allowed forces balance the robot.
    pub needed_mu: Option<f64>,
    /// Available friction, -.
    pub available_mu: Option<f64>,
    /// How far all friction coefficients can fall, -.
    pub margin: Option<f64>,
}

/// Writes a judged path as a new recording at `out`, with the layout of its views.
///
/// # Errors
/// [`ViewerError::Create`], [`ViewerError::Write`]: `out` cannot be written.
pub fn save_path(path: &JudgedPath<'_>, out: &Path) -> Result<(), ViewerError> {
    let destination = out.display().to_string();
    let file = RrdFile::begin(RrdFile::create(out)?).map_err(ViewerError::write(&destination))?;
    let mut writer = Writer::start(&destination, Box::new(file), path.name, fingerprint(path))?;
    let ground = ground(path);
    layout::path::log(&mut writer, &ground)?;
    writer.constant(
        EntityPath::properties(),
        &RecordingInfo::update_fields().with_name(path.name),
    )?;
    let page = TextDocument::new(page(path));
    writer.constant("about", &page.with_media_type(MediaType::markdown()))?;
    // The viewer's 2-D axes have y down.
    writer.constant("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
    writer.constant(
        "world/ground",
        &LineStrips2D::new([ground.iter().copied().map(flat).collect::<Vec<_>>()])
            .with_colors([colours::GROUND])
            .with_radii([Radius::new_ui_points(1.5)]),
    )?;
    let travelled = travelled(path);
    log_wheels(&mut writer, path, &travelled)?;
    log_failure(&mut writer, path)?;
    log_friction(&mut writer, path, &travelled)?;
    writer.finish()
}

/// The ground from behind the rear wheel at the start to ahead of the front wheel at the end, m.
fn ground(path: &JudgedPath<'_>) -> Vec<Vec2> {
    let (Some(first), Some(last)) = (path.places.first(), path.places.last()) else {
        return Vec::new();
    };
    let (from, to) = (first.wheels[2].x - BESIDE, last.wheels[0].x + BESIDE);
    path.terrain.outline(from, to, SPACING)
}

/// Distance that the middle wheel has travelled at each place, m.
fn travelled(path: &JudgedPath<'_>) -> Vec<f64> {
    let start = path.places.first().map_or(0.0, |p| p.wheels[1].x);
    let places = path.places.iter();
    places.map(|p| p.wheels[1].x - start).collect()
}

fn log_wheels(
    out: &mut Writer,
    path: &JudgedPath<'_>,
    travelled: &[f64],
) -> Result<(), ViewerError> {
    let radius = narrow(path.wheel_radius);
    out.constant(
        "world/wheels",
        &Ellipses2D::update_fields()
            .with_half_sizes([[radius, radius]; 3])
            .with_colors(WHEELS)
            .with_line_radii([Radius::new_ui_points(2.5)]),
    )?;
    let centres = path.places.iter().flat_map(|p| p.wheels);
    out.columns(
        "world/wheels",
        travelled,
        Ellipses2D::update_fields()
            .with_centers(centres.map(flat))
            .columns(std::iter::repeat_n(WHEELS.len(), travelled.len())),
    )
}

/// Marks the place of the first failure, below the middle wheel.
fn log_failure(out: &mut Writer, path: &JudgedPath<'_>) -> Result<(), ViewerError> {
    let Some((x, reason)) = path.failure else {
        return Ok(());
    };
    let below = path.terrain.outline(x, x, SPACING);
    let Some(point) = below.first().copied() else {
        return Ok(());
    };
    out.constant(
        "world/failure",
        &Points2D::new([flat(point)])
            .with_colors([NEUTRAL])
            .with_radii([Radius::new_ui_points(6.0)])
            .with_labels([format!("no-go: {reason}")])
            .with_show_labels(true),
    )
}

fn log_friction(
    out: &mut Writer,
    path: &JudgedPath<'_>,
    travelled: &[f64],
) -> Result<(), ViewerError> {
    let mut friction = Plot::new(
        "series/path/friction",
        vec![
            Line::of_width("available mu [-]", NEUTRAL, Line::WIDE),
            Line::estimate("needed mu_n [-]", by_index(0)),
        ],
    );
    let mut margin = Plot::new(
        "series/path/margin",
        vec![
            Line::of_width("margin zero [-]", NEUTRAL, Line::WIDE),
            Line::estimate("margin [-]", by_index(0)),
        ],
    );
    // A gap: no allowed forces balance the robot.
    let or_gap = |value: Option<f64>| value.unwrap_or(f64::NAN);
    for (place, distance) in path.places.iter().zip(travelled) {
        let pair = [place.available_mu, place.needed_mu];
        friction.push(*distance, pair.map(or_gap));
        margin.push(*distance, [0.0, or_gap(place.margin)]);
    }
    friction.flush(out)?;
    margin.flush(out)
}

/// The page that explains the recording.
fn page(path: &JudgedPath<'_>) -> String {
    let JudgedPath { name, text, .. } = path;
    format!(
        "# The {name}\n\n\
         - Judged before it is driven; nothing here is simulated.\n\
         - A path has no times: a second of the timeline stands for a metre that the middle wheel has travelled.\n\
         - Wheels: front blue, middle vermilion, rear green.\n\
         - Needed friction mu_n: narrow line; available friction mu and margin zero: wide grey lines. A gap is a place where \
         no allowed forces balance the robot.\n\n\
         ```text\n{text}\n```\n"
    )
}

/// A number that distinguishes judgements of the same name.
fn fingerprint(path: &JudgedPath<'_>) -> u64 {
    let values = path.places.iter().flat_map(|p| {
        let or_gap = |value: Option<f64>| value.unwrap_or(f64::NAN);
        [
            p.wheels[1].x,
            p.wheels[1].y,
            or_gap(p.needed_mu),
            or_gap(p.margin),
        ]
    });
    values.fold(0, |all: u64, value| {
        all.rotate_left(5).wrapping_mul(31) ^ value.to_bits()
    })
}

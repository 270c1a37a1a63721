//! The scene in 2-D: ground, robot, contacts, forces, trails.
//!
//! Shapes are logged once; what moves is a pose a part and a few points and arrows, in columns.

use crate::ViewerError;
use crate::colours::{self, Colour};
use crate::rrd::RrdWriter;
use crate::shapes;
use re_sdk_types::archetypes::{Arrows2D, Ellipses2D, LineStrips2D, Points2D, Transform3D};
use re_sdk_types::components::Radius;
use re_sdk_types::datatypes::Quaternion;
use robhaz_estimator::Estimate;
use robhaz_model::{Bar, Pin, Robot, Vec2};
use robhaz_run::Frame;
use robhaz_scene::Scene;
use robhaz_sim::{Truth, WheelTruth};
use robhaz_terrain::Terrain;

/// Length of the arrow of a mean static wheel load, m.
const MEAN_LOAD_LENGTH: f64 = 0.15;
/// Estimated arrows stand this far beside the true ones, m.
const BESIDE: f64 = 0.025;
/// Spacing of the ground's points, m.
const GROUND_SPACING: f64 = 0.005;
/// Ground is drawn this far beyond where the wheels' axles go, m.
const GROUND_MARGIN: f64 = 0.4;
/// Every so many frames the trails get a new piece: 20 Hz at 60 frames a second.
const FRAMES_PER_TRAIL: u32 = 3;
/// What is seen around the body in the following view, m: half the width, above, below.
pub(crate) const FOLLOWED: [f32; 3] = [0.62, 0.32, 0.58];

/// How long the arrow of a force is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ForceScale {
    mean_load: f64,
}

impl ForceScale {
    /// The scale at which a robot's mean static wheel load is 0.15 m long.
    pub(crate) fn new(robot: &Robot) -> Self {
        Self {
            mean_load: robot.mean_wheel_load(),
        }
    }

    /// Force that is 1 m long, N.
    pub(crate) fn newtons_per_metre(self) -> f64 {
        self.mean_load / MEAN_LOAD_LENGTH
    }

    /// Length of a force, m.
    fn length(self, force: f64) -> f64 {
        force / self.newtons_per_metre()
    }
}

/// What a frame of the animation shows.
struct Snapshot {
    truth: Truth,
    given_angle: [Option<f64>; 3],
    estimate: Option<Estimate>,
    /// Pieces of the trails that end here: from, to.
    trails: Vec<[Vec2; 2]>,
}

/// The animated scene of a run.
pub(crate) struct SceneView {
    robot: Robot,
    terrain: Terrain,
    scale: ForceScale,
    /// Stretch of the ground that is drawn so far, and the one that the robot covers; m.
    drawn: (f64, f64),
    covered: (f64, f64),
    frames: u32,
    trail_ends: Option<[Vec2; 4]>,
    snapshots: Vec<Snapshot>,
}

impl SceneView {
    /// The view of a scene; nothing is logged yet.
    pub(crate) fn new(scene: &Scene) -> Self {
        let robot = scene.robot.robot.clone();
        let axles = &robot.geometry.axles;
        let drawn = (
            axles[2].x - GROUND_MARGIN,
            axles[0].x + planned_travel(scene) + GROUND_MARGIN,
        );
        Self {
            terrain: Terrain::new(scene.terrain.profile.clone()),
            scale: ForceScale::new(&robot),
            robot,
            drawn,
            covered: drawn,
            frames: 0,
            trail_ends: None,
            snapshots: Vec::new(),
        }
    }

    /// The scale of the arrows.
    pub(crate) fn scale(&self) -> ForceScale {
        self.scale
    }

    /// The stretch of ground that the run is planned to cover, m: from, to, lowest, highest.
    pub(crate) fn ground_box(&self) -> [f64; 4] {
        let (from, to) = self.drawn;
        let heights = self
            .terrain
            .outline(from, to, GROUND_SPACING)
            .into_iter()
            .map(|p| p.y);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        [from, to, low, high]
    }

    /// Logs all that does not move. `estimator` names the source of the estimated arrows.
    pub(crate) fn declare(
        &self,
        out: &mut RrdWriter,
        estimator: Option<&str>,
    ) -> Result<(), ViewerError> {
        // The viewer's 2-D axes have y down.
        out.constant("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
        self.draw_ground(out)?;
        self.declare_bars(out)?;
        self.declare_wheels(out)?;
        out.constant(
            "world/robot/pins",
            &Points2D::update_fields()
                .with_labels(["P", "Q", "R", "S"])
                .with_colors(colours::PINS)
                .with_radii([Radius::new_ui_points(5.0)]),
        )?;
        out.constant(
            "world/trails",
            &LineStrips2D::update_fields()
                .with_colors(colours::PINS)
                .with_radii([Radius::new_ui_points(0.75)]),
        )?;
        out.constant(
            "world/robot/contacts",
            &Points2D::update_fields().with_radii([Radius::new_ui_points(4.0)]),
        )?;
        for (source, light) in [("true", false), ("estimated", true)] {
            for force in ["normal", "traction"] {
                out.constant(
                    format!("world/forces/{source}/{force}"),
                    &arrow_style(colours::WHEELS, light),
                )?;
            }
        }
        self.declare_legend(out, estimator)
    }

    /// Adds one frame of the animation.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, chosen: Option<usize>) {
        let truth = *frame.truth;
        for wheel in &truth.wheels {
            self.covered.0 = self.covered.0.min(wheel.position.x - GROUND_MARGIN);
            self.covered.1 = self.covered.1.max(wheel.position.x + GROUND_MARGIN);
        }
        let trails = self.next_trails(&truth);
        self.snapshots.push(Snapshot {
            truth,
            given_angle: frame.sensors.contact_angle,
            estimate: chosen.and_then(|k| frame.estimates[k].ok()),
            trails,
        });
    }

    /// Logs the frames that have come since the last time.
    pub(crate) fn flush(&mut self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        self.extend_ground(out)?;
        let frames = std::mem::take(&mut self.snapshots);
        let times: Vec<f64> = frames.iter().map(|f| f.truth.time).collect();
        for bar in Bar::ALL {
            let pose = |f: &Snapshot| (f.truth.bar(bar).position, f.truth.bar(bar).angle);
            log_poses(out, &bar_entity(bar), &times, frames.iter().map(pose))?;
        }
        for i in 0..3 {
            let carrier = self.robot.geometry.carriers[i].bar();
            let pose = |f: &Snapshot| {
                let wheel = &f.truth.wheels[i];
                // The spin is relative to the link and positive when it rolls forward, clockwise.
                (wheel.position, f.truth.bar(carrier).angle - wheel.angle)
            };
            log_poses(out, &wheel_entity(i), &times, frames.iter().map(pose))?;
        }
        log_follower(out, &times, &frames)?;
        self.log_points(out, &times, &frames)?;
        self.log_arrows(out, &times, &frames)
    }

    /// Draws more ground where the robot went farther than planned; more than needed, so that this stays rare.
    fn extend_ground(&mut self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let (from, to) = self.covered;
        let more = 0.25 * (to - from);
        let (backward, forward) = (from < self.drawn.0, to > self.drawn.1);
        if backward {
            self.drawn.0 = from - more;
        }
        if forward {
            self.drawn.1 = to + more;
        }
        if backward || forward {
            self.draw_ground(out)?;
        }
        Ok(())
    }

    fn draw_ground(&self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let (from, to) = self.drawn;
        let points = self.terrain.outline(from, to, GROUND_SPACING);
        out.constant(
            "world/ground",
            &LineStrips2D::new([points.into_iter().map(flat)])
                .with_colors([colours::GROUND])
                .with_radii([Radius::new_ui_points(1.5)]),
        )
    }

    fn declare_bars(&self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let geometry = &self.robot.geometry;
        let links = [Bar::Link1, Bar::Link2, Bar::Link3];
        for (bar, colour) in links.into_iter().zip(colours::LINKS) {
            draw_strip(out, bar, shapes::link(geometry, bar), colour, 2.5)?;
        }
        let body = shapes::body(geometry, &self.robot.mass);
        draw_strip(out, Bar::Body, body, colours::BODY, 1.5)
    }

    fn declare_wheels(&self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let radius = self.robot.geometry.wheel_radius;
        let half = narrow(radius);
        for (i, colour) in colours::WHEELS.into_iter().enumerate() {
            out.constant(
                format!("{}/rim", wheel_entity(i)),
                &Ellipses2D::update_fields()
                    .with_half_sizes([[half, half]])
                    .with_colors([colour])
                    .with_line_radii([Radius::new_ui_points(1.5)]),
            )?;
            out.constant(
                format!("{}/spokes", wheel_entity(i)),
                &LineStrips2D::new(shapes::spokes(radius).into_iter().map(|s| s.map(flat)))
                    .with_colors([colour])
                    .with_radii([Radius::new_ui_points(0.75)]),
            )?;
        }
        Ok(())
    }

    /// What the arrows mean and how long they are, in the corner of the following view.
    fn declare_legend(
        &self,
        out: &mut RrdWriter,
        estimator: Option<&str>,
    ) -> Result<(), ViewerError> {
        let load = self.scale.mean_load;
        let mut rows = vec![("true", format!("true: this long is {load:.0} N"))];
        rows.extend(estimator.map(|name| ("estimated", format!("estimated by {name}"))));
        let [half_width, above, _] = FOLLOWED;
        let mut y = 0.05 - above;
        for (source, label) in rows {
            // This frame has y down, like the view.
            let origin = [0.05 - half_width, y];
            out.constant(
                format!("world/follow/legend/{source}"),
                &arrow_style([colours::NEUTRAL], source == "estimated")
                    .with_origins([origin])
                    .with_vectors([[narrow(MEAN_LOAD_LENGTH), 0.0]])
                    .with_labels([label])
                    .with_show_labels(true),
            )?;
            y += 0.06;
        }
        Ok(())
    }

    fn next_trails(&mut self, truth: &Truth) -> Vec<[Vec2; 2]> {
        let due = self.frames.is_multiple_of(FRAMES_PER_TRAIL);
        self.frames = self.frames.wrapping_add(1);
        if !due {
            return Vec::new();
        }
        let now = truth.pins.map(|pin| pin.position);
        let before = self.trail_ends.replace(now).unwrap_or(now);
        before.into_iter().zip(now).map(|(a, b)| [a, b]).collect()
    }

    fn log_points(
        &self,
        out: &mut RrdWriter,
        times: &[f64],
        frames: &[Snapshot],
    ) -> Result<(), ViewerError> {
        let pins = frames.iter().flat_map(|f| f.truth.pins);
        out.columns(
            "world/robot/pins",
            times,
            Points2D::update_fields()
                .with_positions(pins.map(|p| flat(p.position)))
                .columns(std::iter::repeat_n(Pin::ALL.len(), times.len())),
        )?;

        // A wheel in the air has no contact point, so that colours come with the points.
        let touching = |f: &Snapshot| {
            let wheels = f.truth.wheels.into_iter().zip(colours::WHEELS);
            wheels.filter(|(w, _)| w.contacts > 0).collect::<Vec<_>>()
        };
        let touching: Vec<_> = frames.iter().map(touching).collect();
        let radius = self.robot.geometry.wheel_radius;
        let all = || touching.iter().flatten();
        out.columns(
            "world/robot/contacts",
            times,
            Points2D::update_fields()
                .with_positions(all().map(|(w, _)| flat(contact_point(w, radius))))
                .with_colors(all().map(|(_, colour)| *colour))
                .columns(touching.iter().map(Vec::len)),
        )?;

        let with_trails: Vec<_> = frames.iter().filter(|f| !f.trails.is_empty()).collect();
        let times: Vec<f64> = with_trails.iter().map(|f| f.truth.time).collect();
        let pieces = with_trails.iter().flat_map(|f| &f.trails);
        out.columns(
            "world/trails",
            &times,
            LineStrips2D::update_fields()
                .with_strips(pieces.map(|piece| piece.map(flat)))
                .columns(std::iter::repeat_n(Pin::ALL.len(), times.len())),
        )
    }

    fn log_arrows(
        &self,
        out: &mut RrdWriter,
        times: &[f64],
        frames: &[Snapshot],
    ) -> Result<(), ViewerError> {
        let radius = self.robot.geometry.wheel_radius;
        let (mut true_n, mut true_t) = (Arrows::default(), Arrows::default());
        let (mut estimated_n, mut estimated_t) = (Arrows::default(), Arrows::default());
        for frame in frames {
            let estimate = frame.estimate.as_ref();
            for i in 0..3 {
                let wheel = &frame.truth.wheels[i];
                let point = contact_point(wheel, radius);
                let (t, n) = tangent_and_normal(wheel.contact_angle);
                true_n.push_into(point, n * self.scale.length(wheel.normal_force));
                true_t.push_from(point, t * self.scale.length(wheel.traction));
                if let (Some(estimate), Some(angle)) = (estimate, frame.given_angle[i]) {
                    let (t, n) = tangent_and_normal(angle);
                    let (normal, traction) = (estimate.normal_force[i], estimate.traction[i]);
                    estimated_n.push_into(point - t * BESIDE, n * self.scale.length(normal));
                    estimated_t.push_from(point - n * BESIDE, t * self.scale.length(traction));
                }
            }
            true_n.end_row();
            true_t.end_row();
            estimated_n.end_row();
            estimated_t.end_row();
        }
        true_n.log(out, "world/forces/true/normal", times)?;
        true_t.log(out, "world/forces/true/traction", times)?;
        estimated_n.log(out, "world/forces/estimated/normal", times)?;
        estimated_t.log(out, "world/forces/estimated/traction", times)
    }
}

/// Arrows of several times: some in a row, or none.
#[derive(Default)]
struct Arrows {
    origins: Vec<[f32; 2]>,
    vectors: Vec<[f32; 2]>,
    rows: Vec<usize>,
    before: usize,
}

impl Arrows {
    fn push_from(&mut self, origin: Vec2, vector: Vec2) {
        self.origins.push(flat(origin));
        self.vectors.push(flat(vector));
    }

    /// An arrow whose head is at a point: under the ground there is room for it.
    fn push_into(&mut self, head: Vec2, vector: Vec2) {
        self.push_from(head - vector, vector);
    }

    fn end_row(&mut self) {
        self.rows.push(self.origins.len() - self.before);
        self.before = self.origins.len();
    }

    fn log(self, out: &mut RrdWriter, entity: &str, times: &[f64]) -> Result<(), ViewerError> {
        let columns = Arrows2D::update_fields()
            .with_origins(self.origins)
            .with_vectors(self.vectors)
            .columns(self.rows);
        out.columns(entity, times, columns)
    }
}

fn arrow_style(colours: impl IntoIterator<Item = Colour>, light: bool) -> Arrows2D {
    let shade = move |c: Colour| if light { c.light() } else { c };
    let radius = if light { 1.25 } else { 2.5 };
    Arrows2D::update_fields()
        .with_colors(colours.into_iter().map(shade))
        .with_radii([Radius::new_ui_points(radius)])
}

fn draw_strip(
    out: &mut RrdWriter,
    bar: Bar,
    points: Vec<Vec2>,
    colour: Colour,
    radius: f32,
) -> Result<(), ViewerError> {
    out.constant(
        bar_entity(bar),
        &LineStrips2D::new([points.into_iter().map(flat)])
            .with_colors([colour])
            .with_radii([Radius::new_ui_points(radius)]),
    )
}

fn log_poses(
    out: &mut RrdWriter,
    entity: &str,
    times: &[f64],
    poses: impl Iterator<Item = (Vec2, f64)> + Clone,
) -> Result<(), ViewerError> {
    let columns = Transform3D::update_fields()
        .with_many_translation(poses.clone().map(|(position, _)| deep(position)))
        .with_many_quaternion(poses.map(|(_, angle)| turn(angle)));
    out.columns(entity, times, columns.columns_of_unit_batches())
}

/// A frame at the body's centre of mass that stays upright; mirrored back, so that a view can have it as origin.
fn log_follower(
    out: &mut RrdWriter,
    times: &[f64],
    frames: &[Snapshot],
) -> Result<(), ViewerError> {
    let columns = Transform3D::update_fields()
        .with_many_translation(frames.iter().map(|f| deep(f.truth.body.position)))
        .with_many_scale(std::iter::repeat_n([1.0_f32, -1.0, 1.0], frames.len()));
    out.columns("world/follow", times, columns.columns_of_unit_batches())
}

fn bar_entity(bar: Bar) -> String {
    format!("world/robot/{}", bar.name())
}

fn wheel_entity(wheel: usize) -> String {
    format!("world/robot/wheel{}", wheel + 1)
}

/// How far the robot goes if its wheels do what they are told, m.
fn planned_travel(scene: &Scene) -> f64 {
    let time = scene.record.duration - scene.drive.start_time - 0.5 * scene.drive.ramp_time;
    scene.drive.speed.max(0.0) * time.max(0.0)
}

fn contact_point(wheel: &WheelTruth, radius: f64) -> Vec2 {
    let (_, normal) = tangent_and_normal(wheel.contact_angle);
    wheel.position - normal * (radius - wheel.penetration)
}

fn tangent_and_normal(angle: f64) -> (Vec2, Vec2) {
    let (sin, cos) = angle.sin_cos();
    (Vec2::new(cos, sin), Vec2::new(-sin, cos))
}

fn turn(angle: f64) -> Quaternion {
    let (sin, cos) = (0.5 * angle).sin_cos();
    Quaternion::from_xyzw([0.0, 0.0, narrow(sin), narrow(cos)])
}

fn flat(v: Vec2) -> [f32; 2] {
    [narrow(v.x), narrow(v.y)]
}

fn deep(v: Vec2) -> [f32; 3] {
    [narrow(v.x), narrow(v.y), 0.0]
}

/// To the viewer's precision: 1 um at 10 m.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the viewer draws in single precision"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a slope of 90 deg to the left the ground is ahead of the wheel, and the normal points back at it.
    #[test]
    fn the_contact_point_is_the_arm_away_from_the_centre() {
        let wheel = WheelTruth {
            position: Vec2::new(1.0, 0.5),
            contact_angle: std::f64::consts::FRAC_PI_2,
            penetration: 0.001,
            ..WheelTruth::default()
        };
        let found = contact_point(&wheel, 0.1);
        assert!((found - Vec2::new(1.099, 0.5)).norm() < 1e-12);
    }

    #[test]
    fn the_mean_load_is_fifteen_centimetres_long() {
        let robot = Robot::default_a();
        let scale = ForceScale::new(&robot);
        assert!((scale.length(robot.mean_wheel_load()) - 0.15).abs() < 1e-12);
    }
}

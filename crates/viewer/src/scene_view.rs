//! The animation in 2-D: ground, robot, end stops, contacts, forces, paths of the pins.
//!
//! Shapes are logged once. Moving parts are logged as one pose for each frame; contacts, pins and
//! forces as points and arrows.

use crate::ViewerError;
use crate::colours::{self, Colour};
use crate::convert::{deep, flat, narrow, turn};
use crate::forces::Forces;
use crate::ground::Ground;
use crate::rows::Strips;
use crate::scale;
use crate::shapes;
use crate::writer::Writer;
use rerun::archetypes::{Ellipses2D, LineStrips2D, Points2D, Transform3D};
use rerun::components::Radius;
use robhaz_model::{Bar, Robot, Vec2};
use robhaz_run::{Frame, RunDescription};
use robhaz_scene::Scene;
use robhaz_sim::Truth;

/// Number of frames for one piece of a trail: 20 pieces per second at 60 Hz.
const FRAMES_PER_TRAIL: u32 = 3;
/// Visible range around the body in the view that moves with it, m: half the width, above, below.
pub(crate) const FOLLOWED: [f64; 3] = [0.62, 0.32, 0.58];

/// The animation of a run, with what is not logged yet.
pub(crate) struct SceneView {
    robot: Robot,
    ground: Ground,
    forces: Forces,
    /// Index of the estimator that is drawn.
    chosen: Option<usize>,
    frames: u32,
    trail_ends: Option<Vec<Vec2>>,
    /// Times of the frames, s.
    times: Vec<f64>,
    /// Positions (m) and angles (rad) of the bars, then of the wheels.
    poses: [Vec<(Vec2, f64)>; 7],
    pins: Vec<[f32; 2]>,
    /// Contact points, m, with the colours of the wheels, and their number in each frame.
    contacts: Vec<(Vec2, Colour)>,
    contact_counts: Vec<usize>,
    trails: Strips,
}

impl SceneView {
    /// The animation of a simulation. `chosen` is the index of the estimator that is drawn.
    pub(crate) fn new(run: &RunDescription, world: &Scene, chosen: Option<usize>) -> Self {
        let robot = run.robot.robot.clone();
        let estimator = chosen.map(|k| (k, run.estimators[k].label.clone()));
        Self {
            ground: Ground::new(run, world),
            forces: Forces::new(&robot, estimator),
            robot,
            chosen,
            frames: 0,
            trail_ends: None,
            times: Vec::new(),
            poses: Default::default(),
            pins: Vec::new(),
            contacts: Vec::new(),
            contact_counts: Vec::new(),
            trails: Strips::default(),
        }
    }

    /// Logs everything that does not move.
    pub(crate) fn declare(&self, out: &mut Writer) -> Result<(), ViewerError> {
        // The viewer's 2-D axes have y down.
        out.constant("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
        self.ground.draw(out)?;
        self.declare_bars(out)?;
        self.declare_wheels(out)?;
        self.declare_stops(out)?;
        out.constant(
            "world/robot/pins",
            &Points2D::update_fields()
                .with_labels(["P", "Q", "R", "S"])
                .with_colors([colours::PIN])
                .with_radii([Radius::new_ui_points(4.0)]),
        )?;
        out.constant(
            "world/trails",
            &LineStrips2D::update_fields()
                .with_colors([colours::TRAIL])
                .with_radii([Radius::new_ui_points(0.75)]),
        )?;
        out.constant(
            "world/robot/contacts",
            &Points2D::update_fields().with_radii([Radius::new_ui_points(4.0)]),
        )?;
        let [from, to, low, _] = self.ground.box_of();
        scale::log_axis(out, [from, to, low])?;
        let [half_width, above, _] = FOLLOWED;
        self.forces.declare(out, [0.12 - half_width, 0.05 - above])
    }

    /// Adds one frame of the animation with its truth.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, truth: &Truth) {
        self.ground.cover(truth);
        self.times.push(truth.time);
        let bars = Bar::ALL.map(|bar| (truth.bar(bar).position, truth.bar(bar).angle));
        let wheels = (truth.wheels.iter().zip(self.robot.geometry.carriers)).map(|(wheel, c)| {
            // The spin is relative to the link and positive when it rolls forward, clockwise.
            (wheel.position, truth.bar(c.bar()).angle - wheel.angle)
        });
        for (poses, pose) in self.poses.iter_mut().zip(bars.into_iter().chain(wheels)) {
            poses.push(pose);
        }
        let pins = self.robot.geometry.suspension.pins().iter();
        let pins: Vec<Vec2> = pins.map(|pin| truth.pin(*pin).position).collect();
        self.pins.extend(pins.iter().copied().map(flat));
        let before = self.contacts.len();
        for (wheel, colour) in truth.wheels.iter().zip(colours::WHEELS) {
            let points = wheel.contact_list.iter().map(|c| (c.point, colour));
            self.contacts.extend(points);
        }
        self.contact_counts.push(self.contacts.len() - before);
        if self.frames.is_multiple_of(FRAMES_PER_TRAIL) {
            let before = self.trail_ends.replace(pins.clone());
            let before = before.unwrap_or_else(|| pins.clone());
            let pieces = before.into_iter().zip(pins).map(|(a, b)| [a, b]);
            self.trails.push(truth.time, pieces);
        }
        self.frames = self.frames.wrapping_add(1);
        let estimate = self.chosen.and_then(|k| frame.estimates[k].as_ref().ok());
        self.forces
            .push(truth, &frame.sensors.contact_angle, estimate);
    }

    /// Logs the frames that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
        self.ground.extend(out)?;
        let times = std::mem::take(&mut self.times);
        // The frame that moves with the body: at its centre of mass, not rotated, y down as a view
        // needs it.
        let body = self.poses[Bar::Body as usize].iter();
        let columns = Transform3D::update_fields()
            .with_many_translation(body.map(|(position, _)| deep(*position)))
            .with_many_scale(std::iter::repeat_n([1.0_f32, -1.0, 1.0], times.len()));
        out.columns("world/follow", &times, columns.columns_of_unit_batches())?;
        let entities = Bar::ALL.map(bar_entity).into_iter();
        let entities = entities.chain([0, 1, 2].map(wheel_entity));
        for (entity, poses) in entities.zip(&mut self.poses) {
            let poses = std::mem::take(poses);
            let columns = Transform3D::update_fields()
                .with_many_translation(poses.iter().map(|(position, _)| deep(*position)))
                .with_many_quaternion(poses.iter().map(|(_, angle)| turn(*angle)));
            out.columns(entity, &times, columns.columns_of_unit_batches())?;
        }
        let pins = Points2D::update_fields().with_positions(self.pins.drain(..));
        let count = self.robot.geometry.suspension.pins().len();
        let counts = std::iter::repeat_n(count, times.len());
        out.columns("world/robot/pins", &times, pins.columns(counts))?;
        let contacts = std::mem::take(&mut self.contacts);
        let points = Points2D::update_fields()
            .with_positions(contacts.iter().map(|(point, _)| flat(*point)))
            .with_colors(contacts.iter().map(|(_, colour)| *colour));
        let counts = std::mem::take(&mut self.contact_counts);
        out.columns("world/robot/contacts", &times, points.columns(counts))?;
        self.trails.flush(out, "world/trails")?;
        self.forces.flush(out, &times)
    }

    fn declare_bars(&self, out: &mut Writer) -> Result<(), ViewerError> {
        let geometry = &self.robot.geometry;
        let links = [Bar::Link1, Bar::Link2, Bar::Link3];
        for (bar, colour) in links.into_iter().zip(colours::LINKS) {
            draw_strip(out, bar, shapes::link(geometry, bar), colour, 2.5)?;
        }
        let body = shapes::body(geometry, &self.robot.mass);
        draw_strip(out, Bar::Body, body, colours::BODY, 1.5)
    }

    fn declare_wheels(&self, out: &mut Writer) -> Result<(), ViewerError> {
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

    /// Logs the arc between the end stops, which is fixed to link 2.
    fn declare_stops(&self, out: &mut Writer) -> Result<(), ViewerError> {
        let strips = shapes::stops(&self.robot.geometry);
        out.constant(
            "world/robot/link2/stops",
            &LineStrips2D::new(strips.map(|strip| strip.into_iter().map(flat).collect::<Vec<_>>()))
                .with_colors([colours::NEUTRAL])
                .with_radii([Radius::new_ui_points(0.75)]),
        )
    }
}

fn draw_strip(
    out: &mut Writer,
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

fn bar_entity(bar: Bar) -> String {
    format!("world/robot/{}", bar.name())
}

fn wheel_entity(wheel: usize) -> String {
    format!("world/robot/wheel{}", wheel + 1)
}

//! The animation in 2-D: ground, robot, end stops, contacts, forces, paths of the pins.
//!
//! Shapes are logged once. Moving parts are logged as one pose for each frame; contacts, pins and forces as points and
//! arrows.

use crate::ViewerError;
use crate::colours::{self, Colour};
use crate::convert::{deep, flat, narrow, turn};
use crate::forces::{ForceScale, Forces, Shown};
use crate::ground::Ground;
use crate::scale;
use crate::shapes;
use crate::writer::Writer;
use rerun::archetypes::{Ellipses2D, LineStrips2D, Points2D, Transform3D};
use rerun::components::Radius;
use robhaz_estimator::Estimate;
use robhaz_model::{Bar, Pin, Robot, Vec2};
use robhaz_run::{Frame, RunDescription, World};
use robhaz_score::events::EndStop;
use robhaz_sim::Truth;

/// Number of frames for one piece of a trail: 20 pieces per second at 60 Hz.
const FRAMES_PER_TRAIL: u32 = 3;
/// Visible range around the body in the view that moves with it, m: half the width, above, below.
pub(crate) const FOLLOWED: [f64; 3] = [0.62, 0.32, 0.58];

/// One frame of the animation.
struct Snapshot {
    truth: Truth,
    given_angle: [Option<f64>; 3],
    estimate: Option<Estimate>,
    /// Contact points, m, with the colours of the wheels.
    contacts: Vec<(Vec2, Colour)>,
    /// Pieces of the trails that end at this frame, m: start and end.
    trails: Vec<[Vec2; 2]>,
}

/// The animation of a run.
pub(crate) struct SceneView {
    robot: Robot,
    ground: Ground,
    forces: Forces,
    /// Index of the estimator that is drawn.
    chosen: Option<usize>,
    frames: u32,
    trail_ends: Option<[Vec2; 4]>,
    /// The end stop that is highlighted.
    shown_stop: Option<&'static str>,
    snapshots: Vec<Snapshot>,
}

impl SceneView {
    /// The animation of a simulation. `chosen` is the index of the estimator that is drawn.
    pub(crate) fn new(run: &RunDescription, world: &World, chosen: Option<usize>) -> Self {
        let robot = run.robot.robot.clone();
        let estimator = chosen.map(|k| (k, run.estimators[k].label.clone()));
        Self {
            ground: Ground::new(run, world),
            forces: Forces::new(&robot, estimator),
            robot,
            chosen,
            frames: 0,
            trail_ends: None,
            shown_stop: None,
            snapshots: Vec::new(),
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
        scale::log_axis(out, self.ground.box_of(), ForceScale::new(&self.robot))?;
        let [half_width, above, below] = FOLLOWED;
        scale::log_bar(out, [half_width - 0.16, below - 0.14])?;
        self.forces.declare(out, [0.12 - half_width, 0.05 - above])
    }

    /// Adds one frame of the animation with its truth.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, truth: &Truth) {
        let truth = *truth;
        self.ground.cover(&truth);
        let trails = self.next_trails(&truth);
        self.snapshots.push(Snapshot {
            truth,
            given_angle: frame.sensors.contact_angle,
            estimate: self.chosen.and_then(|k| frame.estimates[k].ok()),
            contacts: contact_points(&truth),
            trails,
        });
    }

    /// Logs the frames that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
        self.ground.extend(out)?;
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
        log_points(out, &times, &frames)?;
        log_trails(out, &frames)?;
        self.log_stop(out, &frames)?;
        let shown = frames.iter().map(|f| Shown {
            truth: &f.truth,
            given_angle: &f.given_angle,
            estimate: f.estimate.as_ref(),
        });
        self.forces.log(out, &times, shown)
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
            STOPS,
            &LineStrips2D::new(strips.map(|strip| strip.into_iter().map(flat).collect::<Vec<_>>()))
                .with_colors([colours::NEUTRAL])
                .with_radii([Radius::new_ui_points(0.75)]),
        )?;
        out.constant(
            format!("{STOPS}/reached"),
            &LineStrips2D::update_fields()
                .with_colors([colours::PIN])
                .with_radii([Radius::new_ui_points(3.0)])
                .with_show_labels(true),
        )
    }

    /// Logs an end stop as reached while it has a torque.
    fn log_stop(&mut self, out: &mut Writer, frames: &[Snapshot]) -> Result<(), ViewerError> {
        let geometry = &self.robot.geometry;
        let [_, lower, upper] = shapes::stops(geometry);
        let reached = |f: &Snapshot| {
            let angle = f.truth.links[0].angle - f.truth.links[1].angle;
            (f.truth.stop_torque.abs() > 0.0)
                .then(|| EndStop::nearest(&geometry.stop, angle).name())
        };
        let (mut changes, mut times) = (Vec::new(), Vec::new());
        for frame in frames {
            let now = reached(frame);
            if now != self.shown_stop {
                self.shown_stop = now;
                changes.push(now);
                times.push(frame.truth.time);
            }
        }
        let names = || changes.iter().flatten();
        let strips = names().map(|name| if *name == "upper" { &upper } else { &lower });
        let strips = strips.map(|strip| strip.iter().copied().map(flat).collect::<Vec<_>>());
        out.columns(
            format!("{STOPS}/reached"),
            &times,
            LineStrips2D::update_fields()
                .with_strips(strips)
                .with_labels(names().map(|name| format!("{name} stop")))
                .columns(changes.iter().map(|stop| usize::from(stop.is_some()))),
        )
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
}

/// The points of all contacts, each with the colour of its wheel.
fn contact_points(truth: &Truth) -> Vec<(Vec2, Colour)> {
    let mut points = Vec::new();
    for (wheel, colour) in truth.wheels.iter().zip(colours::WHEELS) {
        points.extend(wheel.contact_list.iter().map(|c| (c.point, colour)));
    }
    points
}

/// Entity of the end stops.
const STOPS: &str = "world/robot/link2/stops";

fn log_points(out: &mut Writer, times: &[f64], frames: &[Snapshot]) -> Result<(), ViewerError> {
    let pins = frames.iter().flat_map(|f| f.truth.pins);
    out.columns(
        "world/robot/pins",
        times,
        Points2D::update_fields()
            .with_positions(pins.map(|p| flat(p.position)))
            .columns(std::iter::repeat_n(Pin::ALL.len(), times.len())),
    )?;
    // A wheel in the air has no contact point, so that each point has its own colour.
    let contacts = || frames.iter().flat_map(|f| &f.contacts);
    out.columns(
        "world/robot/contacts",
        times,
        Points2D::update_fields()
            .with_positions(contacts().map(|(point, _)| flat(*point)))
            .with_colors(contacts().map(|(_, colour)| *colour))
            .columns(frames.iter().map(|f| f.contacts.len())),
    )
}

fn log_trails(out: &mut Writer, frames: &[Snapshot]) -> Result<(), ViewerError> {
    let with_trails = || frames.iter().filter(|f| !f.trails.is_empty());
    let times: Vec<f64> = with_trails().map(|f| f.truth.time).collect();
    let pieces = with_trails().flat_map(|f| &f.trails);
    out.columns(
        "world/trails",
        &times,
        LineStrips2D::update_fields()
            .with_strips(pieces.map(|piece| piece.map(flat)))
            .columns(std::iter::repeat_n(Pin::ALL.len(), times.len())),
    )
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

fn log_poses(
    out: &mut Writer,
    entity: &str,
    times: &[f64],
    poses: impl Iterator<Item = (Vec2, f64)> + Clone,
) -> Result<(), ViewerError> {
    let columns = Transform3D::update_fields()
        .with_many_translation(poses.clone().map(|(position, _)| deep(position)))
        .with_many_quaternion(poses.map(|(_, angle)| turn(angle)));
    out.columns(entity, times, columns.columns_of_unit_batches())
}

/// Logs the frame that moves with the body: at its centre of mass, not rotated, y down as a view needs it.
fn log_follower(out: &mut Writer, times: &[f64], frames: &[Snapshot]) -> Result<(), ViewerError> {
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

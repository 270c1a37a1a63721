//! The animation in 2-D: ground, robot, end stops, contacts, forces, paths of the pins.
//!
//! Shapes are logged once. Moving parts are logged as one pose for each frame; contacts, pins and
//! forces as points and arrows.

use crate::colours;
use crate::draw::{Strips, deep, flat, lines, narrow, turn};
use crate::error::Result;
use crate::forces::Forces;
use crate::ground::{Ground, log_axis};
use crate::writer::Writer;
use re_sdk_types::archetypes::{Ellipses2D, Points2D, Transform3D};
use re_sdk_types::components::{Color, Radius};
use robhaz_model::{Bar, Geometry, MassSet, PinStop, Robot, Vec2};
use robhaz_run::{Frame, RunDescription};
use robhaz_scene::Scene;
use robhaz_sim::Truth;

/// Number of spokes of a wheel. With few spokes its rotation is visible.
const SPOKES: u32 = 5;
/// Distances from Q at which the mark of an end stop of robot A starts and ends, m.
const STOP_TICK: [f64; 2] = [0.03, 0.08];
/// Number of straight pieces of the arc between the end stops.
const STOP_PIECES: u32 = 24;
/// Number of frames for one piece of a trail: 20 pieces per second at 60 Hz.
const FRAMES_PER_TRAIL: u32 = 3;
/// Visible range around the body of robot A in the view that moves with it, m: half the width,
/// above, below.
const FOLLOWED: [f64; 3] = [0.62, 0.32, 0.58];

/// Visible range around the body of a robot in the view that moves with it, m: half the width,
/// above, below.
pub(crate) fn followed(geometry: &Geometry) -> [f64; 3] {
    FOLLOWED.map(|length| length * geometry.size())
}

/// The animation of a run, with what is not logged yet.
pub(crate) struct SceneView {
    pub(crate) robot: Robot,
    pub(crate) ground: Ground,
    forces: Forces,
    frames: u32,
    trail_ends: Option<Vec<Vec2>>,
    /// Times of the frames, s.
    times: Vec<f64>,
    /// Positions (m) and angles (rad) of the bars, then of the wheels.
    poses: [Vec<(Vec2, f64)>; 7],
    pins: Vec<[f32; 2]>,
    /// Contact points, m, with the colours of the wheels, and their number in each frame.
    contacts: Vec<(Vec2, Color)>,
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
    pub(crate) fn declare(&self, out: &mut Writer) -> Result {
        // The viewer's 2-D axes have y down.
        out.constant("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;
        self.ground.draw(out)?;
        self.declare_bars(out)?;
        self.declare_wheels(out)?;
        self.declare_stops(out)?;
        let points = Points2D::update_fields().with_radii([Radius::new_ui_points(4.0)]);
        let pins = points.clone().with_colors([colours::PIN]);
        let names = self.robot.geometry.suspension.pins().iter();
        let names = names.map(|pin| pin.name().to_uppercase());
        out.constant("world/robot/pins", &pins.with_labels(names))?;
        out.constant("world/trails", &lines(colours::TRAIL, 0.75))?;
        out.constant("world/robot/contacts", &points)?;
        let [from, to, low, _] = self.ground.box_of();
        let size = self.robot.geometry.size();
        log_axis(out, [from, to, low], size)?;
        let [half_width, above, _] = followed(&self.robot.geometry);
        let corner = [0.12 * size - half_width, 0.05 * size - above];
        self.forces.declare(out, corner)
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
        self.forces.push(frame, truth);
    }

    /// Logs the frames that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result {
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
        std::mem::take(&mut self.trails).log(out, "world/trails")?;
        self.forces.flush(out, &times)
    }

    fn declare_bars(&self, out: &mut Writer) -> Result {
        let geometry = &self.robot.geometry;
        let links = [Bar::Link1, Bar::Link2, Bar::Link3].into_iter();
        let links = links.zip(colours::LINKS);
        let links = links.map(|(bar, colour)| (bar, link(geometry, bar), colour, 2.5));
        let body = body(geometry, &self.robot.mass);
        for (bar, points, colour, radius) in links.chain([(Bar::Body, body, colours::BODY, 1.5)]) {
            let strip = points.into_iter().map(flat);
            let strip = lines(colour, radius).with_strips([strip]);
            out.constant(bar_entity(bar), &strip)?;
        }
        Ok(())
    }

    fn declare_wheels(&self, out: &mut Writer) -> Result {
        let radius = self.robot.geometry.wheel_radius;
        for (i, colour) in colours::WHEELS.into_iter().enumerate() {
            let rim = Ellipses2D::update_fields()
                .with_half_sizes([[narrow(radius), narrow(radius)]])
                .with_colors([colour])
                .with_line_radii([Radius::new_ui_points(1.5)]);
            out.constant(format!("{}/rim", wheel_entity(i)), &rim)?;
            let spokes = spokes(radius).map(|spoke| spoke.map(flat));
            let spokes = lines(colour, 0.75).with_strips(spokes);
            out.constant(format!("{}/spokes", wheel_entity(i)), &spokes)?;
        }
        Ok(())
    }

    /// Logs the arc between the end stops, which is fixed to link 2.
    fn declare_stops(&self, out: &mut Writer) -> Result {
        let strips = stops(&self.robot.geometry).map(|strip| strip.into_iter().map(flat));
        let stops = lines(colours::NEUTRAL, 0.75).with_strips(strips);
        out.constant("world/robot/link2/stops", &stops)
    }
}

fn bar_entity(bar: Bar) -> String {
    format!("world/robot/{}", bar.name())
}

fn wheel_entity(wheel: usize) -> String {
    format!("world/robot/wheel{}", wheel + 1)
}

// Outlines of the robot's parts, m. Each is in the part's own frame: origin at the centre of mass,
// axes of the nominal pose.

/// A link as a polyline through the points of its outline, from rear to front, m.
fn link(geometry: &Geometry, bar: Bar) -> Vec<Vec2> {
    let cg = geometry.cg(bar);
    let mut points: Vec<Vec2> = geometry.outline_points(bar).map(|p| p - cg).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    points
}

/// The body as a closed outline through its pins and a box, m. The box is three times as long as it
/// is high and has the body's mass and inertia.
fn body(geometry: &Geometry, mass: &MassSet) -> Vec<Vec2> {
    let height = (12.0 * mass.body_inertia / mass.body / 10.0).sqrt();
    let half = Vec2::new(1.5 * height, 0.5 * height);
    let cg = geometry.cg(Bar::Body);
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let corners = corners.map(|(x, y)| Vec2::new(x * half.x, y * half.y));
    let pins = geometry.suspension.pins().iter();
    let pins = pins.filter(|pin| pin.bars().0 == Bar::Body || pin.bars().1 == Bar::Body);
    let pins = pins.map(|pin| geometry.pins.get(*pin) - cg);
    let mut points: Vec<Vec2> = corners.into_iter().chain(pins).collect();
    // Corners in the order of their direction from the centre make an outline that does not cross
    // itself.
    points.sort_by(|a, b| a.y.atan2(a.x).total_cmp(&b.y.atan2(b.x)));
    points.extend(points.first().copied());
    points
}

/// Spokes of a wheel of a radius (m), each from the centre to the rim, m.
fn spokes(radius: f64) -> impl Iterator<Item = [Vec2; 2]> {
    (0..SPOKES).map(move |i| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(SPOKES);
        [Vec2::zeros(), Vec2::new(angle.cos(), angle.sin()) * radius]
    })
}

/// The end stops of pin Q in the frame of link 2, m: the arc over which the line from Q to P on
/// link 1 can turn, the mark of the lower stop, and that of the upper stop.
fn stops(geometry: &Geometry) -> [Vec<Vec2>; 3] {
    let q = geometry.pins.q - geometry.cg(Bar::Link2);
    let towards_p = geometry.pins.p - geometry.pins.q;
    let nominal = towards_p.y.atan2(towards_p.x);
    let at = |radius: f64, turn: f64| {
        let (sin, cos) = (nominal + turn).sin_cos();
        q + Vec2::new(cos, sin) * radius
    };
    let PinStop { lower, upper, .. } = geometry.stop;
    let radii = STOP_TICK.map(|radius| radius * geometry.size());
    let tick = |turn: f64| radii.map(|radius| at(radius, turn)).to_vec();
    let arc = (0..=STOP_PIECES)
        .map(|i| lower + (upper - lower) * f64::from(i) / f64::from(STOP_PIECES))
        .map(|turn| at(radii[1], turn))
        .collect();
    [arc, tick(lower), tick(upper)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::newtons_per_metre;

    /// Closed form: link 2 of geometry A goes from the rear axle through R and Q to the middle
    /// axle.
    #[test]
    fn a_link_goes_through_its_own_pins_and_axles() {
        let geometry = Geometry::a();
        let found = link(&geometry, Bar::Link2);
        let cg = geometry.cg(Bar::Link2);
        let expected = [
            geometry.axles[2],
            geometry.pins.r,
            geometry.pins.q,
            geometry.axles[1],
        ]
        .map(|p| p - cg);
        assert_eq!(found, expected);
    }

    /// Property: the view that moves with the body shows all of every shipped robot in its nominal
    /// pose, and arrows of the mean load below it.
    #[test]
    fn a_robot_of_any_size_is_shown() {
        let robots = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
        for name in [
            "curiosity",
            "exomy",
            "marta",
            "open-source-rover",
            "sojourner",
        ] {
            let choice = robhaz_scene::RobotChoice::load(&robots.join(format!("{name}.toml")));
            let robot = choice.unwrap_or_else(|e| panic!("{name}: {e}")).robot;
            let geometry = &robot.geometry;
            let [half_width, above, below] = followed(geometry);
            let arrow = robot.mean_wheel_load() / newtons_per_metre(&robot);
            for axle in geometry.axles {
                let from_body = axle - geometry.body_cg;
                assert!(
                    from_body.x.abs() + geometry.wheel_radius < half_width,
                    "{name}"
                );
                assert!(
                    arrow + geometry.wheel_radius - from_body.y < below,
                    "{name}"
                );
            }
            // Not much smaller than the view.
            assert!(geometry.wheelbase() > 0.8 * half_width, "{name}");
            let bars = [Bar::Link1, Bar::Link2].map(|bar| (bar, link(geometry, bar)));
            for (bar, points) in bars {
                let top = points.iter().map(|p| p.y + geometry.cg(bar).y);
                let top = top.fold(f64::MIN, f64::max);
                assert!(top - geometry.body_cg.y < above, "{name}");
            }
        }
    }

    /// Closed form: with link 1 turned to an end stop, its line from Q to P lies along the mark of
    /// that stop.
    #[test]
    fn link_1_meets_its_stops() {
        let geometry = Geometry::a();
        let [_, lower, upper] = stops(&geometry);
        let q = geometry.pins.q - geometry.cg(Bar::Link2);
        for (mark, turn) in [(lower, geometry.stop.lower), (upper, geometry.stop.upper)] {
            let line = robhaz_model::rotate(geometry.pins.p - geometry.pins.q, turn);
            for point in mark {
                // Rounding: lengths are below 1 m.
                assert!(robhaz_model::cross(line, point - q).abs() < 1e-12);
                assert!(line.dot(&(point - q)) > 0.0);
            }
        }
    }

    /// Closed form: the box has the body's inertia m (w^2 + h^2)/12, and the closed outline goes
    /// through P and S.
    #[test]
    fn the_body_has_its_own_inertia_and_pins() {
        let (geometry, mass) = (Geometry::a(), MassSet::caption());
        let outline = body(&geometry, &mass);
        assert_eq!(outline.len(), 7);
        assert_eq!(outline.first(), outline.last());
        for pin in [geometry.pins.p, geometry.pins.s] {
            assert!(outline.contains(&(pin - geometry.body_cg)));
        }
        let half = outline
            .iter()
            .fold(Vec2::zeros(), |m, p| Vec2::new(m.x.max(p.x), m.y.max(p.y)));
        let inertia = mass.body * (4.0 * half.norm_squared()) / 12.0;
        assert!((inertia - mass.body_inertia).abs() < 1e-12);
    }
}

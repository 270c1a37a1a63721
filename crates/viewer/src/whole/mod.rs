//! A rover with both sides in 3-D: where it drove, the forces on six wheels, and plots of both
//! sides.

mod ground;
mod plots;
mod pose;
mod still;

use crate::draw::{narrow, solid};
use crate::error::Result;
use crate::explain::rates;
use crate::layout;
use crate::recorder::Recording;
use crate::series::Series;
use crate::writer::Writer;
use ground::Ground;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use pose::{Place, Pose};
use re_sdk_types::archetypes::{Arrows3D, LineStrips3D, Transform3D};
use re_sdk_types::datatypes::Quaternion;
use robhaz_estimator::whole::{Vec3, WholeEstimate};
use robhaz_model::WholeRover;
use robhaz_run::{BothTruth, Frame, RunDescription, RunEnd, Ticker};
use std::iter::repeat_n;

/// Length of the arrow of the mean static wheel load over the wheelbase.
const MEAN_LOAD_LENGTH: f64 = 1.0 / 3.0;
/// Half the width of a wheel over its radius. It is drawn, not known.
const HALF_WIDTH: f64 = 0.35;
/// Names of the sides in entities.
const SIDES: [&str; 2] = ["left", "right"];

/// Makes a Rerun recording of a rover with both sides: its drive in 3-D by dead reckoning, a track
/// on the ground of each wheel, N and T as an arrow at each contact with two standard deviations of
/// N, and plots; with truth the true forces beside.
///
/// A reading that is missing is drawn as the last one.
pub(crate) struct WholeRecorder {
    out: Writer,
    rover: WholeRover,
    due: Ticker,
    pose: Pose,
    /// Where the wheels stood in the last row.
    stood: Option<[Vec3; 6]>,
    ground: Ground,
    /// How far the rover has come since the last row, back negative, m.
    way: f64,
    rows: Rows,
    plots: Series,
}

/// Rows that are not logged yet.
#[derive(Default)]
struct Rows {
    times: Vec<f64>,
    rover: Vec<(Vec3, Quaternion)>,
    wheels: [Vec<(Vec3, Quaternion)>; 6],
    /// Four at each time; bars at the tips of the arrows, and tracks since the last row: six.
    links: Strips,
    bars: Strips,
    tracks: Strips,
    forces: Arrows,
    true_forces: Arrows,
}

/// Polylines, as many at every time, m.
type Strips = Vec<Vec<[f32; 3]>>;

/// Six arrows at each of several times, m.
#[derive(Default)]
struct Arrows {
    times: Vec<f64>,
    origins: Vec<[f32; 3]>,
    vectors: Vec<[f32; 3]>,
}

impl WholeRecorder {
    /// Starts the recording of a run, `thinning` times rarer in time.
    pub(crate) fn begin(
        mut out: Writer,
        rover: WholeRover,
        run: &RunDescription,
        thinning: f64,
    ) -> Result<Self> {
        layout::log_whole(&mut out, &rover)?;
        still::declare(&mut out, &rover, run.has_truth)?;
        out.about(still::page(&rover, run))?;
        let [_, frames] = rates(thinning);
        let width = 2.0 * HALF_WIDTH * rover.side.geometry.wheel_radius;
        Ok(Self {
            out,
            ground: Ground::new(&rover, width),
            rover,
            due: Ticker::new(1.0 / frames),
            pose: Pose::default(),
            stood: None,
            way: 0.0,
            rows: Rows::default(),
            plots: plots::plots(run),
        })
    }

    fn keep(
        &mut self,
        time: f64,
        place: &Place,
        estimate: &WholeEstimate,
        truth: Option<&BothTruth>,
    ) {
        let (rows, contacts) = (&mut self.rows, &place.contacts);
        rows.times.push(time);
        let turn = quaternion(&place.attitude);
        rows.rover.push((place.position, turn));
        for (i, wheel) in rows.wheels.iter_mut().enumerate() {
            let axial = place.posture.axial[i];
            wheel.push((place.posture.axles[i], spun(axial, self.pose.turns[i])));
        }
        let links = place.links(&self.rover).into_iter();
        rows.links.extend(links.map(|link| points(&link)));
        let scale = mean_load_length(&self.rover) / self.rover.mean_wheel_load();
        let radius = self.rover.side.geometry.wheel_radius;
        // Foot and vector of N and T beside a wheel.
        let arrow = |i: usize, beside: f64, [n, t]: [f64; 2]| {
            let c = &contacts[i];
            let foot = c.point + c.axial * (sign(i) * beside * radius);
            (foot, (c.normal * n + c.tangent * t) * scale)
        };
        let beside = 1.5 * HALF_WIDTH;
        let found = |i| arrow(i, beside, [estimate.normal_force[i], estimate.traction[i]]);
        rows.forces.push(time, found);
        if let Some(truth) = truth {
            let arrow = |i| arrow(i, beside + 0.25, true_forces(truth, i));
            rows.true_forces.push(time, arrow);
        }
        rows.bars.extend((0..6).map(|i| {
            let ((foot, vector), c) = (found(i), &contacts[i]);
            let half = c.normal * (2.0 * scale * estimate.sigma_normal(i).unwrap_or(0.0));
            let end = c.tangent * (0.2 * radius);
            let (low, high) = (foot + vector - half, foot + vector + half);
            points(&[low - end, low + end, low, high, high - end, high + end])
        }));
        let now = contacts.map(|c| place.position + place.attitude * c.point);
        let way = std::mem::take(&mut self.way);
        self.ground.push(time, way, now);
        let before = self.stood.replace(now).unwrap_or(now);
        let pieces = before.into_iter().zip(now);
        rows.tracks.extend(pieces.map(|(a, b)| points(&[a, b])));
    }
}

impl Recording for WholeRecorder {
    /// Every record that has an estimate is needed: between frames the drive is reckoned.
    fn push(&mut self, frame: &Frame<'_>) {
        let both = frame.both.as_ref();
        let Some((sides, estimate)) = both.and_then(|b| Some((b.sides, b.estimate?))) else {
            return;
        };
        let place = self.pose.reckon(&self.rover, &sides.readings, estimate);
        self.way += place.as_ref().map_or(0.0, |place| place.way);
        if let Some(place) = place.filter(|_| self.due.is_due(frame.time)) {
            self.keep(frame.time, &place, estimate, sides.truth.as_ref());
            self.plots.push(frame);
        }
    }

    fn flush(&mut self) -> Result {
        let (rows, out) = (std::mem::take(&mut self.rows), &mut self.out);
        let times = &rows.times;
        let wheels = rows.wheels.iter().enumerate();
        let wheels = wheels.map(|(i, poses)| (wheel_entity(i), poses));
        for (entity, poses) in wheels.chain([("world/rover".to_owned(), &rows.rover)]) {
            let columns = Transform3D::update_fields()
                .with_many_translation(poses.iter().map(|(at, _)| solid(at)))
                .with_many_quaternion(poses.iter().map(|(_, turn)| *turn));
            out.columns(entity, times, columns.columns_of_unit_batches())?;
        }
        // A frame that moves with the rover but does not turn: the view's.
        let follow = Transform3D::update_fields()
            .with_many_translation(rows.rover.iter().map(|(at, _)| solid(at)));
        out.columns("world/follow", times, follow.columns_of_unit_batches())?;
        for (entity, strips, count) in [
            ("world/rover/links", rows.links, 4),
            ("world/rover/forces/two_sigma", rows.bars, 6),
            ("world/tracks", rows.tracks, 6),
        ] {
            let columns = LineStrips3D::update_fields().with_strips(strips);
            out.columns(entity, times, columns.columns(repeat_n(count, times.len())))?;
        }
        for (entity, arrows) in [
            ("world/rover/forces", rows.forces),
            ("world/rover/true_forces", rows.true_forces),
        ] {
            let columns = Arrows3D::update_fields()
                .with_origins(arrows.origins)
                .with_vectors(arrows.vectors);
            let six = repeat_n(6, arrows.times.len());
            out.columns(entity, &arrows.times, columns.columns(six))?;
        }
        self.ground.flush(out)?;
        self.plots.flush(out)
    }

    fn end(&mut self, _: Option<&RunEnd>) -> Result {
        self.flush()?;
        self.out.finish()
    }
}

impl Arrows {
    /// Adds the arrow of each wheel at a time (s).
    fn push(&mut self, time: f64, arrow: impl Fn(usize) -> (Vec3, Vec3)) {
        self.times.push(time);
        for (origin, vector) in (0..6).map(arrow) {
            self.origins.push(solid(&origin));
            self.vectors.push(solid(&vector));
        }
    }
}

/// Length of the arrow of the mean static wheel load, m.
fn mean_load_length(rover: &WholeRover) -> f64 {
    MEAN_LOAD_LENGTH * rover.side.geometry.wheelbase()
}

/// True N, in the wheel's plane where it is known, and T of a wheel, N.
fn true_forces(truth: &BothTruth, i: usize) -> [f64; 2] {
    let wheel = &truth.sides[i / 3].wheels[i % 3];
    [wheel.normal_force, wheel.traction]
}

/// +1 for a left wheel, -1 for a right one.
fn sign(wheel: usize) -> f64 {
    if wheel < 3 { 1.0 } else { -1.0 }
}

/// A wheel with an axle that has turned forward by an angle, rad.
fn spun(axial: Vec3, turn: Option<f64>) -> Quaternion {
    let up = (Vec3::z() - axial * axial.z).normalize();
    let axes = Matrix3::from_columns(&[axial.cross(&up), axial, up]);
    let spin = Rotation3::from_axis_angle(&Vec3::y_axis(), turn.unwrap_or(0.0));
    quaternion(&(axes * spin.into_inner()))
}

fn quaternion(turn: &Matrix3<f64>) -> Quaternion {
    let rotation = Rotation3::from_matrix_unchecked(*turn);
    let q = UnitQuaternion::from_rotation_matrix(&rotation);
    Quaternion::from_xyzw([q.i, q.j, q.k, q.w].map(narrow))
}

fn points(strip: &[Vec3]) -> Vec<[f32; 3]> {
    strip.iter().map(solid).collect()
}

fn wheel_entity(i: usize) -> String {
    format!("world/rover/{}_wheel{}", SIDES[i / 3], i % 3 + 1)
}

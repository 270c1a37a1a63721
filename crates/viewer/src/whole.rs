//! A rover with both sides in 3-D: where it drove, the forces on six wheels, and plots of both
//! sides.

use crate::ViewerError;
use crate::colours::{self, Colour, WHEELS, by_index};
use crate::draw::narrow;
use crate::layout::{self, WHOLE_PLOTS as PLOTS};
use crate::recorder::Ticker;
use crate::series::{NARROW, WHEEL_NAMES, WIDE};
use crate::target::Target;
use crate::writer::Writer;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use re_sdk_types::archetypes::{
    Arrows3D, Boxes3D, Cylinders3D, LineStrips3D, Scalars, SeriesLines, TextDocument, Transform3D,
    ViewCoordinates,
};
use re_sdk_types::components::{FillMode, MediaType, Radius};
use re_sdk_types::datatypes::Quaternion;
use robhaz_estimator::whole::{Joints, Link, Vec3, WholeEstimate, WholeFrame, WholePosture};
use robhaz_model::{Coupling, Vec2, WholeRover};
use robhaz_run::{BothTruth, RunDescription};
use std::path::Path;

/// Rate of animation and plots, Hz of the log's time.
const RATE: f64 = 60.0;
/// Longest log that is recorded at this rate, s. A longer one keeps as many rows.
const FULL_RATE_TIME: f64 = 120.0;
/// Time between two writes, s: a file that breaks off loses no more.
const CHUNK_TIME: f64 = 2.0;
/// Length of the arrow of the mean static wheel load, m.
const MEAN_LOAD_LENGTH: f64 = 0.2;
/// Half the width of a wheel over its radius. It is drawn, not known.
const HALF_WIDTH: f64 = 0.35;
/// Spokes of a wheel: its turning is visible.
const SPOKES: usize = 5;
/// Names of the sides in entities.
const SIDES: [&str; 2] = ["left", "right"];

/// Makes a Rerun recording of a rover with both sides: its drive in 3-D by dead reckoning, a track
/// on the ground of each wheel, N and T as an arrow at each contact with two standard deviations of
/// N, and plots; with truth the true forces beside.
///
/// A reading that is missing is drawn as the last one.
pub struct WholeRecording {
    out: Writer,
    rover: WholeRover,
    /// Whether there are true forces.
    has_truth: bool,
    due: Ticker,
    write: Ticker,
    pose: Pose,
    tracks: [Option<Vec3>; 6],
    rows: Rows,
}

/// What dead reckoning knows.
#[derive(Default)]
struct Pose {
    time: Option<f64>,
    /// Of O, m, on ground that starts at height 0.
    position: Vec3,
    /// rad, to the left.
    yaw: f64,
    yaw_rate: f64,
    turns: [Option<f64>; 6],
    inclination: f64,
    joints: Joints,
}

/// Rows that are not logged yet, a value of each at every time.
#[derive(Default)]
struct Rows {
    times: Vec<f64>,
    rover: Vec<(Vec3, Quaternion)>,
    wheels: [Vec<(Vec3, Quaternion)>; 6],
    links: Vec<[Vec<Vec3>; 4]>,
    /// Origin and vector of the arrows, and the bars at their tips.
    arrows: Vec<[(Vec3, Vec3); 6]>,
    /// Those of the true forces, with their times.
    true_times: Vec<f64>,
    true_arrows: Vec<[(Vec3, Vec3); 6]>,
    bars: Vec<[Vec<Vec3>; 6]>,
    /// From the last contact to this one.
    tracks: Vec<[[Vec3; 2]; 6]>,
    plots: [Vec<f64>; PLOTS.len()],
}

impl WholeRecording {
    /// A recording in a new file; an older one of that name is replaced immediately. `fingerprint`
    /// distinguishes recordings of the same `name`. Beyond 120 s of `duration` (s) it is thinned.
    ///
    /// # Errors
    /// [`ViewerError::Io`]
    pub fn save(
        path: &Path,
        rover: &WholeRover,
        name: &str,
        fingerprint: u64,
        duration: f64,
    ) -> Result<Self, ViewerError> {
        let destination = path.display().to_string();
        let out = Writer::start(&destination, Target::create(path)?, name, fingerprint)?;
        let thinning = (duration / FULL_RATE_TIME).max(1.0);
        let write = thinning * CHUNK_TIME;
        Self::begin(out, rover, name, [RATE / thinning, write], [false; 2])
    }

    /// A recording of a run of both sides in an open target, `thinning` times rarer in time.
    pub(crate) fn of_run(
        destination: &str,
        target: Target,
        rover: &WholeRover,
        run: &RunDescription,
        thinning: f64,
    ) -> Result<Self, ViewerError> {
        let is_live = target.is_live();
        let out = Writer::start(destination, target, &run.name, run.fingerprint)?;
        let write = if is_live { 0.05 } else { thinning * CHUNK_TIME };
        let has = [is_live, run.has_truth];
        Self::begin(out, rover, &run.name, [RATE / thinning, write], has)
    }

    fn begin(
        mut out: Writer,
        rover: &WholeRover,
        name: &str,
        [rate, write]: [f64; 2],
        [is_live, has_truth]: [bool; 2],
    ) -> Result<Self, ViewerError> {
        layout::log_whole(&mut out, rover, is_live)?;
        declare(&mut out, rover, has_truth)?;
        let page =
            TextDocument::new(page(rover, name, has_truth)).with_media_type(MediaType::markdown());
        out.constant("about", &page)?;
        Ok(Self {
            out,
            rover: rover.clone(),
            has_truth,
            due: Ticker::new(1.0 / rate),
            write: Ticker::new(write),
            pose: Pose::default(),
            tracks: [None; 6],
            rows: Rows::default(),
        })
    }

    /// Takes a frame, its estimate, and the truth of a run that has one. Every frame that has an estimate is needed: between frames
    /// the drive is reckoned.
    ///
    /// # Errors
    /// [`ViewerError::Io`] of this or an earlier row.
    pub fn log(
        &mut self,
        frame: &WholeFrame,
        estimate: &WholeEstimate,
        truth: Option<&BothTruth>,
    ) -> Result<(), ViewerError> {
        let pose = &mut self.pose;
        pose.read(frame);
        // A four-bar has no recording: `WholeEstimator` refuses it.
        let Ok(posture) = WholePosture::new(&self.rover, &pose.joints) else {
            return Ok(());
        };
        let [inclination, roll] = estimate.attitude;
        let angles =
            std::array::from_fn(|i| estimate.sides[i / 3].contact_angle[i % 3] - inclination);
        let radius = self.rover.side.geometry.wheel_radius;
        let contacts = posture.contacts(radius, &angles);
        let turned = pose.advance(frame, estimate, &contacts.map(|c| c.tangent), radius);
        let attitude = attitude(pose.yaw, inclination, roll);
        if self.tracks == [None; 6] {
            let mean = contacts.iter().map(|c| attitude * c.point).sum::<Vec3>() / 6.0;
            pose.position = Vec3::new(0.0, 0.0, -mean.z);
        }
        pose.position += attitude * turned;
        if self.due.is_due(frame.time) {
            let rows = &mut self.rows;
            rows.times.push(frame.time);
            rows.rover.push((pose.position, quaternion(&attitude)));
            for i in 0..6 {
                let at = (posture.axles[i], spun(posture.axial[i], pose.turns[i]));
                rows.wheels[i].push(at);
            }
            rows.links.push(links(&self.rover, &posture));
            let scale = MEAN_LOAD_LENGTH / self.rover.mean_wheel_load();
            let beside = 1.5 * HALF_WIDTH * radius;
            let arrow_of = |i: usize, beside: f64, [n, t]: [f64; 2]| {
                let (c, side) = (&contacts[i], sign(i));
                let foot = c.point + c.axial * (side * beside);
                (foot, (c.normal * n + c.tangent * t) * scale)
            };
            let arrow = |i: usize| {
                let forces = [estimate.normal_force[i], estimate.traction[i]];
                arrow_of(i, beside, forces)
            };
            rows.arrows.push(std::array::from_fn(arrow));
            if let Some(truth) = truth {
                rows.true_times.push(frame.time);
                let arrow = |i| arrow_of(i, beside + 0.25 * radius, true_forces(truth, i));
                rows.true_arrows.push(std::array::from_fn(arrow));
            }
            rows.bars.push(std::array::from_fn(|i| {
                let (foot, vector) = arrow(i);
                let (tip, c) = (foot + vector, &contacts[i]);
                let half = c.normal * (2.0 * scale * estimate.sigma_normal(i).unwrap_or(0.0));
                let end = c.tangent * (0.2 * radius);
                let (low, high) = (tip - half, tip + half);
                vec![low - end, low + end, low, high, high - end, high + end]
            }));
            let now = contacts.map(|c| pose.position + attitude * c.point);
            let before = &mut self.tracks;
            rows.tracks.push(std::array::from_fn(|i| {
                [before[i].replace(now[i]).unwrap_or(now[i]), now[i]]
            }));
            rows.plot(estimate, truth, self.has_truth);
        }
        if self.write.is_due(frame.time) {
            self.flush()?;
        }
        Ok(())
    }

    /// Logs the rest, and closes the recording.
    ///
    /// # Errors
    /// [`ViewerError::Io`]
    pub fn end(mut self) -> Result<(), ViewerError> {
        self.flush()?;
        self.out.finish()
    }

    fn flush(&mut self) -> Result<(), ViewerError> {
        let Rows {
            times,
            rover,
            wheels,
            links,
            arrows,
            true_times,
            true_arrows,
            bars,
            tracks,
            plots,
        } = std::mem::take(&mut self.rows);
        let out = &mut self.out;
        let wheels = wheels.iter().enumerate().map(|(i, w)| (wheel_entity(i), w));
        for (entity, poses) in std::iter::once(("world/rover".to_owned(), &rover)).chain(wheels) {
            let columns = Transform3D::update_fields()
                .with_many_translation(poses.iter().map(|(at, _)| point(at)))
                .with_many_quaternion(poses.iter().map(|(_, turn)| *turn));
            out.columns(entity, &times, columns.columns_of_unit_batches())?;
        }
        // A frame that moves with the rover but does not turn: the view's.
        let follow = Transform3D::update_fields()
            .with_many_translation(rover.iter().map(|(at, _)| point(at)));
        out.columns("world/follow", &times, follow.columns_of_unit_batches())?;
        let strips = |strips: Vec<Vec<[f32; 3]>>| LineStrips3D::update_fields().with_strips(strips);
        let points = |strip: &Vec<Vec3>| strip.iter().map(point).collect();
        let columns = strips(links.iter().flatten().map(points).collect());
        let four = std::iter::repeat_n(4, times.len());
        out.columns("world/rover/links", &times, columns.columns(four))?;
        let six = || std::iter::repeat_n(6, times.len());
        for (entity, times, arrows) in [
            ("world/rover/forces", &times, &arrows),
            ("world/rover/true_forces", &true_times, &true_arrows),
        ] {
            let columns = Arrows3D::update_fields()
                .with_origins(arrows.iter().flatten().map(|(foot, _)| point(foot)))
                .with_vectors(arrows.iter().flatten().map(|(_, vector)| point(vector)));
            let six = std::iter::repeat_n(6, times.len());
            out.columns(entity, times, columns.columns(six))?;
        }
        let columns = strips(bars.iter().flatten().map(points).collect());
        out.columns(
            "world/rover/forces/two_sigma",
            &times,
            columns.columns(six()),
        )?;
        let pieces = tracks
            .iter()
            .flatten()
            .map(|ends| ends.iter().map(point).collect());
        out.columns(
            "world/tracks",
            &times,
            strips(pieces.collect()).columns(six()),
        )?;
        let lines = plot_lines(self.has_truth);
        for ((entity, values), lines) in PLOTS.iter().zip(plots).zip(lines) {
            let rows = std::iter::repeat_n(lines.len(), times.len());
            let columns = Scalars::new(values).columns(rows);
            out.columns(format!("series/{entity}"), &times, columns)?;
        }
        Ok(())
    }
}

impl Pose {
    /// Holds the readings of a frame.
    fn read(&mut self, frame: &WholeFrame) {
        let held = |held: &mut f64, read: Option<f64>| {
            *held = read.filter(|r| r.is_finite()).unwrap_or(*held);
        };
        held(&mut self.yaw_rate, frame.rates[2]);
        held(&mut self.joints.coupling, frame.coupling);
        (0..2).for_each(|k| held(&mut self.joints.pins[k], frame.pins[k]));
        (0..6).for_each(|i| held(&mut self.joints.steering[i], frame.steering[i]));
    }

    /// Turns by the yaw rate. Returns how far O moves in the body frame, m: the mean of what the
    /// wheels roll along their tangents.
    fn advance(
        &mut self,
        frame: &WholeFrame,
        estimate: &WholeEstimate,
        tangents: &[Vec3; 6],
        radius: f64,
    ) -> Vec3 {
        let dt = self.time.map_or(0.0, |last| frame.time - last);
        self.yaw += self.yaw_rate * dt;
        let pitched = estimate.attitude[0] - self.inclination;
        let (mut moved, mut count) = (Vec3::zeros(), 0.0);
        for (i, tangent) in tangents.iter().enumerate() {
            let read = frame.wheel_angle[i].filter(|angle| angle.is_finite());
            if let (Some(last), Some(now)) = (self.turns[i], read) {
                // A link that turns nose up with its wheel held rolls it back.
                moved += tangent * (radius * (now - last - pitched));
                count += 1.0;
            }
            self.turns[i] = read.or(self.turns[i]);
        }
        self.inclination = estimate.attitude[0];
        self.time = Some(frame.time);
        if count > 0.0 { moved / count } else { moved }
    }
}

impl Rows {
    fn plot(&mut self, estimate: &WholeEstimate, truth: Option<&BothTruth>, has_truth: bool) {
        let around = |value: f64, sigma: Option<f64>| {
            let half = 2.0 * sigma.unwrap_or(f64::NAN);
            [value, value + half, value - half]
        };
        for i in 0..6 {
            let n = around(estimate.normal_force[i], estimate.sigma_normal(i));
            let t = around(estimate.traction[i], estimate.sigma_traction(i));
            if has_truth {
                // A gap where the truth has no row.
                let [n, t] = truth.map_or([f64::NAN; 2], |truth| true_forces(truth, i));
                self.plots[i / 3].push(n);
                self.plots[2 + i / 3].push(t);
            }
            self.plots[i / 3].extend(n);
            self.plots[2 + i / 3].extend(t);
        }
        self.plots[4].extend(estimate.attitude.map(f64::to_degrees));
        self.plots[5].push(estimate.tip_margin);
        self.plots[6].push(estimate.axial_share);
    }
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

/// Turns the body frame into the world's: yaw, then inclination, then roll.
fn attitude(yaw: f64, inclination: f64, roll: f64) -> Matrix3<f64> {
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
    let (yaw, pitch) = (
        about(Vec3::z_axis(), yaw),
        about(Vec3::y_axis(), -inclination),
    );
    (yaw * pitch * about(Vec3::x_axis(), roll)).into_inner()
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

fn point(v: &Vec3) -> [f32; 3] {
    [narrow(v.x), narrow(v.y), narrow(v.z)]
}

fn wheel_entity(i: usize) -> String {
    format!("world/rover/{}_wheel{}", SIDES[i / 3], i % 3 + 1)
}

/// Rockers (or the halves of a rear bogie) and bogies of both sides, from joint to joint.
fn links(rover: &WholeRover, posture: &WholePosture) -> [Vec<Vec3>; 4] {
    let of = |link: Link| {
        let mut points: Vec<Vec3> = (0..6)
            .filter(|i| posture.links[*i] == link)
            .map(|i| posture.axles[i])
            .collect();
        match link {
            Link::Bogie(side) => points.push(posture.q[side]),
            Link::Rocker(side) => {
                let hinge = match rover.coupling {
                    Coupling::Differential => Vec3::y() * posture.q[side].y,
                    Coupling::RearBogie => Vec3::zeros(),
                };
                points.push(hinge);
                if rover.coupling == Coupling::Differential {
                    points.push(posture.q[side]);
                }
            }
            Link::Body => {}
        }
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    };
    [
        Link::Rocker(0),
        Link::Bogie(0),
        Link::Rocker(1),
        Link::Bogie(1),
    ]
    .map(of)
}

/// The lines of each plot: name, colour, width (points).
fn plot_lines(has_truth: bool) -> [Vec<(String, Colour, f32)>; PLOTS.len()] {
    let forces = || {
        let lines = WHEEL_NAMES.iter().zip(WHEELS).flat_map(|(wheel, colour)| {
            let truth = has_truth.then(|| (format!("{wheel} true [N]"), colour, WIDE));
            // Beside the truth an estimate is lighter.
            let colour = if has_truth { colour.light() } else { colour };
            let edge = |sign| (format!("{wheel} {sign} 2 sigma [N]"), colour, 0.75);
            let width = if has_truth { NARROW } else { 2.0 * NARROW };
            let estimate = [
                (format!("{wheel} [N]"), colour, width),
                edge("+"),
                edge("-"),
            ];
            truth.into_iter().chain(estimate).collect::<Vec<_>>()
        });
        lines.collect::<Vec<_>>()
    };
    let one = |name: &str, k| (name.to_owned(), by_index(k), NARROW);
    [
        forces(),
        forces(),
        forces(),
        forces(),
        vec![one("inclination [deg]", 0), one("roll [deg]", 1)],
        vec![one("tip margin [-]", 1)],
        vec![one("axial share [-]", 1)],
    ]
}

/// Logs everything that does not move.
fn declare(out: &mut Writer, rover: &WholeRover, has_truth: bool) -> Result<(), ViewerError> {
    let thin = |points| [Radius::new_ui_points(points)];
    out.constant("world", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let outline = &rover.side.geometry.outline;
    let half = (outline.body_upper - outline.body_lower) * 0.5;
    let centre: Vec2 = outline.body_lower + half - rover.pivot;
    let narrowest = rover.half_tracks.into_iter().fold(f64::INFINITY, f64::min);
    let body = Boxes3D::update_fields()
        .with_centers([point(&Vec3::new(centre.x, 0.0, centre.y))])
        .with_half_sizes([point(&Vec3::new(half.x, 0.7 * narrowest, half.y))])
        .with_colors([colours::BODY])
        .with_fill_mode(FillMode::Solid);
    out.constant("world/rover/body", &body)?;
    let [rocker, bogie, _] = colours::LINKS;
    let links = LineStrips3D::update_fields()
        .with_colors([rocker, bogie, rocker, bogie])
        .with_radii([Radius::new_scene_units(narrow(outline.half_width))]);
    out.constant("world/rover/links", &links)?;
    let radius = rover.side.geometry.wheel_radius;
    let half_width = HALF_WIDTH * radius;
    for i in 0..6 {
        let (entity, colour) = (wheel_entity(i), WHEELS[i % 3]);
        // The viewer's cylinder has its axis along z.
        let along_y = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
        let tyre = Cylinders3D::update_fields()
            .with_lengths([narrow(2.0 * half_width)])
            .with_radii([narrow(radius)])
            .with_quaternions([quaternion(&along_y.to_rotation_matrix().into_inner())])
            .with_colors([colour.dark()])
            .with_fill_mode(FillMode::Solid);
        out.constant(format!("{entity}/tyre"), &tyre)?;
        let spokes = (0..SPOKES).map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / SPOKES as f64;
            let y = sign(i) * 1.05 * half_width;
            let end = Vec3::new(radius * angle.cos(), y, radius * angle.sin());
            [point(&Vec3::new(0.0, y, 0.0)), point(&end)]
        });
        let spokes = LineStrips3D::update_fields()
            .with_strips(spokes)
            .with_colors([colour])
            .with_radii(thin(1.0));
        out.constant(format!("{entity}/spokes"), &spokes)?;
    }
    let colours = || WHEELS.into_iter().chain(WHEELS);
    let arrows = Arrows3D::update_fields()
        .with_colors(colours().map(Colour::light))
        .with_radii(thin(2.5));
    out.constant("world/rover/forces", &arrows)?;
    if has_truth {
        let arrows = Arrows3D::update_fields()
            .with_colors(colours())
            .with_radii(thin(2.5));
        out.constant("world/rover/true_forces", &arrows)?;
    }
    let bars = LineStrips3D::update_fields()
        .with_colors(colours().map(Colour::light))
        .with_radii(thin(1.0));
    out.constant("world/rover/forces/two_sigma", &bars)?;
    let tracks = LineStrips3D::update_fields()
        .with_colors(colours())
        .with_radii(thin(1.5));
    out.constant("world/tracks", &tracks)?;
    for (entity, lines) in PLOTS.iter().zip(plot_lines(has_truth)) {
        let style = SeriesLines::new()
            .with_names(lines.iter().map(|(name, ..)| name.as_str()))
            .with_colors(lines.iter().map(|(_, colour, _)| *colour))
            .with_widths(lines.iter().map(|(.., width)| *width));
        out.constant(format!("series/{entity}"), &style)?;
    }
    Ok(())
}

/// How to read the recording, as Markdown.
fn page(rover: &WholeRover, name: &str, has_truth: bool) -> String {
    let truth = match has_truth {
        true => {
            "- True forces have the full colours: thick lines, and the outer arrows, which stand on the \
             contacts found.\n"
        }
        false => "",
    };
    format!(
        "# {name}\n\n\
         Six wheels of a rover with both sides, from readings. Front wheels are blue, middle ones \
         vermilion, rear ones green.\n\n\
         - 3-D, m: an arrow beside each contact is N and T together, {:.0} N a metre. The bar at its \
         tip is two standard deviations of N to both sides. Axial forces are not drawn.\n\
         - Where the rover is follows from its wheels' turning and its yaw rate: slip and drift add \
         up. Lines on the ground are the tracks of the wheels.\n\
         - N and T of the left and the right wheels; thin lines are two standard deviations. \
         Attitude: inclination (purple), roll (amber).\n\
         - Tip margin: load off the line about which the rover would tip first, over that on level \
         ground; at 0 it tips. Axial share: mean axial force of a wheel over its N.\n{truth}",
        rover.mean_wheel_load() / MEAN_LOAD_LENGTH,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the specific force at rest in the body frame is that of the sensors'
    /// definition, (sin p, cos p sin r, cos p cos r), for any yaw.
    #[test]
    fn the_attitude_is_that_of_the_accelerometer() {
        let (pitch, roll) = (0.3_f64, -0.2_f64);
        let up = attitude(1.1, pitch, roll).transpose() * Vec3::z();
        let expected = Vec3::new(
            pitch.sin(),
            pitch.cos() * roll.sin(),
            pitch.cos() * roll.cos(),
        );
        assert!((up - expected).norm() < 1e-15);
    }
}

//! The ground that the wheels pass, along the path of the robot: heights of the axles by the angles
//! of the links, and how well those of the front wheels explain those of the rear ones
//! ([`crate::check::ground`] has the equations).

use crate::check::Recording;
use crate::check::changes::DEGREE;
use robhaz_model::{Robot, Units, rotate};
use robhaz_score::signals::{deviation, mean, subtract};

/// Step of the path, m.
pub const STEP: f64 = 0.002;
/// Least RMS of the differences of height of robot A that shows something, m: 2 mm.
const LEAST_HEIGHT: f64 = 0.002;
/// Largest number of steps of a path: 1 km. What follows shows nothing new.
const MOST_STEPS: usize = 500_000;
/// Relative difference of the two distances between the axles up to which they count as equal.
const EQUAL_SPACING: f64 = 0.02;
/// Inclination of a link from which on its wheels climb a face, rad: there a wheel rolls further
/// than the line between the axles, or spins. Chosen: ground without corners in the shipped scenes
/// stays below 16 deg, `stairs` is beyond it for 7 to 9 % of the time.
const STEEP: f64 = 20.0 * DEGREE;
/// Share of the way on such faces that makes the distance uncertain. Chosen: a single kerb (`step`,
/// `ditch`) takes 0.1 %.
const SHARE_OF_FACES: f64 = 0.01;
/// The angles that are used for links 1 and 2: parts of the inclinations of both.
pub type Links = [[f64; 2]; 2];

pub const OWN: Links = [[1.0, 0.0], [0.0, 1.0]];

/// Steps of the path in the distance of the front two axles, for encoders of a scale.
pub fn steps_of(course: &Course<'_>, scale: f64) -> usize {
    (scale * course.spacings()[0] / STEP) as usize
}

/// Heights of the axles above those behind them, and what the ground makes of them.
pub struct Heights<'a> {
    course: &'a Course<'a>,
    front: Vec<f64>,
    rear: Vec<f64>,
}

impl<'a> Heights<'a> {
    pub fn of(course: &'a Course<'a>, links: &Links) -> Self {
        let [front, rear] = course.heights(links);
        Self {
            course,
            front,
            rear,
        }
    }

    /// Both sides of the equation, for a shift of the front wheels.
    pub fn sides(&self, shift: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let (course, front, rear) = (self.course, &self.front, &self.rear);
        let (count, [spacing, behind]) = (course.len(), course.spacings());
        let least = steps_of(course, 1.0) / 2;
        if course.is_even() {
            let n = count.checked_sub(shift).filter(|n| *n > least)?;
            return Some((rear[shift..].to_vec(), front[..n].to_vec()));
        }
        let back = (shift as f64 * behind / spacing) as usize;
        let n = count.checked_sub(shift + back);
        let n = n.filter(|n| *n > least)?;
        let moved = |x: &[f64], by: usize| subtract(&x[by..by + n], &x[..n]);
        Some((moved(&rear[back..], shift), moved(front, back)))
    }

    /// The share of the rear side that the front one explains.
    pub fn explained(&self, shift: usize) -> Option<f64> {
        let (y, x) = self.sides(shift)?;
        let pairs = y.iter().zip(&x);
        let y = pairs.map(|(y, x)| if x.is_finite() { *y } else { f64::NAN });
        let y: Vec<f64> = y.collect();
        // The same heights, but for a constant: the start may be on a slope, zeros may be wrong.
        let left = deviation(&subtract(&y, &x));
        let size = deviation(&y);
        (size > self.course.least_height()).then_some(1.0 - (left / size).powi(2))
    }
}

/// The inclinations of a log along the path of the robot.
pub struct Course<'a> {
    robot: &'a Robot,
    /// Inclination of links 1 and 2 at each step, rad.
    inclination: [Vec<f64>; 2],
}

impl<'a> Course<'a> {
    /// The course of a robot, in the order of the places: on the way back from its end.
    pub fn of(recording: &Recording, robot: &'a Robot) -> Self {
        Self::with(recording, robot, &recording.inclination)
    }

    /// The same for other angles of links 1 and 2, rad.
    pub fn with(recording: &Recording, robot: &'a Robot, inclination: &[Vec<f64>; 2]) -> Self {
        let (samples, back) = samples(recording, robot.geometry.wheel_radius);
        let inclination = inclination.each_ref().map(|x| mean_along(&samples, x));
        let course = Self { robot, inclination };
        if back { course.turned_round() } else { course }
    }

    /// The same course driven the other way.
    pub fn turned_round(&self) -> Self {
        let reversed = |x: &Vec<f64>| x.iter().rev().copied().collect();
        Self {
            robot: self.robot,
            inclination: self.inclination.each_ref().map(reversed),
        }
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.inclination[0].len()
    }

    /// Distances between front and middle, and middle and rear axle, m.
    pub fn spacings(&self) -> [f64; 2] {
        let axles = &self.robot.geometry.axles;
        [axles[0].x - axles[1].x, axles[1].x - axles[2].x]
    }

    /// Least RMS of the differences of height that shows something, m.
    pub fn least_height(&self) -> f64 {
        LEAST_HEIGHT * Units::of(self.robot).length
    }

    /// Whether wheels climb faces that are steeper than [`STEEP`].
    pub fn climbs_faces(&self) -> bool {
        let steps = SHARE_OF_FACES * self.len() as f64;
        let is_beyond = |x: &[f64]| x.iter().filter(|x| x.abs() > STEEP).count() as f64 > steps;
        self.inclination.iter().any(|x| is_beyond(x))
    }

    /// Whether both spacings are the same.
    pub fn is_even(&self) -> bool {
        let [front, rear] = self.spacings();
        (front - rear).abs() <= EQUAL_SPACING * front
    }

    /// Heights of an axle above the next one behind it, m: front above middle, middle above rear,
    /// at each step.
    pub fn heights(&self, links: &Links) -> [Vec<f64>; 2] {
        let geometry = &self.robot.geometry;
        let height = |i: usize, k: usize| {
            let [a, b] = links[geometry.carriers[i].index()];
            let angle = a * self.inclination[0][k] + b * self.inclination[1][k];
            rotate(geometry.axles[i] - geometry.pins.q, angle).y
        };
        let steps = 0..self.len();
        [
            steps.clone().map(|k| height(0, k) - height(1, k)).collect(),
            steps.map(|k| height(1, k) - height(2, k)).collect(),
        ]
    }
}

/// The sample at each step of the path, and the fraction from there to the next one: at a low rate
/// or a high speed a sample takes several steps. And whether the way leads back.
fn samples(recording: &Recording, radius: f64) -> (Vec<(usize, f64)>, bool) {
    let spin = recording.while_driving(&recording.middle_spin);
    // Most of the way decides the direction.
    let net: f64 = spin.iter().filter(|s| s.is_finite()).sum();
    let direction = if net < 0.0 { -1.0 } else { 1.0 };
    let (mut samples, mut distance) = (vec![(0, 0.0)], 0.0);
    for (k, (spin, slope)) in spin.iter().zip(&recording.slope).enumerate() {
        let advance = direction * radius * spin * slope.cos() * recording.dt;
        if !advance.is_finite() {
            continue;
        }
        let missing = |count: usize| STEP * count as f64 - distance;
        while samples.len() < MOST_STEPS && missing(samples.len()) < advance {
            samples.push((k, missing(samples.len()) / advance));
        }
        distance += advance;
    }
    (samples, direction < 0.0)
}

/// Values of a signal along the path: means over the samples of a step, and between samples on a
/// straight line.
fn mean_along(samples: &[(usize, f64)], x: &[f64]) -> Vec<f64> {
    let at = |(k, part): (usize, f64)| {
        let here = x.get(k).copied().unwrap_or(f64::NAN);
        let next = x.get(k + 1).copied().unwrap_or(here);
        here + (next - here) * part
    };
    let means = samples.windows(2).map(|w| {
        let (from, to) = (w[0].0, w[1].0);
        if to <= from + 1 {
            return 0.5 * (at(w[0]) + at(w[1]));
        }
        mean(&x[from..to]).unwrap_or(f64::NAN)
    });
    means.collect()
}

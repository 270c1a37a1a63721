//! Readings along the path, and the curve of the axles that they show.

use crate::check::motion::Motion;
use crate::check::recording::Recording;
use crate::check::signal::{mean, smooth, zip};
use robhaz_model::{Robot, Units, Vec2};

/// Step of the path, m.
pub const STEP: f64 = 0.002;
/// Least RMS of the differences of height of robot A that shows something, m: 2 mm.
const LEAST_HEIGHT: f64 = 0.002;
/// Largest number of steps of a path: 1 km. What follows shows nothing new.
const MOST_STEPS: usize = 500_000;
/// Relative difference of the two distances between the axles up to which they count as equal.
const EQUAL_SPACING: f64 = 0.02;

/// Time over which inclinometers count in [`fused`], s: an acceleration of the robot does not last
/// as long.
const SLOW: f64 = 1.0;

/// Angles of links 1 and 2, rad: inclinometers over long times, gyroscopes over short ones. For
/// readings that agree.
pub fn fused(recording: &Recording) -> [Vec<f64>; 2] {
    [0, 1].map(|k| {
        let (turned, drift) = recording.turned(k);
        let drift = smooth(&drift, recording.steps(0.5 * SLOW));
        zip(&turned, &drift, |a, b| a + b)
    })
}

/// The angles that are used for links 1 and 2: parts of the inclinations of both.
pub type Links = [[f64; 2]; 2];

/// The inclinations of a log along the path of the robot.
pub struct Course<'a> {
    robot: &'a Robot,
    /// Inclination of links 1 and 2 at each step, rad.
    inclination: [Vec<f64>; 2],
}

impl<'a> Course<'a> {
    /// The course of a robot, for angles of links 1 and 2 (rad), in the order of the places: on the
    /// way back from its end.
    pub fn new(motion: &Motion, robot: &'a Robot, inclination: &[Vec<f64>; 2]) -> Self {
        let (samples, is_back) = samples(motion, robot);
        let inclination = inclination.each_ref().map(|x| mean_along(&samples, x));
        let course = Self { robot, inclination };
        if is_back {
            course.turned_round()
        } else {
            course
        }
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

    /// Whether both are the same.
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
            let arm: Vec2 = geometry.axles[i] - geometry.pins.q;
            let angle = a * self.inclination[0][k] + b * self.inclination[1][k];
            let (sin, cos) = angle.sin_cos();
            arm.x * sin + arm.y * cos
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
fn samples(motion: &Motion, robot: &Robot) -> (Vec<(usize, f64)>, bool) {
    let radius = robot.geometry.wheel_radius;
    let spin = motion.while_driving(&motion.middle_spin);
    // Most of the way decides the direction.
    let net: f64 = spin.iter().filter(|s| s.is_finite()).sum();
    let direction = if net < 0.0 { -1.0 } else { 1.0 };
    let (mut samples, mut distance) = (vec![(0, 0.0)], 0.0);
    for (k, (spin, slope)) in spin.iter().zip(&motion.slope).enumerate() {
        let advance = direction * radius * spin * slope.cos() * motion.step;
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
pub fn mean_along(samples: &[(usize, f64)], x: &[f64]) -> Vec<f64> {
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

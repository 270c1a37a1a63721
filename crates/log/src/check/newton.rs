//! Newton's law of a robot that starts: lateness and size of its torques, whatever controls them.
//!
//! With the means over the wheels of acceleration, speed and angle, alpha, omega and phi, and the inertia
//! `J = 3 (J_wheel + J_rotor) + m r^2` and damping `3 B` of what is stated,
//!
//! ```text
//! sum tau = q (J alpha + 3 B omega) + k phi + f sign(omega) + c
//! ```
//!
//! q is the size of the torques, k the curvature of the ground, f >= 0 dry friction, c holds offsets and the
//! slope. A driver makes its torques late by a delay, or by a low pass, of which the motion then has one,
//! too: the one with which the law leaves the least is theirs.

use crate::check::recording::{LONGEST_STEP, SMOOTHING, range};
use crate::check::rest::rest;
use crate::check::{Readings, Recording};
use robhaz_estimator::LATE_TORQUE;
use robhaz_model::{Robot, Units};
use robhaz_score::signals::{
    Fit, delayed, derivative, deviation, fit, integral, mean, residuals, rms, smooth,
};
use std::ops::Range;

/// Size of all torques, over that which the law asks for, that is a fault: masses are known better, and inertias of
/// rotors to a third.
pub const OTHER_SIZE: f64 = 1.4;
/// Rest before the first motion, and time after it, that count, s: late torques still pass their peak.
const BEFORE: f64 = 0.3;
const AFTER: f64 = 1.2;
/// Time constants of a low pass that are tried, s, each with delays; readings that were moved by its lag have one
/// that is negative.
const LOW_PASSES: [f64; 7] = [0.0, 0.03, 0.06, 0.1, 0.15, 0.2, LONGEST_LOW_PASS];
const LONGEST_LOW_PASS: f64 = 0.3;
/// Least lag and greatest delay that are tried, s, and their least step.
const LAGS: Range<f64> = -0.1..0.3;
const STEP: f64 = 0.005;
/// Spin speeds at which friction may have its size, rad/s for robot A: gears at once, soil after a millimetre or two.
const SLIDES: [f64; 3] = [0.05, 0.1, 0.2];
/// Part of the friction that may come earlier or later than by that law: soil gives way, gears stick.
const ONSET: f64 = 0.5;
/// Part of the variance that the law leaves at most where it holds: a wheel at an obstacle leaves more.
const LEFT: f64 = 0.02;
/// Part that torques leave without the delay, over that with it, and by itself, from which on they are late: half of
/// a standard deviation of the noise, and a tenth of the torque's size.
const WORSE: f64 = 4.0;
const SHOWN: f64 = 0.01;
/// The same up to which they are in time.
const NO_WORSE: f64 = 1.5;

/// What a start shows of the torques.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// How much later than the motion they are, s.
    pub lag: f64,
    /// The size of the torques over what the robot's inertias ask for, and its standard deviation: the one nearest to
    /// 1 that the start allows.
    pub size: f64,
    pub sigma: f64,
    /// Part of the variance that the law leaves, with that lag and without.
    pub left: f64,
    pub left_in_time: f64,
}

impl Start {
    /// Whether they are late.
    pub fn is_late(&self) -> bool {
        self.lag.abs() > LATE_TORQUE
            && self.left_in_time > WORSE * self.left
            && self.left_in_time > SHOWN
    }

    /// Whether they are in time.
    pub fn is_in_time(&self) -> bool {
        self.left_in_time < NO_WORSE * self.left
    }

    /// What a start shows, if the log has one to which the law applies.
    pub fn of(log: &Readings<'_>) -> Option<Self> {
        let recording = &log.recording;
        let motion = Motion::of(recording)?;
        if log.has_other_side() && !motion.is_on_a_plane(log) {
            return None;
        }
        let tried = LOW_PASSES.map(|constant| motion.tried(log, constant));
        let tried = tried.concat();
        let least = |a: &&Self, b: &&Self| a.left.total_cmp(&b.left);
        let best = tried.iter().min_by(least).filter(|best| best.left < LEFT)?;
        let allowed = LATE_TORQUE + 0.5 * recording.slowest.max(recording.dt);
        let in_time = |tried: &&Self| tried.lag.abs() <= allowed + 1e-9;
        // Friction that sets in and a slope hide a part of the size: the one nearest to 1 that explains as much.
        let is_as_good = |tried: &&Self| tried.left < NO_WORSE * best.left;
        let as_good = tried.iter().filter(is_as_good);
        let wrong = |start: &&Self| start.size.ln().abs();
        let nearest = as_good.min_by(|a, b| wrong(a).total_cmp(&wrong(b)))?;
        let best_in_time = tried.iter().filter(in_time).min_by(least);
        Some(Self {
            lag: best.lag,
            left: best.left,
            left_in_time: best_in_time.map_or(f64::INFINITY, |t| t.left),
            ..*nearest
        })
    }
}

/// The motion at a start, and its torques.
struct Motion {
    /// Time between samples, s.
    dt: f64,
    /// Half of the number of samples of a mean, less a half.
    half: usize,
    /// Mean angle of the wheels since the start, rad, with `lead` samples at rest before the recording, which
    /// delays and means look at.
    angle: Vec<f64>,
    lead: usize,
    /// The samples of the recording that count.
    range: Range<usize>,
    /// Their sums of the torques, four times averaged, N m.
    torque: Vec<f64>,
}

impl Motion {
    fn of(recording: &Recording) -> Option<Self> {
        let dt = recording.dt;
        let end = rest(recording);
        let before = recording.steps(BEFORE);
        let range = end.checked_sub(before)?..end + recording.steps(AFTER);
        if range.end > recording.len() || recording.slowest > LONGEST_STEP {
            return None;
        }
        // What delays and means look at beyond its ends.
        let half = recording.steps(0.5 * SMOOTHING);
        let ends = [LAGS.start - LONGEST_LOW_PASS, LAGS.end];
        let [earliest, longest] = ends.map(|time| steps(time, dt).unsigned_abs());
        let lead = longest + 4 * half;
        let until = (range.end + earliest + 4 * half).min(recording.len());
        let sum_of = |x: &[Vec<f64>; 3]| -> Vec<f64> {
            (0..until).map(|k| x[0][k] + x[1][k] + x[2][k]).collect()
        };
        let angles = sum_of(&recording.wheel_angle);
        let before_motion = angles[range.start..end].iter();
        let start = before_motion.copied().find(|x| x.is_finite())?;
        // What was before is a rest, too.
        let still = |(k, x): (usize, &f64)| match k < range.start {
            true => 0.0,
            false => (x - start) / 3.0,
        };
        let mut angle = vec![0.0; lead];
        angle.extend(angles.iter().enumerate().map(still));
        Some(Self {
            torque: smooth_again(&sum_of(&recording.torque), half, 4)[range.clone()].to_vec(),
            dt,
            half,
            angle,
            lead,
            range,
        })
    }

    /// Whether the wheels stay on a plane, but for a slope that asks for less than the sizes that are distinguished: a wheel
    /// that meets other ground turns its link by as much as its contact angle changes over a wheel base, and less before.
    /// On uneven ground one side pushes the other, and its torques have no law of their own.
    fn is_on_a_plane(&self, log: &Readings<'_>) -> bool {
        let (recording, robot) = (&log.recording, log.stated.robot);
        let rest = 0..self.range.start + recording.steps(BEFORE);
        let turn = |rate: &Vec<f64>| {
            let bias = mean(&rate[rest.clone()]).unwrap_or(0.0);
            let rates: Vec<f64> = rate[self.range.clone()].iter().map(|x| x - bias).collect();
            range(&integral(&rates, self.dt))
        };
        let speed = derivative(&self.angle, self.half, self.dt);
        let acceleration = derivative(&speed, self.half, self.dt);
        let weight = robot.mass.total() * robot.gravity;
        let asked = inertia(robot) * range(&acceleration[self.lead..][self.range.clone()]);
        let slope = asked / (weight * robot.geometry.wheel_radius);
        let largest = (1.0 - 1.0 / OTHER_SIZE) * slope;
        recording.rate.iter().all(|rate| turn(rate) < largest)
    }

    /// What the law leaves with torques behind a low pass of this time constant (s) and each delay.
    fn tried(&self, log: &Readings<'_>, constant: f64) -> Vec<Start> {
        let Self { dt, half, .. } = *self;
        let (robot, stated) = (log.stated.robot, &log.stated.settings);
        let inertia = inertia(robot);
        let damping = 3.0 * stated.viscous_damping;
        let slides = SLIDES.map(|speed| speed / Units::of(robot).time);
        let (angle, lag) = low_pass(&self.angle, constant, dt);
        // Each as smooth as the torque.
        let speed = derivative(&angle, half, dt);
        let acceleration = derivative(&speed, half, dt);
        let speed = smooth_again(&speed, half, 2);
        let motion = speed.iter().zip(&acceleration);
        let law: Vec<f64> = motion.map(|(w, a)| inertia * a + damping * w).collect();
        let friction = |at: f64| -> Vec<f64> { speed.iter().map(|w| (w / at).tanh()).collect() };
        let (frictions, angle) = (slides.map(friction), smooth_again(&angle, half, 4));
        let ones = vec![1.0; self.torque.len()];
        let of_shift = |shift: isize| {
            let late = |x: &Vec<f64>| delayed(x, shift)[self.lead..][self.range.clone()].to_vec();
            let [law, angle] = [&law, &angle].map(late);
            // Of means of means, that many samples err alike.
            let alike = 8.0 * half as f64;
            let of = |friction: &Vec<f64>| {
                let all = [&law, &angle, &ones, &late(friction)];
                judge(&self.torque, all.map(Vec::as_slice), alike)
            };
            let judged = frictions.iter().filter_map(of);
            let (left, size, sigma) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
            Some(Start {
                lag: shift as f64 * dt + lag,
                size,
                sigma,
                left,
                left_in_time: f64::INFINITY,
            })
        };
        let step = ((STEP / dt).round() as usize).max(1);
        let shifts = (steps(LAGS.start - lag, dt)..=steps(LAGS.end, dt)).step_by(step);
        shifts.filter_map(of_shift).collect()
    }
}

/// That of the law, kg m^2.
pub fn inertia(robot: &Robot) -> f64 {
    let (mass, radius) = (&robot.mass, robot.geometry.wheel_radius);
    3.0 * (mass.wheel_inertia + mass.rotor_inertia) + mass.total() * radius * radius
}

fn steps(time: f64, dt: f64) -> isize {
    (time / dt).round() as isize
}

/// So many times averaged.
fn smooth_again(x: &[f64], half: usize, times: usize) -> Vec<f64> {
    (0..times).fold(x.to_vec(), |x, _| smooth(&x, half))
}

/// What the law leaves of the torques' variance that it explains, their size, and its standard deviation, if as many
/// residuals as `alike` are one; `None` of no law.
fn judge(torque: &[f64], all: [&[f64]; 4], alike: f64) -> Option<(f64, f64, f64)> {
    let of = |x: &[&[f64]], found: &Fit| {
        let size = found.coefficients[0];
        let left = rms(&residuals(torque, x, found)) / (size * deviation(x[0]));
        let friction = found.coefficients.get(3);
        let friction = friction.map_or(0.0, |f| f * deviation(all[3]));
        let of_onset = ONSET * friction / deviation(all[0]);
        let sigma = (found.deviations[0] * alike.sqrt()).hypot(of_onset);
        (size > 0.0).then_some((left * left, size, sigma))
    };
    let found = fit(torque, &all)?;
    // Friction brakes.
    if found.coefficients[3] >= 0.0 {
        return of(&all, &found);
    }
    let found = fit(torque, &all[..3])?;
    of(&all[..3], &found)
}

/// An angle behind a low pass of this time constant (s), and how much later it is, s.
fn low_pass(angle: &[f64], constant: f64, dt: f64) -> (Vec<f64>, f64) {
    if constant <= 0.0 {
        return (angle.to_vec(), 0.0);
    }
    let share = -(-dt / constant).exp_m1();
    let mut passed = angle.first().copied().unwrap_or(0.0);
    let mut pass = |x: &f64| {
        if x.is_finite() {
            passed += share * (x - passed);
        }
        passed
    };
    let filtered = angle.iter().map(&mut pass).collect();
    (filtered, dt * (1.0 - share) / share)
}

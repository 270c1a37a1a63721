//! Exchanged and late torques, from torques and encoders of the wheels.

use super::smoothing::{Smoothing, Step, WINDOW, WheelReadings, follow};
use super::start::{RollingRobot, Start};
use crate::common::TYPICAL;

/// Finds out whether torques are exchanged or late.
///
/// Torques are exchanged if another pairing of torques and encoders leaves a small part of the
/// residual of the stated one, in the answer of a speed control to each wheel's own speed
/// ([`Answer`]). Nothing is said while the torques hardly differ, as on flat ground, or do not
/// answer the wheels' speeds.
///
/// Where wheels are commanded apart on purpose, as in a friction test, a greater torque makes its
/// own wheel creep ahead. The stated pairing may explain that, too: any sign counts for it, for the
/// others only a control most of whose answer brakes.
///
/// Torques are late if the robot's motion is ahead of them when it starts ([`Start`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wiring {
    smoothing: Smoothing,
    answer: Answer,
    /// Finds out whether all torques are later than the robot's motion.
    pub start: Start,
    /// Torques that belong to another encoder.
    pub exchanged: [bool; 3],
}

impl Wiring {
    /// RMS of the differences between the torques that shows something, N m: the noise of a
    /// reading, which is some times what the smoothing leaves of it.
    /// Data sheet.
    const LEAST_DIFFERENCE: f64 = TYPICAL.torque_noise;
    /// Part of the residual that another pairing leaves at most if torques are exchanged: it then
    /// explains at least two thirds of the differences.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const EXCHANGED: f64 = 1.0 / 3.0;
    /// Part of the residual from which on they are no longer: twice as much, as for all tests.
    /// Definition.
    const RIGHT: f64 = 2.0 * Self::EXCHANGED;

    /// Takes the readings of one sample, `dt` (s) after the last. Starts anew without readings.
    pub fn update(
        &mut self,
        readings: Option<&WheelReadings>,
        drives: bool,
        robot: &RollingRobot,
        dt: f64,
    ) {
        let Some(readings) = readings else {
            self.start.interrupt();
            *self = Self {
                start: self.start,
                exchanged: self.exchanged,
                ..Self::default()
            };
            return;
        };
        let Some(step) = self.smoothing.update(readings, dt) else {
            return;
        };
        self.answer.update(&step);
        self.start.update(&step, robot);
        if drives {
            self.judge();
        }
    }

    /// Compares the pairings, where the torques differ enough, and have been followed for half as long as
    /// the means last.
    fn judge(&mut self) {
        if self.answer.followed < 0.5 * WINDOW {
            return;
        }
        if self.answer.torque_torque < 3.0 * Self::LEAST_DIFFERENCE * Self::LEAST_DIFFERENCE {
            return;
        }
        let [stated, others @ ..] = self.answer.shares();
        let [right, wrong @ ..] = PAIRINGS;
        let (mut most, mut best) = (0.0, right);
        for (explained, pairing) in others.into_iter().zip(wrong) {
            if explained > most {
                (most, best) = (explained, pairing);
            }
        }
        let (residual, left) = (1.0 - stated, 1.0 - most);
        if left > Self::RIGHT * residual {
            self.exchanged = [false; 3];
        } else if left < Self::EXCHANGED * residual {
            self.exchanged = [0, 1, 2].map(|i| best[i] != i);
        }
    }
}

/// Fits the differences between the torques to those between the encoders, for each pairing of
/// torques and encoders.
///
/// A speed control brakes a wheel that is ahead. Differences from the mean over the wheels, without
/// their slow part, then follow
///
/// ```text
/// dtau_i = a dphi_i + b domega_i,   terms with a < 0, b < 0 explain most
/// ```
///
/// with the same a and b for all wheels (least squares over the last two seconds).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Answer {
    started: bool,
    /// Time since, s.
    followed: f64,
    /// Slow part of the differences of torques (N m), angles (rad) and speeds (rad/s).
    slow: [[f64; 3]; 3],
    /// Mean of the squared differences of the torques, summed over the wheels, (N m)^2.
    pub torque_torque: f64,
    /// Means of products with the angles, N m rad, and speeds, N m rad/s, for each pairing.
    torque_angle: [f64; 6],
    torque_speed: [f64; 6],
    angle_angle: f64,
    angle_speed: f64,
    speed_speed: f64,
}

impl Answer {
    /// Time constant beyond which differences are slow, s: offsets of torques, wheels on a longer
    /// way.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const SLOW: f64 = 0.3;
    /// Takes a step.
    pub fn update(&mut self, step: &Step) {
        let dt = step.dt;
        let mut differences = [step.torque, step.angle, step.speed].map(deviations);
        if !self.started {
            (self.started, self.slow) = (true, differences);
        }
        self.followed += dt;
        let weight = robhaz_model::low_pass_share(dt, Self::SLOW);
        for (difference, slow) in differences.iter_mut().zip(&mut self.slow) {
            follow(slow, difference, weight);
            for (difference, slow) in difference.iter_mut().zip(slow) {
                *difference -= *slow;
            }
        }
        let [torque, angle, speed] = differences;
        let weight = robhaz_model::low_pass_share(dt, WINDOW);
        let mean = |sum: &mut f64, a: &[f64; 3], b: &[f64; 3]| *sum += weight * (dot(a, b) - *sum);
        mean(&mut self.torque_torque, &torque, &torque);
        mean(&mut self.angle_angle, &angle, &angle);
        mean(&mut self.angle_speed, &angle, &speed);
        mean(&mut self.speed_speed, &speed, &speed);
        for (sum, angle) in self.torque_angle.iter_mut().zip(&pairings(angle)) {
            mean(sum, &torque, angle);
        }
        for (sum, speed) in self.torque_speed.iter_mut().zip(&pairings(speed)) {
            mean(sum, &torque, speed);
        }
    }

    /// Share of the torques' differences that is explained, for each of [`PAIRINGS`]: by a stable
    /// speed control, or with the stated pairing by torques that drive their wheels.
    pub fn shares(&self) -> [f64; 6] {
        let mut shares = [0.0; 6];
        let determinant = self.angle_angle * self.speed_speed - self.angle_speed * self.angle_speed;
        // No speed of its own, or none at all. In this order a NaN tells nothing, too.
        if !(determinant > 1e-9 * self.angle_angle * self.speed_speed) {
            return shares;
        }
        let sums = self.torque_angle.iter().zip(&self.torque_speed);
        for (k, (share, (torque_angle, torque_speed))) in shares.iter_mut().zip(sums).enumerate() {
            let a = torque_angle * self.speed_speed - torque_speed * self.angle_speed;
            let b = torque_speed * self.angle_angle - torque_angle * self.angle_speed;
            let parts = [(a, a * torque_angle), (b, b * torque_speed)];
            let explained = parts[0].1 + parts[1].1;
            let brakes = parts.iter().filter(|(coefficient, _)| *coefficient < 0.0);
            let stable = brakes.map(|(_, part)| part).sum::<f64>();
            if k == 0 || 2.0 * stable > explained {
                *share = explained / (determinant * self.torque_torque);
            }
        }
        shares
    }
}

/// Differences from the mean.
fn deviations([a, b, c]: [f64; 3]) -> [f64; 3] {
    let mean = (a + b + c) / 3.0;
    [a - mean, b - mean, c - mean]
}

fn dot([a, b, c]: &[f64; 3], [x, y, z]: &[f64; 3]) -> f64 {
    a * x + b * y + c * z
}

/// All pairings of torques and encoders: the encoder of each torque. The first is the stated one.
pub const PAIRINGS: [[usize; 3]; 6] = pairings([0, 1, 2]);

/// The wheels' values in all orders; the first is the stated one.
const fn pairings<T: Copy>([a, b, c]: [T; 3]) -> [[T; 3]; 6] {
    [
        [a, b, c],
        [b, a, c],
        [a, c, b],
        [c, b, a],
        [b, c, a],
        [c, a, b],
    ]
}

#[cfg(test)]
mod tests;

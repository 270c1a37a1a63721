//! The way a speed control answers each wheel's own speed: fits of torques to encoders.

use super::smoothing::{Step, follow};

/// Fits the differences between the torques to those between the encoders, for each pairing of
/// torques and encoders.
///
/// A speed control brakes a wheel that is ahead. Differences from the mean over the wheels, without
/// their slow part, then follow
///
/// ```text
/// dtau_i = a dphi_i + b domega_i,   a < 0 or b < 0
/// ```
///
/// with the same a and b for all wheels (least squares over the last two seconds).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Answer {
    started: bool,
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
    /// Time constant of the means, s: that of the other tests.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const WINDOW: f64 = 2.0;
    /// Takes a step.
    pub fn update(&mut self, step: &Step) {
        let dt = step.dt;
        let mut differences = [step.torque, step.angle, step.speed].map(deviations);
        if !self.started {
            (self.started, self.slow) = (true, differences);
        }
        let weight = dt / (Self::SLOW + dt);
        for (difference, slow) in differences.iter_mut().zip(&mut self.slow) {
            follow(slow, difference, weight);
            for (difference, slow) in difference.iter_mut().zip(slow) {
                *difference -= *slow;
            }
        }
        let [torque, angle, speed] = differences;
        let weight = dt / (Self::WINDOW + dt);
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

    /// Share of the torques' differences that a stable speed control explains, for each of
    /// [`PAIRINGS`].
    pub fn shares(&self) -> [f64; 6] {
        let mut shares = [0.0; 6];
        let determinant = self.angle_angle * self.speed_speed - self.angle_speed * self.angle_speed;
        // No speed of its own, or none at all. In this order a NaN tells nothing, too.
        if !(determinant > 1e-9 * self.angle_angle * self.speed_speed) {
            return shares;
        }
        let sums = self.torque_angle.iter().zip(&self.torque_speed);
        for (share, (torque_angle, torque_speed)) in shares.iter_mut().zip(sums) {
            let a = torque_angle * self.speed_speed - torque_speed * self.angle_speed;
            let b = torque_speed * self.angle_angle - torque_angle * self.angle_speed;
            if a < 0.0 || b < 0.0 {
                *share = (a * torque_angle + b * torque_speed) / (determinant * self.torque_torque);
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

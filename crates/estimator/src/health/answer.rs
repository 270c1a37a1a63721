//! The way a speed control answers each wheel's own speed: fits of torques to encoders.

use super::smoothing::{Smoothing, Step, follow};

/// Fits the differences between the torques to those between the encoders, for each pairing of torques and encoders.
///
/// A speed control brakes a wheel that is ahead. Differences from the mean over the wheels, without their slow part, then
/// follow
///
/// ```text
/// dtau_i = a dphi_i + b domega_i,   a < 0 or b < 0
/// ```
///
/// with the same a and b for all wheels (least squares over the last two seconds).
///
/// Torques that are late by d follow what the encoders were before. To second order in d,
///
/// ```text
/// dtau_i = a dphi_i + (b - d a) domega_i + (d^2 a/2 - d b) dalpha_i
/// ```
///
/// with the angular accelerations alpha: a fit of the three coefficients gives d and its deviation, which has two parts:
/// noise of the readings, and gains of the torques, each with an error of its own. An obstacle changes all torques, and gains
/// that differ make differences of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Answer {
    started: bool,
    /// Slow part of the torques (N m), and of the differences of angles (rad), speeds (rad/s), accelerations (rad/s^2).
    slow: [[f64; 3]; 4],
    /// Mean of the squared differences of the torques, summed over the wheels, (N m)^2.
    torque_torque: f64,
    /// Means of products with the angles, N m rad, and speeds, N m rad/s, for each pairing.
    torque_angle: [f64; 6],
    torque_speed: [f64; 6],
    angle_angle: f64,
    angle_speed: f64,
    speed_speed: f64,
    /// Means of products of each wheel's torque with its angle, speed and acceleration, of the stated pairing.
    own: [[f64; 3]; 3],
    angle_acceleration: f64,
    speed_acceleration: f64,
    acceleration_acceleration: f64,
}

/// What the three coefficients say of late torques.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lateness {
    /// Delay of the torques behind the encoders, s.
    pub delay: f64,
    /// Its standard deviation, s.
    pub sigma: f64,
    /// Share of the torques' differences that the fit leaves.
    pub left: f64,
}

impl Answer {
    /// Time constant beyond which differences are slow, s: offsets of torques, wheels on a longer way.
    const SLOW: f64 = 0.3;
    /// Time constant of the means, s: that of the other tests.
    const WINDOW: f64 = 2.0;
    /// Independent samples of the fit: two differences, over both sides of the window.
    const SAMPLES: f64 = 4.0 * Self::WINDOW / Smoothing::TIME;

    /// Takes a step.
    pub fn update(&mut self, step: &Step) {
        let dt = step.dt;
        let [angle, speed, acceleration] =
            [step.angle, step.speed, step.acceleration].map(deviations);
        let mut differences = [step.torque, angle, speed, acceleration];
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
        let [of_wheel, angle, speed, acceleration] = differences;
        let torque = deviations(of_wheel);
        let weight = dt / (Self::WINDOW + dt);
        for (means, with) in self.own.iter_mut().zip([angle, speed, acceleration]) {
            follow(means, &products(&of_wheel, &with), weight);
        }
        let mean = |sum: &mut f64, a: &[f64; 3], b: &[f64; 3]| *sum += weight * (dot(a, b) - *sum);
        mean(&mut self.torque_torque, &torque, &torque);
        mean(&mut self.angle_angle, &angle, &angle);
        mean(&mut self.angle_speed, &angle, &speed);
        mean(&mut self.speed_speed, &speed, &speed);
        mean(&mut self.angle_acceleration, &angle, &acceleration);
        mean(&mut self.speed_acceleration, &speed, &acceleration);
        let squared = &mut self.acceleration_acceleration;
        mean(squared, &acceleration, &acceleration);
        for (sum, angle) in self.torque_angle.iter_mut().zip(&pairings(angle)) {
            mean(sum, &torque, angle);
        }
        for (sum, speed) in self.torque_speed.iter_mut().zip(&pairings(speed)) {
            mean(sum, &torque, speed);
        }
    }

    /// Mean of the squared differences of the torques, summed over the wheels, (N m)^2.
    pub fn squared(&self) -> f64 {
        self.torque_torque
    }

    /// Share of the torques' differences that a stable speed control explains, for each of [`PAIRINGS`].
    pub fn shares(&self) -> [f64; 6] {
        let mut shares = [0.0; 6];
        let Some(determinant) = self.determinant() else {
            return shares;
        };
        let sums = self.torque_angle.iter().zip(&self.torque_speed);
        for (share, (torque_angle, torque_speed)) in shares.iter_mut().zip(sums) {
            let [a, b] = self.coefficients(determinant, *torque_angle, *torque_speed);
            if a < 0.0 || b < 0.0 {
                *share = (a * torque_angle + b * torque_speed) / self.torque_torque;
            }
        }
        shares
    }

    /// Determinant of the means of angles and speeds; `None` where they do not tell two coefficients.
    fn determinant(&self) -> Option<f64> {
        let determinant = self.angle_angle * self.speed_speed - self.angle_speed * self.angle_speed;
        // No speed of its own, or none at all. In this order a NaN tells nothing, too.
        let regular = determinant > 1e-9 * self.angle_angle * self.speed_speed;
        regular.then_some(determinant)
    }

    /// Coefficients of angles and speeds that fit a signal best, from the means of its products with both.
    fn coefficients(&self, determinant: f64, with_angle: f64, with_speed: f64) -> [f64; 2] {
        let a = with_angle * self.speed_speed - with_speed * self.angle_speed;
        let b = with_speed * self.angle_angle - with_angle * self.angle_speed;
        [a / determinant, b / determinant]
    }

    /// Delay of the torques in the stated pairing, with relative errors of the torques' scales of standard deviation `gain`.
    /// `None` where the accelerations tell nothing, or the fit is no stable control.
    pub fn lateness(&self, gain: f64) -> Option<Lateness> {
        let determinant = self.determinant()?;
        let [torque_angle, ..] = self.torque_angle;
        let [torque_speed, ..] = self.torque_speed;
        let without = self.coefficients(determinant, torque_angle, torque_speed);
        // The part of the accelerations that angles and speeds do not explain.
        let of_angle = self.angle_acceleration;
        let of_speed = self.speed_acceleration;
        let of_others = self.coefficients(determinant, of_angle, of_speed);
        let own =
            self.acceleration_acceleration - of_others[0] * of_angle - of_others[1] * of_speed;
        if !(own > 1e-9 * self.acceleration_acceleration) {
            return None;
        }
        let [with_angle, with_speed, with_acceleration] = self.own;
        let mut shared_of = with_acceleration;
        for (coefficient, with) in of_others.iter().zip([with_angle, with_speed]) {
            for (shared, with) in shared_of.iter_mut().zip(with) {
                *shared -= coefficient * with;
            }
        }
        let shared: f64 = shared_of.iter().sum();
        let c = shared / own;
        let [a, b] = [without[0] - c * of_others[0], without[1] - c * of_others[1]];
        let explained = without[0] * torque_angle + without[1] * torque_speed + c * shared;
        let residual = (self.torque_torque - explained).max(0.0);
        // The smaller root of a d^2/2 + (b - d a) d + c = 0, in a form without a difference of equal numbers.
        let square = b * b - 2.0 * a * c;
        if !(square >= 0.0) {
            return None;
        }
        let root = robhaz_model::sqrt(square);
        let delay = -2.0 * c / (b + libm::copysign(root, b));
        let of_speed_alone = b + delay * a;
        let is_stable = a < 0.0 || of_speed_alone < 0.0;
        let of_noise = residual / (own * Self::SAMPLES);
        let of_gains = gain * gain * dot(&shared_of, &shared_of) / (own * own);
        let sigma = robhaz_model::sqrt(of_noise + of_gains) / of_speed_alone.abs();
        is_stable.then_some(Lateness {
            delay,
            sigma,
            left: residual / self.torque_torque,
        })
    }
}

/// Differences from the mean.
fn deviations([a, b, c]: [f64; 3]) -> [f64; 3] {
    let mean = (a + b + c) / 3.0;
    [a - mean, b - mean, c - mean]
}

fn products([a, b, c]: &[f64; 3], [x, y, z]: &[f64; 3]) -> [f64; 3] {
    [a * x, b * y, c * z]
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [x, y, z] = products(a, b);
    x + y + z
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

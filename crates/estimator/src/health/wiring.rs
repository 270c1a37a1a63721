//! Exchanged and late torques, from the way a speed control answers each wheel's own speed.

use crate::visit::visit_fields;

/// Motor torques and encoders of one sample, of wheels 1 to 3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelReadings {
    /// Motor torques, N m.
    pub torque: [f64; 3],
    /// Spin angles, rad.
    pub angle: [f64; 3],
    /// Whether the robot drives.
    pub drives: bool,
}

/// Fits the differences between the torques to those between the encoders, for each pairing of torques and encoders.
///
/// A speed control brakes a wheel that is ahead. Differences from the mean over the wheels, without their slow part, then
/// follow
///
/// ```text
/// dtau_i = a dphi_i + b domega_i,   a < 0 or b < 0
/// ```
///
/// with the same a and b for all wheels (least squares over the last two seconds). Torques are exchanged if another pairing
/// leaves a small part of the residual of the stated one. Nothing is said while the torques hardly differ, as on flat
/// ground, or do not answer the wheels' speeds.
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
pub(crate) struct Wiring {
    started: bool,
    /// Time since the sums were last updated, s.
    elapsed: f64,
    /// Time for which the robot has driven, s; at most [`Self::LEAST_TIME`].
    driven: f64,
    /// Time between the last two updates of the sums, s.
    last_step: f64,
    /// Smoothed torques, N m.
    torque: [f64; 3],
    /// The same at the last update of the sums, N m.
    last_torque: [f64; 3],
    /// Smoothed angles, rad.
    angle: [f64; 3],
    /// The same at the last update of the sums, and at the one before, rad.
    last_angle: [f64; 3],
    before_angle: [f64; 3],
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
    /// Torques that belong to another encoder.
    exchanged: [bool; 3],
    /// All torques are later than the encoders.
    late: bool,
    /// Time for which the fit has said the opposite, s.
    doubted: f64,
}

visit_fields!(Wiring: started, elapsed, driven, last_step, torque, last_torque, angle, last_angle, before_angle, slow,
    torque_torque, torque_angle, torque_speed, angle_angle, angle_speed, speed_speed, own, angle_acceleration,
    speed_acceleration, acceleration_acceleration, exchanged, late,
    doubted);

/// What the three coefficients say of late torques.
#[derive(Clone, Copy, Debug)]
struct Lateness {
    /// Delay of the torques behind the encoders, s.
    delay: f64,
    /// Its standard deviation, s.
    sigma: f64,
    /// Share of the torques' differences that the fit leaves.
    left: f64,
}

impl Wiring {
    /// Time constant of the smoothing of torques and angles, s: an encoder of 40 urad a count then gives a speed and an
    /// acceleration.
    const SMOOTHING: f64 = 0.03;
    /// Time constant beyond which differences are slow, s: offsets of torques, wheels on a longer way.
    const SLOW: f64 = 0.3;
    /// Time constant of the means, s: that of the other tests.
    const WINDOW: f64 = 2.0;
    /// Time between updates of the sums, s: shorter than the smoothing.
    const INTERVAL: f64 = 0.01;
    /// Time of driving from which on the fit is judged, s: the start of the drive is one event only.
    const LEAST_TIME: f64 = 1.0;
    /// RMS of the differences between the torques that shows something, N m: as in `robhaz check`.
    const LEAST_DIFFERENCE: f64 = 0.15;
    /// Part of the residual that another pairing leaves at most if torques are exchanged.
    const EXCHANGED: f64 = 0.2;
    /// Part of the residual from which on they are no longer.
    const RIGHT: f64 = 0.5;
    /// Share that the other pairing explains at least.
    const EXPLAINED: f64 = 0.8;
    /// Share that the stated pairing leaves at least: below it the ratio of the residuals is that of their noise.
    const LEAST_RESIDUAL: f64 = 0.005;
    /// Delay of a torque behind its encoder that a control itself may have, s: as in `robhaz check`.
    const CONTROL_DELAY: f64 = 0.008;
    /// Share that the fit of a delay leaves at most: a control beyond its limits is not linear.
    const LEFT: f64 = 0.02;
    /// Standard deviations beyond that which tell that torques are late. Those that tell that they are not: one.
    const LATE: f64 = 3.0;
    /// Time for which a fit must find torques late, or not late, s: an impact disturbs it for some hundredths.
    const LASTS: f64 = 0.2;
    /// Independent samples of the fit: two differences, over both sides of the window.
    const SAMPLES: f64 = 4.0 * Self::WINDOW / Self::SMOOTHING;

    /// The torques that belong to another encoder, for each pairing of [`pairings`].
    const MOVED: [[bool; 3]; 6] = [
        [false; 3],
        [true, true, false],
        [false, true, true],
        [true, false, true],
        [true; 3],
        [true; 3],
    ];

    /// Torques 1 to 3 that belong to another encoder.
    pub fn exchanged(&self) -> [bool; 3] {
        self.exchanged
    }

    /// Whether all torques are later than a speed control can make them.
    pub fn late(&self) -> bool {
        self.late
    }

    /// Takes the readings of one sample, `dt` (s) after the last. Starts anew without readings.
    ///
    /// `gain` is the standard deviation of the relative error of a torque's scale.
    pub fn update(&mut self, readings: Option<&WheelReadings>, gain: f64, dt: f64) {
        let Some(readings) = readings else {
            *self = Self {
                exchanged: self.exchanged,
                late: self.late,
                ..Self::default()
            };
            return;
        };
        if !self.started {
            self.started = true;
            (self.torque, self.angle) = (readings.torque, readings.angle);
            self.last_torque = readings.torque;
            (self.last_angle, self.before_angle) = (readings.angle, readings.angle);
            [self.slow[0], self.slow[1], ..] =
                [self.torque, deviations(self.angle), [0.0; 3], [0.0; 3]];
            return;
        }
        let weight = dt / (Self::SMOOTHING + dt);
        follow(&mut self.torque, &readings.torque, weight);
        follow(&mut self.angle, &readings.angle, weight);
        if readings.drives {
            self.driven = (self.driven + dt).min(Self::LEAST_TIME);
        }
        self.elapsed += dt;
        // Sums of rounded steps: half a microsecond less is the whole interval.
        if self.elapsed > Self::INTERVAL - 0.5e-6 {
            self.update_sums();
            (self.last_step, self.elapsed) = (self.elapsed, 0.0);
            if readings.drives && self.driven >= Self::LEAST_TIME {
                self.judge(gain);
            }
        }
    }

    /// Torques and the differences of angles, speeds and accelerations at the last update, between this one and the one before.
    fn differences(&mut self) -> [[f64; 3]; 4] {
        let (dt, before) = (self.elapsed, self.last_step);
        let (mut speed, mut acceleration) = ([0.0; 3], [0.0; 3]);
        // Before the second update there is no step.
        if before > 0.0 {
            let angles = self.angle.iter().zip(&self.last_angle);
            let angles = angles.zip(&self.before_angle);
            let rates = speed.iter_mut().zip(&mut acceleration);
            for (((now, last), before_last), (speed, acceleration)) in angles.zip(rates) {
                let (after, until) = ((now - last) / dt, (last - before_last) / before);
                *speed = (now - before_last) / (dt + before);
                *acceleration = 2.0 * (after - until) / (dt + before);
            }
        }
        let [angle, speed, acceleration] = [self.last_angle, speed, acceleration].map(deviations);
        let differences = [self.last_torque, angle, speed, acceleration];
        self.before_angle = self.last_angle;
        (self.last_angle, self.last_torque) = (self.angle, self.torque);
        differences
    }

    fn update_sums(&mut self) {
        let dt = self.elapsed;
        let mut differences = self.differences();
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
    fn lateness(&self, gain: f64) -> Option<Lateness> {
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

    /// Finds out whether the torques are late, where the fit tells.
    fn judge_lateness(&mut self, gain: f64) {
        let Some(found) = self.lateness(gain).filter(|found| found.left < Self::LEFT) else {
            return;
        };
        let beyond = found.delay - Self::CONTROL_DELAY;
        let doubts = if self.late {
            beyond < -found.sigma
        } else {
            beyond > Self::LATE * found.sigma
        };
        self.doubted = if doubts {
            self.doubted + self.last_step
        } else {
            0.0
        };
        if self.doubted > Self::LASTS {
            (self.late, self.doubted) = (!self.late, 0.0);
        }
    }

    /// Share of the torques' differences that a stable speed control explains, from the means of their products with the
    /// angles and speeds of a pairing.
    fn explained(&self, torque_angle: f64, torque_speed: f64) -> f64 {
        let Some(determinant) = self.determinant() else {
            return 0.0;
        };
        let [a, b] = self.coefficients(determinant, torque_angle, torque_speed);
        if a < 0.0 || b < 0.0 {
            (a * torque_angle + b * torque_speed) / self.torque_torque
        } else {
            0.0
        }
    }

    /// Compares the pairings, where the torques differ enough.
    fn judge(&mut self, gain: f64) {
        let least = 3.0 * Self::LEAST_DIFFERENCE * Self::LEAST_DIFFERENCE;
        if self.torque_torque < least {
            return;
        }
        self.judge_lateness(gain);
        let mut stated = None;
        let (mut most, mut moved) = (0.0, Self::MOVED[0]);
        let sums = self.torque_angle.iter().zip(&self.torque_speed);
        for ((torque_angle, torque_speed), torques) in sums.zip(&Self::MOVED) {
            let explained = self.explained(*torque_angle, *torque_speed);
            if stated.is_none() {
                stated = Some(explained);
            } else if explained > most {
                (most, moved) = (explained, *torques);
            }
        }
        let residual = 1.0 - stated.unwrap_or(0.0);
        let left = 1.0 - most;
        if left < Self::EXCHANGED * residual
            && residual > Self::LEAST_RESIDUAL
            && most > Self::EXPLAINED
        {
            self.exchanged = moved;
        } else if left > Self::RIGHT * residual {
            self.exchanged = Self::MOVED[0];
        }
    }
}

/// Moves `slow` towards `value` by a weight.
fn follow(slow: &mut [f64; 3], value: &[f64; 3], weight: f64) {
    for (slow, value) in slow.iter_mut().zip(value) {
        *slow += weight * (value - *slow);
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

/// The wheels' values in all orders; the first is the stated one.
const fn pairings([a, b, c]: [f64; 3]) -> [[f64; 3]; 6] {
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

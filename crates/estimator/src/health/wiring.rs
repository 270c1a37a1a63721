//! Exchanged torques, from the way a speed control answers each wheel's own speed.

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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wiring {
    started: bool,
    /// Time since the sums were last updated, s.
    elapsed: f64,
    /// Time for which the robot has driven, s; at most [`Self::LEAST_TIME`].
    driven: f64,
    /// Smoothed torques, N m.
    torque: [f64; 3],
    /// Smoothed angles, rad.
    angle: [f64; 3],
    /// The same at the last update of the sums, rad.
    last_angle: [f64; 3],
    /// Slow part of the differences of torques (N m), angles (rad), speeds (rad/s).
    slow: [[f64; 3]; 3],
    /// Mean of the squared differences of the torques, summed over the wheels, (N m)^2.
    torque_torque: f64,
    /// Means of products with the angles, N m rad, and speeds, N m rad/s, for each pairing.
    torque_angle: [f64; 6],
    torque_speed: [f64; 6],
    angle_angle: f64,
    angle_speed: f64,
    speed_speed: f64,
    /// Torques that belong to another encoder.
    exchanged: [bool; 3],
}

visit_fields!(Wiring: started, elapsed, driven, torque, angle, last_angle, slow, torque_torque, torque_angle,
    torque_speed, angle_angle, angle_speed, speed_speed, exchanged);

impl Wiring {
    /// Time constant of the smoothing of torques and angles, s: an encoder of 40 urad a count then gives a speed.
    const SMOOTHING: f64 = 0.025;
    /// Time constant beyond which differences are slow, s: offsets of torques, wheels on a longer way.
    const SLOW: f64 = 1.0;
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

    /// Takes the readings of one sample, `dt` (s) after the last. Starts anew without readings.
    pub fn update(&mut self, readings: Option<&WheelReadings>, dt: f64) {
        let Some(readings) = readings else {
            *self = Self {
                exchanged: self.exchanged,
                ..Self::default()
            };
            return;
        };
        if !self.started {
            self.started = true;
            (self.torque, self.angle) = (readings.torque, readings.angle);
            self.last_angle = readings.angle;
            [self.slow[0], self.slow[1]] = [deviations(readings.torque), deviations(self.angle)];
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
            self.elapsed = 0.0;
            if readings.drives && self.driven >= Self::LEAST_TIME {
                self.judge();
            }
        }
    }

    fn update_sums(&mut self) {
        let dt = self.elapsed;
        let mut speed = self.angle;
        for (speed, last) in speed.iter_mut().zip(&self.last_angle) {
            *speed = (*speed - last) / dt;
        }
        self.last_angle = self.angle;
        let mut differences = [self.torque, self.angle, speed].map(deviations);
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

    /// Share of the torques' differences that a stable speed control explains, from the means of their products with the
    /// angles and speeds of a pairing.
    fn explained(&self, torque_angle: f64, torque_speed: f64) -> f64 {
        let determinant = self.angle_angle * self.speed_speed - self.angle_speed * self.angle_speed;
        // No speed of its own, or none at all. In this order a NaN explains nothing, too.
        let regular = determinant > 1e-9 * self.angle_angle * self.speed_speed;
        if !regular {
            return 0.0;
        }
        let a = (torque_angle * self.speed_speed - torque_speed * self.angle_speed) / determinant;
        let b = (torque_speed * self.angle_angle - torque_angle * self.angle_speed) / determinant;
        if a < 0.0 || b < 0.0 {
            (a * torque_angle + b * torque_speed) / self.torque_torque
        } else {
            0.0
        }
    }

    /// Compares the pairings, where the torques differ enough.
    fn judge(&mut self) {
        let least = 3.0 * Self::LEAST_DIFFERENCE * Self::LEAST_DIFFERENCE;
        if self.torque_torque < least {
            return;
        }
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

fn dot([a, b, c]: &[f64; 3], [x, y, z]: &[f64; 3]) -> f64 {
    a * x + b * y + c * z
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
mod tests {
    use super::*;
    use libm::{cos, sin};

    const DT: f64 = 1e-3;

    /// Wheels that oscillate about a common angle with frequencies of their own, under a PI control whose torques are read in
    /// an order. The control is that of the sampled angles: the fit is exact but for the smoothing of the speed.
    fn run(wiring: &mut Wiring, order: [usize; 3], size: f64, time: f64) {
        for k in 0..(time / DT) as u32 {
            let t = f64::from(k) * DT;
            let speeds = [3.0, 4.1, 5.3];
            let ahead = speeds.map(|w| size * sin(w * t));
            let rate = speeds.map(|w| size * w * cos(w * t));
            let torque = order.map(|i| 0.5 - 50.0 * ahead[i] - 5.0 * rate[i]);
            let readings = WheelReadings {
                torque,
                angle: ahead.map(|ahead| 2.0 * t + ahead),
                drives: true,
            };
            wiring.update(Some(&readings), DT);
        }
    }

    /// Each exchange is found within 5 s, with the torques concerned, and forgotten when it is repaired.
    #[test]
    fn exchanged_torques_are_found_and_forgotten() {
        let orders = [
            [0, 1, 2],
            [1, 0, 2],
            [0, 2, 1],
            [2, 1, 0],
            [1, 2, 0],
            [2, 0, 1],
        ];
        for order in orders {
            let mut wiring = Wiring::default();
            run(&mut wiring, order, 0.02, 5.0);
            let moved = [0, 1, 2].map(|i| order[i] != i);
            assert_eq!(wiring.exchanged(), moved, "{order:?}");
            wiring.update(None, DT);
            assert_eq!(wiring.exchanged(), moved, "a gap repairs nothing");
            run(&mut wiring, [0, 1, 2], 0.02, 5.0);
            assert_eq!(wiring.exchanged(), [false; 3], "{order:?}");
        }
    }

    /// Closed form: the residual of the right pairing is zero but for the step of the sums: the speed is that half an interval
    /// (5 ms) before, at 5.3 rad/s a phase of 0.03.
    #[test]
    fn the_right_pairing_explains_all() {
        let mut wiring = Wiring::default();
        run(&mut wiring, [0, 2, 1], 0.02, 20.0);
        let explained = wiring.explained(wiring.torque_angle[2], wiring.torque_speed[2]);
        assert!(explained > 0.99 && explained < 1.0 + 1e-9, "{explained}");
    }

    /// Torques whose differences are 0.1 N m say nothing, nor do a robot at rest and torques that drive a wheel that is ahead.
    #[test]
    fn small_differences_say_nothing() {
        let mut wiring = Wiring::default();
        run(&mut wiring, [0, 2, 1], 0.002, 20.0);
        assert_eq!(wiring.exchanged(), [false; 3]);
        let mut wiring = Wiring::default();
        for k in 0..20_000 {
            let t = f64::from(k) * DT;
            let speeds = [3.0, 4.1, 5.3];
            let ahead = speeds.map(|w| 0.02 * sin(w * t));
            let [a, b, c] = speeds.map(|w| 0.02 * (50.0 * sin(w * t) + 5.0 * w * cos(w * t)));
            let readings = WheelReadings {
                torque: [a, c, b],
                angle: ahead,
                drives: true,
            };
            wiring.update(Some(&readings), DT);
        }
        assert_eq!(wiring.exchanged(), [false; 3]);
    }
}

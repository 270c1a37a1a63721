//! Motor torques and encoders of the wheels, smoothed, with their rates.

use crate::common::FILTER_TIME;

/// Time constant of the means of all tests, s: long against impacts and against the correlation
/// times of the errors, which are at most 0.5 s; short enough to report a fault within 5 s, longer
/// than an obstacle turns a link.
/// Chosen; held by the faults and honest logs of `tests/check`.
pub(super) const WINDOW: f64 = 2.0;

/// Motor torques and encoders of one sample, of wheels 1 to 3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelReadings {
    /// Motor torques, N m.
    pub torque: [f64; 3],
    /// Spin angles, rad.
    pub angle: [f64; 3],
}

/// Smoothed torques and angles with their rates, all of the same instant.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    /// Time since the last step, s.
    pub dt: f64,
    /// Motor torques, N m, and their rates, N m/s.
    pub torque: [f64; 3],
    pub torque_rate: [f64; 3],
    /// Spin angles, rad, speeds, rad/s, and accelerations, rad/s^2.
    pub angle: [f64; 3],
    pub speed: [f64; 3],
    pub acceleration: [f64; 3],
}

/// Smooths readings by the same low pass, and takes differences at longer steps.
///
/// An encoder of 40 urad a count then gives a speed and an acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Smoothing {
    started: bool,
    /// Time since the last step, s.
    elapsed: f64,
    /// Time between the last two steps, s; 0 before the first.
    last_dt: f64,
    /// Torques now, at the last step, and at the one before, N m.
    torque: [[f64; 3]; 3],
    /// Angles now, at the last step, and at the one before, rad.
    angle: [[f64; 3]; 3],
}

impl Smoothing {
    /// Time constant, s.
    pub const TIME: f64 = FILTER_TIME;
    /// Time between steps, s: a third of the time constant.
    /// Definition.
    pub const INTERVAL: f64 = Self::TIME / 3.0;

    /// Takes the readings of one sample, `dt` (s) after the last. Returns a step each
    /// [`Self::INTERVAL`]; it is that of the last time, because rates need a value before and one
    /// after. The first has no rates.
    pub fn update(&mut self, readings: &WheelReadings, dt: f64) -> Option<Step> {
        if !self.started {
            self.started = true;
            (self.torque, self.angle) = ([readings.torque; 3], [readings.angle; 3]);
            return None;
        }
        let weight = robhaz_model::low_pass_share(dt, Self::TIME);
        follow(&mut self.torque[0], &readings.torque, weight);
        follow(&mut self.angle[0], &readings.angle, weight);
        self.elapsed += dt;
        // Sums of rounded steps: half a microsecond less is the whole interval.
        if self.elapsed <= Self::INTERVAL - 0.5e-6 {
            return None;
        }
        let (after, until) = (self.elapsed, self.last_dt);
        let mut step = Step {
            dt: after,
            torque: self.torque[1],
            angle: self.angle[1],
            ..Step::default()
        };
        if until > 0.0 {
            (step.torque_rate, _) = rates(&self.torque, after, until);
            (step.speed, step.acceleration) = rates(&self.angle, after, until);
        }
        for values in [&mut self.torque, &mut self.angle] {
            values[2] = values[1];
            values[1] = values[0];
        }
        (self.last_dt, self.elapsed) = (after, 0.0);
        Some(step)
    }
}

/// First and second derivatives at the middle one of three instants, of values now, `after` (s) and
/// `after + until` before.
fn rates(values: &[[f64; 3]; 3], after: f64, until: f64) -> ([f64; 3], [f64; 3]) {
    let [now, last, before] = values;
    let first = |i: usize| (now[i] - before[i]) / (after + until);
    let change = |i: usize| (now[i] - last[i]) / after - (last[i] - before[i]) / until;
    let second = |i: usize| 2.0 * change(i) / (after + until);
    ([0, 1, 2].map(first), [0, 1, 2].map(second))
}

/// Moves `slow` towards `value` by a weight.
pub(super) fn follow(slow: &mut [f64; 3], value: &[f64; 3], weight: f64) {
    for (slow, value) in slow.iter_mut().zip(value) {
        *slow += weight * (value - *slow);
    }
}

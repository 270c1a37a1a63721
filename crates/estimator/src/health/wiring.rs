//! Exchanged and late torques, from torques and encoders of the wheels.

use super::answer::{Answer, PAIRINGS};
use super::smoothing::{Smoothing, WheelReadings};
use super::start::{RollingRobot, Start};

/// Finds out whether torques are exchanged or late.
///
/// Torques are exchanged if another pairing of torques and encoders leaves a small part of the
/// residual of the stated one, in the answer of a speed control to each wheel's own speed
/// ([`Answer`]). Nothing is said while the torques hardly differ, as on flat ground, or do not
/// answer the wheels' speeds.
///
/// Torques are late if the robot's motion is ahead of them when it starts ([`Start`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wiring {
    smoothing: Smoothing,
    answer: Answer,
    /// Whether all torques are later than the robot's motion.
    pub start: Start,
    /// Time for which the robot has driven, s; at most [`Self::LEAST_TIME`].
    driven: f64,
    /// Torques that belong to another encoder.
    pub exchanged: [bool; 3],
    /// Time for which another pairing has fitted better than [`Self::RIGHT`], s.
    fits_better: f64,
}

impl Wiring {
    /// Time of driving from which on the fit is judged, s: the start of the drive is one event
    /// only.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LEAST_TIME: f64 = 1.0;
    /// RMS of the differences between the torques that shows something, N m: some times their
    /// smoothed noise.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LEAST_DIFFERENCE: f64 = 0.1;
    /// Part of the residual that another pairing leaves at most if torques are exchanged.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const EXCHANGED: f64 = 1.0 / 3.0;
    /// Part of the residual from which on they are no longer.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const RIGHT: f64 = 0.5;
    /// Share that the other pairing explains at least.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const EXPLAINED: f64 = 0.8;
    /// Share that the stated pairing leaves at least: below it the ratio of the residuals is that
    /// of their noise.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LEAST_RESIDUAL: f64 = 0.005;
    /// Time for which another pairing must fit better, s: an impact disturbs the fit for some
    /// hundredths.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LASTS: f64 = 0.2;

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
        if drives {
            self.driven = (self.driven + dt).min(Self::LEAST_TIME);
        }
        let Some(step) = self.smoothing.update(readings, dt) else {
            return;
        };
        self.answer.update(&step);
        self.start.update(&step, robot);
        if drives && self.driven >= Self::LEAST_TIME {
            self.judge(step.dt);
        }
    }

    /// Compares the pairings, where the torques differ enough.
    fn judge(&mut self, dt: f64) {
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
            (self.exchanged, self.fits_better) = ([false; 3], 0.0);
            return;
        }
        self.fits_better += dt;
        if self.fits_better > Self::LASTS
            && left < Self::EXCHANGED * residual
            && residual > Self::LEAST_RESIDUAL
            && most > Self::EXPLAINED
        {
            self.exchanged = [0, 1, 2].map(|i| best[i] != i);
        }
    }
}

#[cfg(test)]
mod tests;

//! The forces at which a ramp of a friction test ended in slip.

use crate::friction::WheelFriction;
use crate::quadrature::root_sum_square;

/// One wheel at the end of a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WheelLimit {
    /// Largest T/N by size, low-pass filtered, with its sign, -. Nothing is taken from it for the differences of the torque
    /// offsets.
    ratio: f64,
    /// Standard deviation of the part of the wheel's torque offset in it, -.
    offset_sigma: f64,
    /// Standard deviation of the rest, -.
    sigma: f64,
}

/// A ramp that ended because a wheel slipped.
///
/// Where the ground is the same under all wheels, the wheel that slips is the one with the largest |T/N|, and that is mu_max. It is
/// the tested wheel, or another one that could not bear the reaction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampLimit {
    tested: usize,
    wheels: [WheelLimit; 3],
}

/// mu_max by one ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct RampFriction {
    /// mu_max, -.
    pub mu: f64,
    /// Part of mu_max by which the ramp differs from the other one of its wheel, as a standard deviation, -.
    pub own: f64,
    /// Standard deviation of the rest, -.
    pub rest: f64,
}

impl RampLimit {
    /// Part of mu_max by which two ramps of a wheel differ without errors of offsets: lag of the filters, errors of N and of the slope
    /// of about 1 % each at the two ends.
    const RAMP: f64 = 0.02;
    /// The same where another wheel slipped: the ground under it, and its tyre, are not quite those of the tested wheel.
    const OTHER_WHEEL: f64 = 0.04;

    /// Standard deviations by which a wheel that slips may seem to need less than another.
    const GATE: f64 = 2.0;

    /// The limit where the tested wheel is seen to slip: the other wheels say nothing of mu_max. Their offsets can make T/N of one of them
    /// the largest on ice.
    pub(super) fn of_tested(self) -> Self {
        let mut wheels = [WheelLimit::default(); 3];
        let found = wheels
            .get_mut(self.tested)
            .zip(self.wheels.get(self.tested));
        if let Some((tested, wheel)) = found {
            *tested = *wheel;
        }
        Self { wheels, ..self }
    }

    /// Whether wheel `i` may be the one that slips: its |T/N| is the largest within its deviation.
    pub(super) fn may_slip(&self, i: usize) -> bool {
        let most = self.friction(&[0.0; 3]).mu;
        self.wheels.get(i).is_some_and(|wheel| {
            let sigma = root_sum_square(wheel.offset_sigma, wheel.sigma);
            wheel.ratio.abs() + Self::GATE * sigma > most
        })
    }

    /// mu_max if the torque offsets of the wheels, less their mean, are `offsets` of their standard deviations.
    pub(super) fn friction(&self, offsets: &[f64; 3]) -> RampFriction {
        let (mut most, mut at, mut rest) = (0.0, self.tested, 0.0);
        for (i, (wheel, offset)) in self.wheels.iter().zip(offsets).enumerate() {
            let ratio = (wheel.ratio - wheel.offset_sigma * offset).abs();
            if ratio > most {
                (most, at, rest) = (ratio, i, wheel.sigma);
            }
        }
        let part = if at == self.tested {
            Self::RAMP
        } else {
            Self::OTHER_WHEEL
        };
        RampFriction {
            mu: most,
            own: part,
            rest,
        }
    }
}

/// Follows the T/N of all wheels under a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LimitWatch {
    wheels: [RatioWatch; 3],
}

impl LimitWatch {
    /// Takes a sample, `dt` (s) after the last. A wheel without load starts anew.
    pub fn update(&mut self, wheels: &[WheelFriction; 3], dt: f64) {
        for (watch, wheel) in self.wheels.iter_mut().zip(wheels) {
            watch.update(wheel, dt);
        }
    }

    /// The limit, if a wheel slips now under the ramp of wheel `tested`.
    pub fn limit(&self, tested: usize) -> RampLimit {
        RampLimit {
            tested,
            wheels: self.wheels.map(|watch| watch.peak),
        }
    }
}

/// Follows the largest T/N by size of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RatioWatch {
    /// Low-pass filtered T/N, -.
    ratio: Option<f64>,
    peak: WheelLimit,
    /// Time since the peak, s.
    age: f64,
}

impl RatioWatch {
    /// Time constant of the low pass, s: as in the watch for slip, T/N is level for longer before a slip is found.
    const SMOOTHING: f64 = 0.05;
    /// Age beyond which a peak is forgotten, s.
    const WINDOW: f64 = 0.6;

    fn update(&mut self, wheel: &WheelFriction, dt: f64) {
        let Some(needed) = wheel.needed else {
            *self = Self::default();
            return;
        };
        let now = needed.value + wheel.offset.removed;
        let ratio = self.ratio.get_or_insert(now);
        *ratio += dt / (Self::SMOOTHING + dt) * (now - *ratio);
        let ratio = *ratio;
        self.age += dt;
        if ratio.abs() >= self.peak.ratio.abs() || self.age > Self::WINDOW {
            self.peak = WheelLimit {
                ratio,
                offset_sigma: wheel.offset.sigma,
                sigma: needed.sigma,
            };
            self.age = 0.0;
        }
    }
}

#[cfg(test)]
pub(super) mod testing {
    use super::{RampLimit, WheelLimit};

    /// A limit from T/N and loads (N), with a deviation of the offsets of `force` (N) and 0.01 for the rest.
    pub fn limit(tested: usize, ratio: [f64; 3], load: [f64; 3], force: f64) -> RampLimit {
        RampLimit {
            tested,
            wheels: [0, 1, 2].map(|i| WheelLimit {
                ratio: ratio[i],
                offset_sigma: force / load[i],
                sigma: 0.01,
            }),
        }
    }
}

//! The forces at which a ramp of a friction test ended in slip.

use libm::hypot;
use robhaz_estimator::{PeakFriction, WheelFriction};

/// One wheel at the end of a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WheelLimit {
    /// Largest T/N by size, low-pass filtered, with its sign, -. Nothing is taken from it for the
    /// differences of the torque offsets.
    ratio: f64,
    /// Standard deviation of the part of the wheel's torque offset in it, -.
    offset_sigma: f64,
    /// Standard deviation of the rest, -.
    sigma: f64,
}

/// A ramp that ended because a wheel slipped.
///
/// Where the ground is the same under all wheels, the wheel that slips is the one with the largest
/// |T/N|, and that is mu_max. It is the tested wheel, or another one that could not bear the
/// reaction.
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
    /// Part of mu_max by which the ramp differs from the other one of its wheel, as a standard
    /// deviation, -.
    pub own: f64,
    /// Standard deviation of the rest, -.
    pub rest: f64,
}

impl RampLimit {
    /// The limit, if a wheel slips now under the ramp of wheel `tested`.
    pub(super) fn new(tested: usize, wheels: &[WheelFriction; 3]) -> Self {
        let limit = |wheel: &WheelFriction| {
            let PeakFriction { needed, offset } = wheel.peak;
            WheelLimit {
                ratio: needed.value + offset.removed,
                offset_sigma: offset.sigma,
                sigma: needed.sigma,
            }
        };
        Self {
            tested,
            wheels: wheels.each_ref().map(limit),
        }
    }

    /// Part of mu_max by which two ramps of a wheel differ without errors of offsets: lag of the
    /// filters, errors of N and of the slope of about 1 % each at the two ends.
    const RAMP: f64 = 0.02;
    /// The same where another wheel slipped: the ground under it, and its tyre, are not quite those
    /// of the tested wheel.
    const OTHER_WHEEL: f64 = 0.04;

    /// Standard deviations by which a wheel that slips may seem to need less than another.
    const GATE: f64 = 2.0;

    /// The limit where the tested wheel is seen to slip: the other wheels say nothing of mu_max.
    /// Their offsets can make T/N of one of them the largest on ice.
    pub(super) fn of_tested(self) -> Self {
        let mut wheels = [WheelLimit::default(); 3];
        let tested = wheels.iter_mut().zip(self.wheels).nth(self.tested);
        if let Some((tested, wheel)) = tested {
            *tested = wheel;
        }
        Self { wheels, ..self }
    }

    /// Whether wheel `i` may be the one that slips: its |T/N| is the largest within its deviation.
    pub(super) fn may_slip(&self, i: usize) -> bool {
        let most = self.friction(&[0.0; 3]).mu;
        self.wheels.get(i).is_some_and(|wheel| {
            let sigma = hypot(wheel.offset_sigma, wheel.sigma);
            wheel.ratio.abs() + Self::GATE * sigma > most
        })
    }

    /// mu_max if the torque offsets of the wheels, less their mean, are `offsets` of their standard
    /// deviations.
    pub(super) fn friction(&self, offsets: &[f64; 3]) -> RampFriction {
        let (mut most, mut at, mut rest) = (0.0, self.tested, 0.0);
        for (i, (wheel, offset)) in self.wheels.iter().zip(offsets).enumerate() {
            let ratio = (wheel.ratio - wheel.offset_sigma * offset).abs();
            if ratio > most {
                (most, at, rest) = (ratio, i, wheel.sigma);
            }
        }
        let own = match at == self.tested {
            true => Self::RAMP,
            false => Self::OTHER_WHEEL,
        };
        let mu = most;
        RampFriction { mu, own, rest }
    }
}

#[cfg(test)]
pub(super) mod testing {
    use super::{RampLimit, WheelLimit};

    /// A limit from T/N and loads (N), with a deviation of the offsets of `force` (N) and 0.01 for
    /// the rest.
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

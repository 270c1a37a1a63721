//! What a friction test has found, and the forces at which its ramps ended in slip.

use core::cmp::Ordering;
use libm::hypot;
use robhaz_estimator::{PeakFriction, WheelFriction};

/// How a friction test ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionTestEnd {
    /// The wheel slipped: mu_max was found.
    Slipped,
    /// The tested wheel slipped, or another one (0 to 2), which needed about as much friction.
    /// mu_max was found, if the ground is the same under both.
    EitherWheel(usize),
    /// The torque reached its limit.
    TorqueLimit,
    /// The test took too long.
    TimeLimit,
    /// Another wheel, 0 to 2, slipped first: the reaction was more than it can bear.
    OtherWheel(usize),
    /// A wheel carries no load, the linkage is at a stop, readings are stale, or there is no
    /// estimate, for more than [`PATIENCE`](super::FrictionTest::PATIENCE).
    NotClear,
    /// Noise and rate of the readings hide an onset of slip, for more than that time: see
    /// [`FrictionTestResult::slip_noise`].
    Noise,
    /// The run ended first.
    #[default]
    Unfinished,
}

impl FrictionTestEnd {
    /// Short name in summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slipped => "slipped",
            Self::EitherWheel(_) => "slipped, or another wheel",
            Self::TorqueLimit => "torque limit",
            Self::TimeLimit => "time limit",
            Self::OtherWheel(_) => "other wheel slipped",
            Self::NotClear => "not clear",
            Self::Noise => "noise hides slip",
            Self::Unfinished => "unfinished",
        }
    }
}

/// Result of a friction test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionTestResult {
    /// The tested wheel, 0 to 2.
    pub wheel: usize,
    /// How it ended.
    pub end: FrictionTestEnd,
    /// Time of the largest T/N, s.
    pub time: f64,
    /// Place of the wheel's contact at that time along the path, m, in the frame of
    /// [`robhaz_estimator::Estimator::ground`]. `None` before the robot has moved, and without
    /// slip.
    pub place: Option<f64>,
    /// mu_max, -, if a ramp ended in slip. Else the largest |T/N|: mu_max is at least this.
    pub mu: f64,
    /// Its standard deviation by the budget of the readings, -. A common scale of all torques
    /// ([`robhaz_estimator::TorqueScale`]) multiplies mu_max, and is not in it.
    pub sigma: f64,
    /// Part of that deviation that comes from the torque offsets, -.
    pub systematic: f64,
    /// Number of ramps that ended in slip of the tested wheel ([`FrictionTestEnd::Slipped`],
    /// [`FrictionTestEnd::EitherWheel`]).
    pub ramps: u32,
    /// The ramps that ended because a wheel slipped, the tested one or another.
    pub limits: [Option<RampLimit>; 2],
    /// Distance that the rim slid from the largest T/N until the wheel gripped again, m. Creep
    /// before it does not count.
    pub slipped_distance: f64,
    /// Noise and rate of the readings at the end of the ramp, over what an onset of slip needs to
    /// show, -: [`WheelFriction::slip_noise`]. Above 1 for [`FrictionTestEnd::Noise`].
    pub slip_noise: f64,
    /// Time from the start of the ramp until the wheel gripped again, or until the ramp ended, s.
    pub duration: f64,
}

impl FrictionTestResult {
    /// This result together with that of a ramp in the other direction, at about the same place.
    ///
    /// Time, place and end are those of the surer one. If neither ended in slip, it is that with
    /// the larger bound. mu_max follows from both by [`together`](super::together()).
    pub fn combined(&self, other: &Self) -> Self {
        let rank = |result: &Self| match result.end {
            FrictionTestEnd::Slipped => 2,
            FrictionTestEnd::EitherWheel(_) => 1,
            _ => 0,
        };
        let bound = |result: &Self| result.mu - result.sigma;
        let other_counts = match rank(other).cmp(&rank(self)) {
            Ordering::Less => false,
            Ordering::Greater => true,
            Ordering::Equal => rank(self) == 0 && bound(other) > bound(self),
        };
        let counts = if other_counts { other } else { self };
        let [first, _] = self.limits;
        let [second, _] = other.limits;
        Self {
            duration: self.duration + other.duration,
            slipped_distance: self.slipped_distance + other.slipped_distance,
            ramps: self.ramps + other.ramps,
            limits: [first, second],
            ..*counts
        }
    }
}

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

    /// The limit where the tested wheel is known to slip: the other wheels do not bound mu_max.
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

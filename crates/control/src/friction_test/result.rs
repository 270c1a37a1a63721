//! What a friction test has found.

use super::limit::RampLimit;
use core::cmp::Ordering;

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
    /// Its standard deviation, -.
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

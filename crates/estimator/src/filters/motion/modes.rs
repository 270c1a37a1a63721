//! What the robot and its wheels do while the constraints of rolling do not hold, and for how long
//! the readings bear the mark of it.

use super::tuning;
use crate::common::SMOOTHING;

/// After an impact, at an edge, at rest, sliding, under a load that no reading shows.
///
/// | while | what follows |
/// |---|---|
/// | after an impact, at an edge, at rest | rolling constraints count less, inclinometers show no acceleration, mapped slopes no contact angle, the acceleration lasts for a short time only; health and the torques' scale wait |
/// | a wheel slides | its slip corrects nothing |
/// | unmodelled load | eq. (8) and its parity residual are as uncertain |
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Modes {
    /// Remaining time after an impact, s.
    impact: f64,
    /// Remaining time for which each wheel counts as sliding, s.
    sliding: [f64; 3],
    /// Variance of the unmodelled load, N^2.
    load: f64,
}

impl Modes {
    /// An impact, an edge, or standstill, at this sample.
    pub fn set_impact(&mut self) {
        self.impact = tuning::IMPACT_TIME;
    }

    pub fn is_after_impact(&self) -> bool {
        self.impact > 0.0
    }

    /// Wheel `i` slides at this sample.
    pub fn set_sliding(&mut self, i: usize) {
        if let Some(time) = self.sliding.get_mut(i) {
            *time = tuning::SLIDING_TIME;
        }
    }

    pub fn is_sliding(&self, i: usize) -> bool {
        self.sliding.get(i).is_some_and(|time| *time > 0.0)
    }

    /// A load of this variance that no reading shows, N^2.
    pub fn load_at_least(&mut self, variance: f64) {
        self.load = self.load.max(variance);
    }

    /// Variance of the load that no reading shows, N^2.
    pub fn load(&self) -> f64 {
        self.load
    }

    /// Lets `dt` pass, s.
    pub fn advance(&mut self, dt: f64) {
        self.impact = (self.impact - dt).max(0.0);
        for time in &mut self.sliding {
            *time = (*time - dt).max(0.0);
        }
        self.load *= libm::exp(-dt / SMOOTHING);
        if self.load < tuning::UNMODELLED_FLOOR {
            self.load = 0.0;
        }
    }
}

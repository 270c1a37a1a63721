//! How much the other side of a robot with two pushes through the body.

use crate::common::OBSTACLES;
use crate::deviation::WITHIN;

/// Mean square of the push, as the parity residual shows it: with tractions that the motors'
/// torques give, the horizontal balance of a side is left with the push.
///
/// The mean is that since the start, over some seconds at most. A residual shows errors of contact
/// angles as well, so it is rather too large. A push beyond two of its deviations makes it larger at
/// once: what the other side does when it meets an obstacle is no outlier of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PushFilter {
    /// N^2.
    square: f64,
    /// Time over which the mean is, s.
    time: f64,
}

impl PushFilter {
    /// Standard deviation before anything is seen, over the weight of the side. On uneven ground
    /// wheels push by a twentieth of it where their speed control yields, by a quarter where each
    /// holds its own speed, in a skid turn by half.
    /// Chosen; insensitive.
    const PRIOR: f64 = 0.1;
    /// Correlation time of a push, s, for which the prior counts: some tenths of a metre of ground
    /// under a wheel, or a turn.
    /// Chosen; sensitive: with 2 s one side of drawn rovers errs by up to a fifth more.
    pub const LASTS: f64 = 1.0;

    /// For a side of this weight, N.
    pub fn new(weight: f64) -> Self {
        let prior = Self::PRIOR * weight;
        Self {
            square: prior * prior,
            time: Self::LASTS,
        }
    }

    /// Takes the square of the push that a residual shows less the variance of its noise (N^2), `dt`
    /// (s) after the last.
    pub fn update(&mut self, seen: f64, dt: f64) {
        self.time = (self.time + dt).min(OBSTACLES);
        let mean = self.square + (dt / self.time).min(1.0) * (seen - self.square);
        self.square = mean.max(seen / (WITHIN * WITHIN)).max(0.0);
    }

    /// Mean square, N^2.
    pub fn variance(&self) -> f64 {
        self.square
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the first seconds are a mean with the prior, which counts for its time; a push
    /// beyond two deviations counts at once by half.
    #[test]
    fn a_push_becomes_the_deviation() {
        let dt = 1e-3;
        let mut push = PushFilter::new(100.0);
        let prior = push.variance();
        for _ in 0..2000 {
            push.update(16.0, dt);
        }
        let expected = (PushFilter::LASTS * prior + 2.0 * 16.0) / (PushFilter::LASTS + 2.0);
        // Rounding.
        assert!((push.variance() - expected).abs() < 1e-9 * expected);
        push.update(60.0 * 60.0, dt);
        assert!((push.variance().sqrt() - 30.0).abs() < 1e-9);
        // Noise that is less than expected leaves no negative variance.
        for _ in 0..30_000 {
            push.update(-9.0, dt);
        }
        assert!(push.variance() == 0.0);
    }
}

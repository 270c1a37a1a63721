//! A measurement as a filter takes it: what is declared of it, and the one way in which it is tested and
//! corrects the states.

use super::kalman::{Innovation, Kalman, Projection};

/// A time-correlated error: a first-order Gauss-Markov process, given by its stationary standard
/// deviation (in the unit of its quantity) and its correlation time (s).
#[derive(Clone, Copy, Debug)]
pub struct GaussMarkov {
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation time, s.
    pub time: f64,
}

impl GaussMarkov {
    /// A process with the correlation time `time` (s).
    pub const fn new(sigma: f64, time: f64) -> Self {
        Self { sigma, time }
    }

    /// The process at `speed_ratio` times the speed: the standard deviation times the ratio, the
    /// time over the ratio.
    pub fn at_speed(self, speed_ratio: f64) -> Self {
        Self {
            sigma: self.sigma * speed_ratio,
            time: self.time / speed_ratio,
        }
    }

    /// Variance of the white noise, at samples every `dt` (s), whose mean
    /// over a long time is as uncertain: `sigma^2 2 time/dt`, from the integral of the
    /// autocorrelation `sigma^2 exp(-|t|/time)`. At least `sigma^2`, for samples that are rarer than
    /// the error lasts.
    pub fn white(self, dt: f64) -> f64 {
        self.sigma * self.sigma * (2.0 * self.time / dt).max(1.0)
    }
}

/// A scalar measurement: `measured - predicted = h' (x - x_estimated) + error`.
///
/// An error that lasts has the deviation that it has at one sample; in the correction it counts as
/// white noise whose mean over many samples is as uncertain ([`GaussMarkov::white`]). An error that
/// decides an estimate within its own correlation time must be a state instead, as the speed of
/// penetration is.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<const K: usize, const L: usize> {
    /// h: states, each with the derivative by it.
    pub row: [(usize, f64); K],
    /// Measured minus predicted, in the measurement's unit.
    pub innovation: f64,
    /// Variance of the error that is new at every sample.
    pub white: f64,
    /// Errors that last: deviation at one sample, correlation time.
    pub correlated: [GaussMarkov; L],
    /// Variance by which it counts less while its model may not hold. Not expected of good readings:
    /// it is no part of the predicted variance of the innovation.
    pub inflation: f64,
    /// Deviations beyond which the innovation's variance is inflated: [`crate::deviation`].
    pub gate: f64,
}

/// What a filter expects of a measurement before it corrects the states.
#[derive(Clone, Copy, Debug)]
pub struct Expected<const N: usize> {
    /// The innovation, with its predicted variance at one sample.
    pub innovation: Innovation,
    /// The measurement's row on the states.
    pub projection: Projection<N>,
}

impl<const K: usize, const L: usize> Measurement<K, L> {
    /// Variance of its error at one sample.
    pub fn at_once(&self) -> f64 {
        let correlated = self
            .correlated
            .iter()
            .map(|error| error.sigma * error.sigma);
        self.white + correlated.sum::<f64>()
    }

    /// R of samples every `dt`, s.
    fn noise(&self, dt: f64) -> f64 {
        let correlated = self.correlated.iter().map(|error| error.white(dt));
        self.white + self.inflation + correlated.sum::<f64>()
    }

    /// Variance of the innovation by which the measurement corrects, `dt` seconds after the last of
    /// its kind. `None` where a number is not finite: it corrects nothing.
    ///
    /// Beyond its gate the variance is inflated until the innovation lies there, so that the
    /// correction falls with one over the innovation, but no wrong state shuts out all later readings
    /// (Chang, Robust Kalman filtering based on Mahalanobis distance, J. Geodesy 88, 2014).
    pub fn weight<const N: usize>(&self, expected: &Expected<N>, dt: f64) -> Option<f64> {
        let found = Innovation {
            value: self.innovation,
            variance: expected.projection.variance + self.noise(dt),
        };
        found.inflated(self.gate)
    }
}

impl<const N: usize, const FIRST: usize, const CONSIDERED: usize> Kalman<N, FIRST, CONSIDERED> {
    /// What the states predict of a measurement.
    pub fn expect<const K: usize, const L: usize>(
        &self,
        measurement: &Measurement<K, L>,
    ) -> Expected<N> {
        let projection = self.project(&measurement.row);
        Expected {
            innovation: Innovation {
                value: measurement.innovation,
                variance: projection.variance + measurement.at_once(),
            },
            projection,
        }
    }

    /// Corrects all but the consider states by a measurement, `dt` seconds after the last of its kind.
    pub fn correct<const K: usize, const L: usize>(
        &mut self,
        measurement: &Measurement<K, L>,
        expected: &Expected<N>,
        dt: f64,
    ) {
        if let Some(s) = measurement.weight(expected, dt) {
            self.apply(&expected.projection.ph, measurement.innovation, s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::positive;
    use proptest::prelude::*;

    /// Of the second state alone, with white noise and a gate of five deviations.
    fn of_the_second(innovation: f64, white: f64) -> Measurement<1, 0> {
        Measurement {
            row: [(1, 1.0)],
            innovation,
            white,
            correlated: [],
            inflation: 0.0,
            gate: 5.0,
        }
    }

    proptest! {
        /// Closed form: a measurement beyond the gate of five deviations corrects as one whose
        /// innovation has the variance d^2/25. Rounding.
        #[test]
        fn outliers_count_by_less(root in prop::array::uniform9(-1.0_f64..1.0), far in 20.0_f64..200.0, sign in prop::bool::ANY) {
            let p = positive::<3>(&root);
            let before: Kalman<3> = Kalman { x: [1.0, 2.0, 3.0], p: [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[(i, j)])) };
            let far = if sign { far } else { -far };
            let (mut outlier, mut noisy) = (before, before);
            let measurement = of_the_second(far, 0.1);
            let expected = outlier.expect(&measurement);
            outlier.correct(&measurement, &expected, 1.0);
            prop_assume!(expected.innovation.nis() > 25.0);
            noisy.update(&[(1, 1.0)], far, far * far / 25.0 - p[(1, 1)]);
            for i in 0..3 {
                prop_assert!((outlier.x[i] - noisy.x[i]).abs() < 1e-9);
                for j in 0..3 {
                    prop_assert!((outlier.p[i][j] - noisy.p[i][j]).abs() < 1e-9);
                }
            }
        }

        /// A measurement that is not a finite number changes nothing.
        #[test]
        fn nan_is_rejected(root in prop::array::uniform9(-1.0_f64..1.0)) {
            let p = positive::<3>(&root);
            let before: Kalman<3> = Kalman { x: [1.0, 2.0, 3.0], p: [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[(i, j)])) };
            for (difference, r) in [(f64::NAN, 0.1), (0.1, f64::NAN), (f64::INFINITY, 0.1), (0.1, f64::INFINITY)] {
                let mut filter = before;
                let measurement = of_the_second(difference, r);
                let expected = filter.expect(&measurement);
                filter.correct(&measurement, &expected, 1.0);
                prop_assert_eq!(filter, before);
            }
        }
    }
}

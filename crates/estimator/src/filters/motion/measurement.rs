//! A measurement as the filter takes it: what is declared of it, and the one way in which it is
//! tested and corrects the states.

use super::filter::MotionFilter;
use super::tuning::GaussMarkov;
use crate::filters::{Innovation, Projection};
use crate::state::COUNT;

/// A scalar measurement: `measured - predicted = h' (x - x_estimated) + error`.
///
/// An error that lasts has the deviation that it has at one sample; in the correction it counts as
/// white noise whose mean over many samples is as uncertain ([`GaussMarkov::white`]). An error that
/// decides an estimate within its own correlation time must be a state instead, as the speed of
/// penetration is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement<const K: usize, const L: usize> {
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

/// What the filter expects of a measurement before it corrects the states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// The innovation, with its predicted variance at one sample.
    pub innovation: Innovation,
    projection: Projection<COUNT>,
}

impl<const K: usize, const L: usize> Measurement<K, L> {
    /// Variance of its error at one sample.
    pub(super) fn at_once(&self) -> f64 {
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
}

impl MotionFilter {
    /// What the states predict of a measurement.
    pub(super) fn expect<const K: usize, const L: usize>(
        &self,
        measurement: &Measurement<K, L>,
    ) -> Expected {
        let projection = self.filter.project(&measurement.row);
        Expected {
            innovation: Innovation {
                value: measurement.innovation,
                variance: projection.variance + measurement.at_once(),
            },
            projection,
        }
    }

    /// Variance of a predicted measurement by the states without `state`, whose derivative is 1.
    pub(super) fn variance_without(&self, expected: &Expected, state: usize) -> f64 {
        let Expected { projection, .. } = expected;
        projection.variance - 2.0 * projection.ph[state] + self.filter.p[state][state]
    }

    /// Corrects the states by a measurement, `dt` seconds after the last of its kind; all but the
    /// torque gains.
    pub(super) fn correct<const K: usize, const L: usize>(
        &mut self,
        measurement: &Measurement<K, L>,
        expected: &Expected,
        dt: f64,
    ) {
        let Expected { projection, .. } = expected;
        let found = Innovation {
            value: measurement.innovation,
            variance: projection.variance + measurement.noise(dt),
        };
        if let Some(s) = found.inflated(measurement.gate) {
            self.correct_guests(&measurement.row, &projection.ph, s);
            self.filter.apply(&projection.ph, found.value, s);
        }
    }
}

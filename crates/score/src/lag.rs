//! The time by which an estimate follows the truth.

use crate::sum::Sum;

/// Sums over pairs of neighbouring samples.
///
/// An estimate that is late by tau errs by `-tau dN/dt` to first order: tau is the least-squares
/// fit of that line to the errors of the three wheels. A constant error does not change it where
/// the truth comes back to its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LagSums {
    /// The last sample: time (s), true N and its error (N).
    last: Option<(f64, [f64; 3], [f64; 3])>,
    /// Sum of error times change of the truth, N^2.
    product: Sum,
    /// Sum of the squared change of the truth over the time between the samples, N^2/s.
    square: Sum,
    /// Sum of these times over pairs and wheels, s.
    time: Sum,
}

impl LagSums {
    /// Longest time between neighbouring samples, s: records at 50 Hz.
    const LONGEST_STEP: f64 = 0.02 + 1e-9;
    /// Rate of the true N from which a change is an impact, in wheel loads a second: there the
    /// first order does not hold, and a few samples would outweigh all others. Rolling wheels stay
    /// below a fifth of it.
    const IMPACT: f64 = 10.0;
    /// RMS rate of the true N below which there is nothing to follow, N/s.
    const LEAST_RATE: f64 = 0.1;

    /// Adds the true N and its errors (N) at a time (s).
    pub(crate) fn add(&mut self, time: f64, truth: [f64; 3], error: [f64; 3]) {
        let Some((before, old_truth, old_error)) = self.last.replace((time, truth, error)) else {
            return;
        };
        let dt = time - before;
        if !(dt > 0.0 && dt <= Self::LONGEST_STEP) {
            return;
        }
        let load = truth.iter().sum::<f64>() / 3.0;
        for i in 0..3 {
            let change = truth[i] - old_truth[i];
            if change.abs() <= Self::IMPACT * load * dt {
                self.product.add(0.5 * (error[i] + old_error[i]) * change);
                self.square.add(change * change / dt);
                self.time.add(dt);
            }
        }
    }

    /// The lag, s; `None` where the truth hardly changes.
    pub(crate) fn lag(&self) -> Option<f64> {
        let square = self.square.value();
        let least = Self::LEAST_RATE * Self::LEAST_RATE * self.time.value();
        (square > least).then(|| -self.product.value() / square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Feeds N = 40 + 10 sin(pi t) over five periods at 1 kHz, estimated with a delay (s) and a
    /// bias (N).
    fn found(delay: f64, bias: f64, impact: f64) -> Option<f64> {
        let mut sums = LagSums::default();
        let n = |t: f64| 40.0 + 10.0 * (PI * t).sin();
        for k in 0..10_000 {
            let t = 1e-3 * f64::from(k);
            // A record in which the truth jumps and the estimate does not.
            let jump = if k == 5000 { impact } else { 0.0 };
            sums.add(t, [n(t) + jump; 3], [n(t - delay) + bias - n(t) - jump; 3]);
        }
        sums.lag()
    }

    /// Closed form: over whole periods a sine of the rate w that is late by tau has the lag
    /// `sin(w tau)/w`, whatever the bias. The last step of the record is missing: 1e-3 of the lag,
    /// and 1e-3 of the bias over the amplitude w 10 N.
    #[test]
    fn a_delayed_sine_has_that_lag() {
        for delay in [-0.02, 0.0, 0.005, 0.05] {
            let lag = found(delay, 0.0, 0.0).expect("the truth changes");
            let expected = (PI * delay).sin() / PI;
            assert!(
                (lag - expected).abs() < 1e-3 * delay.abs() + 1e-9,
                "{delay} {lag}"
            );
            let biased = found(delay, 1.0, 0.0).expect("the truth changes");
            assert!((biased - lag).abs() < 1e-4, "{biased} {lag}");
        }
    }

    /// An impact does not count, a constant truth has no lag.
    #[test]
    fn impacts_do_not_count() {
        let lag = found(0.01, 0.0, 100.0).expect("the truth changes");
        assert!((lag - 0.01).abs() < 1e-4, "{lag}");
        let mut sums = LagSums::default();
        for k in 0..100 {
            sums.add(1e-3 * f64::from(k), [40.0; 3], [1.0; 3]);
        }
        assert_eq!(sums.lag(), None);
    }
}

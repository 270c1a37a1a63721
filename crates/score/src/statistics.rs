//! Statistics of errors over samples.

use crate::rule::Compared;
use crate::sum::{Sum, means, share};
use nalgebra::{Matrix3, Vector3};
use robhaz_estimator::Estimate;
use serde::{Deserialize, Serialize};

/// Errors of one estimator over a set of samples, and how they compare with the covariance that it
/// states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    samples: u64,
    load: [Sum; 3],
    normal_force: ErrorSums,
    traction: ErrorSums,
    lag: LagSums,
    stated: Stated,
}

/// Sums over the samples for which the estimator states a covariance of N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stated {
    /// Samples with a positive definite covariance of the three N and every N > 0. At N = 0 the
    /// error is not Gaussian. The NIS has its own count.
    samples: u64,
    /// Sum of ln sigma over wheels and samples.
    logarithm: Sum,
    /// Sum of `(e/sigma)^2` over wheels and samples.
    normalised: Sum,
    nees: Sum,
    /// Errors within two standard deviations, over wheels and samples.
    inside: u64,
    /// Samples with an expected standard deviation of the parity residual.
    innovations: u64,
    nis: Sum,
}

impl Statistics {
    /// Adds a sample with an estimate whose forces are finite.
    pub(crate) fn add(&mut self, time: f64, compared: &Compared, estimate: &Estimate) {
        let wheels = &compared.wheels;
        let normal_force = [0, 1, 2].map(|i| estimate.normal_force[i] - wheels[i].normal_force);
        let traction = [0, 1, 2].map(|i| estimate.traction[i] - wheels[i].traction);
        self.samples += 1;
        for (sum, wheel) in self.load.iter_mut().zip(wheels) {
            sum.add(wheel.normal_force);
        }
        self.normal_force.add(time, normal_force);
        self.traction.add(time, traction);
        let truth = wheels.each_ref().map(|wheel| wheel.normal_force);
        self.lag.add(time, truth, normal_force);
        self.stated.add(estimate, normal_force);
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Errors of N; `None` without samples.
    pub fn normal_force(&self) -> Option<ForceErrors> {
        self.normal_force.errors(self.samples, self.mean_load())
    }

    /// Errors of T; `None` without samples.
    pub fn traction(&self) -> Option<ForceErrors> {
        self.traction.errors(self.samples, self.mean_load())
    }

    /// Time by which the estimated N follow the true ones, s: see [`crate`]. `None` where the truth
    /// hardly changes.
    pub fn lag(&self) -> Option<f64> {
        self.lag.lag()
    }

    /// RMS error of N divided by the mean true N, dimensionless; `None` without samples or load.
    pub fn nrmse(&self) -> Option<f64> {
        self.normal_force()?.nrmse
    }

    /// Mean true N of each wheel, N; `None` without samples.
    pub fn mean_normal_force(&self) -> Option<[f64; 3]> {
        means(&self.load, self.samples)
    }

    /// Geometric mean of the stated standard deviations of N, divided by the mean true N,
    /// dimensionless; `None` if the estimator stated none. Geometric, because at an impact the
    /// estimator states hundreds of times as much as before and after.
    pub fn stated(&self) -> Option<f64> {
        let sigma = self.stated.logarithm.mean(3 * self.stated.samples)?.exp();
        Some(sigma / self.mean_load()?)
    }

    /// RMS of error divided by stated standard deviation of N, dimensionless: 1 if these are right;
    /// `None` if none was stated.
    pub fn normalised(&self) -> Option<f64> {
        let mean = self.stated.normalised.mean(3 * self.stated.samples)?;
        Some(mean.sqrt())
    }

    /// Mean NEES of the three N: 3 if the stated covariance is right; `None` if none was stated.
    pub fn nees(&self) -> Option<f64> {
        self.stated.nees.mean(self.stated.samples)
    }

    /// Mean NIS of the parity residual: 1 if its expected variance is right; `None` if none was
    /// stated.
    pub fn nis(&self) -> Option<f64> {
        self.stated.nis.mean(self.stated.innovations)
    }

    /// Share of errors of N within two stated standard deviations, -; `None` if none was stated.
    pub fn coverage(&self) -> Option<f64> {
        share(self.stated.inside, 3 * self.stated.samples)
    }

    /// Mean of N over wheels and samples, N; `None` where it is not positive.
    fn mean_load(&self) -> Option<f64> {
        let mean = self.mean_normal_force()?.iter().sum::<f64>() / 3.0;
        (mean > 0.0).then_some(mean)
    }
}

impl Stated {
    /// Adds the errors of N at one sample, N.
    fn add(&mut self, estimate: &Estimate, error: [f64; 3]) {
        let Some(covariance) = estimate.kalman.as_ref().map(|k| &k.covariance) else {
            return;
        };
        if let Some(parity) = estimate.parity.filter(|p| p.sigma > 0.0) {
            self.innovations += 1;
            self.nis.add((parity.value / parity.sigma).powi(2));
        }
        if estimate.normal_force.iter().any(|n| *n <= 0.0) {
            return;
        }
        // The covariance is ordered as x' = [T1 N1 T2 N2 T3 N3].
        let p = Matrix3::from_fn(|i, j| covariance[2 * i + 1][2 * j + 1]);
        let Some(nees) = mahalanobis(&error.into(), p) else {
            return;
        };
        self.samples += 1;
        self.nees.add(nees);
        for (i, e) in error.iter().enumerate() {
            let variance = p[(i, i)];
            self.logarithm.add(0.5 * variance.ln());
            self.normalised.add(e * e / variance);
            self.inside += u64::from(e * e <= 4.0 * variance);
        }
    }
}

/// `e' P^-1 e`; `None` where P is not positive definite.
fn mahalanobis(e: &Vector3<f64>, p: Matrix3<f64>) -> Option<f64> {
    Some(e.dot(&p.cholesky()?.solve(e)))
}

/// Errors of one force over the samples of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceErrors {
    /// Root mean square error of each wheel, N.
    pub rmse: [f64; 3],
    /// Root mean square error over the three wheels, N.
    pub rmse_all: f64,
    /// `rmse_all` over the mean true normal force of the three wheels, -; `None` when no wheel ever
    /// carried load.
    pub nrmse: Option<f64>,
    /// Mean error of each wheel, estimate minus truth, N.
    pub bias: [f64; 3],
    /// Largest absolute error of any wheel, N.
    pub max_abs: f64,
    /// Time of that error, s.
    pub max_abs_time_s: f64,
}

/// Root mean square error of N over the three wheels at one sample, N.
pub fn rms_over_wheels(estimate: &Estimate, compared: &Compared) -> f64 {
    let wheels = compared.wheels.iter().zip(estimate.normal_force);
    let squares: f64 = wheels
        .map(|(wheel, n)| (n - wheel.normal_force).powi(2))
        .sum();
    (squares / 3.0).sqrt()
}

/// Running sums of the errors of one force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ErrorSums {
    errors: [Sum; 3],
    squares: [Sum; 3],
    largest: f64,
    largest_at: f64,
}

impl ErrorSums {
    /// Adds the errors of the three wheels (N) at the sample of a time (s).
    fn add(&mut self, time: f64, errors: [f64; 3]) {
        for (i, error) in errors.into_iter().enumerate() {
            self.errors[i].add(error);
            self.squares[i].add(error * error);
            if error.abs() > self.largest {
                (self.largest, self.largest_at) = (error.abs(), time);
            }
        }
    }

    /// The errors over `samples`, for a mean load in N; `None` without samples.
    fn errors(&self, samples: u64, mean_load: Option<f64>) -> Option<ForceErrors> {
        let mean_squares = means(&self.squares, samples)?;
        let rmse_all = (mean_squares.iter().sum::<f64>() / 3.0).sqrt();
        Some(ForceErrors {
            rmse: mean_squares.map(f64::sqrt),
            rmse_all,
            nrmse: mean_load.map(|load| rmse_all / load),
            bias: means(&self.errors, samples)?,
            max_abs: self.largest,
            max_abs_time_s: self.largest_at,
        })
    }
}

/// The time by which an estimate follows the truth: sums over pairs of neighbouring samples.
///
/// An estimate that is late by tau errs by `-tau dN/dt` to first order: tau is the least-squares
/// fit of that line to the errors of the three wheels. A constant error does not change it where
/// the truth comes back to its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct LagSums {
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
    fn add(&mut self, time: f64, truth: [f64; 3], error: [f64; 3]) {
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
    fn lag(&self) -> Option<f64> {
        let square = self.square.value();
        let least = Self::LEAST_RATE * Self::LEAST_RATE * self.time.value();
        (square > least).then(|| -self.product.value() / square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Closed form: P = L L' with L = [[2,0,0],[1,1,0],[0,3,1]] and e = L (1, 2, 3) give 1 + 4 + 9.
    #[test]
    fn mahalanobis_distance_of_a_known_factor() {
        let l = Matrix3::new(2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 3.0, 1.0);
        let e = l * Vector3::new(1.0, 2.0, 3.0);
        let square = mahalanobis(&e, l * l.transpose()).expect("positive definite");
        assert!((square - 14.0).abs() < 1e-12, "{square}");
        assert_eq!(mahalanobis(&e, Matrix3::zeros()), None);
    }

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

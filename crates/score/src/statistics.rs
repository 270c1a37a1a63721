//! Statistics of errors over samples.

use crate::errors::{ErrorSums, ForceErrors};
use crate::lag::LagSums;
use crate::rule::Compared;
use crate::sum::{Sum, means, share};
use nalgebra::{Matrix3, Vector3};
use robhaz_estimator::Estimate;

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
        let Some(covariance) = &estimate.covariance else {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: P = L L' with L = [[2,0,0],[1,1,0],[0,3,1]] and e = L (1, 2, 3) give 1 + 4 + 9.
    #[test]
    fn mahalanobis_distance_of_a_known_factor() {
        let l = Matrix3::new(2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 3.0, 1.0);
        let e = l * Vector3::new(1.0, 2.0, 3.0);
        let square = mahalanobis(&e, l * l.transpose()).expect("positive definite");
        assert!((square - 14.0).abs() < 1e-12, "{square}");
        assert_eq!(mahalanobis(&e, Matrix3::zeros()), None);
    }
}

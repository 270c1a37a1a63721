//! Errors of the six normal forces of a rover with both sides.

use crate::sum::{Sum, means, share};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Sums over the samples of a run with both sides. Wheels are left 1 to 3, then right 1 to 3.
#[derive(Clone, Copy, Debug, Default)]
pub struct BothStatistics {
    samples: u64,
    squares: [Sum; 6],
    variances: [Sum; 6],
    normalised: Sum,
    inside: u64,
    nees: Sum,
    definite: u64,
}

/// Errors of six normal forces, and how they compare with what is stated. Shares refer to the mean
/// of the true N over the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BothErrors {
    /// RMS error over all wheels, over the mean N, -.
    pub nrmse: f64,
    /// RMS error of each wheel over the mean N, -.
    pub nrmse_of_wheels: [f64; 6],
    /// RMS of the stated standard deviations over the mean N, -.
    pub stated: f64,
    /// Share of the errors within two stated standard deviations, -.
    pub coverage: f64,
    /// RMS of the errors, each over its stated standard deviation: 1 if these are right.
    pub error_over_stated: f64,
    /// Mean NEES of the six N: 6 if the stated covariance is right; `None` where it never is
    /// positive definite.
    pub nees: Option<f64>,
}

impl BothStatistics {
    /// Adds the errors of a sample, N, and their stated covariance, N^2.
    pub fn add(&mut self, errors: [f64; 6], covariance: &[[f64; 6]; 6]) {
        self.samples += 1;
        for (i, error) in errors.into_iter().enumerate() {
            let (square, variance) = (error * error, covariance[i][i]);
            self.squares[i].add(square);
            self.variances[i].add(variance);
            self.normalised.add(square / variance);
            self.inside += u64::from(square <= 4.0 * variance);
        }
        let p = SMatrix::<f64, 6, 6>::from_fn(|i, j| covariance[i][j]);
        let e = SVector::from(errors);
        if let Some(factor) = p.cholesky() {
            self.nees.add(e.dot(&factor.solve(&e)));
            self.definite += 1;
        }
    }

    /// The errors for a mean load (N); `None` without samples.
    pub fn errors(&self, load: f64) -> Option<BothErrors> {
        let squares = means(&self.squares, self.samples)?;
        let variances = means(&self.variances, self.samples)?;
        let of_all = |means: &[f64; 6]| (means.iter().sum::<f64>() / 6.0).sqrt() / load;
        Some(BothErrors {
            nrmse: of_all(&squares),
            nrmse_of_wheels: squares.map(|square| square.sqrt() / load),
            stated: of_all(&variances),
            coverage: share(self.inside, 6 * self.samples)?,
            error_over_stated: self.normalised.mean(6 * self.samples)?.sqrt(),
            nees: self.nees.mean(self.definite),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: errors of 1, 2 and 3 N, twice each, with a deviation of 1 N: mean square 14/3,
    /// which is also the normalised one; four of six within two deviations; NEES 28.
    #[test]
    fn errors_of_six_wheels() {
        let mut sums = BothStatistics::default();
        assert!(sums.errors(10.0).is_none());
        let unit = core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
        sums.add([1.0, 2.0, 3.0, -1.0, -2.0, -3.0], &unit);
        let found = sums.errors(10.0).expect("a sample");
        let rms = (14.0_f64 / 3.0).sqrt();
        assert!((found.nrmse - rms / 10.0).abs() < 1e-15);
        assert!((found.nrmse_of_wheels[5] - 0.3).abs() < 1e-15);
        assert!((found.stated - 0.1).abs() < 1e-15);
        assert!((found.error_over_stated - rms).abs() < 1e-14);
        assert!((found.coverage - 4.0 / 6.0).abs() < 1e-15);
        assert!((found.nees.expect("definite") - 28.0).abs() < 1e-12);
    }
}

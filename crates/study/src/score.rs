//! How exact one estimator is over one run.

use nalgebra::{Matrix3, Vector3};
use robhaz_estimator::Estimate;
use robhaz_sim::Truth;

/// Errors of one estimator over one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    samples: u64,
    missing: u64,
    normal_square: f64,
    normal_sum: f64,
    traction_square: f64,
    /// Where the estimator stated a covariance of N. Where it holds an N at zero the covariance is none of the three N.
    judged: u64,
    /// Sum of ln sigma, and of squares of errors over sigma.
    stated_logarithm: f64,
    normalised_square: f64,
    nees: f64,
    inside: u64,
    /// Where it stated what to expect of the parity residual.
    innovations: u64,
    nis: f64,
}

impl Score {
    /// Takes an instant. Without an estimate, or with forces that are not finite, it counts as missing.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Estimate>) {
        let usable = |e: &&Estimate| {
            let mut forces = e.normal_force.iter().chain(&e.traction);
            forces.all(|f| f.is_finite())
        };
        let Some(estimate) = estimate.filter(usable) else {
            self.missing += 1;
            return;
        };
        self.samples += 1;
        let mut error = [0.0; 3];
        for (i, wheel) in truth.wheels.iter().enumerate() {
            error[i] = estimate.normal_force[i] - wheel.normal_force;
            self.normal_square += error[i] * error[i];
            self.normal_sum += wheel.normal_force;
            self.traction_square += (estimate.traction[i] - wheel.traction).powi(2);
        }
        let Some(covariance) = &estimate.covariance else {
            return;
        };
        if let Some(parity) = estimate.parity.filter(|p| p.sigma > 0.0) {
            self.innovations += 1;
            self.nis += (parity.value / parity.sigma).powi(2);
        }
        if estimate.normal_force.iter().any(|n| *n <= 0.0) {
            return;
        }
        let p = Matrix3::from_fn(|i, j| covariance[2 * i + 1][2 * j + 1]);
        let Some(nees) = mahalanobis(&error.into(), p) else {
            return;
        };
        self.judged += 1;
        self.nees += nees;
        for (i, e) in error.iter().enumerate() {
            let variance = p[(i, i)];
            self.stated_logarithm += 0.5 * variance.ln();
            self.normalised_square += e * e / variance;
            self.inside += u64::from(e * e <= 4.0 * variance);
        }
    }

    /// RMS error of N over its mean; `None` without an estimate.
    pub fn nrmse(&self) -> Option<f64> {
        Some(ratio(self.normal_square, 3 * self.samples)?.sqrt() / self.mean_load()?)
    }

    /// RMS error of T, N; `None` without an estimate.
    pub fn traction_rmse(&self) -> Option<f64> {
        Some(ratio(self.traction_square, 3 * self.samples)?.sqrt())
    }

    /// The standard deviation that the estimator stated for N, over the mean of N: the geometric mean, because in a blow
    /// it states hundreds of times as much as before and after. `None` if it stated none.
    pub fn stated(&self) -> Option<f64> {
        Some(ratio(self.stated_logarithm, 3 * self.judged)?.exp() / self.mean_load()?)
    }

    /// RMS of the errors of N, each over its stated standard deviation: 1 if these are right; `None` if it stated none.
    pub fn normalised(&self) -> Option<f64> {
        Some(ratio(self.normalised_square, 3 * self.judged)?.sqrt())
    }

    /// Mean NEES of the three N: 3 if the stated covariance is right; `None` if the estimator stated none.
    pub fn nees(&self) -> Option<f64> {
        ratio(self.nees, self.judged)
    }

    /// Mean NIS of the parity residual: 1 if its stated spread is right; `None` if the estimator stated none.
    pub fn nis(&self) -> Option<f64> {
        ratio(self.nis, self.innovations)
    }

    /// Share of errors of N within two stated standard deviations; `None` if the estimator stated none.
    pub fn coverage(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "a count of samples")]
        let inside = self.inside as f64;
        ratio(inside, 3 * self.judged)
    }

    /// Instants without an estimate.
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// Mean of N over wheels and instants, N.
    fn mean_load(&self) -> Option<f64> {
        ratio(self.normal_sum, 3 * self.samples).filter(|mean| *mean > 0.0)
    }
}

/// `None` for a count of zero.
fn ratio(sum: f64, count: u64) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a count of samples")]
    let mean = (count > 0).then(|| sum / count as f64);
    mean
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
    fn mahalanobis_undoes_the_covariance() {
        let l = Matrix3::new(2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 3.0, 1.0);
        let e = l * Vector3::new(1.0, 2.0, 3.0);
        let square = mahalanobis(&e, l * l.transpose()).expect("positive definite");
        assert!((square - 14.0).abs() < 1e-12, "{square}");
        assert_eq!(mahalanobis(&e, Matrix3::zeros()), None);
    }

    /// Nothing observed is nothing, never a number.
    #[test]
    fn an_empty_score_is_none() {
        let mut score = Score::default();
        score.add(&Truth::default(), None);
        assert_eq!(score.missing(), 1);
        let all = [
            score.nrmse(),
            score.traction_rmse(),
            score.stated(),
            score.normalised(),
            score.nees(),
            score.nis(),
            score.coverage(),
        ];
        assert_eq!(all, [None; 7]);
    }
}

//! How exact one estimator is over one run, and over many.

use crate::consistency::Consistency;
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
    floor: f64,
    nees: f64,
    nis: f64,
    inside: u64,
    judged: u64,
}

impl Score {
    /// Takes an instant. Without an estimate it counts as missing. Instants at which a wheel bridges a corner are left out: one
    /// contact angle is all that an estimator is told of a wheel.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Estimate>) {
        if truth.wheels.iter().any(|wheel| wheel.contacts > 1) {
            return;
        }
        let Some(estimate) = estimate else {
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
        let normal = |i: usize, j: usize| covariance[2 * i + 1][2 * j + 1];
        let Some(nees) = mahalanobis(&error, normal) else {
            return;
        };
        self.judged += 1;
        self.nees += nees;
        self.floor += (0..3).map(|i| normal(i, i)).sum::<f64>();
        for (i, e) in error.iter().enumerate() {
            self.inside += u64::from(e * e <= 4.0 * normal(i, i));
        }
        if let Some(parity) = estimate.parity {
            self.nis += (parity.value / parity.sigma).powi(2);
        }
    }

    /// RMS error of N over its mean.
    pub fn nrmse(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a count of samples")]
        let wheels = 3.0 * self.samples as f64;
        (self.normal_square / wheels).sqrt() / (self.normal_sum / wheels)
    }

    /// RMS error of T, N.
    pub fn traction_rmse(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a count of samples")]
        let wheels = 3.0 * self.samples as f64;
        (self.traction_square / wheels).sqrt()
    }

    /// RMS of the standard deviations that the estimator stated for N, over the mean of N; `None` if it stated none.
    pub fn stated(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "counts of samples")]
        let (judged, samples) = (self.judged as f64, self.samples as f64);
        (self.judged > 0)
            .then(|| (self.floor / (3.0 * judged)).sqrt() / (self.normal_sum / (3.0 * samples)))
    }

    /// Mean NEES of the three N, mean NIS of the parity residual, share of errors of N within two stated standard
    /// deviations; `None` if the estimator states none.
    pub fn sureness(&self) -> Option<[f64; 3]> {
        #[expect(clippy::cast_precision_loss, reason = "counts of samples")]
        let (judged, inside) = (self.judged as f64, self.inside as f64);
        (self.judged > 0).then(|| {
            [
                self.nees / judged,
                self.nis / judged,
                inside / (3.0 * judged),
            ]
        })
    }

    /// Share of instants without an estimate.
    pub fn missing(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "counts of samples")]
        let share = self.missing as f64 / (self.samples + self.missing).max(1) as f64;
        share
    }
}

/// `e' P^-1 e` for three components; `None` where P is not positive definite (a wheel whose N is held at zero).
fn mahalanobis(e: &[f64; 3], p: impl Fn(usize, usize) -> f64) -> Option<f64> {
    // Cholesky.
    let mut l = [[0.0; 3]; 3];
    let mut y = [0.0; 3];
    for i in 0..3 {
        let mut right = e[i];
        for j in 0..i {
            let mut sum = p(i, j);
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            l[i][j] = sum / l[j][j];
            right -= l[i][j] * y[j];
        }
        let square = p(i, i) - (0..i).map(|k| l[i][k] * l[i][k]).sum::<f64>();
        // Written so that a NaN fails too.
        if !(square > 1e-9 * p(i, i)) {
            return None;
        }
        l[i][i] = square.sqrt();
        y[i] = right / l[i][i];
    }
    Some(y.iter().map(|v| v * v).sum())
}

/// Scores of one estimator over many seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Name of the estimator.
    pub name: String,
    scores: Vec<Score>,
}

impl Summary {
    pub(crate) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            scores: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, score: &Score) {
        self.scores.push(score.clone());
    }

    fn values(&self, of: impl Fn(&Score) -> Option<f64>) -> Vec<f64> {
        self.scores.iter().filter_map(of).collect()
    }

    /// Mean over the seeds of the RMS error of N over its mean, and the standard error of that mean.
    pub fn nrmse(&self) -> (f64, f64) {
        mean_and_error(&self.values(|s| Some(s.nrmse())))
    }

    /// The same for T, N.
    pub fn traction_rmse(&self) -> (f64, f64) {
        mean_and_error(&self.values(|s| Some(s.traction_rmse())))
    }

    /// Mean over the seeds of [`Score::stated`].
    pub fn stated(&self) -> Option<f64> {
        let values = self.values(Score::stated);
        (!values.is_empty()).then(|| mean_and_error(&values).0)
    }

    /// Whether the estimator is as exact as it says; `None` if it says nothing.
    pub fn consistency(&self) -> Option<Consistency> {
        let of = |k: usize| self.values(|s| s.sureness().map(|v| v[k]));
        let nees = of(0);
        (!nees.is_empty()).then(|| Consistency {
            nees: mean_and_error(&nees),
            nis: mean_and_error(&of(1)),
            coverage: mean_and_error(&of(2)),
        })
    }

    /// Share of instants without an estimate.
    pub fn missing(&self) -> f64 {
        mean_and_error(&self.values(|s| Some(s.missing()))).0
    }
}

/// Mean and its standard error (0 for a single value).
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    #[expect(clippy::cast_precision_loss, reason = "a count of seeds")]
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < 2 {
        return (mean, 0.0);
    }
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (square / n).sqrt())
}

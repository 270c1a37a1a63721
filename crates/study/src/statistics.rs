//! Means over seeds, and how well they are known.

use serde::Serialize;

/// Fewest runs whose scatter tells how well their mean is known.
pub const LEAST_RUNS: usize = 5;

/// A mean over independent runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Its standard error, from the scatter of the runs; `None` for a single run.
    pub standard_error: Option<f64>,
    /// Number of runs.
    pub runs: usize,
}

impl Mean {
    /// Of one value a run; `None` without any.
    pub fn of(values: &[f64]) -> Option<Self> {
        let runs = values.len();
        if runs == 0 {
            return None;
        }
        #[expect(clippy::cast_precision_loss, reason = "a count of seeds")]
        let n = runs as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Some(Self {
            mean,
            standard_error: (runs > 1).then(|| (square / (n - 1.0) / n).sqrt()),
            runs,
        })
    }

    /// The interval that holds the expected value with a probability of 95 %, by Student's t; `None` for fewer than five runs, and
    /// for runs that are all the same, because nothing random differs between them.
    pub fn interval(&self) -> Option<(f64, f64)> {
        let error = self.standard_error?;
        if self.runs < LEAST_RUNS || error <= 1e-12 * self.mean.abs() {
            return None;
        }
        let half = student(self.runs - 1) * error;
        Some((self.mean - half, self.mean + half))
    }
}

/// The 97.5 % point of Student's t, Cornish and Fisher's expansion (Abramowitz and Stegun 26.7.5): within 0.3 % from 4
/// degrees of freedom on.
fn student(degrees: usize) -> f64 {
    const X: f64 = 1.959_963_984_540_054;
    #[expect(clippy::cast_precision_loss, reason = "a count of seeds")]
    let v = degrees as f64;
    let (x3, x5, x7) = (X.powi(3), X.powi(5), X.powi(7));
    X + (x3 + X) / (4.0 * v)
        + (5.0 * x5 + 16.0 * x3 + 3.0 * X) / (96.0 * v * v)
        + (3.0 * x7 + 19.0 * x5 + 17.0 * x3 - 15.0 * X) / (384.0 * v * v * v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against printed tables of the 97.5 % point.
    #[test]
    fn student_is_that_of_the_tables() {
        for (degrees, expected) in [(4, 2.776), (9, 2.262), (19, 2.093), (120, 1.980)] {
            assert!(
                (student(degrees) / expected - 1.0).abs() < 3e-3,
                "{degrees}"
            );
        }
    }

    /// Closed form: 1 to 5 have the mean 3, the variance 2.5 and the standard error sqrt(2.5/5).
    #[test]
    fn a_mean_knows_its_error() {
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).expect("values");
        assert!((mean.mean - 3.0).abs() < 1e-15);
        assert!((mean.standard_error.expect("five runs") - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(Mean::of(&[]), None);
        let one = Mean::of(&[2.0]).expect("a value");
        assert_eq!((one.standard_error, one.interval()), (None, None));
        assert_eq!(
            Mean::of(&[1.0, 2.0, 3.0, 4.0]).and_then(|m| m.interval()),
            None
        );
    }
}

//! Means over seeds and their standard errors.

use serde::Serialize;

/// Smallest number of runs for a standard error that can be trusted.
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
    /// Mean of one value per run; `None` without values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let runs = values.len();
        if runs == 0 {
            return None;
        }
        // A count of seeds.
        let n = runs as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        Some(Self {
            mean,
            standard_error: (runs > 1).then(|| (square / (n - 1.0) / n).sqrt()),
            runs,
        })
    }

    /// Whether the runs allow a verdict: at least five, and not all equal, as they are when nothing
    /// random differs between them.
    pub fn allows_verdict(&self) -> bool {
        let differ = self
            .standard_error
            .is_some_and(|error| error > 1e-12 * self.mean.abs());
        self.runs >= LEAST_RUNS && differ
    }
}

/// 2.5 % and 97.5 % points of the mean of `runs` draws from a chi-squared distribution with
/// `components` degrees of freedom (Wilson and Hilferty): from 5 degrees of freedom on within 0.5 %
/// at the upper end and 5 % at the lower; from 30 on within 0.1 %.
pub fn chi_squared_bounds(components: f64, runs: usize) -> (f64, f64) {
    // A count of seeds.
    let degrees = components * runs as f64;
    let c = 2.0 / (9.0 * degrees);
    let at = |z: f64| components * (1.0 - c + z * c.sqrt()).powi(3);
    (at(-X), at(X))
}

/// The 97.5 % point of the normal distribution.
const X: f64 = 1.959_963_984_540_054;

#[cfg(test)]
mod tests {
    use super::*;

    /// Against printed tables: 0.831 and 12.833 for 5 degrees of freedom, 16.791 and 46.979 for 30.
    #[test]
    fn chi_squared_bounds_match_printed_tables() {
        let within = |components, runs, expected: [f64; 2], tolerance: [f64; 2]| {
            let (least, greatest) = chi_squared_bounds(components, runs);
            let found = [least, greatest].map(|mean| mean * runs as f64);
            for i in 0..2 {
                let error = (found[i] / expected[i] - 1.0).abs();
                assert!(error < tolerance[i], "{found:?} {expected:?}");
            }
        };
        within(1.0, 5, [0.831, 12.833], [0.05, 5e-3]);
        within(3.0, 10, [16.791, 46.979], [1e-3, 1e-3]);
    }

    /// Closed form: 1 to 5 have the mean 3, the variance 2.5 and the standard error sqrt(2.5/5).
    #[test]
    fn standard_error_of_five_values() {
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0, 5.0]).expect("values");
        assert!((mean.mean - 3.0).abs() < 1e-15);
        assert!((mean.standard_error.expect("five runs") - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(Mean::of(&[]), None);
        let one = Mean::of(&[2.0]).expect("a value");
        assert_eq!((one.standard_error, one.allows_verdict()), (None, false));
        assert!(mean.allows_verdict());
        let allows = |values: &[f64]| Mean::of(values).expect("values").allows_verdict();
        assert!(!allows(&[1.0, 2.0, 3.0, 4.0]) && !allows(&[3.0; 5]));
    }
}

//! Means over seeds with their standard errors, and whether the covariance that an estimator states
//! is right.

use robhaz_model::named;
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

/// Statistics of normalised errors, as means over runs.
///
/// Errors of one run are not independent samples: offsets, gains and biases last for the whole run.
/// Runs with different seeds are: each counts once, and their scatter gives the standard error of
/// the mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Consistency {
    /// Normalised estimation error squared of the three N, `e' P^-1 e`: 3 if the covariance is
    /// right.
    pub nees: Mean,
    /// Normalised innovation squared of the parity residual: 1 if its expected variance is right.
    /// `None` where no contact geometry of the run defined one.
    pub nis: Option<Mean>,
    /// Share of errors of N within two standard deviations: 0.954 if they are Gaussian and the
    /// covariance is right.
    pub coverage: Mean,
}

named! {
    /// Verdict on a stated covariance.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum CovarianceVerdict {
        /// The mean lies within the 95 % bounds of what a right covariance gives.
        Consistent = "consistent",
        /// Errors are smaller than stated.
        Cautious = "cautious",
        /// Errors are larger than stated.
        Overconfident = "overconfident",
        /// Fewer than five runs, or runs that do not differ: no verdict.
        NotJudged = "not judged",
    }
}

impl CovarianceVerdict {
    /// Verdict on the mean square of normalised errors with a number of components. With a right
    /// covariance it is equal to that number.
    ///
    /// If the error of a run were constant, the sum over runs would be chi-squared distributed,
    /// with components times runs degrees of freedom. Less correlated errors scatter less about the
    /// same mean: these bounds are the widest.
    fn of(mean: &Mean, components: f64) -> Self {
        if !mean.allows_verdict() {
            return Self::NotJudged;
        }
        let (low, high) = chi_squared_bounds(components, mean.runs);
        if mean.mean > high {
            Self::Overconfident
        } else if mean.mean < low {
            Self::Cautious
        } else {
            Self::Consistent
        }
    }
}

impl Consistency {
    /// Number of components of the error in the NEES: the three N.
    pub const COMPONENTS: f64 = 3.0;

    /// Whether the stated covariance of N is right, judged by the NEES.
    pub fn verdict(&self) -> CovarianceVerdict {
        CovarianceVerdict::of(&self.nees, Self::COMPONENTS)
    }

    /// Whether the expected variance of the parity residual is right, judged by the NIS.
    pub fn parity_verdict(&self) -> Option<CovarianceVerdict> {
        self.nis.map(|nis| CovarianceVerdict::of(&nis, 1.0))
    }
}

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

    /// Closed form: chi-squared with 15 degrees of freedom lies between 6.262 and 27.488, a mean of
    /// five between 1.252 and 5.498.
    #[test]
    fn the_verdict_follows_chi_squared() {
        let verdict = |centre: f64, runs: usize| {
            let values: Vec<f64> = (0..runs)
                .map(|i| centre + 0.01 * (i as f64 - 2.0))
                .collect();
            let mean = Mean::of(&values).expect("values");
            let consistency = Consistency {
                nees: mean,
                nis: None,
                coverage: mean,
            };
            consistency.verdict()
        };
        assert_eq!(verdict(5.45, 5), CovarianceVerdict::Consistent);
        assert_eq!(verdict(5.55, 5), CovarianceVerdict::Overconfident);
        assert_eq!(verdict(1.35, 5), CovarianceVerdict::Consistent);
        assert_eq!(verdict(1.15, 5), CovarianceVerdict::Cautious);
        assert_eq!(verdict(3.0, 4), CovarianceVerdict::NotJudged);
        let same = Mean::of(&[3.0; 5]).expect("values");
        assert_eq!(
            CovarianceVerdict::of(&same, 3.0),
            CovarianceVerdict::NotJudged
        );
    }

    /// One run in ten with large errors gives an overconfident verdict, although it raises the
    /// scatter too.
    #[test]
    fn one_bad_run_is_not_hidden_by_its_scatter() {
        let mut values = [2.0; 10];
        values[3] = 80.0;
        let mean = Mean::of(&values).expect("values");
        // Four standard errors would reach from below 3 to above.
        assert!(mean.mean - 4.0 * mean.standard_error.expect("ten runs") < 3.0);
        assert_eq!(
            CovarianceVerdict::of(&mean, 3.0),
            CovarianceVerdict::Overconfident
        );
    }
}

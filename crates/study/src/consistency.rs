//! Whether the covariance that an estimator states is right.

use crate::statistics::{Mean, chi_squared_bounds};
use serde::Serialize;

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

/// Verdict on a stated covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CovarianceVerdict {
    /// The mean lies within the 95 % bounds of what a right covariance gives.
    Consistent,
    /// Errors are smaller than stated.
    Cautious,
    /// Errors are larger than stated.
    Overconfident,
    /// Fewer than five runs, or runs that do not differ: no verdict.
    NotJudged,
}

impl CovarianceVerdict {
    /// The verdict as text.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Cautious => "cautious",
            Self::Overconfident => "overconfident",
            Self::NotJudged => "not judged",
        }
    }

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

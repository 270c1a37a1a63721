//! Does an estimator know how exact it is?

use crate::statistics::{Mean, chi_squared_bounds};
use serde::Serialize;

/// Statistics that tell, as means over runs.
///
/// Errors of one run are not independent samples: offsets, gains and biases last for the whole run. Runs with different seeds
/// are, so that each counts once, and their scatter tells how well the mean is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Consistency {
    /// Normalised estimation error squared of the three N, `e' P^-1 e`: 3 if the covariance is right.
    pub nees: Mean,
    /// Normalised innovation squared of the parity residual: 1 if its expected variance is right. `None` where no contact
    /// geometry of the run defined one.
    pub nis: Option<Mean>,
    /// Share of errors of N within two standard deviations: 0.954 if they are normal and the covariance is right.
    pub coverage: Mean,
}

/// What a statistic says of the covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The mean lies within the 95 % bounds of what a right covariance gives.
    Consistent,
    /// Errors are smaller than stated.
    Cautious,
    /// Errors are larger than stated.
    Overconfident,
    /// Fewer than five runs, or runs that do not differ, cannot tell.
    NotJudged,
}

impl Verdict {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Cautious => "cautious",
            Self::Overconfident => "overconfident",
            Self::NotJudged => "not judged",
        }
    }

    /// Of a mean square of normalised errors with so many components, which it should be equal to.
    ///
    /// Were all errors of a run one single error that lasts, the sum over runs would be chi-squared with as many degrees of freedom as
    /// components and runs. Errors that are less correlated scatter less about the same mean, so that these are the widest bounds.
    fn of(mean: &Mean, components: f64) -> Self {
        if !mean.tells() {
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
    /// Components of the error that the NEES judges: the three N.
    pub const COMPONENTS: f64 = 3.0;

    /// Whether the stated covariance of N is right: by the NEES.
    pub fn verdict(&self) -> Verdict {
        Verdict::of(&self.nees, Self::COMPONENTS)
    }

    /// Whether the stated spread of the parity residual is right: by the NIS.
    pub fn parity_verdict(&self) -> Option<Verdict> {
        self.nis.map(|nis| Verdict::of(&nis, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: chi-squared with 15 degrees of freedom lies between 6.262 and 27.488, a mean of five between 1.252 and 5.498.
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
        assert_eq!(verdict(5.45, 5), Verdict::Consistent);
        assert_eq!(verdict(5.55, 5), Verdict::Overconfident);
        assert_eq!(verdict(1.35, 5), Verdict::Consistent);
        assert_eq!(verdict(1.15, 5), Verdict::Cautious);
        assert_eq!(verdict(3.0, 4), Verdict::NotJudged);
        let same = Mean::of(&[3.0; 5]).expect("values");
        assert_eq!(Verdict::of(&same, 3.0), Verdict::NotJudged);
    }

    /// Scatter is no excuse: one run in ten that is far off makes a mean that no right covariance gives.
    #[test]
    fn one_bad_run_is_not_hidden_by_its_scatter() {
        let mut values = [2.0; 10];
        values[3] = 80.0;
        let mean = Mean::of(&values).expect("values");
        // Four standard errors would reach from below 3 to above.
        assert!(mean.mean - 4.0 * mean.standard_error.expect("ten runs") < 3.0);
        assert_eq!(Verdict::of(&mean, 3.0), Verdict::Overconfident);
    }
}

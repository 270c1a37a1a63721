//! Does an estimator know how exact it is?

use crate::statistics::Mean;
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
    /// The expected value lies in the 95 % interval of the mean.
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

    /// Of a mean square of normalised errors that should be `expected`.
    fn of(mean: &Mean, expected: f64) -> Self {
        match mean.interval() {
            None => Self::NotJudged,
            Some((least, _)) if least > expected => Self::Overconfident,
            Some((_, greatest)) if greatest < expected => Self::Cautious,
            Some(_) => Self::Consistent,
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

    /// Closed form: five runs with a NEES of `centre` -2 to +2 have the 95 % interval +-2.776 sqrt(0.5) = +-1.963.
    #[test]
    fn the_verdict_follows_the_interval() {
        let verdict = |centre: f64, runs: usize| {
            let values: Vec<f64> = (0..runs).map(|i| centre + i as f64 - 2.0).collect();
            let mean = Mean::of(&values).expect("values");
            let consistency = Consistency {
                nees: mean,
                nis: None,
                coverage: mean,
            };
            consistency.verdict()
        };
        assert_eq!(verdict(4.9, 5), Verdict::Consistent);
        assert_eq!(verdict(5.0, 5), Verdict::Overconfident);
        assert_eq!(verdict(1.1, 5), Verdict::Consistent);
        assert_eq!(verdict(1.0, 5), Verdict::Cautious);
        assert_eq!(verdict(3.0, 4), Verdict::NotJudged);
    }
}

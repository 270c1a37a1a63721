//! Does an estimator know how exact it is?

/// Statistics that tell, as means over seeds with their standard errors.
///
/// Errors of one run are not independent samples: offsets, gains and biases last for the whole run. Runs with different seeds
/// are, so that each counts once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    /// Normalised estimation error squared of the three N, `e' P^-1 e`: 3 if the covariance is right.
    pub nees: (f64, f64),
    /// Normalised innovation squared of the parity residual: 1 if its expected variance is right.
    pub nis: (f64, f64),
    /// Share of errors of N within two standard deviations: 0.954 if they are normal and the covariance is right.
    pub coverage: (f64, f64),
}

/// What the statistics say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The stated covariance is right within its 95 % bounds.
    Consistent,
    /// Errors are smaller than stated: two standard deviations hold more than 95 % of them.
    Cautious,
    /// Errors are larger than stated.
    Overconfident,
}

impl Verdict {
    /// In a word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Cautious => "cautious",
            Self::Overconfident => "overconfident",
        }
    }
}

impl Consistency {
    /// Bounds of two standard errors on the NEES.
    pub fn verdict(&self) -> Verdict {
        let (mean, error) = self.nees;
        if mean - 2.0 * error > 3.0 {
            Verdict::Overconfident
        } else if mean + 2.0 * error < 3.0 {
            Verdict::Cautious
        } else {
            Verdict::Consistent
        }
    }
}

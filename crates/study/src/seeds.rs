//! The scores of one estimator over many seeds.

use crate::consistency::Consistency;
use crate::statistics::Mean;
use robhaz_score::{Score, Statistics};
use std::ops::Deref;

/// The errors of one estimator, one per seed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeedErrors(Vec<Statistics>);

impl SeedErrors {
    fn mean(&self, of: impl Fn(&Statistics) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.0.iter().filter_map(of).collect::<Vec<_>>())
    }

    /// Mean of [`Statistics::nrmse`].
    pub fn nrmse(&self) -> Option<Mean> {
        self.mean(Statistics::nrmse)
    }

    /// Mean RMS error of T over the wheels, N.
    pub fn traction_rmse(&self) -> Option<Mean> {
        self.mean(|errors| Some(errors.traction()?.rmse_all))
    }

    /// Mean of [`Statistics::stated`].
    pub fn stated(&self) -> Option<Mean> {
        self.mean(Statistics::stated)
    }

    /// Mean of [`Statistics::normalised`].
    pub fn normalised(&self) -> Option<Mean> {
        self.mean(Statistics::normalised)
    }

    /// Whether the stated covariance is right; `None` if the estimator states none.
    pub fn consistency(&self) -> Option<Consistency> {
        Some(Consistency {
            nees: self.mean(Statistics::nees)?,
            nis: self.mean(Statistics::nis),
            coverage: self.mean(Statistics::coverage)?,
        })
    }
}

/// The scores of one estimator over all samples that count, one per seed.
#[derive(Clone, Debug, PartialEq)]
pub struct SeedScores {
    /// Name of the estimator.
    pub name: String,
    all: SeedErrors,
    one_contact: SeedErrors,
    missing: u64,
}

impl Deref for SeedScores {
    type Target = SeedErrors;

    fn deref(&self) -> &SeedErrors {
        &self.all
    }
}

impl SeedScores {
    pub(crate) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            all: SeedErrors::default(),
            one_contact: SeedErrors::default(),
            missing: 0,
        }
    }

    pub(crate) fn add(&mut self, score: &Score) {
        self.all.0.push(*score.all());
        self.one_contact.0.push(*score.at_one_contact());
        self.missing += score.missing();
    }

    /// The errors over the samples at which no wheel has two contacts.
    pub fn at_one_contact(&self) -> &SeedErrors {
        &self.one_contact
    }

    /// Samples without an estimate, of all seeds together.
    pub fn missing(&self) -> u64 {
        self.missing
    }
}

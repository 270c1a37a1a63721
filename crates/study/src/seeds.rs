//! The scores of one estimator over many seeds.

use crate::consistency::Consistency;
use crate::statistics::Mean;
use robhaz_score::Score;

/// The scores of one estimator, one per seed.
#[derive(Clone, Debug, PartialEq)]
pub struct SeedScores {
    /// Name of the estimator.
    pub name: String,
    scores: Vec<Score>,
}

impl SeedScores {
    pub(crate) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            scores: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, score: Score) {
        self.scores.push(score);
    }

    /// The scores, in the order of the seeds.
    pub fn scores(&self) -> &[Score] {
        &self.scores
    }

    fn mean(&self, of: impl Fn(&Score) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.scores.iter().filter_map(of).collect::<Vec<_>>())
    }

    /// Mean of [`Score::nrmse`].
    pub fn nrmse(&self) -> Option<Mean> {
        self.mean(Score::nrmse)
    }

    /// Mean NRMSE of N over the samples at which no wheel has two contacts ([`Score::normal_force_at_one_contact`]).
    pub fn nrmse_at_one_contact(&self) -> Option<Mean> {
        self.mean(|score| score.normal_force_at_one_contact()?.nrmse)
    }

    /// Mean RMS error of T over the wheels, N.
    pub fn traction_rmse(&self) -> Option<Mean> {
        self.mean(|score| Some(score.traction()?.rmse_all))
    }

    /// Mean of [`Score::stated`].
    pub fn stated(&self) -> Option<Mean> {
        self.mean(Score::stated)
    }

    /// Mean of [`Score::normalised`].
    pub fn normalised(&self) -> Option<Mean> {
        self.mean(Score::normalised)
    }

    /// Whether the stated covariance is right; `None` if the estimator states none.
    pub fn consistency(&self) -> Option<Consistency> {
        Some(Consistency {
            nees: self.mean(Score::nees)?,
            nis: self.mean(Score::nis),
            coverage: self.mean(Score::coverage)?,
        })
    }

    /// Samples without an estimate, of all seeds together.
    pub fn missing(&self) -> u64 {
        self.scores.iter().map(Score::missing).sum()
    }
}

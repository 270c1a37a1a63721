//! How exact one estimator is over many seeds.

use crate::consistency::Consistency;
use crate::score::Score;
use crate::statistics::Mean;

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

    pub(crate) fn add(&mut self, score: Score) {
        self.scores.push(score);
    }

    /// The scores, one a seed.
    pub fn scores(&self) -> &[Score] {
        &self.scores
    }

    fn mean(&self, of: impl Fn(&Score) -> Option<f64>) -> Option<Mean> {
        Mean::of(&self.scores.iter().filter_map(of).collect::<Vec<_>>())
    }

    /// Of [`Score::nrmse`].
    pub fn nrmse(&self) -> Option<Mean> {
        self.mean(Score::nrmse)
    }

    /// Of [`Score::traction_rmse`], N.
    pub fn traction_rmse(&self) -> Option<Mean> {
        self.mean(Score::traction_rmse)
    }

    /// Of [`Score::stated`].
    pub fn stated(&self) -> Option<Mean> {
        self.mean(Score::stated)
    }

    /// Of [`Score::normalised`].
    pub fn normalised(&self) -> Option<Mean> {
        self.mean(Score::normalised)
    }

    /// Whether the estimator is as exact as it says; `None` if it says nothing.
    pub fn consistency(&self) -> Option<Consistency> {
        Some(Consistency {
            nees: self.mean(Score::nees)?,
            nis: self.mean(Score::nis),
            coverage: self.mean(Score::coverage)?,
        })
    }

    /// Instants without an estimate, in all runs together.
    pub fn missing(&self) -> u64 {
        self.scores.iter().map(Score::missing).sum()
    }
}

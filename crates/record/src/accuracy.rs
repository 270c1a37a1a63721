//! The score of a named estimator.

use crate::summary::EstimatorSummary;
use robhaz_estimator::{Estimate, EstimateError};
pub use robhaz_score::Rms;
use robhaz_score::{Rule, Score};
use robhaz_sim::Truth;

/// The score of one estimator over a run.
#[derive(Clone, Debug)]
pub struct Accuracy {
    name: String,
    score: Score,
}

impl Accuracy {
    /// A score without samples; records before `compare_from` (s) will not count.
    pub fn new(name: &str, compare_from: f64) -> Self {
        Self {
            name: name.to_owned(),
            score: Score::new(Rule { compare_from }),
        }
    }

    /// Adds a record.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Result<Estimate, EstimateError>>) {
        self.score
            .add(truth, estimate.and_then(|e| e.as_ref().ok()));
    }

    /// The result so far.
    pub fn summary(&self) -> EstimatorSummary {
        EstimatorSummary::new(&self.name, &self.score)
    }
}

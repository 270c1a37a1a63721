//! Channels whose readings contradicted others.

use indexmap::IndexMap;
use robhaz_estimator::Estimate;
use serde::{Deserialize, Serialize};

/// When a channel was suspect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Suspicion {
    /// Time of the first record at which it was, s.
    pub first_s: f64,
    /// Number of such records.
    pub records: u64,
}

/// Suspect channels by name, in the order of their first record: [`robhaz_estimator::Health::suspect`].
pub type Suspects = IndexMap<String, Suspicion>;

/// Adds the suspect channels of a record at `time` (s).
pub(super) fn add_suspects(suspects: &mut Suspects, time: f64, estimate: &Estimate) {
    let Some(health) = estimate.health else {
        return;
    };
    for name in health.suspect.names() {
        match suspects.get_mut(name) {
            Some(suspicion) => suspicion.records += 1,
            None => {
                let first = Suspicion {
                    first_s: time,
                    records: 1,
                };
                suspects.insert(name.to_owned(), first);
            }
        }
    }
}

//! Clearance of body and links over a run.

use robhaz_score::events::{Event, EventKind};
use robhaz_sim::clearance::Clearances;
use serde::{Deserialize, Serialize};

/// Clearance of body and links to the ground over a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearanceSummary {
    /// The least of all records, m; at 0 or below a bar touched the ground.
    pub least_m: f64,
    /// The bar that it belongs to: `body`, `link1` ...
    pub bar: String,
    /// Its time, s.
    pub time_s: f64,
    /// How often a bar began to touch the ground.
    pub touches: u64,
    /// Time of the first touch, s, and its bar. From then on forces are wrong: that of the touch is
    /// not modelled.
    pub first_touch: Option<(f64, String)>,
}

impl ClearanceSummary {
    /// Adds a record to the summary so far.
    pub(super) fn add(so_far: &mut Option<Self>, time: f64, clearances: &Clearances) {
        let (bar, least) = clearances.least;
        // A clearance that is not a number is that of no bar.
        if !least.is_finite() {
            return;
        }
        let found = so_far.get_or_insert_with(|| Self {
            least_m: f64::INFINITY,
            bar: String::new(),
            time_s: time,
            touches: 0,
            first_touch: None,
        });
        if least < found.least_m {
            (found.least_m, found.time_s) = (least, time);
            bar.name().clone_into(&mut found.bar);
        }
    }

    /// Adds an event after its record.
    pub(super) fn add_event(&mut self, event: &Event) {
        if let EventKind::BarTouches(bar) = event.kind {
            self.touches += 1;
            let first = || (event.time, bar.name().to_owned());
            self.first_touch.get_or_insert_with(first);
        }
    }
}

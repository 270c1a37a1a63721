//! What the page of an estimate shows of a recorded log: means, flags and health of the estimators.

use crate::summary::{EstimatorSummary, MeanForces, Suspicion};
use maud::{Markup, html};

/// Means, flags and health of the estimators of a recorded log; `None` of a simulation.
pub fn means_page(estimators: &[EstimatorSummary]) -> Option<Markup> {
    let of_log: Vec<(&EstimatorSummary, &MeanForces)> = estimators
        .iter()
        .filter_map(|e| Some((e, e.means.as_ref()?)))
        .collect();
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("-".to_owned(), |v| format!("{v:.digits$}"))
    };
    (!of_log.is_empty()).then(|| {
        html! {
            h2 { "Means of the estimates" }
            p { "Means over the records that count, with the stated standard deviation (RMS over the records). T/N is the needed \
                 friction." }
            div class="wide" {
                table {
                    tr { @for title in ["estimator, wheel", "N, N", "sigma, N", "T, N", "sigma, N", "T/N", "largest |T/N|"] { th { (title) } } }
                    @for (e, means) in &of_log {
                        @for (i, wheel) in ["front", "middle", "rear"].into_iter().enumerate() {
                            tr {
                                td { (e.name) ", " (wheel) }
                                td { (number(Some(means.normal_force[i]), 2)) }
                                td { (number(means.normal_force_sigma.map(|s| s[i]), 2)) }
                                td { (number(Some(means.traction[i]), 2)) }
                                td { (number(means.traction_sigma.map(|s| s[i]), 2)) }
                                td { (number(means.needed_friction[i], 3)) }
                                td { (number(means.largest_needed_friction[i], 3)) }
                            }
                        }
                    }
                }
            }
            h2 { "Flags and health" }
            p { "Shares of the records, %. Parity: RMS of the parity residual over its expected deviation, 1 for a right noise budget. \
                 Contradictions: channels whose readings contradict others, with the time of the first record." }
            div class="wide" {
                table {
                    tr {
                        th { "estimator" } th { "parity" }
                        @for (title, _) in FLAGS { th { (title) } }
                        th { "contradictions" }
                    }
                    @for (e, means) in &of_log {
                        tr {
                            td { (e.name) }
                            td { (number(means.parity, 2)) }
                            @for (_, count) in FLAGS { td { (share(count(means), e.samples)) } }
                            td { (contradictions(e)) }
                        }
                    }
                }
            }
        }
    })
}

/// What is counted, and how often.
type Flag = (&'static str, fn(&MeanForces) -> u64);

/// The flags of an estimate, and the number of records with each.
const FLAGS: [Flag; 6] = [
    ("wheel without load", |m| m.unloaded),
    ("linkage at a stop", |m| m.at_stop),
    ("reading missing", |m| m.reading_missing),
    ("reading stale", |m| m.reading_stale),
    ("reading absurd", |m| m.reading_absurd),
    ("parity beyond 5 sigma", |m| m.out_of_range),
];

/// A share of records, %.
fn share(count: u64, of: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "counts of records")]
    let share = 100.0 * count as f64 / of as f64;
    if count == 0 {
        "0".to_owned()
    } else {
        format!("{share:.2}")
    }
}

/// The channels whose readings contradict others.
fn contradictions(estimator: &EstimatorSummary) -> String {
    let channel =
        |(name, found): (&String, &Suspicion)| format!("{name} from {:.1} s", found.first_s);
    let channels: Vec<String> = estimator.suspects.iter().map(channel).collect();
    if channels.is_empty() {
        "none".to_owned()
    } else {
        channels.join(", ")
    }
}

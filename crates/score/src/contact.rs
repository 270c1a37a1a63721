//! Contact states of an estimator against the truth.

use crate::rule::Rule;
use crate::sum::share;
use robhaz_estimator::{ContactEstimate, ContactState, Estimate};
use robhaz_sim::{Truth, WheelTruth};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Time by which an estimated state may differ from the true one, s: around each change of the true
/// state.
pub const TOLERANCE: f64 = 0.020;

/// Whether a contact state holds, in the truth and in the estimate.
type Flag = (fn(&WheelTruth) -> bool, fn(&ContactEstimate) -> bool);

/// No contact, two contacts, sliding ([`WheelTruth::slides`]).
const FLAGS: [Flag; 3] = [
    (
        |truth| truth.contacts == 0,
        |found| found.state == ContactState::InAir,
    ),
    (
        |truth| truth.contacts > 1,
        |found| found.state == ContactState::TwoContacts,
    ),
    (|truth| truth.slides, |found| found.sliding),
];

/// How well one contact state was found, over the three wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlagScore {
    /// Number of events: a wheel enters the state.
    pub events: u64,
    /// How many of the events were found: the estimated state holds at some time within 20 ms
    /// before or after the event.
    pub found: u64,
    /// Mean delay of the estimated state after the event, s, over the events found; 0 where it
    /// holds at the event. `None` if none was found.
    pub delay_s: Option<f64>,
    /// Share of samples with a false flag: the estimated state holds, the true one does not. Of all
    /// samples at which the true state does not hold, without those within 20 ms of a change.
    /// `None` without such samples.
    pub false_share: Option<f64>,
    /// Share of samples with a missed flag: the true state holds, the estimated one does not. Of
    /// all samples at which the true state holds, without those within 20 ms of a change. `None`
    /// without such samples.
    pub missed_share: Option<f64>,
}

/// How well each contact state was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlagScores {
    /// No contact.
    pub air: FlagScore,
    /// Two contacts.
    pub two_contacts: FlagScore,
    /// Sliding.
    pub sliding: FlagScore,
}

/// Compares the contact states of an estimator with the truth, event by event and sample by sample.
#[derive(Clone, Debug, Default)]
pub struct ContactScore {
    rule: Rule,
    /// Whether any estimate stated contact states.
    stated: bool,
    /// By flag in the order of [`FLAGS`], then by wheel.
    judges: [[Judge; 3]; 3],
}

impl ContactScore {
    /// A score without samples. Events and samples count from `rule.compare_from` on.
    pub fn new(rule: Rule) -> Self {
        Self {
            rule,
            ..Self::default()
        }
    }

    /// Adds a sample. Samples without an estimate, or whose estimate states no contact states,
    /// count as without any flag.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Estimate>) {
        let contact = estimate.and_then(|e| e.kalman).map(|k| k.contact);
        self.stated |= contact.is_some();
        let counts = self.rule.compares(truth.time);
        for ((of_truth, of_estimate), judges) in FLAGS.into_iter().zip(&mut self.judges) {
            for (i, judge) in judges.iter_mut().enumerate() {
                judge.add(&Sample {
                    time: truth.time,
                    truth: of_truth(&truth.wheels[i]),
                    estimate: contact.is_some_and(|c| of_estimate(&c[i])),
                    counts,
                });
            }
        }
    }

    /// The scores of the states; `None` if the estimator states no contact states.
    pub fn scores(&self) -> Option<FlagScores> {
        let [air, two_contacts, sliding] = self.judges.each_ref().map(|judges| {
            let mut sum = Counts::default();
            for judge in judges {
                sum.add(&judge.counts_to_the_end());
            }
            sum.score()
        });
        self.stated.then_some(FlagScores {
            air,
            two_contacts,
            sliding,
        })
    }
}

/// One sample of one flag of one wheel.
#[derive(Clone, Copy, Debug)]
struct Sample {
    time: f64,
    truth: bool,
    estimate: bool,
    counts: bool,
}

/// Counts over samples and events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counts {
    events: u64,
    found: u64,
    delays: f64,
    /// Samples away from changes, by true state: all, and those with the wrong estimate.
    samples: [u64; 2],
    wrong: [u64; 2],
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.events += other.events;
        self.found += other.found;
        self.delays += other.delays;
        for k in 0..2 {
            self.samples[k] += other.samples[k];
            self.wrong[k] += other.wrong[k];
        }
    }

    fn add_sample(&mut self, sample: &Sample) {
        let k = usize::from(sample.truth);
        self.samples[k] += 1;
        self.wrong[k] += u64::from(sample.estimate != sample.truth);
    }

    fn score(&self) -> FlagScore {
        FlagScore {
            events: self.events,
            found: self.found,
            delay_s: (self.found > 0).then(|| self.delays / self.found as f64),
            false_share: share(self.wrong[0], self.samples[0]),
            missed_share: share(self.wrong[1], self.samples[1]),
        }
    }
}

/// Judges one flag of one wheel. A sample is decided when no later change can lie within the
/// tolerance.
#[derive(Clone, Debug, Default)]
struct Judge {
    /// True state at the last sample; `None` before the first.
    truth: Option<bool>,
    /// Last time at which the estimated state held, s.
    held: Option<f64>,
    /// Last change of the true state, s.
    changed: Option<f64>,
    /// Times of events that are not found yet, s.
    open: VecDeque<f64>,
    /// Samples that are not decided yet.
    pending: VecDeque<Sample>,
    counts: Counts,
}

/// Whether two times (s) are within the tolerance; times of records are rounded.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE + 1e-9
}

impl Judge {
    fn add(&mut self, sample: &Sample) {
        let now = sample.time;
        if sample.estimate {
            self.held = Some(now);
        }
        let changes = self.truth.is_some_and(|before| before != sample.truth);
        self.truth = Some(sample.truth);
        if changes {
            self.changed = Some(now);
            // All that is pending lies within the tolerance before this change, or is decided.
            self.decide(now);
            self.pending.clear();
            if sample.truth && sample.counts {
                self.counts.events += 1;
                self.open.push_back(now);
            }
        }
        self.open.retain(|event| near(now, *event));
        if let Some(held) = self.held {
            self.open.retain(|event| {
                let found = near(held, *event);
                if found {
                    self.counts.found += 1;
                    self.counts.delays += (held - event).max(0.0);
                }
                !found
            });
        }
        if sample.counts && self.changed.is_none_or(|time| !near(now, time)) {
            self.pending.push_back(*sample);
        }
        self.decide(now);
    }

    /// Counts the pending samples that lie further than the tolerance before `now` (s).
    fn decide(&mut self, now: f64) {
        while let Some(sample) = self.pending.front().filter(|s| !near(s.time, now)) {
            self.counts.add_sample(sample);
            self.pending.pop_front();
        }
    }

    /// The counts, with the pending samples: after the last sample nothing changes.
    fn counts_to_the_end(&self) -> Counts {
        let mut counts = self.counts;
        for sample in &self.pending {
            counts.add_sample(sample);
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Judges samples at 1 kHz, given by stretches of true and estimated state: (from ms, to ms).
    fn judge(length: u32, truth: &[(u32, u32)], estimate: &[(u32, u32)]) -> FlagScore {
        let within = |k: u32, list: &[(u32, u32)]| list.iter().any(|(a, b)| (*a..*b).contains(&k));
        let mut judge = Judge::default();
        for k in 0..length {
            judge.add(&Sample {
                time: 1e-3 * f64::from(k),
                truth: within(k, truth),
                estimate: within(k, estimate),
                counts: true,
            });
        }
        judge.counts_to_the_end().score()
    }

    /// Closed form: delays, and shares without the 20 ms around each change.
    #[test]
    fn delays_and_shares_of_given_stretches() {
        // Found 15 ms late; it ends 30 ms late, of which 10 count.
        let found = judge(1000, &[(400, 500)], &[(415, 530)]);
        assert_eq!((found.events, found.found), (1, 1));
        assert!((found.delay_s.unwrap_or_default() - 0.015).abs() < 1e-12);
        // Within 20 ms of the changes at 400 and 500 lie the samples 380 to 420 and 480 to 520.
        let without = |count: f64| Some(count / f64::from(380 + 479));
        assert_eq!(found.false_share, without(9.0));
        assert_eq!(found.missed_share, Some(0.0));

        // 21 ms are too late, 20 ms are not; a flag that ended 20 ms before counts, one that ended
        // 21 ms before does not.
        let found = |estimate: (u32, u32)| judge(1000, &[(400, 500)], &[estimate]).found;
        assert_eq!([(420, 430), (421, 430)].map(found), [1, 0]);
        assert_eq!([(350, 381), (350, 380)].map(found), [1, 0]);
        assert_eq!(found((390, 600)), 1);
    }

    /// An event shorter than the tolerance is found after its end; the flag is then not false. Two
    /// events near each other are two.
    #[test]
    fn short_events_are_found_after_their_end() {
        let short = judge(200, &[(100, 103)], &[(110, 120)]);
        assert_eq!((short.events, short.found), (1, 1));
        assert_eq!((short.false_share, short.missed_share), (Some(0.0), None));
        let two = judge(200, &[(100, 103), (110, 113)], &[(111, 113)]);
        assert_eq!((two.events, two.found), (2, 2));
        let none = judge(200, &[], &[]);
        assert_eq!((none.events, none.delay_s), (0, None));
        assert_eq!(none.false_share, Some(0.0));
    }

    /// A state that is never stated is missed in all samples away from its changes.
    #[test]
    fn a_missed_state_counts() {
        let missed = judge(300, &[(100, 200)], &[]);
        assert_eq!((missed.events, missed.found), (1, 0));
        assert_eq!(
            (missed.missed_share, missed.false_share),
            (Some(1.0), Some(0.0))
        );
    }
}

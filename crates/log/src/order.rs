//! The order of the time stamps of one channel.

use std::collections::VecDeque;

/// Largest step back in time that is taken for a late row and not for a clock that was set, s: the
/// estimators start anew after a gap of this length.
const LARGEST_STEP_BACK: f64 = 0.5;
/// Least time between two rows, s: estimators refuse less.
pub const SHORTEST_STEP: f64 = 0.5e-6;
/// A step of more periods than this is a gap.
pub const GAP: f64 = 1.5;
/// Largest number of gaps that are remembered: late rows of one burst come from few.
const MOST_GAPS: usize = 64;

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accept {
    /// It is used.
    Use,
    /// It has the time of the last row: left out.
    Duplicate,
    /// It is earlier than the last row: left out.
    Late,
    /// It is the first of rows whose times are there already, because the clock was set back by
    /// this much (s) or rows are repeated: left out like all that follow up to the last row's time.
    SetBack(f64),
    /// The time jumps back by this much, s.
    JumpBack(f64),
}

/// Judges the rows of a channel by their times.
#[derive(Clone, Debug, Default)]
pub struct Order {
    latest: Option<f64>,
    /// The last step, s.
    step: f64,
    /// The last gaps, from row to row, s: a row that is late comes from one.
    gaps: VecDeque<(f64, f64)>,
    /// Whether the times are those of rows before.
    is_set_back: bool,
}

impl Order {
    /// Judges a row at a time, s.
    pub fn accept(&mut self, time: f64) -> Accept {
        let Some(latest) = self.latest else {
            self.latest = Some(time);
            return Accept::Use;
        };
        let step = time - latest;
        if step >= SHORTEST_STEP {
            // The first step has none before it.
            if step > GAP * self.step {
                self.gaps.push_back((latest, time));
            }
            if self.gaps.len() > MOST_GAPS {
                self.gaps.pop_front();
            }
            self.latest = Some(time);
            self.step = step;
            self.is_set_back = false;
            Accept::Use
        } else if step < -LARGEST_STEP_BACK {
            Accept::JumpBack(-step)
        } else if step > -SHORTEST_STEP {
            Accept::Duplicate
        } else if self.is_set_back || self.gaps.iter().any(|(a, b)| *a < time && time < *b) {
            Accept::Late
        } else {
            self.is_set_back = true;
            // The row is one step after the last one, by the clock that was set.
            Accept::SetBack(self.step - step)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows in order are used, equal times and late rows left out, a clock that was set is
    /// reported.
    #[test]
    fn rows_are_judged_by_their_times() {
        let mut order = Order::default();
        assert_eq!(order.accept(10.0), Accept::Use);
        assert_eq!(order.accept(10.5), Accept::Use);
        assert_eq!(order.accept(10.5), Accept::Duplicate);
        assert_eq!(order.accept(10.25), Accept::Late);
        assert_eq!(order.accept(11.0), Accept::Use);
        assert_eq!(order.accept(1.0), Accept::JumpBack(10.0));
    }

    /// A clock that is set back by 0.25 s over rows that are there, at 8 and at 64 Hz, is no late
    /// row, and is reported once.
    #[test]
    fn a_clock_that_is_set_back_is_found() {
        for period in [0.125, 1.0 / 64.0] {
            let mut order = Order::default();
            let rows = (0..1000).map(|k| f64::from(k) * period);
            let set = rows.map(|t| if t > 10.0 { t - 0.25 } else { t });
            let found: Vec<Accept> = set
                .map(|t| order.accept(t))
                .filter(|a| matches!(a, Accept::SetBack(_) | Accept::Late))
                .collect();
            let late = found.len() - 1;
            assert_eq!(found.first(), Some(&Accept::SetBack(0.25)), "{found:?}");
            // The rows within the 0.25 s, but for that at the time of the last one.
            assert_eq!(late, (0.25 / period).round() as usize - 2, "{found:?}");
        }
        // Two rows that come late, after those that follow them.
        let mut order = Order::default();
        let times = [0.0, 0.125, 0.25, 0.625, 0.75, 0.375, 0.5, 0.875];
        let late = times.map(|t| order.accept(t) == Accept::Late);
        assert_eq!(late.iter().filter(|late| **late).count(), 2);
    }
}

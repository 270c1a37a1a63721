//! The order of the time stamps of one channel.

/// Largest step back in time that is taken for a late row and not for a clock that was set, s: the estimators start anew
/// after a gap of this length.
const LARGEST_STEP_BACK: f64 = 0.5;
/// Least time between two rows, s: estimators refuse less.
const SHORTEST_STEP: f64 = 0.5e-6;

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accept {
    /// It is used; time since the last row, s. `None` for the first.
    Use(Option<f64>),
    /// It has the time of the last row: left out.
    Duplicate,
    /// It is earlier than the last row: left out.
    Late,
    /// The time jumps back by this much, s.
    JumpBack(f64),
}

/// Judges the rows of a channel by their times.
#[derive(Clone, Copy, Debug, Default)]
pub struct Order {
    latest: Option<f64>,
}

impl Order {
    /// Judges a row at a time, s.
    pub fn accept(&mut self, time: f64) -> Accept {
        let Some(latest) = self.latest else {
            self.latest = Some(time);
            return Accept::Use(None);
        };
        let step = time - latest;
        if step >= SHORTEST_STEP {
            self.latest = Some(time);
            Accept::Use(Some(step))
        } else if step < -LARGEST_STEP_BACK {
            Accept::JumpBack(-step)
        } else if step <= -SHORTEST_STEP {
            Accept::Late
        } else {
            Accept::Duplicate
        }
    }
}

/// A median of steps from a bounded number of them: every `keep`-th step.
#[derive(Clone, Debug)]
pub struct MedianStep {
    steps: Vec<f64>,
    keep: u64,
    seen: u64,
}

/// Largest number of steps that are kept.
const MOST_STEPS: usize = 200_000;

impl Default for MedianStep {
    fn default() -> Self {
        Self {
            steps: Vec::new(),
            keep: 1,
            seen: 0,
        }
    }
}

impl MedianStep {
    /// Adds a step, s.
    pub fn add(&mut self, step: f64) {
        if self.seen.is_multiple_of(self.keep) {
            self.steps.push(step);
            if self.steps.len() >= MOST_STEPS {
                let mut i = 0;
                self.steps.retain(|_| {
                    i += 1;
                    i % 2 == 1
                });
                self.keep *= 2;
            }
        }
        self.seen += 1;
    }

    /// The median, s; `None` without steps.
    pub fn median(mut self) -> Option<f64> {
        let middle = self.steps.len() / 2;
        if self.steps.is_empty() {
            return None;
        }
        let (_, median, _) = self.steps.select_nth_unstable_by(middle, f64::total_cmp);
        Some(*median)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows in order are used, equal times and late rows left out, a clock that was set is reported.
    #[test]
    fn rows_are_judged_by_their_times() {
        let mut order = Order::default();
        assert_eq!(order.accept(10.0), Accept::Use(None));
        assert_eq!(order.accept(10.5), Accept::Use(Some(0.5)));
        assert_eq!(order.accept(10.5), Accept::Duplicate);
        assert_eq!(order.accept(10.25), Accept::Late);
        assert_eq!(order.accept(11.0), Accept::Use(Some(0.5)));
        assert_eq!(order.accept(1.0), Accept::JumpBack(10.0));
    }

    /// However many steps: within the range of the middle ones, and the memory is bounded.
    #[test]
    fn the_median_needs_bounded_memory() {
        let mut median = MedianStep::default();
        for i in 0..1_000_000 {
            median.add(if i % 3 == 0 { 0.1 } else { 0.001 });
        }
        assert!(median.steps.len() < MOST_STEPS);
        assert_eq!(median.median(), Some(0.001));
        assert_eq!(MedianStep::default().median(), None);
    }
}

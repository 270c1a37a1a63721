//! Sums over long runs, and extremes.

/// A sum that keeps the rounding errors of its additions (Neumaier 1974), so that an hour at 1 kHz
/// is summed as exactly as a second. Each error is found without a branch (Knuth's two-sum).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    total: f64,
    compensation: f64,
}

impl Sum {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        let total = self.total + value;
        let added = total - self.total;
        self.compensation += (self.total - (total - added)) + (value - added);
        self.total = total;
    }

    /// The sum so far.
    pub fn value(&self) -> f64 {
        self.total + self.compensation
    }

    /// The sum over a count; `None` for a count of zero.
    pub fn mean(&self, count: u64) -> Option<f64> {
        (count > 0).then(|| self.value() / count as f64)
    }
}

/// The means over a count; `None` for a count of zero.
pub(crate) fn means<const N: usize>(sums: &[Sum; N], count: u64) -> Option<[f64; N]> {
    // A count above zero has a mean.
    (count > 0).then(|| sums.map(|sum| sum.value() / count as f64))
}

/// The share of a count; `None` of nothing.
pub(crate) fn share(part: u64, of: u64) -> Option<f64> {
    (of > 0).then(|| part as f64 / of as f64)
}

/// A root mean square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rms {
    squares: Sum,
    /// Values so far.
    pub(crate) count: u64,
}

impl Rms {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.squares.add(value * value);
        self.count += 1;
    }

    /// The root mean square so far; `None` before the first value.
    pub fn value(&self) -> Option<f64> {
        self.squares.mean(self.count).map(f64::sqrt)
    }
}

/// Least and largest of some values; infinite and the wrong way round of none.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    values.into_iter().fold(none, wider)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plain sum would lose every one of the small values.
    #[test]
    fn small_values_are_not_lost_in_a_large_sum() {
        let mut sum = Sum::default();
        sum.add(1e16);
        for _ in 0..1000 {
            sum.add(1.0);
        }
        sum.add(-1e16);
        assert!((sum.value() - 1000.0).abs() < 1e-9);
    }

    /// Closed form: 3 and 4 have the root mean square sqrt(12.5).
    #[test]
    fn root_mean_square_of_two_values() {
        let mut rms = Rms::default();
        assert_eq!(rms.value(), None);
        rms.add(3.0);
        rms.add(-4.0);
        assert!(
            rms.value()
                .is_some_and(|v| (v - 12.5_f64.sqrt()).abs() < 1e-15)
        );
    }
}

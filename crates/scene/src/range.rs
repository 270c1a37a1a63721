//! Ranges that a number may lie in.

use std::fmt;

/// Longest time of a run, s.
pub(crate) const LONGEST_RUN: f64 = 1e6;

/// An end of a range.
#[derive(Clone, Copy)]
enum End {
    None,
    /// The end itself is not allowed.
    Open(f64),
    /// The end itself is allowed.
    Closed(f64),
}

/// The numbers that a key takes, SI. Never an infinite one or a NaN.
#[derive(Clone, Copy)]
pub(crate) struct Range {
    low: End,
    high: End,
}

/// Above a number.
pub(crate) const fn above(low: f64) -> Range {
    Range {
        low: End::Open(low),
        high: End::None,
    }
}

/// A number or more.
pub(crate) const fn at_least(low: f64) -> Range {
    Range {
        low: End::Closed(low),
        high: End::None,
    }
}

impl Range {
    /// And at most `high`.
    pub const fn at_most(self, high: f64) -> Self {
        Self {
            low: self.low,
            high: End::Closed(high),
        }
    }

    /// And below `high`.
    pub const fn below(self, high: f64) -> Self {
        Self {
            low: self.low,
            high: End::Open(high),
        }
    }

    /// Lower and upper end, each with whether it belongs to the range; `None` where there is none.
    pub fn ends(self) -> [Option<(f64, bool)>; 2] {
        [self.low, self.high].map(|end| match end {
            End::None => None,
            End::Open(at) => Some((at, false)),
            End::Closed(at) => Some((at, true)),
        })
    }

    /// Whether a number lies in it.
    pub fn contains(self, value: f64) -> bool {
        let low = match self.low {
            End::None => true,
            End::Open(low) => value > low,
            End::Closed(low) => value >= low,
        };
        let high = match self.high {
            End::None => true,
            End::Open(high) => value < high,
            End::Closed(high) => value <= high,
        };
        value.is_finite() && low && high
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.low {
            End::None => {}
            End::Open(low) => write!(f, "above {}", short(low))?,
            End::Closed(low) => write!(f, "of at least {}", short(low))?,
        }
        if !matches!(self.low, End::None) && !matches!(self.high, End::None) {
            f.write_str(" and ")?;
        }
        match self.high {
            End::None => Ok(()),
            End::Open(high) => write!(f, "below {}", short(high)),
            End::Closed(high) => write!(f, "at most {}", short(high)),
        }
    }
}

/// A number in its short form: `0.2`, `20000`, `1.5e-4`. Reads back as the same number.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_in_or_out_as_the_text_says() {
        let range = above(0.0).at_most(1.5e-4);
        assert_eq!(range.to_string(), "above 0 and at most 1.5e-4");
        assert!(!range.contains(0.0) && range.contains(1e-300));
        assert!(range.contains(1.5e-4) && !range.contains(1.6e-4));
        let range = at_least(0.0).below(1.0);
        assert_eq!(range.to_string(), "of at least 0 and below 1");
        assert!(range.contains(0.0) && !range.contains(1.0));
        assert!(!at_least(0.0).contains(f64::INFINITY));
        assert!(!at_least(0.0).contains(f64::NAN));
    }
}

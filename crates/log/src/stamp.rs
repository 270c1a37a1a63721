//! Time stamps as a log has them.

/// A time stamp. Whole nanoseconds stay exact: in seconds since 1970 a double resolves 0.24 us
/// only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamp {
    /// Seconds.
    Seconds(f64),
    /// Nanoseconds.
    Nanoseconds(i64),
}

/// Unit of the numbers in a time column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeUnit(
    /// Units in a second: 1, or a power of ten up to 1e9.
    pub i64,
);

impl TimeUnit {
    /// Seconds.
    pub const SECOND: Self = Self(1);
    /// Milliseconds.
    pub const MILLISECOND: Self = Self(1_000);
    /// Microseconds.
    pub const MICROSECOND: Self = Self(1_000_000);
    /// Nanoseconds.
    pub const NANOSECOND: Self = Self(1_000_000_000);

    /// The stamp of a whole number; `None` beyond the range of nanoseconds, 292 years.
    pub fn of_whole(self, number: i64) -> Option<Stamp> {
        if self == Self::SECOND {
            return Some(Stamp::Seconds(seconds(number)));
        }
        let nanoseconds = number.checked_mul(1_000_000_000 / self.0)?;
        Some(Stamp::Nanoseconds(nanoseconds))
    }

    /// The stamp of a number; `None` where it is not finite.
    pub fn of_float(self, number: f64) -> Option<Stamp> {
        let stamp = match self {
            // So a time in seconds keeps its bits.
            Self::SECOND => number,
            _ => number / seconds(self.0),
        };
        stamp.is_finite().then_some(Stamp::Seconds(stamp))
    }
}

impl Stamp {
    /// The stamp of whole seconds and of nanoseconds, 0 to 999 999 999; `None` of other numbers.
    pub fn of_parts(seconds: f64, nanoseconds: f64) -> Option<Self> {
        // Far below the largest whole number that a double has exactly.
        const MOST: f64 = 9e9;
        let is_whole = seconds.fract() == 0.0 && nanoseconds.fract() == 0.0;
        let is_allowed = is_whole && seconds.abs() < MOST && (0.0..1e9).contains(&nanoseconds);
        // The casts are exact.
        is_allowed.then(|| Self::Nanoseconds(seconds as i64 * 1_000_000_000 + nanoseconds as i64))
    }

    /// Time since another stamp, s.
    pub fn since(self, origin: Self) -> f64 {
        match (self, origin) {
            (Self::Nanoseconds(a), Self::Nanoseconds(b)) if a.checked_sub(b).is_some() => {
                Self::Nanoseconds(a - b).seconds()
            }
            _ => self.seconds() - origin.seconds(),
        }
    }

    /// In seconds, rounded to a double.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::Nanoseconds(nanoseconds) => seconds(nanoseconds) / 1e9,
        }
    }
}

fn seconds(number: i64) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: differences of nanoseconds are exact at any date, those of seconds keep the
    /// bits of a run's times.
    #[test]
    #[expect(clippy::float_cmp, reason = "exact numbers")]
    fn differences_are_exact() {
        let now = 1_719_912_345_123_456_789;
        let (a, b) = (Stamp::Nanoseconds(now), Stamp::Nanoseconds(now + 1_000_001));
        assert_eq!(b.since(a), 0.001_000_001);
        let time = 0.1 + 0.2;
        assert_eq!(Stamp::Seconds(time).since(Stamp::Seconds(0.0)), time);
        assert_eq!(
            TimeUnit::MILLISECOND.of_float(2500.0),
            Some(Stamp::Seconds(2.5))
        );
        assert_eq!(
            TimeUnit::MICROSECOND.of_whole(7),
            Some(Stamp::Nanoseconds(7_000))
        );
        assert_eq!(TimeUnit::MICROSECOND.of_whole(i64::MAX), None);
        assert_eq!(TimeUnit::SECOND.of_float(f64::NAN), None);
        let parts = Stamp::of_parts(1_719_912_345.0, 123_456_789.0);
        assert_eq!(parts, Some(Stamp::Nanoseconds(now)));
        assert_eq!(Stamp::of_parts(1.5, 0.0), None);
        assert_eq!(Stamp::of_parts(1.0, 1e9), None);
    }
}

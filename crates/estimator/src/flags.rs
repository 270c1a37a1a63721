//! Why an estimate deserves less trust.

/// A set of reasons to trust an estimate less. Empty: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(u8);

impl Flags {
    /// A wheel carries next to nothing: its contact angle and traction say little.
    pub const WHEEL_UNLOADED: Self = Self(1);
    /// A reading or a result is out of the range in which the estimator is valid.
    pub const OUT_OF_RANGE: Self = Self(1 << 1);
    /// A reading is missing.
    pub const SENSOR_MISSING: Self = Self(1 << 2);
    /// A reading is older than it may be.
    pub const SENSOR_STALE: Self = Self(1 << 3);
    /// Pin Q is at a stop: its moment is not in the statics.
    pub const AT_STOP: Self = Self(1 << 4);

    const NAMED: [(Self, &'static str); 5] = [
        (Self::WHEEL_UNLOADED, "wheel unloaded"),
        (Self::OUT_OF_RANGE, "out of range"),
        (Self::SENSOR_MISSING, "sensor missing"),
        (Self::SENSOR_STALE, "sensor stale"),
        (Self::AT_STOP, "at stop"),
    ];

    /// No reason.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Holds all of `other`.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Names of the reasons, in a fixed order.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMED
            .into_iter()
            .filter(move |(flag, _)| self.contains(*flag))
            .map(|(_, name)| name)
    }
}

impl core::ops::BitOr for Flags {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_set() {
        assert!(Flags::default().is_empty());
        let flags = Flags::AT_STOP | Flags::WHEEL_UNLOADED;
        assert!(flags.names().eq(["wheel unloaded", "at stop"]));
    }
}

//! Warnings of an estimate.

use crate::bit_set::bit_set;

/// A set of warnings. As a number ([`Self::bits`]): wheels 1, 2, 4; stop 8; missing 16; stale 32;
/// absurd 64; out of range 128; spins in place 256; contradiction 512.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags(u16);

bit_set!(Flags);

impl Flags {
    /// Wheel 1, 2 or 3 carries no load: its normal force came out negative and was set to zero, or
    /// it is below a twentieth of the mean load. Its traction and contact angle have no meaning.
    pub const WHEEL_UNLOADED: [Self; 3] = [Self(1), Self(2), Self(4)];
    /// The linkage is at an end stop of pin Q, whose torque no sensor measures.
    pub const AT_STOP: Self = Self(8);
    /// A reading is missing from this frame; the last good one stands in for it.
    pub const SENSOR_MISSING: Self = Self(16);
    /// A reading has been missing for more than 0.1 s, or the filters start anew: after a gap in
    /// time, with a clock that was set back, with an encoder that counts from a new zero.
    pub const SENSOR_STALE: Self = Self(32);
    /// A reading was not a finite number or beyond what the robot can do; it counts as missing.
    pub const SENSOR_ABSURD: Self = Self(64);
    /// The parity residual is beyond five standard deviations: an impact, an unknown load, a wrong
    /// contact angle. Or a force is beyond five times the weight: wrong readings.
    pub const OUT_OF_RANGE: Self = Self(128);
    /// The drives turn the wheels or push, but the robot stands. Where its wheels touch the ground
    /// is then hardly known.
    pub const SPINS_IN_PLACE: Self = Self(256);
    /// Readings contradict each other: see [`crate::Health::faulty`].
    pub const CONTRADICTION: Self = Self(512);

    /// Warnings with which forces and motion say nothing of the friction: an unknown torque, old
    /// readings, an impact.
    pub const UNRELIABLE: Self =
        Self(Self::AT_STOP.0 | Self::SENSOR_STALE.0 | Self::OUT_OF_RANGE.0);

    /// This set if a condition holds, else none.
    pub(crate) fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::NONE }
    }

    /// All flags and their names.
    const NAMES: [(Self, &'static str); 10] = [
        (Self::WHEEL_UNLOADED[0], "wheel 1 unloaded"),
        (Self::WHEEL_UNLOADED[1], "wheel 2 unloaded"),
        (Self::WHEEL_UNLOADED[2], "wheel 3 unloaded"),
        (Self::AT_STOP, "linkage at a stop"),
        (Self::SENSOR_MISSING, "reading missing"),
        (Self::SENSOR_STALE, "reading stale"),
        (Self::SENSOR_ABSURD, "reading absurd"),
        (Self::OUT_OF_RANGE, "out of the model's range"),
        (Self::SPINS_IN_PLACE, "wheels spin in place"),
        (Self::CONTRADICTION, "readings contradict each other"),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_a_union_and_names() {
        let mut flags = Flags::WHEEL_UNLOADED[1] | Flags::AT_STOP;
        assert!(flags.names().eq(["wheel 2 unloaded", "linkage at a stop"]));
        flags |= Flags::SENSOR_STALE;
        assert!(flags.contains(Flags::SENSOR_STALE) && !flags.contains(Flags::SENSOR_MISSING));
        assert!(Flags::NONE.is_empty() && Flags::NONE.names().next().is_none());
        assert_eq!(flags.bits(), 2 + 8 + 32);
    }
}

//! Sets of named bits: warnings of an estimate, and channels of readings.

/// Gives a set of bits, a tuple struct of a `u16` with the constant `NAMES` (pairs of an element
/// and its name), its operations.
macro_rules! bit_set {
    ($set:ident) => {
        impl $set {
            /// The empty set.
            pub const NONE: Self = Self(0);

            /// The set as a number, one bit an element.
            pub const fn bits(self) -> u16 {
                self.0
            }

            /// Whether there is none.
            pub const fn is_empty(self) -> bool {
                self.0 == 0
            }

            /// Whether all of `other` are in this set.
            pub const fn contains(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }

            /// Whether any of `other` is in this set.
            pub const fn intersects(self, other: Self) -> bool {
                self.0 & other.0 != 0
            }

            /// Names of the elements in this set.
            pub fn names(self) -> impl Iterator<Item = &'static str> {
                Self::NAMES
                    .into_iter()
                    .filter(move |(element, _)| self.contains(*element))
                    .map(|(_, name)| name)
            }
        }

        impl core::ops::BitOr for $set {
            type Output = Self;

            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }

        impl core::ops::BitOrAssign for $set {
            fn bitor_assign(&mut self, other: Self) {
                self.0 |= other.0;
            }
        }
    };
}

/// A set of warnings. As a number ([`Self::bits`]): wheels 1, 2, 4; stop 8; missing 16; stale 32;
/// absurd 64; out of range 128; spins in place 256; contradiction 512.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags(u16);

bit_set!(Flags);

impl Flags {
    /// Wheel 1, 2 or 3 carries no load: its normal force is below a twentieth of the mean load, and
    /// the mean load is beyond three of its standard deviations. Its traction and contact angle have
    /// no meaning. A normal force that is only uncertain does not raise it, even where it came out
    /// negative and was set to zero.
    pub const WHEEL_UNLOADED: [Self; 3] = [Self(1), Self(2), Self(4)];
    /// The linkage is at an end stop of pin Q, whose torque no sensor measures.
    pub const AT_STOP: Self = Self(8);
    /// A reading is missing from this frame, or jumps and no other has confirmed it yet; the last
    /// good one stands in for it.
    pub const SENSOR_MISSING: Self = Self(16);
    /// A reading has been missing for more than 0.1 s, or the filters start anew: after a gap in
    /// time, with a clock that was set back, with an encoder that counts from a new zero, with an angle that its
    /// gyroscope had led astray.
    pub const SENSOR_STALE: Self = Self(32);
    /// A reading was not a finite number or beyond what the robot can do; it counts as missing.
    pub const SENSOR_ABSURD: Self = Self(64);
    /// The parity residual is beyond five standard deviations: an impact, an unknown load, a wrong
    /// contact angle. Or a force is beyond five times the weight: wrong readings.
    pub const OUT_OF_RANGE: Self = Self(128);
    /// The drives turn the wheels or push, but the robot stands. Where its wheels touch the ground
    /// is then hardly known.
    pub const SPINS_IN_PLACE: Self = Self(256);
    /// Readings contradict each other: see [`crate::Health::faulty`], and of a rover with both sides
    /// [`crate::whole::WholeEstimate::body_flags`].
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

/// A set of channels of readings. As a number ([`Self::bits`]): encoders 1, 2, 4; torques 8, 16,
/// 32; contact angles 64, 128, 256; gyroscopes 512, 1024; inclinometers 2048, 4096; parity 8192;
/// torque scale or mass 16384.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Channels(u16);

bit_set!(Channels);

impl Channels {
    /// Encoders of wheels 1 to 3.
    pub const ENCODER: [Self; 3] = [Self(1), Self(2), Self(4)];
    /// Motor torques of wheels 1 to 3.
    pub const TORQUE: [Self; 3] = [Self(8), Self(16), Self(32)];
    /// Contact angles of wheels 1 to 3.
    pub const CONTACT_ANGLE: [Self; 3] = [Self(64), Self(128), Self(256)];
    /// Gyroscopes on links 1 and 2.
    pub const GYROSCOPE: [Self; 2] = [Self(512), Self(1024)];
    /// Inclinometers on links 1 and 2.
    pub const INCLINOMETER: [Self; 2] = [Self(2048), Self(4096)];
    /// The parity residual: a torque, an angle or a load, of which nothing more is known.
    pub const PARITY: Self = Self(8192);
    /// All torques against the weight: their scale, or the robot's mass. See
    /// [`crate::TorqueScale`].
    pub const TORQUE_SCALE: Self = Self(16384);

    /// All channels and their names.
    const NAMES: [(Self, &'static str); 15] = [
        (Self::ENCODER[0], "encoder 1"),
        (Self::ENCODER[1], "encoder 2"),
        (Self::ENCODER[2], "encoder 3"),
        (Self::TORQUE[0], "torque 1"),
        (Self::TORQUE[1], "torque 2"),
        (Self::TORQUE[2], "torque 3"),
        (Self::CONTACT_ANGLE[0], "contact angle 1"),
        (Self::CONTACT_ANGLE[1], "contact angle 2"),
        (Self::CONTACT_ANGLE[2], "contact angle 3"),
        (Self::GYROSCOPE[0], "gyroscope 1"),
        (Self::GYROSCOPE[1], "gyroscope 2"),
        (Self::INCLINOMETER[0], "inclinometer 1"),
        (Self::INCLINOMETER[1], "inclinometer 2"),
        (Self::PARITY, "parity"),
        (Self::TORQUE_SCALE, "torque scale or mass"),
    ];

    /// The set of a number: the inverse of [`Self::bits`]. Other bits are ignored.
    pub fn from_bits(bits: u16) -> Self {
        let all = Self::NAMES
            .iter()
            .fold(0, |all, (element, _)| all | element.0);
        Self(bits & all)
    }
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

    #[test]
    fn sets_have_a_union_names_and_bits() {
        let mut set = Channels::TORQUE[1] | Channels::PARITY;
        assert!(set.names().eq(["torque 2", "parity"]));
        set |= Channels::GYROSCOPE[0];
        assert!(set.contains(Channels::GYROSCOPE[0]) && !set.contains(Channels::ENCODER[0]));
        assert_eq!(Channels::from_bits(set.bits()), set);
        assert_eq!(
            Channels::from_bits(u16::MAX).names().count(),
            Channels::NAMES.len()
        );
        assert!(Channels::NONE.is_empty() && Channels::NONE.names().next().is_none());
    }
}

//! A set of channels of readings.

use crate::bit_set::bit_set;

/// A set of channels of readings. As a number ([`Self::bits`]): encoders 1, 2, 4; torques 8, 16, 32;
/// contact angles 64, 128, 256; gyroscopes 512, 1024; inclinometers 2048, 4096; parity 8192; torque
/// scale or mass 16384.
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
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits & 0x7fff)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_a_union_names_and_bits() {
        let mut set = Channels::TORQUE[1] | Channels::PARITY;
        assert!(set.names().eq(["torque 2", "parity"]));
        set |= Channels::GYROSCOPE[0];
        assert!(set.contains(Channels::GYROSCOPE[0]) && !set.contains(Channels::ENCODER[0]));
        assert_eq!(Channels::from_bits(set.bits()), set);
        assert_eq!(Channels::from_bits(u16::MAX).names().count(), 15);
        assert!(Channels::NONE.is_empty() && Channels::NONE.names().next().is_none());
    }
}

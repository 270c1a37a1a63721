//! Layout of the motion filter's state: one index space for the filter, its measurements and eq. (8).
//!
//! The first [`INPUTS`] states are the uncertain inputs of eq. (8): quantities that no sensor measures,
//! or that sensors measure with correlated errors. Columns of the equation's sensitivity have the same
//! places.

use core::ops::Range;

/// The places of one quantity: one, one an axis (x, y), or one a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    first: usize,
    len: usize,
}

impl Block {
    /// The block of `len` places after this one.
    const fn then(self, len: usize) -> Self {
        Self {
            first: self.end(),
            len,
        }
    }

    /// The place after its last.
    pub const fn end(self) -> usize {
        self.first + self.len
    }

    /// The place of its axis or wheel `i`.
    pub const fn of(self, i: usize) -> usize {
        self.first + i
    }

    /// Number of its places.
    pub const fn len(self) -> usize {
        self.len
    }

    /// All of its places.
    pub const fn all(self) -> Range<usize> {
        self.first..self.end()
    }
}

const AXES: usize = 2;
const WHEELS: usize = 3;
const ONE: usize = 1;

/// Acceleration of Q, m/s^2.
pub(crate) const ACCELERATION: Block = Block {
    first: 0,
    len: AXES,
};
/// Contact-angle errors, reading minus true, rad. An unknown contact angle counts as given with 0.
pub(crate) const CONTACT_ANGLE: Block = ACCELERATION.then(WHEELS);
/// What resists the spin of each wheel at the mean load, N m; positive opposes the spin
/// ([`crate::resistance`]).
pub(crate) const RESISTANCE: Block = CONTACT_ANGLE.then(ONE);
/// Torque offsets, reading minus true, N m.
pub(crate) const TORQUE_OFFSET: Block = RESISTANCE.then(WHEELS);
/// Relative errors of the torque readings, positive for readings that are too large: consider
/// states. Only products with creep and contact angles make them observable. A linearised filter is
/// inconsistent there: its variance would fall while its error grows.
pub(crate) const TORQUE_GAIN: Block = TORQUE_OFFSET.then(WHEELS);
/// Number of the uncertain inputs of eq. (8).
pub(crate) const INPUTS: usize = TORQUE_GAIN.end();
/// Velocity of Q, m/s, as wheels that roll with their unloaded radius show it. That over the ground is
/// `1 - compression/radius` times it ([`crate::EstimatorSettings::compression`]).
pub(crate) const VELOCITY: Block = TORQUE_GAIN.then(AXES);
/// Natural logarithm of the creep speed c (m/s) of each wheel: slope of the slip speed over T/N at
/// small T/N (slip = c T/N), the inverse of its slip stiffness. It is not the dimensionless
/// creepage, which is c over the rolling speed.
pub(crate) const CREEP: Block = VELOCITY.then(WHEELS);
/// Speed at which each wheel comes out of the ground, m/s, because its load falls.
pub(crate) const PENETRATION: Block = CREEP.then(WHEELS);
/// Relative error of each wheel's rolling radius, true over nominal less 1.
pub(crate) const RADIUS: Block = PENETRATION.then(WHEELS);
/// Number of states.
pub(crate) const COUNT: usize = RADIUS.end();

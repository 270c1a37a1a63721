//! The states of the motion filter and their indices.
//!
//! From [`INPUTS`] on they are the uncertain inputs of eq. (8), in the order of [`input`].

use crate::statics::input;

/// Velocity of Q, m/s: x, y.
pub const VELOCITY: usize = 0;
/// Natural logarithm of the creep speed c (m/s) of each wheel: slope of the slip speed over T/N at
/// small T/N (slip = c T/N), the inverse of its slip stiffness. It is not the dimensionless
/// creepage, which is c over the rolling speed.
pub const CREEP: usize = 2;
/// The first of the uncertain inputs.
pub const INPUTS: usize = 5;
/// Acceleration of Q, m/s^2: x, y.
pub const ACCELERATION: usize = INPUTS + input::ACCELERATION;
/// Contact-angle errors, reading minus true, rad.
pub const CONTACT_ANGLE: usize = INPUTS + input::CONTACT_ANGLE;
/// Torque offsets, reading minus true, N m.
pub const TORQUE_OFFSET: usize = INPUTS + input::TORQUE_OFFSET;
/// Dry gear friction at the wheel, common to all wheels, N m; positive opposes the spin.
pub const GEAR_FRICTION: usize = INPUTS + input::GEAR_FRICTION;
/// Relative errors of the torque readings, positive for readings that are too large: consider
/// states. Only products with creep and contact angles make them observable. A linearised filter is
/// inconsistent there: its variance would fall while its error grows.
pub const TORQUE_GAIN: usize = INPUTS + input::TORQUE_GAIN;
/// Number of states.
pub const COUNT: usize = INPUTS + input::COUNT;
/// Number of consider states, at the end.
pub const CONSIDERED: usize = COUNT - TORQUE_GAIN;

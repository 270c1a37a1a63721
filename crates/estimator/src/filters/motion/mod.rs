//! Motion of the robot, errors of contact angles and torques, creep of the wheels: one Kalman filter.
//!
//! Three constraints hold, and each is a measurement of these states:
//! - A wheel's centre moves along the ground. The direction of its velocity is the contact angle, up to the speed of its
//!   penetration (`rolling.rs`).
//! - A wheel rolls. The speed of its centre is that of its rim less the slip, and the slip of a sticking wheel is
//!   proportional to T/N: creep (`rolling.rs`).
//! - The parity residual of eq. (8) is zero (`parity.rs`).
//!
//! The first relates the contact angles to each other and to the gyroscopes. The second separates torque offsets from
//! tractions, because a wheel without slip has no traction. The third relates the sum of tractions and slopes to the weight.
//!
//! States and their places are in `states.rs`, their change over time is in `prediction.rs`, all constants are in
//! `tuning.rs`, and errors that last in `noise.rs`.

mod filter;
mod noise;
mod parity;
mod prediction;
mod rolling;
mod states;
#[cfg(test)]
mod tests;
mod tuning;

pub(crate) use filter::MotionFilter;
pub(crate) use parity::ParityResidual;
pub(crate) use prediction::MeasuredAccelerations;
pub(crate) use rolling::RollingWheel;

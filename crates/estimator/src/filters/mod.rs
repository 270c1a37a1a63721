//! Filters: from readings over time to link angles, wheel torques, motion and the readings' errors.
//!
//! | filter | file |
//! |---|---|
//! | link angle (Fig. 5) and traction (eq. (3)) of the paper | `paper.rs` |
//! | Kalman filter of fixed size, with consider states | `kalman.rs` |
//! | a measurement: what is declared of it, how it corrects | `measurement.rs` |
//! | link angle and the gyroscope's bias; the inclination | `link_angle.rs`, `link_angle/inclination.rs` |
//! | torque of the ground on a wheel; the encoder's angle | `wheel_torque.rs`, `wheel_torque/encoder.rs` |
//! | low passes on rates | `smoothing.rs` |
//! | push of the other side of a robot with two | `push.rs` |
//! | unevenness of the ground under one side | `unevenness.rs` |
//! | turn of one side | `turn.rs` |
//! | motion of the robot, errors of contact angles and torques, creep | `motion/` |

mod kalman;
mod link_angle;
mod measurement;
pub(crate) mod motion;
mod paper;
mod push;
mod smoothing;
mod turn;
mod unevenness;
mod wheel_torque;

pub use kalman::{Innovation, Kalman, Projection};
pub use link_angle::LinkAngleKalman;
pub(crate) use measurement::{Expected, GaussMarkov, Measurement};
pub use paper::{ComplementaryFilter, TractionObserver};
pub(crate) use push::PushFilter;
pub(crate) use smoothing::smoothing_time;
pub(crate) use turn::TurnFilter;
pub(crate) use unevenness::Unevenness;
pub(crate) use wheel_torque::{COUNT_SIGMA, TorqueObserver, WheelParameters};

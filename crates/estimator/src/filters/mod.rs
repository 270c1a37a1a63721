//! Filters: from readings over time to link angles, wheel torques, motion and the readings' errors.
//!
//! | filter | file |
//! |---|---|
//! | link angle of the paper (Fig. 5) | `complementary.rs` |
//! | traction of the paper, eq. (3) | `traction.rs` |
//! | Kalman filter of fixed size, with consider states | `kalman.rs` |
//! | link angle and the gyroscope's bias | `link_angle.rs` |
//! | torque of the ground on a wheel | `wheel_torque.rs` |
//! | low passes on rates | `smoothing.rs` |
//! | motion of the robot, errors of contact angles and torques, creep | `motion/` |

mod complementary;
mod kalman;
mod link_angle;
pub(crate) mod motion;
mod smoothing;
mod traction;
mod wheel_torque;

pub use complementary::ComplementaryFilter;
pub use kalman::{Innovation, Kalman, Projection};
pub use link_angle::LinkAngleKalman;
pub(crate) use smoothing::smoothing_time;
pub use traction::TractionObserver;
pub(crate) use wheel_torque::{COUNT_SIGMA, TorqueObserver, UNIFORM, WheelParameters};

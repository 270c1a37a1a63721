//! Whether the readings agree with each other, from the innovations of the filters of `kalman`.
//!
//! A filter whose model and noise budget are right has normalised innovations squared (NIS) with a
//! mean of at most 1. A wrong sign, a wrong unit or exchanged channels make the mean of some of
//! them larger. [`HealthMonitor`] averages the NIS of each test over the last seconds of driving.
//!
//! | test | compares | faulty channels |
//! |---|---|---|
//! | encoder of wheel i | its angle with that which the torque observer predicts | encoder i |
//! | slip of wheel i | its rim speed, less the creep of its T/N, with those of the other wheels | encoder i, torque i |
//! | direction of wheel i | velocity of its centre with its contact angle | contact angle i |
//! | inclination of link k | inclinometer with the integrated gyroscope | gyroscope k, inclinometer k |
//! | turning of link k | mean of the inclinometer with the gyroscope, without the filters | gyroscope k, inclinometer k |
//! | parity | all torques, angles and loads, eq. (8) | parity |
//! | change of torque i | is it exactly constant while its wheel turns | torque i |
//! | answer of the control | differences of the torques with those of the encoders, in each pairing | the exchanged torques |
//! | start | sum of the torques with the motion of the robot that starts | late torques |
//! | torque scale | work of all torques with the robot's energy, [`crate::TorqueScale`] | all torques, the masses |
//!
//! A wrong gyroscope disturbs the slip of the wheels on its link, too: then the link alone is
//! faulty.

mod constancy;
mod monitor;
mod smoothing;
mod start;
mod turning;
mod wiring;

pub use monitor::Health;
pub(crate) use monitor::{HealthMonitor, HealthSample, Innovations};
pub(crate) use smoothing::WheelReadings;
pub use start::LATE_TORQUE;
pub(crate) use start::RollingRobot;
pub use wiring::PAIRINGS;

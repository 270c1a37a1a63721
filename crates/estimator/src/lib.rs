#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! | paper | here |
//! |---|---|
//! | Fig. 5, linkage position from two inclinometers and gyroscopes | `filters/paper.rs` |
//! | eq. (3), traction from motor torque and wheel speed | `filters/paper.rs` |
//! | eq. (1), the full system `G x = F` | `FullSystem` in `tests/full_system/derivation.rs` |
//! | eqs. (4) to (7), its block form | `BlockForm` there |
//! | eq. (8), the reduced system `H x' = F'`, as derived from them | `ReducedSystem` there |
//! | eq. (8), written directly | [`statics::Equilibrium`] |
//! | section 3.4, least squares for the three N | [`statics::Equilibrium::least_squares`] |
//! | Figs. 7 and 8, the linkage's mass lumped to body or wheels | [`Masses`] |
//!
//! `tests/full_system` derives eq. (8) as the paper does. It is a reference for
//! [`statics::Equilibrium`], which the estimators use.
//!
//! | beyond the paper: [`EstimatorSettings::kalman`] | here |
//! |---|---|
//! | inertial loads | [`statics::Loads::moving`] |
//! | eq. (8) with its redundancy, the parity residual | [`statics::Equilibrium::parity_direction`] |
//! | link angles and the gyroscopes' biases | `filters/link_angle.rs` |
//! | the ground's torque on a wheel from the encoder's angle | `filters/wheel_torque.rs` |
//! | motion, errors of contact angles and torques, creep: one filter | `filters/motion/` |
//! | sensitivity of eq. (8) to the filter's states | `statics/solve.rs` |
//! | mu_n and mu_max, section 5 | `friction/` |
//! | normal forces with their covariance, N >= 0 | `statics/solve.rs` |
//!
//! | folder | content |
//! |---|---|
//! | top | [`Estimator`], frames, settings, estimates, flags |
//! | [`statics`] | eq. (8), arms, loads, least squares, sensitivity |
//! | `filters/` | from readings over time to angles, torques, motion and errors |
//! | `ground/` | memory of the ground |
//! | `friction/` | needed friction, onset of slip, bounds of the friction |
//! | `health/` | whether the readings agree with each other |
//! | `torque_scale.rs` | the torques against the weight: a scale, a payload |
//! | `contact/` | velocity of a wheel relative to the ground, contact state, wheels that spin in place |
//! | [`whole`] | statics of a rover with both sides: six wheels, nine rows |
//! | `methods/` | the paper's method and `kalman`: filters and statics put together |
//!
//! Constants say where they come from. *Definition*, *Data sheet*, *Textbook*: the value follows
//! from it. *Chosen*: an assumption of the stated size; *sensitive* if half or double of it changes
//! the error of N of a case by more than 2 % (`docs/measurements/sensitivity.md` has the figures),
//! else *insensitive*; *held by* the tests that fail first. *Guard*: any value far beyond those of
//! a robot does, or it acts only while a reading is missing or wrong, where half or double of it
//! serves as well.
//!
//! The crate depends on the robot's nominal parameters (`robhaz-model`) alone: it cannot reach a
//! simulator.
#![no_std]
// Indices name wheels, links and states.
#![allow(clippy::needless_range_loop, reason = "one for several arrays")]
#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN must fail")]

mod common;
mod contact;
mod deviation;
mod door;
mod estimate;
mod estimator;
mod filters;
mod flags;
mod frame;
mod friction;
mod ground;
mod health;
mod methods;
mod nominal;
mod resistance;
mod settings;
mod start;
mod state;
pub mod statics;
#[cfg(test)]
mod testing;
mod torque_scale;
pub mod whole;

pub use common::DRIVING_SPEED;
pub use contact::{ContactEstimate, ContactState};
pub use estimate::{Estimate, EstimateError, KalmanReport, Parity, ReadingErrors};
pub use estimator::Estimator;
pub use flags::{Channels, Flags};
pub use frame::{LARGEST_TORQUE, LinkReading, SensorFrame};
pub use friction::{NeededFriction, OffsetShare, PeakFriction, SlipEvent, WheelFriction};
pub use ground::{FrictionBounds, GroundPoint};
pub use health::{Health, LATE_TORQUE, PAIRINGS};
pub use settings::{
    ContactAngles, EstimatorSettings, KalmanMethod, Masses, Method, NoiseBudget, PaperMethod, Sides,
};
pub use torque_scale::{Confirmation, TorqueScale};

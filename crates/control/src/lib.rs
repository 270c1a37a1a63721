#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! A [`Controller`] takes the readings of one sample, the estimate of the same sample and the set
//! speed, and returns a [`WheelCommand`] for each wheel. A command acts from the next sample on and
//! is held until the one after it.
//!
//! | kind | module |
//! |---|---|
//! | `speed`: every drive follows its own plan with its continuous PI control | [`Controller`] |
//! | `shared`: one speed control, its torque shared so that every wheel needs the same T/N | [`shared`] |
//! | `friction-test`: torque ramps on one wheel after the other | [`friction_test`] |
//!
//! The crate depends on the estimator and on the robot's nominal parameters alone: it cannot reach
//! a simulator.
#![no_std]
#![allow(
    clippy::needless_range_loop,
    reason = "indices name wheels, and go through several arrays at once"
)]
#![allow(
    clippy::manual_clamp,
    reason = "max and min turn a NaN into a limit; clamp would keep it, or panic"
)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "comparisons are written so that a NaN fails them"
)]

#[cfg(test)]
extern crate std;

mod controller;
pub mod friction_test;
mod input;
pub mod shared;

pub use controller::Controller;
pub use friction_test::{FrictionTestEnd, FrictionTestResult};
pub use input::{
    ControlInput, ControlKind, ControlSettings, ControlSettingsError, FrictionTestPlan,
};
pub use robhaz_model::WheelCommand;

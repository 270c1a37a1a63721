//! Wheel forces of ROBHAZ-6WHEEL from sensor readings alone.
//!
//! After Choi, Kang, Hyun, Kim and Kwak, *Force Distribution Estimation of Wheeled Mobile Robot: Application to Friction
//! Coefficients Estimation*: linkage angles, motor torque and wheel speed, put into static equilibrium, give the normal
//! force of every wheel by least squares.
//!
//! | paper | here |
//! |---|---|
//! | Fig. 5, linkage position from two inclinometers and gyros | [`linkage`] |
//! | eq. (3), traction from motor torque and wheel speed | [`traction`] |
//! | eq. (1), the full system `G x = F` | [`statics::FullSystem`] |
//! | eqs. (4) to (7), its block form | [`statics::BlockForm`] |
//! | eq. (8), the reduced system `H x' = F'` | [`statics::ReducedSystem`] |
//! | section 3.4, least squares for the three N | [`statics::ReducedSystem::normal_forces`] |
//! | Figs. 7 and 8, the linkage's mass lumped to body or wheels | [`Masses`] |
//!
//! | beyond the paper: [`EstimatorSettings::best`] | here |
//! |---|---|
//! | eq. (8) written directly, with inertial loads and its one redundancy, the parity residual | [`equilibrium`] |
//! | positions and accelerations on the linkage | [`arms`] |
//! | link angles and the gyroscopes' biases | [`linkage::LinkAngleKalman`] |
//! | the ground's torque on a wheel from the encoder's angle | [`torque_observer`] |
//! | motion, errors of contact angles and torques, creep: one filter | `motion.rs` |
//! | what forces depend on of that: their covariance | `sensitivity.rs` |
//! | normal forces with their covariance, N >= 0 | `forces.rs` |
//!
//! The crate is `no_std`, allocates nothing, and depends on the robot's drawings (`robhaz-model`) alone: it cannot reach
//! the simulator.
//!
//! ```
//! use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
//! use robhaz_model::Robot;
//!
//! let robot = Robot::default_a();
//! let mut estimator = Estimator::new(&robot, EstimatorSettings::paper_wheels());
//! // At rest on level ground: no torque, no turning, linkage in its nominal pose.
//! let estimate = estimator.update(&SensorFrame {
//!     time: 0.0,
//!     wheel_angle: [Some(0.0); 3],
//!     motor_torque: [Some(0.0); 3],
//!     link1: LinkReading { inclination: Some(0.0), rate: Some(0.0) },
//!     link2: LinkReading { inclination: Some(0.0), rate: Some(0.0) },
//!     contact_angle: [Some(0.0); 3],
//! })?;
//! let weight = 14.0 * 9.81;
//! assert!((estimate.normal_force.iter().sum::<f64>() - weight).abs() < 1e-9);
//! # Ok::<(), robhaz_estimator::EstimateError>(())
//! ```
#![no_std]
#![allow(
    clippy::needless_range_loop,
    reason = "indices name wheels, links and states, and go through several arrays at once"
)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "comparisons are written so that a NaN fails them"
)]

pub mod arms;
mod best;
pub mod equilibrium;
mod estimate;
mod estimator;
mod flags;
mod forces;
mod frame;
mod kalman;
pub mod linkage;
mod motion;
mod paper;
mod saved;
mod sensitivity;
mod settings;
pub mod statics;
#[cfg(test)]
mod testing;
mod told;
pub mod torque_observer;
pub mod traction;
mod visit;

pub use estimate::{Estimate, EstimateError, Parity, ReadingErrors};
pub use estimator::Estimator;
pub use flags::Flags;
pub use frame::{LinkReading, SensorFrame};
pub use saved::{RestoreError, SavedState};
pub use settings::{EstimatorSettings, Filters, Masses, NoiseBudget};

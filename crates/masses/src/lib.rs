//! Masses and centres of mass of a robot from its wheels on scales.
//!
//! The robot stands with its wheels on horizontal plates at different heights: blocks, and scales
//! under some or all wheels. The inclinations of links 1 and 2 and the scales' readings in a few
//! postures, with the nominal values as the prior, give masses, centres of mass and pins with their
//! covariance by least squares.
//!
//! | step | file |
//! |---|---|
//! | the unknowns and what the nominal values know of them | `parameters.rs` |
//! | forces on the plates: eq. (8) with contact angles of 0 | `statics.rs` |
//! | readings and their errors | `measurements.rs` |
//! | least squares with a prior (Gauss and Newton) | `prior.rs`, `fit.rs` |
//! | the covariance in the seven parameters that forces depend on | `loads.rs` |
//! | the lateral centre of mass, from scales under both sides | `lateral.rs` |
//! | postures on blocks, what scales would show there, and the most informative ones | `blocks.rs`, `plan.rs` |
//!
//! On scales the wheels are free or on plates that give way, so that no traction acts: T = 0 but
//! for a small rest ([`Accuracy::horizontal_force`]). With one wheel each on links 1 and 2, eq. (8)
//! then determines the three normal forces of a posture from the seven load parameters of
//! [`robhaz_estimator::statics`]; scales measure these, and single masses only as far as the
//! nominal values separate them.
#![allow(
    clippy::needless_range_loop,
    reason = "indices name wheels and parameters, and go through several arrays at once"
)]

mod blocks;
mod error;
mod fit;
mod lateral;
mod loads;
mod measurements;
mod parameters;
mod plan;
mod prior;
mod statics;

pub use blocks::{Blocks, simulate};
pub use error::WeighError;
pub use fit::{CHECK_UNITS, Misfit, Weighed, is_other_mass, weigh};
pub use lateral::{Lateral, lateral, simulate_both};
pub use loads::{ForceDeviation, WeighedValue};
pub use measurements::{Accuracy, Measurements, Reading};
pub use parameters::Tolerances;
pub use plan::{Plan, PlannedPosture, plan};
pub use statics::plate_forces;

//! Statics of the linkage: the paper's eq. (8), with inertial loads, bounded least squares
//! and covariance.
//!
//! | step | file |
//! |---|---|
//! | positions and accelerations on the linkage, relative to Q | `arms.rs` |
//! | gravity and inertial loads of the parts | `loads.rs` |
//! | eq. (8) written directly, its left inverse and parity direction | `equilibrium.rs` |
//! | push and share of the load by the other side of the robot | `other_side.rs` |
//! | what the loads' weights depend on, and its covariance | `load_parameters.rs` |
//! | sensitivity to the uncertain inputs, least squares for N, with covariance | `solve.rs` |
//! | forces of the wheels with their covariance, bounded by N >= 0 | `forces.rs` |
//!
//! `tests/full_system` of this crate derives eq. (8) from eq. (1) as the paper does: a reference
//! for `equilibrium.rs`.

mod arms;
mod equilibrium;
mod forces;
mod load_parameters;
mod loads;
mod other_side;
mod solve;

pub use arms::{Arms, Turning};
pub(crate) use equilibrium::Equations;
pub use equilibrium::{Equilibrium, LeastSquaresInverse};
pub(crate) use forces::Forces;
pub use load_parameters::{
    LOAD_PARAMETER_NAMES, LOAD_PARAMETERS, LoadCovariance, LoadCovarianceError, by_load_parameters,
    load_parameters,
};
pub use loads::{LinkageMotion, Load, Loads};
pub(crate) use other_side::OtherSide;
pub(crate) use solve::{
    CAUSES, DIRECT, RightSide, Sensitivity, Traction, causes, sensitivity, solve,
};

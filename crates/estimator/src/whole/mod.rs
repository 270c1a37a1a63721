//! Statics of a whole rover: six wheels on both sides, coupled by a differential or a rear bogie.
//!
//! | step | file |
//! |---|---|
//! | positions of pins, axles and centres of mass; contact frames | `posture.rs` |
//! | weight and inertia of the parts | `loads.rs` |
//! | the nine rows: forces, moments, coupling, bogies | `equilibrium.rs` |
//! | weighted least squares for six N, with covariance | `solve.rs` |
//! | from both sides' filters to the inputs of the rows | `inputs.rs` |
//! | the readings of the rover as those of each side's links | `readings.rs` |
//! | readings of both sides in, forces of six wheels out | `estimator.rs`, `estimate.rs` |
//!
//! Vectors are in the body frame: origin O on [`WholeRover::pivot`] in the middle plane, x forward,
//! y left, z up. Links turn nose up, which is about -y; roll is about x, left side up; yaw about z,
//! to the left. Wheels are left 1 to 3, then right 1 to 3, links left, then right.
//!
//! `docs/whole-rover.md` writes the equations.
//!
//! [`WholeRover::pivot`]: robhaz_model::WholeRover::pivot

mod equilibrium;
mod estimate;
mod estimator;
mod inputs;
mod loads;
mod posture;
mod readings;
mod solve;

pub use equilibrium::{ROWS, Rows, WholeEquilibrium};
pub use estimate::{TipLine, WholeEstimate};
pub use estimator::WholeEstimator;
pub use loads::{JointMotion, WholeMotion};
pub use posture::{Contact, Joints, Link, WholePosture};
pub use readings::{SideReadings, WholeFrame};
pub use solve::{INPUTS, InputCovariance, WholeForces, input};

/// A vector in the body frame.
pub type Vec3 = nalgebra::Vector3<f64>;

/// Reason why there are no forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WholeError {
    /// The side is a four-bar, whose sides share the body's moment in a way that statics leave
    /// undetermined.
    FourBar,
    /// The contacts leave a normal force undetermined, or an input is not finite.
    Singular,
}

impl core::fmt::Display for WholeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::FourBar => {
                "the side is a four-bar: statics do not say how the sides share the body's moment"
            }
            Self::Singular => {
                "the six normal forces are not determined: contacts that carry no load apart, or an input that is not finite"
            }
        })
    }
}

impl core::error::Error for WholeError {}

//! Contact of a wheel with the ground: its velocity relative to the ground, contact state, and
//! wheels that spin in place.

mod detector;
mod standing;
mod velocity;

pub(crate) use detector::{
    ContactDetector, ContactEvidence, LEAST_SLIP, RollingResiduals, SLIPPING_RATIO, SlipResidual,
};
pub use detector::{ContactEstimate, ContactState};
pub(crate) use standing::StandingDetector;
pub(crate) use velocity::ContactVelocity;

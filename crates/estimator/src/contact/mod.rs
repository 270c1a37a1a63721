//! Contact of a wheel with the ground: its velocity relative to the ground, creep, and contact state.

mod creep;
mod detector;
mod state;
mod velocity;

pub(crate) use creep::Creep;
pub(crate) use detector::{ContactDetector, ContactEvidence, RollingResiduals, SlipResidual};
pub use state::{ContactEstimate, ContactState};
pub(crate) use velocity::ContactVelocity;

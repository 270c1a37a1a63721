//! Contact of a rolling wheel with the ground: its velocity relative to the ground, and creep.

mod creep;
mod velocity;

pub(crate) use creep::Creep;
pub(crate) use velocity::ContactVelocity;

//! Terrain profiles and the nearest contacts of a wheel with them.
//!
//! A [`Profile`] is what a user writes: level ground, bumps, ramps, stairs. A [`Terrain`] is the same ground made ready for contact: a
//! chain of edges, straight or curved, with a grid that finds those under a wheel. Distances are measured along the true
//! normal, to the curve itself and never to a polygon of it: a polygon's kinks would show as spikes in the normal force.

mod bumps;
mod chain;
mod check;
mod contact;
mod cosbump;
mod course;
mod ditch;
mod edge;
mod grid;
mod heights;
mod profile;
mod ramp;
mod rough;
mod sine;
mod stairs;
mod survey;
mod terrain;

pub use bumps::Bump;
pub use contact::Contact;
pub use cosbump::CosBump;
pub use course::Course;
pub use ditch::Ditch;
pub use heights::{Heights, Interpolation, Overshoot};
pub use profile::{Profile, ProfileError};
pub use ramp::Ramp;
pub use rough::{Rough, RoughClass, RoughSettings};
pub use sine::Sine;
pub use stairs::Stairs;
pub use survey::Surveyed;
pub use terrain::Terrain;

/// A point or direction in the plane (x forward, y up).
pub type Vec2 = nalgebra::Vector2<f64>;

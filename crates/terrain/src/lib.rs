//! Terrain profiles and the nearest contacts of a wheel with them.
//!
//! A [`Profile`] is what a user writes: level ground, bumps, ramps, stairs. A [`Terrain`] is the same ground made ready for contact: a
//! chain of edges, straight or curved, in a bounding volume hierarchy of parry2d. Distances are measured along the true
//! normal, to the curve itself and never to a polygon of it: a polygon's kinks would show as spikes in the normal force.

mod course;
mod heights;
mod profile;
mod rough;
mod terrain;

pub use course::Course;
pub use heights::{Heights, Interpolation};
pub use profile::{Bump, Profile, ProfileError};
pub use rough::{Rough, RoughClass, RoughSettings};
pub use terrain::{Contact, Terrain};

/// A point or direction in the plane (x forward, y up).
pub type Vec2 = nalgebra::Vector2<f64>;

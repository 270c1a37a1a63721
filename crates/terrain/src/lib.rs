//! Terrain profiles and the nearest contacts of a wheel with them.
//!
//! A [`Profile`] describes the height of the ground over x by its parameters: level ground, bumps,
//! ramps, stairs. A [`Terrain`] holds the same ground as a chain of straight and curved edges, with
//! a grid that finds the edges near a wheel. Distances are measured along the normal of the curve
//! itself. A polygon in place of the curve would have kinks, which appear as spikes of the normal
//! force. [`read_track`] reads measured points; [`text_table`] is the reader of text tables for all
//! other crates, too.

mod chain;
pub mod decimals;
mod edge;
mod grid;
mod heights;
mod kinds;
mod profile;
mod risers;
mod rough;
mod shape;
mod terrain;
pub mod text_table;
mod track;

pub use edge::{Contact, Jump};
pub use heights::{Heights, Interpolation, Overshoot};
pub use kinds::{Bump, CosBump, Ditch, Ramp, Sine, Stairs};
pub use profile::{Course, Profile};
pub use risers::check_risers;
pub use robhaz_model::Vec2;
pub use rough::{Rough, RoughClass, RoughSettings};
pub use shape::ProfileError;
pub use terrain::{Surveyed, Terrain};
pub use track::{Column, TrackError, TrackFormat, read_track};

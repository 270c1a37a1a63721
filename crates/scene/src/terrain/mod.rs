//! `[terrain]`: kinds of ground, each with keys of its own, and points from tracks.

mod ground;
mod keys;
mod kinds;
mod points;

pub use ground::{TerrainChoice, Track};
pub(crate) use kinds::Terrain;

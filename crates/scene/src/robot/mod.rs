//! `[robot]`: geometry and masses, by name, from a file, or written in the scene.

mod across;
mod checks;
mod choice;
mod fault;
mod keys;
mod part;
mod stance;

pub use choice::RobotChoice;
pub(crate) use keys::{GEOMETRY, GEOMETRY_PART, MASS_PART, MASSES};
pub(crate) use stance::ROBOT;

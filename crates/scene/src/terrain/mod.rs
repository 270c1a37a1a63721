//! `[terrain]`: kinds of ground, each with a table of keys of its own, and points from tracks.

mod bump;
mod choice;
mod columns;
mod kinds;
mod points;
mod read;
mod schema;
mod section;
mod tables;
mod track;

pub(crate) use bump::{BUMP, NO_BUMP};
pub use choice::TerrainChoice;
pub(crate) use columns::Column;
pub(crate) use kinds::{DEFAULT, KINDS, Parameters, Visitor, kind_of};
pub(crate) use read::read;
pub(crate) use schema::{part, section};
pub(crate) use section::{COMMON, NO_STRETCH, PATH, STRETCH, STRETCHES};
pub use track::Track;

//! Distance of the robot's body and links to the ground, by parry2d.
//!
//! Contacts of wheels are the simulation's own. Body and links have an outline
//! ([`robhaz_model::Outline`]) whose contact is not modelled: no force acts where a bar touches the
//! ground. This module computes their distance to it. What a link's own wheels cover does not
//! count: there the wheel touches first.

mod meter;
mod part;

pub use meter::{ClearanceMeter, Clearances};
pub use part::BarPlace;

//! The plant: ROBHAZ-6WHEEL on its ground, with the forces as they truly are.
//!
//! | paper | here |
//! |---|---|
//! | eq. (2), the wheel with its drive | [`drive`] |
//! | eq. (10), contact | [`contact`] |
//! | eq. (11), friction | [`friction`] |
//! | limited pin joint | [`stop`] |
//! | closed four-bar, three wheels | [`rapier`], and independently [`direct`] |
//!
//! [`Plant`] owns time and returns one [`Truth`] per record; [`sensors`] turns truth into readings. Nothing flows back.

mod balance;
pub mod contact;
pub mod direct;
pub mod drive;
mod energy;
pub mod friction;
mod ground;
mod joints;
mod plant;
pub mod random;
pub mod rapier;
pub mod sensors;
pub mod stability;
mod start;
pub mod stop;
mod truth;

pub use balance::Balance;
pub use energy::mechanical_energy;
pub use plant::{EngineKind, Plant, PlantError, PlantSetup};
pub use start::{NoRest, StartKind};
pub use truth::{BarTruth, PinTruth, Truth, WheelTruth};

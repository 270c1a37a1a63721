//! The plant: ROBHAZ-6WHEEL on its ground, with the true motion and forces.
//!
//! | topic | module |
//! |---|---|
//! | eq. (2), the wheel with its drive; set speeds that differ from wheel to wheel | [`drive`] |
//! | eq. (10), contact | [`contact`] |
//! | eq. (11), friction; rolling resistance | [`friction`] |
//! | closed four-bar with three wheels | [`rapier`] and, in another formulation, [`direct`] |
//! | stability of an explicit step | [`stability`] |
//! | distance of body and links to the ground | [`clearance`] |
//! | sensors: readings from the truth | [`sensors`] |
//!
//! Without the feature `engines` there is no [`Plant`] and no [`clearance`]: laws, settings and sensors
//! alone, as files of scenes need them.
//!
//! [`Plant`] owns time and returns one [`Truth`] per period; [`sensors`] turns truths into
//! readings. Data flows in this direction only.
//!
//! Inside, the modules build on each other in this order: the laws; [`PlantSetup`] and
//! [`PlantError`]; `ground` (terrain, contact and friction of one wheel); `mechanics` (equations of
//! motion in minimal coordinates); `start` (state at time zero, from `mechanics`); the engines
//! (`direct` integrates `mechanics`; `rapier` has mechanics of its own); [`Plant`].

#![cfg_attr(
    not(feature = "engines"),
    allow(dead_code, reason = "what only the engines use")
)]

#[cfg(feature = "engines")]
pub mod clearance;
pub mod contact;
pub mod direct;
pub mod drive;
mod energy;
mod engine;
mod error;
pub mod friction;
mod ground;
mod mechanics;
#[cfg(feature = "engines")]
mod plant;
mod power;
pub mod random;
#[cfg(feature = "engines")]
pub mod rapier;
pub mod sensors;
mod setup;
pub mod stability;
mod start;
mod truth;

pub use energy::mechanical_energy;
pub use engine::Balance;
pub use error::{NoRest, NoTruth, PlantError};
#[cfg(feature = "engines")]
pub use plant::Plant;
pub use setup::{EngineChoice, EngineKind, PlantSetup, StartKind};
pub use truth::{
    BarTruth, ContactList, ContactTruth, EquivalentContact, PinTruth, Truth, WheelTruth,
};

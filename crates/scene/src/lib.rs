//! Scene files: what a user writes, read, checked and turned into the parts of a run.
//!
//! [`Scene::load`] reads a file and the overrides of the command line; [`Scene::to_toml`] writes the scene with every
//! choice made. Each key is declared once, with its unit, range, meaning and the field that it sets; reading, writing,
//! defaults and [`reference()`] come from that declaration.

mod checks;
mod columns;
mod error;
mod estimators;
mod excerpt;
mod file;
mod key;
mod load;
mod model_error;
mod name;
mod overrides;
mod plant_failure;
mod points;
mod range;
mod reader;
mod reference;
mod robot;
mod robot_keys;
mod scene;
mod sections;
mod seed;
mod sensors;
mod source;
mod suggest;
mod terrain;
mod terrain_keys;
mod track;
mod units;
mod write;

pub use error::{Problem, SceneError};
pub use model_error::{ModelError, ModelErrorTooLarge};
pub use plant_failure::PlantFailure;
pub use reference::{KeyReference, reference};
pub use robhaz_sim::EngineKind;
pub use robhaz_sim::sensors::{Grade, SensorSpec};
pub use scene::{
    EngineChoice, EstimatorChoice, RecordChoice, RobotChoice, Scene, SensorChoice, TerrainChoice,
    is_compared,
};
pub use track::Track;

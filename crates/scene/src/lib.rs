//! Scene files: what a user writes, read, checked and turned into the parts of a run.
//!
//! [`Scene::load`] reads a file and the overrides of the command line; [`Scene::to_toml`] writes the scene with every
//! choice made. Each key is declared once, with its unit, range, meaning and the field that it sets; reading, writing,
//! defaults and [`reference()`] come from that declaration.

mod checks;
mod error;
mod estimators;
mod excerpt;
mod fields;
mod file;
mod key;
mod load;
mod model_error;
mod name;
mod overrides;
mod plant_failure;
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
mod units;
mod write;

pub use error::{Problem, SceneError};
pub use estimators::EstimatorChoice;
pub use model_error::{ModelError, ModelErrorTooLarge};
pub use plant_failure::PlantFailure;
pub use reference::{KeyReference, reference};
pub use robhaz_sim::EngineKind;
pub use robhaz_sim::sensors::{Grade, SensorSpec};
pub use robot::RobotChoice;
pub use scene::{EngineChoice, RecordChoice, Scene, SensorChoice};
pub use terrain::{TerrainChoice, Track};

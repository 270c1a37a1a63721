//! Scene files, study files and descriptions of recorded logs: read, checked, written, and turned into plant, sensors and
//! estimators.
//!
//! [`Scene::load`] reads a file and the overrides of the command line; [`Scene::to_toml`] writes the resolved scene. Each
//! key is declared once, with its unit, range, meaning and the field that it sets. Reading, writing, defaults and
//! [`reference()`] use that declaration.
//!
//! | modules | job |
//! |---|---|
//! | `source` | a text as a tree of values with their places |
//! | `key`, `range`, `units` | declarations of keys |
//! | `reader`, `fields` | problems; values of a table by its declarations |
//! | `terrain`, `robot`, `contact`, `drive`, `control`, `estimators`, `sensors`, `sections` | the sections of a scene and their keys |
//! | `overrides`, `load`, `checks`, `explicit_step` | from a file and overrides to a checked [`Scene`] |
//! | `log` | descriptions of recorded logs |
//! | `study` | study files: what is varied in which scene |
//! | `write`, `reference` | the resolved scene; all keys |
//! | `json`, `schema` | JSON Schema for editors |
//! | `error`, `excerpt`, `suggest` | messages |

mod checks;
mod conflict;
mod contact;
mod control;
mod drive;
mod error;
mod estimators;
mod excerpt;
mod explicit_step;
mod fields;
mod file;
mod json;
mod key;
mod load;
mod log;
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
mod schema;
mod sections;
mod seed;
mod sensors;
mod source;
mod study;
mod suggest;
mod terrain;
mod units;
mod wheels;
mod write;

pub use error::{Problem, SceneError};
pub use estimators::EstimatorChoice;
pub use excerpt::harmless;
pub use log::{
    ChannelChoice, ImuChoice, InclinationSource, LogChoice, LogEstimator, Mapping,
    NeedsContactAngles, READINGS, ReadingChoice, UnknownEstimator, log_reference,
};
pub use model_error::{ModelError, ModelErrorTooLarge, NominalRobot, simulated_weighing};
pub use name::from_stem;
pub use plant_failure::PlantFailure;
pub use reference::{KeyReference, reference};
pub use robhaz_control::ControlKind;
pub use robhaz_sim::EngineKind;
pub use robhaz_sim::sensors::{Grade, SensorSpec};
pub use robot::RobotChoice;
pub use scene::{ControlChoice, EngineChoice, RecordChoice, Scene, SensorChoice};
pub use schema::{SchemaKind, schema};
pub use study::{
    Axis, AxisItem, AxisValue, AxisValues, BaseScene, Distribution, DrawMethod, Draws, Setting,
    StudyChoice, StudyTables,
};
pub use terrain::{TerrainChoice, Track};

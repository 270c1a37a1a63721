//! Scene files, study files and descriptions of recorded logs: read, checked, written, and turned
//! into plant, sensors and estimators.
//!
//! [`Scene::load`] reads a file and the overrides of the command line; [`Scene::to_toml`] writes
//! the resolved scene. Each key is declared once, with its unit, range, meaning and the field that
//! it sets. Reading, writing, defaults and [`reference()`] use that declaration.
//!
//! | modules | job |
//! |---|---|
//! | `source` | a file or an override as a tree of values with their places |
//! | `key` | keys: name, meaning, form, field; each declared once; tables of keys |
//! | `form`, `values`, `quantity` | what a value may be: read, written into files, described; single values; numbers with unit and range |
//! | `load` | all keys of a scene; from a file to a [`Scene`] and back |
//! | `robot`, `terrain`, `contact`, `drive`, `estimators` | its sections |
//! | `overrides`, `checks`, `conflict` | overrides of the command line; rules over several keys |
//! | `log` | descriptions of recorded logs |
//! | `study` | study files: what is varied in which scene |
//! | `schema` | JSON Schema from the declarations |
//! | `reader`, `error` | problems and their messages |

mod checks;
mod conflict;
mod contact;
mod drive;
mod error;
mod estimators;
mod form;
mod key;
mod load;
mod log;
mod overrides;
mod plant_failure;
mod quantity;
mod reader;
mod robot;
mod scene;
mod schema;
mod source;
mod study;
mod terrain;
mod values;

pub use error::{Problem, SceneError, harmless};
pub use estimators::EstimatorChoice;
pub use form::KeyReference;
pub use load::reference;
pub use log::{
    ChannelChoice, EstimatorError, ImuChoice, InclinationSource, LogChoice, Mapping, READINGS,
    ReadingChoice, is_of_body, log_reference,
};
pub use plant_failure::PlantFailure;
pub use robhaz_control::ControlKind;
pub use robhaz_masses::{ModelError, ModelErrorTooLarge, NominalRobot};
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
pub use values::from_stem;

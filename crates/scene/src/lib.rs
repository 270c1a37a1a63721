//! Scene files, study files and descriptions of recorded logs: read, checked, written, and turned
//! into plant, sensors and estimators.
//!
//! [`Scene::load`] reads a file and the overrides of the command line; [`Scene::to_toml`] writes
//! the resolved scene. Each key is declared once, with its unit, range, meaning and the field that
//! it sets, by the means of [`robhaz_keys`]. Reading, writing, defaults and [`reference()`] use that
//! declaration.
//!
//! | modules | job |
//! |---|---|
//! | `scene` | a [`Scene`], and the parts of a run that it gives |
//! | `load` | all keys of a scene; from a file and overrides to a [`Scene`] and back |
//! | `robot`, `terrain`, `contact`, `drive`, `estimators` | its sections |
//! | `model_error` | the nominal robot: drawn, and weighed if it is |
//! | `values` | forms of single values of robots |
//! | `checks` | rules over several keys |
//! | `log` | descriptions of recorded logs |
//! | `study` | study files: what is varied in which scene |
//! | `schema` | JSON Schema of the files |
//! | `plant_failure` | errors of the plant with the keys that can help |

mod checks;
mod contact;
mod drive;
mod estimators;
mod load;
mod log;
mod model_error;
mod plant_failure;
mod robot;
mod scene;
mod schema;
mod study;
mod terrain;
mod values;

pub use estimators::EstimatorChoice;
pub use load::reference;
pub use log::{
    ChannelChoice, EstimatorError, ImuChoice, InclinationSource, Kind, LogChoice, LogSides,
    Mapping, Reading, ReadingChoice, StatedAt, Unit, Values, World, coupling_angle, frame,
    log_reference, whole_frame,
};
pub use model_error::{ModelError, ModelErrorTooLarge, errors_of_scales};
pub use plant_failure::PlantFailure;
pub use robhaz_control::ControlKind;
pub use robhaz_keys::error::{FileError, Problem, harmless};
pub use robhaz_keys::form::KeyReference;
pub use robhaz_keys::reader::nearest;
pub use robhaz_keys::values::from_stem;
pub use robhaz_sim::sensors::{Grade, SensorSpec};
pub use robhaz_sim::{EngineChoice, EngineKind};
pub use robot::RobotChoice;
pub use scene::{ControlChoice, RecordChoice, Scene, SensorChoice};
pub use schema::{SchemaKind, schema};
pub use study::{
    Axis, AxisItem, AxisValue, AxisValues, BaseScene, Distribution, DrawMethod, Draws, Setting,
    StudyChoice, StudyTables,
};
pub use terrain::{TerrainChoice, Track};

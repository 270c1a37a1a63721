//! Scene files: what a user writes, read, checked and turned into the parts of a run.

mod scene;

pub use scene::{
    EngineChoice, EngineKind, EstimatorChoice, Grade, RecordChoice, RobotChoice, Scene,
    SensorChoice, TerrainChoice,
};

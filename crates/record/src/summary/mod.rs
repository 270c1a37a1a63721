//! `summary.json`: how a run went, and the errors of each estimator.

mod clearance;
mod file;
mod log;
mod parts;
mod sink;

pub use clearance::ClearanceSummary;
pub use file::Summary;
pub use log::MeanForces;
pub use parts::{
    BrokenOff, EstimatorSummary, Faulty, FrictionSummary, FrictionTestSummary, NominalRobot,
    SensorErrors,
};
pub use sink::SummarySink;

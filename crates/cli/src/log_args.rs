//! A recorded log on the command line.

use miette::{Report, Result};
use robhaz_log::{LogPlace, PlaceError};
use std::path::PathBuf;

/// A log and its descriptions, as `robhaz estimate` and `robhaz check` take them.
#[derive(clap::Args)]
pub struct LogArgs {
    /// The log: a table of readings (.parquet, .csv), an MCAP file, or the folder of a run or of an
    /// estimate.
    log: PathBuf,
    /// The robot: a file with the section robot of a scene, or a weighed robot; by default that of
    /// the log's folder, else robot A.
    #[arg(long, value_name = "ROBOT.toml")]
    robot: Option<PathBuf>,
    /// Description of the log: columns and units of the readings, clocks, noise budget, nominal
    /// damping, estimators. See docs/logs.md.
    #[arg(long, value_name = "SENSORS.toml")]
    pub sensors: Option<PathBuf>,
}

impl LogArgs {
    /// The log with its descriptions. Warns where the robot, or how exact it is, is not stated.
    pub fn place(&self) -> Result<LogPlace> {
        let mut place = LogPlace::find(&self.log).map_err(shown)?;
        let (sensors, robot) = (self.sensors.as_deref(), self.robot.as_deref());
        let (choice, notice) = place.choice.clone().described(sensors, robot)?;
        if !choice.states("robot") && !place.is_described {
            let warning = "no robot is stated, so it is robot A: --robot ROBOT.toml states yours";
            place.warnings.push(warning.to_owned());
        }
        place.warnings.extend(notice);
        place.choice = choice;
        Ok(place)
    }
}

/// The error with the excerpt of the scene that it is about.
pub fn shown(error: PlaceError) -> Report {
    match error {
        PlaceError::Scene(error) => error.into(),
        other => Report::from_err(other),
    }
}

//! `robhaz estimate`: the estimators on a recorded log.

use crate::choice::{Choice, choice, choices};
use crate::results::{self, Job};
use crate::terminal::{tell_json, warn_of};
use miette::{IntoDiagnostic, Report, Result, WrapErr, bail};
use robhaz_estimator::Sides;
use robhaz_log::{Log, LogOptions, LogPlace, PlaceError};
use robhaz_model::Suspension;
use robhaz_scene::LogSides;
use serde_json::Value;
use std::path::PathBuf;
use std::time::Instant;

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
    sensors: Option<PathBuf>,
}

/// Arguments of `robhaz estimate`.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// An estimator of the description, or a preset; can be repeated. By default all of the
    /// description.
    #[arg(long, value_name = "NAME")]
    estimator: Vec<String>,
    /// Whether contact angles of the log are used; by default where the log has them.
    #[arg(long, value_parser = choice(CONTACT_ANGLES))]
    contact_angles: Option<bool>,
    /// A table of true forces to compare with, such as the table `truth` of a run.
    #[arg(long, value_name = "TABLE")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    results: results::Args,
}

/// Whether contact angles are used.
const CONTACT_ANGLES: &[Choice<bool>] = choices! {
    "given", "Those of the log" => true;
    "none", "None: only estimators that need none run" => false;
};

/// Runs the estimators on the log, writes the results, prints the table.
pub fn run(args: &Args) -> Result<()> {
    let start = Instant::now();
    let mut place = args.log.place()?;
    if !args.estimator.is_empty() {
        place.choice.select(&args.estimator).into_diagnostic()?;
    }
    if let Some(name) = &place.choice.name {
        place.name.clone_from(name);
    }
    let folder = format!("{}-estimate", place.file_name);
    let options = LogOptions {
        truth: args.truth.clone(),
        contact_angles: args.contact_angles,
        named_estimators: !args.estimator.is_empty(),
        allows_empty: false,
    };
    let known = place.warnings.len();
    let mut log = Log::open(place, &options).into_diagnostic()?;
    if log.choice.sides == LogSides::OneOfTwo {
        let slope = log.choice.budget.cross_slope.to_degrees();
        let uneven = match log.choice.robot.robot.geometry.suspension {
            Suspension::FourBar => {
                ", and so does uneven ground, which lifts wheels of a body that is fixed to two four-bars by what no reading shows (budget.cross_slope = 0: a floor)"
            }
            Suspension::Bogie { .. } => "",
        };
        let warning = format!(
            "one side of a robot with two: pushes of the other side and a cross slope of {slope:.1} deg (budget.cross_slope) widen what is stated{uneven}; {}",
            Sides::REMEDY
        );
        log.warnings.insert(known, warning);
    }
    log.warnings.iter().for_each(|w| warn_of(&log.name, w));
    let version = format!("robhaz {}", env!("CARGO_PKG_VERSION"));
    let resolved = log.choice.to_toml(&version);
    let mut files = vec![(LogPlace::DESCRIPTION.to_owned(), resolved.into())];
    if let Some(path) = &args.log.sensors {
        // The user's description as it is.
        let content = std::fs::read(path).into_diagnostic();
        let content = content.wrap_err_with(|| format!("cannot read {}", path.display()))?;
        files.push((LogPlace::SENSORS.to_owned(), content));
    }
    let name = log.name.clone();
    let job = Job {
        start,
        name: &name,
        folder,
        work: "reading and estimation",
        files,
    };
    let document = results::write(log.into_run().into_diagnostic()?, &job, &args.results)?;
    let has_forces = |estimator: &Value| !estimator["means"].is_null();
    let estimators = document["summary"]["estimators"].as_object();
    let is_empty = estimators.is_some_and(|all| !all.values().any(has_forces));
    tell_json(|| Ok(document))?;
    if is_empty {
        bail!("{name}: no estimator found a force in the whole log; `robhaz check` says why");
    }
    Ok(())
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

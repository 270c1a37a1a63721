//! `robhaz estimate`: the estimators on a recorded log.

use crate::check::Checked;
use crate::choice::{Choice, choice, choices};
use crate::log_args::LogArgs;
use crate::output_file::io_error;
use crate::results::{self, Job};
use crate::terminal::{tell_json, warn_of};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_estimator::Sides;
use robhaz_log::check::{Consistency, Finding};
use robhaz_log::{Log, LogOptions, LogPlace};
use robhaz_model::Suspension;
use robhaz_scene::LogSides;
use serde_json::Value;
use std::path::PathBuf;
use std::time::Instant;

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
    let consistency = log.consistency().into_diagnostic()?;
    let faults = faults(&args.log, &log, consistency.as_ref());
    let of_faults = of_faults(faults.as_deref());
    of_faults.iter().for_each(|w| warn_of(&log.name, w));
    let version = format!("robhaz {}", env!("CARGO_PKG_VERSION"));
    let resolved = log.counted().to_toml(&version);
    let mut files = vec![(LogPlace::DESCRIPTION.to_owned(), resolved.into())];
    if let Some(path) = &args.log.sensors {
        // The user's description as it is.
        let content = io_error("cannot read", path, std::fs::read(path))?;
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
    let run = log.into_run(consistency).into_diagnostic()?;
    let mut document = results::write(run, &job, &args.results)?;
    let has_forces = |estimator: &Value| !estimator["means"].is_null();
    let estimators = document["summary"]["estimators"].as_object();
    let is_empty = estimators.is_some_and(|all| !all.values().any(has_forces));
    document["faults"] = serde_json::to_value(&faults).into_diagnostic()?;
    tell_json(|| Ok(document))?;
    if is_empty {
        bail!("{name}: no estimator found a force in the whole log; `robhaz check` says why");
    }
    Ok(())
}

/// The faults that the tests of `robhaz check` find; `None` of a log that they are not run on.
fn faults(args: &LogArgs, log: &Log, consistency: Option<&Consistency>) -> Option<Vec<Finding>> {
    /// Frames up to which they are looked for, 20 min at 50 Hz: the tests take as long as the estimate.
    const LONGEST: f64 = 60_000.0;
    if log.record.duration * log.record.rate > LONGEST {
        return None;
    }
    // What keeps it from being checked keeps it from being estimated.
    let checked = Checked::of(args, consistency).ok()?;
    Some(checked.report.faults().cloned().collect())
}

/// What an estimate says of them, a line each.
fn of_faults(faults: Option<&[Finding]>) -> Vec<String> {
    /// Faults that are shown.
    const SHOWN: usize = 5;
    let Some(faults) = faults else {
        return vec!["`robhaz check` has not been run on it".to_owned()];
    };
    let shown = faults.iter().take(SHOWN).map(|fault| {
        let remedy = fault.remedy.iter().flat_map(|remedy| remedy.lines());
        let remedy: String = remedy.take(1).map(|line| format!(" -> {line}")).collect();
        let (test, channel, figure) = (fault.test, &fault.channel, &fault.figure);
        format!("FAULT: {test}, {channel}: {figure}{remedy}")
    });
    let more = faults.len().saturating_sub(SHOWN);
    let more = (more > 0).then(|| format!("and {more} faults more: `robhaz check`"));
    shown.chain(more).collect()
}

//! `robhaz check`: is a recorded log what the estimators take it for?

use crate::estimate::{describe, shown};
use crate::terminal::{tell, warn_of};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_log::check::{Finding, Report, Stated, Verdict, check};
use robhaz_log::{Log, LogOptions, LogPlace};
use robhaz_record::time_lines;
use robhaz_run::{ChannelReport, LogReport};
use std::path::PathBuf;

/// Arguments of `robhaz check`.
#[derive(clap::Args)]
pub struct Args {
    /// The log: a table of readings (.parquet, .csv), an MCAP file, or the folder of a run or of an
    /// estimate.
    log: PathBuf,
    /// The robot: a file with the section robot of a scene; by default that of the log's folder,
    /// else robot A.
    #[arg(long, value_name = "ROBOT.toml")]
    robot: Option<PathBuf>,
    /// Description of the log, as for `robhaz estimate`.
    #[arg(long, value_name = "SENSORS.toml")]
    sensors: Option<PathBuf>,
}

/// The estimator that runs on the log.
const BEST: &str = "best";

/// Checks the log and prints the findings. An error if one is a fault.
pub fn run(args: &Args) -> Result<()> {
    let mut place = LogPlace::find(&args.log).map_err(shown)?;
    describe(&mut place, args.sensors.as_deref(), args.robot.as_deref())?;
    let is_of_unknown = !place.choice.states_robot && !place.is_described;
    // Others may need contact angles.
    place.choice.select(&[BEST.to_owned()]).into_diagnostic()?;
    let options = LogOptions {
        named_estimators: true,
        ..LogOptions::default()
    };
    let log = Log::open(place, &options).into_diagnostic()?;
    log.warnings.iter().for_each(|w| warn_of(&log.name, w));
    let choice = log.choice.clone();
    let stated = Stated {
        robot: &choice.robot.robot,
        budget: choice.budget,
        viscous_damping: choice.viscous_damping,
        compression: choice.compression,
        of_body: log.is_of_body() || choice.of_body,
    };
    let name = log.name.clone();
    let mut source = log.into_source();
    let mut frames = Vec::new();
    while let Some(sample) = source.next_sample().into_diagnostic()? {
        frames.push(sample.sensors);
    }
    // The time stamps first: all else depends on them.
    let mut findings: Vec<Finding> = source.log_report().iter().flat_map(of_time).collect();
    if is_of_unknown {
        let finding = Finding::ok("robot", "all", "none is stated: robot A counts");
        findings.push(finding.cannot_tell("state yours: --robot ROBOT.toml"));
    }
    findings.extend(check(&frames, &stated).findings);
    let report = Report::new(findings);
    tell(
        &report.text(),
        &serde_json::to_value(&report).into_diagnostic()?,
    )?;
    match report.verdict {
        Verdict::Fault => match report.faults().count() {
            1 => bail!("{name}: 1 test found a fault"),
            count => bail!("{name}: {count} tests found faults"),
        },
        Verdict::Ok | Verdict::CannotTell => Ok(()),
    }
}

/// The findings of the time stamps, as `robhaz estimate` prints them.
fn of_time(log: &LogReport) -> impl Iterator<Item = Finding> {
    log.channels.iter().flat_map(of_channel)
}

fn of_channel(channel: &ChannelReport) -> impl Iterator<Item = Finding> {
    let name = channel.name.clone();
    let lines = time_lines(channel);
    lines.into_iter().map(move |line| {
        let finding = match line.remedy {
            Some(remedy) => Finding::ok(line.what, &name, line.text).fault(remedy),
            None => Finding::ok(line.what, &name, line.text),
        };
        let numbers = line.numbers.into_iter();
        numbers.fold(finding, |f, (name, value, unit)| f.with(name, value, unit))
    })
}

//! `robhaz check`: is a recorded log what the estimators take it for?

use crate::log_args::LogArgs;
use crate::terminal::{Output, tell, warn_of};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_estimator::EstimatorSettings;
use robhaz_log::check::{
    BodyNoise, Consistency, Finding, Report, Stated, StatedBoth, check, check_both,
};
use robhaz_log::{Log, LogOptions};
use robhaz_record::time_lines;
use robhaz_run::ChannelReport;

/// Arguments of `robhaz check`.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
}

/// The estimator that runs on the log.
const KALMAN: &str = "kalman";

/// Checks the log and prints the findings. An error if one is a fault.
pub fn run(args: &Args) -> Result<()> {
    let Checked {
        name,
        warnings,
        report,
    } = Checked::of(&args.log, None)?;
    warnings.iter().for_each(|w| warn_of(&name, w));
    let document = serde_json::to_value(&report).into_diagnostic()?;
    tell(&report.text(Output::get().verbose > 0), &document)?;
    match report.faults().count() {
        0 => Ok(()),
        1 => bail!("{name}: 1 test found a fault"),
        count => bail!("{name}: {count} tests found faults"),
    }
}

/// What the tests find of a log.
pub struct Checked {
    name: String,
    warnings: Vec<String>,
    /// The findings.
    pub report: Report,
}

impl Checked {
    /// Reads the log and checks it. `known`: see [`check_both`].
    pub fn of(log: &LogArgs, known: Option<&Consistency>) -> Result<Self> {
        let mut place = log.place()?;
        let is_of_unknown = !place.choice.states("robot") && !place.is_described;
        // Others may need contact angles.
        place
            .choice
            .select(&[KALMAN.to_owned()])
            .into_diagnostic()?;
        let options = LogOptions {
            named_estimators: true,
            allows_empty: true,
            ..LogOptions::default()
        };
        let log = Log::open(place, &options).into_diagnostic()?;
        let choice = log.choice.clone();
        let (name, compare_from) = (log.name.clone(), log.record.compare_from);
        let warnings = log.warnings.clone();
        let stated = Stated {
            robot: &choice.robot.robot,
            settings: choice.stated(EstimatorSettings::kalman()),
            compare_from,
            body: choice.body.map(|[inclination, rate]| BodyNoise {
                inclination,
                rate,
                pin: choice.pin[0],
            }),
        };
        let mut source = log.into_source();
        let (mut frames, mut of_both) = (Vec::new(), Vec::new());
        while let Some(sample) = source.next_sample().into_diagnostic()? {
            frames.push(sample.sensors);
            of_both.extend(sample.both.map(|both| both.readings));
        }
        // The time stamps first: all else depends on them.
        let log = source.log_report();
        let channels = || log.iter().flat_map(|log| &log.channels);
        let mut findings: Vec<Finding> = channels().flat_map(of_channel).collect();
        let is_other = channels().any(ChannelReport::is_of_other_unit);
        if is_of_unknown {
            let finding = Finding::ok("robot", "all", "none is stated: robot A counts");
            findings.push(finding.cannot_tell("state yours: --robot ROBOT.toml"));
        }
        let rover = choice.robot.whole_rover().filter(|_| !of_both.is_empty());
        findings.extend(match (rover, choice.estimators.first()) {
            _ if is_other => {
                let others = Finding::ok("other tests", "all", "left out");
                vec![others.cannot_tell("correct the unit of the times first")]
            }
            (Some(rover), Some(listed)) => check_both(
                &of_both,
                &StatedBoth {
                    rover: &rover,
                    settings: choice.settings(listed),
                    joint: choice.pin,
                    compare_from,
                },
                known,
            ),
            _ => check(&frames, &stated).findings,
        });
        Ok(Self {
            name,
            warnings,
            report: Report::new(findings),
        })
    }
}

/// The findings of the time stamps, as `robhaz estimate` prints them.
fn of_channel(channel: &ChannelReport) -> Vec<Finding> {
    let mut findings = Vec::new();
    for line in time_lines(channel) {
        let mut finding = Finding::ok(line.what, &channel.name, line.text);
        if let Some(remedy) = line.remedy {
            finding = finding.fault(remedy);
        }
        let numbers = line.numbers.into_iter();
        findings.push(numbers.fold(finding, |f, (name, value, unit)| f.with(name, value, unit)));
    }
    findings
}

//! The `robhaz` command.

mod check;
mod choice;
mod compare;
mod errors;
mod estimate;
mod export;
mod interrupt;
mod keys;
mod live;
mod log_args;
mod new;
mod output;
mod output_file;
mod path;
mod progress;
mod report;
mod results;
mod run;
mod schema;
mod shell;
mod study;
mod terminal;
mod verify;
#[cfg(feature = "viewer")]
mod view;
mod weigh;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;
use terminal::Output;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::time::uptime;
use tracing_subscriber::prelude::*;

/// Wheel forces of ROBHAZ-6WHEEL on rough ground: simulation, estimation after Choi et al.,
/// comparison.
#[derive(Parser)]
#[command(version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    output: Output,
}

/// The end of `--help`.
const EXIT_CODES: &str = "\
Exit codes:
  0    done; of check, path and verify: the verdict is good
  1    an error, or a bad verdict: check found a fault, path is no-go, a check of verify failed
  2    the command line is wrong
  130  stopped by Ctrl-C
  143  stopped by SIGTERM";

#[derive(Subcommand)]
enum Command {
    /// Write a scene to edit.
    New(new::Args),
    /// Explain the keys of scene files: unit, default, allowed values, meaning.
    Keys(keys::Args),
    /// Print the JSON Schema of scene files, studies and others, by which an editor completes and
    /// checks them.
    Schema(schema::Args),
    /// Run a scene: simulate, estimate, write tables, figures and a recording, print the errors of
    /// the estimates.
    Run(run::Args),
    /// Run the estimators on a recorded log: a table of readings, or the folder of a run.
    Estimate(estimate::Args),
    /// Check whether a recorded log is what the estimators take it for: signs, units, wiring,
    /// delays, zeros, noise. Exit code 0 without a fault, 1 with faults and for errors.
    Check(check::Args),
    /// Write a run or an estimate as a log that other tools open: MCAP or CSV.
    Export(export::Args),
    /// Print the table of errors of one or several finished runs.
    Compare(compare::Args),
    /// Write a run, an estimate or a study as one page of HTML that needs no other file: errors,
    /// figures, how it was made.
    Report(report::Args),
    /// Check the simulated truth of a scene: both engines, conservation, half the step; one verdict
    /// a line.
    Verify(verify::Args),
    /// Show runs in the Rerun viewer.
    #[cfg(feature = "viewer")]
    View(view::Args),
    /// Judge the path of a scene from its geometry before it is driven: needed friction, go or
    /// no-go. Exit code 0 for go, 1 for no-go and for errors.
    Path(path::Args),
    /// Run a scene with many seeds of its sensors, or a study file, which varies anything: errors
    /// of the estimators, consistency of their covariance, one table of scores. On all cores or
    /// many machines; stopped at any instant, the same command goes on.
    Study(study::Args),
    /// Masses and centres of mass of a robot from its wheels on scales, with the budget for the
    /// estimators; the postures that tell most.
    Weigh(weigh::Args),
    /// Print the completions of a shell.
    Completions(shell::Args),
}

/// Commands whose result has no form in JSON.
const WITHOUT_JSON: [&str; 3] = ["weigh", "view", "completions"];

/// The command line: no command shows a flag that it refuses.
fn command_line() -> clap::Command {
    let all = Cli::command();
    let json = all.get_arguments().find(|a| a.get_id() == "json").cloned();
    let hidden = json.map(|json| json.hide(true));
    all.mut_subcommands(|command| match &hidden {
        Some(json) if WITHOUT_JSON.contains(&command.get_name()) => command.arg(json),
        _ => command,
    })
}

/// Sets what the process prints. Ends it where the command, `name`, has no form in JSON.
fn apply(output: Output, name: Option<&str>) {
    if output.json && name.is_some_and(|name| WITHOUT_JSON.contains(&name)) {
        let text = "this command has no result in JSON";
        command_line()
            .error(ErrorKind::ArgumentConflict, text)
            .exit();
    }
    output.set();
    let level = match output.verbose {
        0 => return,
        1 => LevelFilter::INFO,
        _ => LevelFilter::DEBUG,
    };
    // Lines for files as much as for terminals: no colours.
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .with_timer(uptime());
    let ours = Targets::new().with_target("robhaz", level);
    tracing_subscriber::registry()
        .with(lines.with_filter(ours))
        .init();
}

/// Adds to the error of the command `view`, which a build without the viewer does not know, how to
/// have it.
fn absent(mut error: clap::Error) -> clap::Error {
    use clap::error::{ContextKind, ContextValue};
    let is_view =
        |value: &ContextValue| matches!(value, ContextValue::String(name) if name == "view");
    if error
        .get(ContextKind::InvalidSubcommand)
        .is_some_and(is_view)
    {
        let text = format!("this robhaz has no command view: {}", live::WITHOUT_VIEWER).into();
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![text]));
        error.remove(ContextKind::SuggestedSubcommand);
    }
    error
}

fn main() -> ExitCode {
    let given = command_line().try_get_matches();
    let given = given.unwrap_or_else(|error| absent(error).exit());
    let cli = Cli::from_arg_matches(&given).unwrap_or_else(|error| error.exit());
    errors::install();
    apply(cli.output, given.subcommand_name());
    let done = match cli.command {
        Command::New(args) => new::run(&args),
        Command::Keys(args) => keys::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Estimate(args) => estimate::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Report(args) => report::run(&args),
        Command::Verify(args) => verify::run(&args),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(&args),
        Command::Path(args) => path::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Weigh(args) => weigh::run(&args),
        Command::Completions(args) => shell::completions(&args, command_line()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            // A closed or full standard error is no reason to panic.
            let _ = writeln!(std::io::stderr().lock(), "{report:?}");
            interrupt::exit_code().unwrap_or(ExitCode::FAILURE)
        }
    }
}

//! The `robhaz` command.

mod compare;
mod interrupt;
mod live;
mod output;
#[cfg(feature = "viewer")]
mod output_file;
mod pace;
mod progress;
mod recover;
mod run;
mod study;
mod terminal;
mod verify;
#[cfg(feature = "viewer")]
mod view;

use clap::{Parser, Subcommand};
use interrupt::Interrupt;
use std::process::ExitCode;

/// Wheel forces of ROBHAZ-6WHEEL on rough ground: simulated, estimated as Choi et al. do, compared.
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene: simulate, estimate, write tables, figures and a recording, print how far off the estimates are.
    Run(run::Args),
    /// Print the same table for finished runs, several at once.
    Compare(compare::Args),
    /// Make tables of what a run had recorded when it was killed or its disk was full.
    Recover(recover::Args),
    /// Check that the simulated truth of a scene can be trusted: both engines, conservation, half the step; a verdict a line.
    Verify(verify::Args),
    /// Look at runs in the Rerun viewer, at one or several side by side, or at a scene while it is simulated.
    #[cfg(feature = "viewer")]
    View(view::Args),
    /// Observe a scene with many seeds: how exact its estimators are, and whether they know it; with --ladder, what each step brings.
    Study(study::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let interrupt = Interrupt::default();
    let done = match cli.command {
        Command::Run(args) => run::run(&args, &interrupt),
        Command::Compare(args) => compare::compare(&args),
        Command::Recover(args) => recover::recover(&args),
        Command::Verify(args) => verify::run(&args, &interrupt),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(&args, &interrupt),
        Command::Study(args) => study::run(&args, &interrupt),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("{report:?}");
            interrupt.exit_code().unwrap_or(ExitCode::FAILURE)
        }
    }
}

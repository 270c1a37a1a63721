//! `robhaz completions`: what a shell reads.

use clap::Command;
use clap_complete::Shell;
use miette::{IntoDiagnostic, Result};
use std::io::{self, Write};

/// Arguments of `robhaz completions`.
#[derive(clap::Args)]
pub struct Args {
    /// The shell.
    shell: Shell,
}

/// Prints the completions of a shell. A closed pipe is no error: its reader needs no more.
pub fn completions(args: &Args, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "robhaz", &mut text);
    match io::stdout().lock().write_all(&text) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).into_diagnostic(),
        _ => Ok(()),
    }
}

//! `robhaz completions`: what a shell reads.

use crate::terminal::print;
use clap::Command;
use clap_complete::Shell;
use miette::Result;

/// Arguments of `robhaz completions`.
#[derive(clap::Args)]
pub struct Args {
    /// The shell.
    shell: Shell,
}

/// Prints the completions of a shell.
pub fn completions(args: &Args, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "robhaz", &mut text);
    print(String::from_utf8_lossy(&text).trim_end_matches('\n'))
}

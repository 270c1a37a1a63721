//! `robhaz completions` and `robhaz man`: what a shell and `man` read.

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

/// Prints the completions of a shell.
pub fn completions(args: &Args, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "robhaz", &mut text);
    print(&text)
}

/// Prints the manual page, with a section for each command.
pub fn man(mut command: Command) -> Result<()> {
    // Names the subcommands in full.
    command.build();
    let mut text = Vec::new();
    let commands: Vec<Command> = command.get_subcommands().cloned().collect();
    clap_mangen::Man::new(command)
        .render(&mut text)
        .into_diagnostic()?;
    for command in commands.into_iter().filter(|c| c.get_name() != "help") {
        let title = format!("robhaz {}", command.get_name());
        let page = clap_mangen::Man::new(command);
        writeln!(text, ".SH \"{}\"", title.to_uppercase()).into_diagnostic()?;
        page.render_synopsis_section(&mut text).into_diagnostic()?;
        page.render_description_section(&mut text)
            .into_diagnostic()?;
        page.render_options_section(&mut text).into_diagnostic()?;
    }
    print(&text)
}

/// A closed pipe is no error: its reader needs no more.
fn print(text: &[u8]) -> Result<()> {
    match io::stdout().lock().write_all(text) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).into_diagnostic(),
        _ => Ok(()),
    }
}

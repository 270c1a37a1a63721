//! `robhaz compare`: the table of finished runs.

use crate::terminal::say;
use miette::{IntoDiagnostic, Result};
use robhaz_record::{Summary, comparison_table};
use std::path::PathBuf;

/// Arguments of `robhaz compare`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of finished runs, as `robhaz run` leaves them.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
}

/// Reads the summaries and prints one table over all of them.
pub fn compare(args: &Args) -> Result<()> {
    let mut summaries = Vec::new();
    for run in &args.runs {
        summaries.push((
            run.display().to_string(),
            Summary::read(run).into_diagnostic()?,
        ));
    }
    let rows: Vec<(&str, &Summary)> = summaries
        .iter()
        .map(|(label, summary)| (label.as_str(), summary))
        .collect();
    say(&comparison_table(&rows))
}

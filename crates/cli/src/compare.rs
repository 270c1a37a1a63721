//! `robhaz compare`: finished runs side by side.

use crate::terminal::{Output, print, shown};
use miette::{IntoDiagnostic, Result};
use robhaz_record::{Summary, comparison_json, comparison_table};
use std::path::PathBuf;

/// Arguments of `robhaz compare`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of finished runs, as `robhaz run` leaves them. With `--json` all scores, among them
    /// bias, time of the largest error, lag, coverage and NEES.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
}

/// Reads the summaries and prints one comparison of all of them.
pub fn compare(args: &Args) -> Result<()> {
    let mut summaries = Vec::new();
    for run in &args.runs {
        summaries.push((shown(run), Summary::read(run).into_diagnostic()?));
    }
    let rows = summaries.iter().map(|(label, run)| (label.as_str(), run));
    let rows: Vec<(&str, &Summary)> = rows.collect();
    print(&match Output::get().json {
        true => comparison_json(&rows).into_diagnostic()?,
        false => comparison_table(&rows),
    })
}

//! `robhaz compare`: finished runs side by side.

use crate::terminal::{Output, print};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_record::{
    Summary, comparison_csv, comparison_json, comparison_markdown, comparison_table,
};
use std::path::PathBuf;

/// Arguments of `robhaz compare`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of finished runs, as `robhaz run` leaves them.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// What to print. All but `table` also have bias, time of the largest error, lag, coverage and
    /// NEES.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

/// Form of the comparison.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// The table of a run, to read on the terminal, with what happened in each run.
    Table,
    /// An array with an object for each run and estimator.
    Json,
    /// A line for each run and estimator.
    Csv,
    /// A table for documents.
    Markdown,
}

/// Reads the summaries and prints one comparison of all of them.
pub fn compare(args: &Args) -> Result<()> {
    if Output::get().json && matches!(args.format, Format::Csv | Format::Markdown) {
        bail!("--json prints one JSON document: leave it out, or leave out --format");
    }
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
    let json = || comparison_json(&rows).into_diagnostic();
    print(&match args.format {
        Format::Table if Output::get().json => json()?,
        Format::Table => comparison_table(&rows),
        Format::Json => json()?,
        Format::Csv => comparison_csv(&rows).into_diagnostic()?,
        Format::Markdown => comparison_markdown(&rows),
    })
}

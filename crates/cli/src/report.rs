//! `robhaz report`: a run or a study on one page.

use crate::output_file::{Format, OutputFile};
use crate::terminal::{shown, tell};
use miette::{IntoDiagnostic, Result};
use robhaz_record::{Dataset, page, study_page};
use robhaz_study::DATASET;
use serde_json::json;
use std::path::PathBuf;

const PAGE: Format = ("pages", "html");

/// Arguments of `robhaz report`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a finished run, estimate or study.
    run: PathBuf,
    /// The file; by default `report.html` in that folder.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
}

/// Writes the page.
pub fn run(args: &Args) -> Result<()> {
    let dataset = args.run.join(DATASET);
    let text = match dataset.is_file() {
        true => study_page(&Dataset::read(&dataset).into_diagnostic()?),
        false => page(&args.run).into_diagnostic()?,
    };
    let default = || args.run.join("report.html");
    let target = args.out.clone().unwrap_or_else(default);
    let file = OutputFile::create(&target, PAGE, &[], args.force)?;
    file.write(&text)?;
    let page = shown(&file.finish()?);
    tell(&format!("Page: {page}"), &json!({"page": page}))
}

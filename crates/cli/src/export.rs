//! `robhaz export`: a run or an estimate as a log that other tools open.

use crate::choice::{Choice, choice, choices};
use crate::interrupt;
use crate::log_args::shown as shown_place;
use crate::output_file::OutputFile;
use crate::terminal::{shown, tell, warn_of};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_log::{ExportFormat, LogError, LogPlace, export};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `robhaz export`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run or of an estimate.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Format of the log.
    #[arg(long, value_parser = choice(FORMATS), value_name = "FORMAT")]
    to: To,
    /// The file; by default the folder's name with the extension of the format, beside the folder.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
}

/// Format of the log, and extension of its file.
type To = (ExportFormat, &'static str);

const FORMATS: &[Choice<To>] = choices! {
    "mcap", "MCAP with messages of ROS 2: joint states, IMUs, readings, forces, wrenches, odometry" => (ExportFormat::Mcap, "mcap");
    "csv", "One table of readings and forces" => (ExportFormat::Csv, "csv");
};

/// Writes the log and prints what is in it.
pub fn run(args: &Args) -> Result<()> {
    let (format, extension) = args.to;
    if !args.run.is_dir() {
        bail!(
            "there is no folder {}: export takes the folder of a run or of an estimate",
            args.run.display()
        );
    }
    let name = || {
        // Without a slash at the end.
        let folder: PathBuf = args.run.components().collect();
        folder.with_added_extension(extension)
    };
    let target = args.out.clone().unwrap_or_else(name);
    let place = LogPlace::find(&args.run).map_err(shown_place)?;
    let what = ("such logs", extension);
    let file = OutputFile::create(&target, what, &[], args.force)?;
    let exported = export(&place, format, file.path(), &interrupt::cause);
    let exported = exported.map_err(|error| match error {
        // The user knows the file by its own name.
        LogError::Write { source, .. } => LogError::Write {
            path: target.clone(),
            source,
        },
        other => other,
    });
    let exported = exported.into_diagnostic()?;
    let path = file.finish()?;
    let run = args.run.display().to_string();
    exported.warnings.iter().for_each(|w| warn_of(&run, w));
    let path = shown(&path);
    let (rows, parts) = (exported.rows, &exported.parts);
    tell(
        &format!("{path}: {rows} rows of {}", parts.join(", ")),
        &json!({"log": path, "rows": rows, "parts": parts}),
    )
}

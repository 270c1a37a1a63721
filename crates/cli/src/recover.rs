//! `robhaz recover`: the tables of a run that was killed.

use crate::output::is_being_written;
use crate::terminal::{shown, tell};
use miette::{IntoDiagnostic, Result, bail};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `robhaz recover`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run that was killed, or whose disk was full: `runs/NAME.partial`.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Folder for the tables; by default that of the run.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replaces existing tables.
    #[arg(long)]
    force: bool,
}

/// Makes a Parquet file from each stream in the folder and prints the time of its last record.
pub fn recover(args: &Args) -> Result<()> {
    let out = args.out.as_ref().unwrap_or(&args.folder);
    if args.out.is_none() && is_being_written(&args.folder) {
        bail!(
            "a run is writing in {}: --out DIR makes the tables elsewhere",
            args.folder.display()
        );
    }
    let tables = robhaz_record::recover(&args.folder, out, args.force).into_diagnostic()?;
    let (mut lines, mut documents) = (Vec::new(), Vec::new());
    for table in tables {
        let (path, rows) = (shown(&table.path), table.rows);
        lines.push(match table.end {
            Some(end) => format!("{path}: {rows} rows, up to {end:.3} s"),
            None => format!("{path}: no rows"),
        });
        documents.push(json!({"table": path, "rows": rows, "end_s": table.end}));
    }
    tell(&lines.join("\n"), &json!({"tables": documents}))
}

//! `robhaz recover`: the tables of a run that was killed.

use crate::terminal::say;
use miette::{IntoDiagnostic, Result};
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
    let tables = robhaz_record::recover(&args.folder, out, args.force).into_diagnostic()?;
    for table in tables {
        let (path, rows) = (table.path.display(), table.rows);
        match table.end {
            Some(end) => say(&format!("{path}: {rows} rows, up to {end:.3} s"))?,
            None => say(&format!("{path}: no rows"))?,
        }
    }
    Ok(())
}

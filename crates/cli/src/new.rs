//! `robhaz new`: a scene to edit.

use crate::output_file::{Format, OutputFile};
use crate::terminal::{shown, tell};
use miette::{IntoDiagnostic, Result};
use serde_json::json;
use std::path::PathBuf;

const SCENE: Format = Format {
    what: "scenes",
    extension: "toml",
};

const TEXT: &str = include_str!("new_scene.toml");

/// Arguments of `robhaz new`.
#[derive(clap::Args)]
pub struct Args {
    /// Name of the scene; its file is NAME.toml. A path puts it elsewhere.
    name: PathBuf,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
}

/// Writes the file.
pub fn run(args: &Args) -> Result<()> {
    let mut target = args.name.clone();
    if target.extension().is_none_or(|e| e != SCENE.extension) {
        target.as_mut_os_string().push(".toml");
    }
    let file = OutputFile::create(&target, SCENE, &[], args.force)?;
    std::fs::write(file.path(), TEXT).into_diagnostic()?;
    let path = file.finish()?;
    let path = shown(&path);
    let text =
        format!("{path}: edit it, then `robhaz run {path}`. `robhaz keys` explains its keys.");
    tell(&text, &json!({"scene": path}))
}

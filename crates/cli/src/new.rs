//! `robhaz new`: a scene to edit.

use crate::output_file::{Format, OutputFile};
use crate::terminal::{shown, tell};
use miette::{IntoDiagnostic, Result, bail};
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
    // Without a slash at the end.
    let mut target: PathBuf = args.name.components().collect();
    if target.file_name().is_none() || target.is_dir() {
        bail!(
            "{} is a folder; allowed: the name of a scene, such as {}",
            args.name.display(),
            target.join("my-scene").display()
        );
    }
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

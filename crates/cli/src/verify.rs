//! `robhaz verify`: checks of the simulated truth of a scene.

use crate::interrupt;
use crate::progress::bar;
use crate::terminal::{say, tell_json, warn};
use indicatif::ProgressBar;
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_run::verify::verify;
use robhaz_scene::Scene;
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `robhaz verify`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML); by default the main scene.
    scene: Option<PathBuf>,
    /// Sets a key of the scene, in place of the file's value. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Runs the checks and prints one verdict a line. An error if a check fails.
pub fn run(args: &Args) -> Result<()> {
    let scene = match &args.scene {
        Some(path) => Scene::load(path, &args.set)?,
        None => Scene::parse("", "smooth", &PathBuf::new(), &args.set)?,
    };
    warn(&scene);
    let progress = bar(ProgressBar::new_spinner());
    progress.enable_steady_tick(Duration::from_millis(100));
    interrupt::listen()?;
    let mut step = |step: &str| progress.set_message(step.to_owned());
    let verdicts = verify(&scene, &mut step, &interrupt::cause).into_diagnostic();
    progress.finish_and_clear();
    let verdicts = match interrupt::cause() {
        Some(_) => verdicts.wrap_err("nothing was written")?,
        None => verdicts?,
    };
    let width = verdicts.iter().map(|v| v.check.chars().count()).max();
    let width = width.unwrap_or(0);
    tell_json(|| Ok(json!({"scene": scene.name, "checks": verdicts})))?;
    for verdict in &verdicts {
        let word = match verdict.passed {
            Some(true) => "passed",
            Some(false) => "FAILED",
            None => "not judged",
        };
        let (check, finding) = (&verdict.check, &verdict.finding);
        say(&format!("{word:10}  {check:width$}  {finding}"))?;
    }
    let (all, name) = (verdicts.len(), &scene.name);
    match verdicts.iter().filter(|v| v.passed == Some(false)).count() {
        0 => say(&format!(
            "{name}: the truth holds in every check that applies."
        )),
        failed => bail!("{failed} of {all} checks failed for {name}"),
    }
}

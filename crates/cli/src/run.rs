//! `robhaz run`: scenes from their files to their results.

use crate::results::{self, Job};
use crate::terminal::{tell_json, warn};
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use robhaz_run::Run;
use robhaz_scene::Scene;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Instant;
use tracing::info;

/// Arguments of `robhaz run`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene files (TOML), run one after the other. With several, --out is the folder of their
    /// folders.
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Sets a key of the scene, in place of the file's value: `--set drive.speed=0.3`. Can be
    /// repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Engine that computes the truth: `rapier` or `direct`; short for `--set engine.kind=...`.
    #[arg(long, value_name = "KIND")]
    engine: Option<String>,
    /// Seed of everything random in the run.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    #[command(flatten)]
    results: results::Args,
}

/// Runs each scene, writes its results, prints its table. All scenes are read before the first
/// runs; the first run that fails is the last one.
pub fn run(args: &Args) -> Result<()> {
    let mut start = Instant::now();
    let mut overrides = args.set.clone();
    overrides.extend(args.engine.iter().map(|kind| format!("engine.kind={kind}")));
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let mut scenes: Vec<Scene> = Vec::new();
    for file in &args.scenes {
        let scene = Scene::load(file, &overrides)?;
        info!(
            file = %file.display(),
            ground = scene.terrain.kind,
            engine = scene.engine.kind.name(),
            estimators = scene.estimators.len(),
            "scene read"
        );
        if let Some(other) = scenes.iter().position(|s| s.name == scene.name) {
            return Err(miette!(
                help = "give one of them another `name`",
                "{} and {} have the same name, {}: they would write the same folder",
                args.scenes[other].display(),
                file.display(),
                scene.name
            ));
        }
        scenes.push(scene);
    }
    let mut documents = Vec::new();
    for scene in &scenes {
        let results = match scenes.len() {
            1 => args.results.clone(),
            _ => args.results.below(&scene.name),
        };
        documents.push(run_one(scene, start, &results)?);
        start = Instant::now();
    }
    tell_json(|| Ok(json!({"runs": documents})))
}

fn run_one(scene: &Scene, start: Instant, results: &results::Args) -> Result<Value> {
    warn(scene);
    // Before anything is written, so that a robot that cannot stand leaves no folder.
    let run = Run::new(scene)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot start {}", scene.name))?
        .on_threads();
    let engine = scene.engine.kind.library();
    let version = format!("robhaz {}, {engine}", env!("CARGO_PKG_VERSION"));
    let job = Job {
        start,
        name: &scene.name,
        folder: scene.name.clone(),
        work: "simulation and estimation",
        files: scene.files(&version),
    };
    results::write(run, &job, results)
}

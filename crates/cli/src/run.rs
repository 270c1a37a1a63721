//! `robhaz run`: one scene from its file to its results.

use crate::interrupt::Interrupt;
use crate::results::{self, Job};
use crate::terminal::warn;
use miette::{IntoDiagnostic, Result, WrapErr};
use robhaz_run::Run;
use robhaz_scene::Scene;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `robhaz run`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Sets a key of the scene, in place of the file's value: `--set drive.speed=0.3`. Can be repeated.
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

/// Runs the scene, writes the results, prints the table.
pub fn run(args: &Args, interrupt: &Interrupt) -> Result<()> {
    let start = Instant::now();
    let mut overrides = args.set.clone();
    overrides.extend(args.engine.iter().map(|kind| format!("engine.kind={kind}")));
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let scene = Scene::load(&args.scene, &overrides)?;
    warn(&scene);
    // Before anything is written, so that a robot that cannot stand leaves no folder.
    let run = Run::new(&scene)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot start {}", scene.name))?;
    let version = format!(
        "robhaz {}, {}",
        env!("CARGO_PKG_VERSION"),
        scene.engine.kind.library()
    );
    let resolved = ("scene.toml".to_owned(), scene.to_toml(&version).into());
    let tracks = scene.terrain.tracks.iter();
    let tracks = tracks.map(|track| (track.file_name(), track.bytes.to_vec()));
    let job = Job {
        start,
        name: &scene.name,
        folder: scene.name.clone(),
        work: "simulation and estimation",
        files: std::iter::once(resolved).chain(tracks).collect(),
    };
    results::write(run, &job, &args.results, interrupt)
}

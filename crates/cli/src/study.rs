//! `robhaz study`: errors of a scene's estimators and consistency of their covariance, over many seeds.

use crate::interrupt::Interrupt;
use crate::output_file::{Format, OutputFile};
use crate::progress::bar;
use crate::terminal::{tell, warn};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_scene::Scene;
use robhaz_study::{Report, TruthRun, floor, ladder, study};
use std::path::PathBuf;
use std::time::Duration;

/// The format of `--out`.
const JSON: Format = Format {
    what: "results of a study",
    extension: "json",
};

/// Arguments of `robhaz study`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Number of seeds, from the scene's seed on; fewer than 5 give no verdict.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: u64,
    /// Sets a key of the scene, in place of the file's value: `--set sensors.grade=typical`. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Engine that computes the truth: `rapier` or `direct`; short for `--set engine.kind=...`.
    #[arg(long, value_name = "KIND")]
    engine: Option<String>,
    /// Studies the ablation ladder instead of the scene's estimators: from the paper's to `best`. From the fourth on
    /// each has one method more than the one above. The last two are given no contact angles.
    #[arg(long)]
    ladder: bool,
    /// Also writes the result to a JSON file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replaces an existing JSON file.
    #[arg(long)]
    force: bool,
}

/// Simulates the scene once, estimates with the readings of every seed, prints the table.
pub fn run(args: &Args, interrupt: &Interrupt) -> Result<()> {
    let mut overrides = args.set.clone();
    overrides.extend(args.engine.iter().map(|kind| format!("engine.kind={kind}")));
    let mut scene = Scene::load(&args.scene, &overrides)?;
    warn(&scene);
    // Its control drives it, whatever is studied.
    let driven = scene.clone();
    if args.ladder {
        scene.estimators = ladder();
    }
    if scene.estimators.is_empty() {
        bail!(
            "{} has no estimator to study: leave out `estimator = []`, or study the --ladder",
            scene.name
        );
    }
    let Some(last) = scene.seed.checked_add(args.seeds - 1) else {
        bail!(
            "{} seeds from {} on: the last seed must be below 2^64",
            args.seeds,
            scene.seed
        );
    };
    let seeds: Vec<u64> = (scene.seed..=last).collect();
    let inputs = [args.scene.clone()];
    let create = |path: &PathBuf| OutputFile::create(path, JSON, &inputs, args.force);
    // Tried before the study is computed. Nothing is left of it: a signal may end the process meanwhile.
    args.out.as_ref().map(create).transpose()?;
    let report = report(&driven, &scene, &seeds, interrupt)?;
    tell(
        &report.text(),
        &serde_json::to_value(&report).into_diagnostic()?,
    )?;
    if let Some(file) = args.out.as_ref().map(create).transpose()? {
        let text = serde_json::to_string_pretty(&report).into_diagnostic()?;
        std::fs::write(file.path(), text + "\n")
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot write {}", file.path().display()))?;
        file.finish()?;
    }
    Ok(())
}

/// Simulates `driven` once and studies the estimators of `scene` on its truth.
fn report(driven: &Scene, scene: &Scene, seeds: &[u64], interrupt: &Interrupt) -> Result<Report> {
    let progress = bar(ProgressBar::new(seeds.len() as u64));
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}");
    progress.set_style(style.into_diagnostic()?);
    progress.enable_steady_tick(Duration::from_millis(100));
    progress.set_message("simulating");
    let shown = progress.clone();
    interrupt.end_process("study", move || shown.finish_and_clear())?;
    let cannot = || format!("cannot study {}", scene.name);
    let truth = TruthRun::of(driven)
        .into_diagnostic()
        .wrap_err_with(cannot)?;
    progress.set_message("observing");
    let scores = study(scene, &truth, seeds, &|| progress.inc(1))
        .into_diagnostic()
        .wrap_err_with(cannot)?;
    progress.finish_and_clear();
    Ok(Report::new(
        scene,
        &truth,
        seeds,
        floor(scene, &truth),
        &scores,
    ))
}

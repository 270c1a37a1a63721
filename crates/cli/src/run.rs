//! `robhaz run`: one scene from its file to its results.

use crate::live::{Rerun, Viewing};
use crate::output::OutputFolder;
use crate::pace::{Pace, PaceSink};
use crate::progress::Progress;
use crate::terminal::{say, warn};
use miette::{IntoDiagnostic, Result, WrapErr};
use robhaz_record::{FigureSink, Summary, SummarySink, TableFormat, TableSink, comparison_table};
use robhaz_run::Sink;
use robhaz_scene::Scene;
use std::path::{Path, PathBuf};

/// Arguments of `robhaz run`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Folder for the results; by default `runs/` and the scene's name.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the tables.
    #[arg(long, value_enum, default_value_t = Format::Parquet)]
    format: Format,
    /// Sets a key of the scene, over what the file says: `--set drive.speed=0.3`. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Engine that computes the truth: `rapier` or `direct`; short for `--set engine.kind=...`.
    #[arg(long, value_name = "KIND")]
    engine: Option<String>,
    /// Seed of everything random in the run.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// What the Rerun viewer gets: `off` nothing; `save` the file run.rrd. Beside that file, live: `spawn` starts the viewer here,
    /// `connect=HOST:PORT` shows the run in a viewer that listens there, `serve` lets viewers connect to this command.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse, default_value = Rerun::DEFAULT)]
    rerun: Rerun,
    /// How fast the run may go.
    #[arg(long, value_enum, default_value_t = Pace::Fast)]
    pace: Pace,
    /// Replaces an earlier run in the output folder.
    #[arg(long)]
    force: bool,
}

/// Format of the tables.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// Apache Parquet, units in the field metadata.
    Parquet,
    /// Comma-separated text.
    Csv,
}

/// Runs the scene, writes the results, prints the table.
pub fn run(args: &Args) -> Result<()> {
    let mut overrides = args.set.clone();
    overrides.extend(args.engine.iter().map(|kind| format!("engine.kind={kind}")));
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let scene = Scene::load(&args.scene, &overrides)?;
    warn(&scene);
    let target = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("runs").join(&scene.name));
    let mut viewing = Viewing::open(&args.rerun)?;
    let folder = OutputFolder::create(&target, args.force)?;
    let version = format!(
        "robhaz {}, {}",
        env!("CARGO_PKG_VERSION"),
        scene.engine.kind.library()
    );
    for track in &scene.terrain.tracks {
        folder.write(&track.file_name(), &track.bytes)?;
    }
    folder.write("scene.toml", scene.to_toml(&version).as_bytes())?;

    viewing.record(folder.path())?;
    let summary = match simulate(&scene, args, folder.path(), &mut viewing) {
        Ok(summary) => summary,
        Err(report) => {
            return Err(report.wrap_err(format!(
                "{} broke off; what it recorded is in {}",
                scene.name,
                folder.path().display()
            )));
        }
    };
    summary.write(folder.path()).into_diagnostic()?;
    let path = folder.finish()?;
    say(&comparison_table(&[(&scene.name, &summary)]))?;
    say(&format!("Results in {}", path.display()))?;
    viewing.finish()
}

fn simulate(scene: &Scene, args: &Args, folder: &Path, viewing: &mut Viewing) -> Result<Summary> {
    let format = match args.format {
        Format::Parquet => TableFormat::Parquet,
        Format::Csv => TableFormat::Csv,
    };
    let mut tables = TableSink::new(folder, format);
    let mut summary = SummarySink::new();
    let mut figures = FigureSink::new(&folder.join("figures"));
    let mut progress = Progress::new();
    let mut pace = PaceSink::new(args.pace);
    let mut sinks: Vec<&mut dyn Sink> =
        vec![&mut tables, &mut summary, &mut figures, &mut progress];
    sinks.extend(viewing.sinks());
    sinks.push(&mut pace);
    robhaz_run::run(scene, &mut sinks)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot finish {}", scene.name))?;
    summary.summary().into_diagnostic()
}

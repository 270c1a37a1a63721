//! `robhaz run`: one scene from its file to its results.

use crate::interrupt::Interrupt;
use crate::live::{Rerun, Viewing};
use crate::output::OutputFolder;
use crate::pace::{Pace, PaceSink};
use crate::progress::Progress;
use crate::terminal::{say, warn};
use miette::{IntoDiagnostic, Result, WrapErr};
use robhaz_record::{FigureSink, Summary, SummarySink, TableFormat, TableSink, comparison_table};
use robhaz_run::{Run, RunEnd, RunError, Sink};
use robhaz_scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

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
    /// Sets a key of the scene, in place of the file's value: `--set drive.speed=0.3`. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Engine that computes the truth: `rapier` or `direct`; short for `--set engine.kind=...`.
    #[arg(long, value_name = "KIND")]
    engine: Option<String>,
    /// Seed of everything random in the run.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Output for the Rerun viewer: `off` none; `save` the file run.rrd. With that file and live: `spawn` starts the
    /// viewer on this machine, `connect=HOST:PORT` sends the run to a viewer that listens there, `serve` lets viewers
    /// connect to this command.
    #[arg(long, value_name = "HOW", value_parser = Rerun::parse, default_value = Rerun::DEFAULT)]
    rerun: Rerun,
    /// Speed of the run.
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
pub fn run(args: &Args, interrupt: &Interrupt) -> Result<()> {
    let start = Instant::now();
    let mut overrides = args.set.clone();
    overrides.extend(args.engine.iter().map(|kind| format!("engine.kind={kind}")));
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let scene = Scene::load(&args.scene, &overrides)?;
    warn(&scene);
    let target = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("runs").join(&scene.name));
    // Before anything is written, so that a robot that cannot stand leaves no folder.
    let run = Run::new(&scene)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot start {}", scene.name))?;
    let mut viewing = Viewing::open(&args.rerun)?;
    interrupt.listen()?;
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
    let mut sink = SummarySink::new();
    let simulated = simulate(run, args, &folder, &mut sink, &mut viewing, interrupt);
    let table = |summary: &Summary| say(&comparison_table(&[(&scene.name, summary)]));
    if let Err(error) = simulated {
        // A run without a record has no summary. The first error is reported, not those that follow from it.
        let mut title = format!("{} broke off", scene.name);
        if let Ok(summary) = sink.summary() {
            title.push_str(&format!(" at {:.3} s", summary.duration_s));
            if summary.write(folder.path()).is_ok() && matches!(error, RunError::Stopped { .. }) {
                table(&summary)?;
            }
        }
        title.push_str(&what_is_left(&folder));
        return Err(error).into_diagnostic().wrap_err(title);
    }
    let summary = sink.summary().into_diagnostic()?;
    summary.write(folder.path()).into_diagnostic()?;
    let path = folder.finish()?;
    table(&summary)?;
    say(&format!(
        "Results in {}; the whole command took {:.2} s, of which simulation and estimation {:.2} s",
        path.display(),
        start.elapsed().as_secs_f64(),
        summary.wall_s,
    ))?;
    viewing.finish(interrupt)
}

fn simulate(
    run: Run,
    args: &Args,
    folder: &OutputFolder,
    summary: &mut SummarySink,
    viewing: &mut Viewing,
    interrupt: &Interrupt,
) -> Result<RunEnd, RunError> {
    let format = match args.format {
        Format::Parquet => TableFormat::Parquet,
        Format::Csv => TableFormat::Csv,
    };
    let mut tables = TableSink::new(folder.path(), format);
    let mut figures = FigureSink::new(&folder.path().join("figures"));
    let mut progress = Progress::new();
    let mut pace = PaceSink::new(args.pace, interrupt);
    let mut sinks: Vec<&mut dyn Sink> = vec![&mut tables, summary, &mut figures, &mut progress];
    sinks.extend(viewing.sinks());
    sinks.push(&mut pace);
    run.until(&mut sinks, &|| interrupt.cause())
}

/// Names the folder with the records of a run that broke off.
fn what_is_left(folder: &OutputFolder) -> String {
    let path = folder.path().display();
    let mut text = format!("; what it recorded is in {path}");
    if folder.has_streams() {
        text.push_str(&format!(
            ", tables as .arrows: `robhaz recover {path}` makes Parquet of them"
        ));
    }
    text
}

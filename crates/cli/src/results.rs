//! A run, simulated or of a log, from its start to its folder and the table on the terminal.

use crate::choice::{Choice, choice, choices};
use crate::interrupt;
use crate::live::{Rerun, Viewing};
use crate::output::OutputFolder;
use crate::progress::{Pace, Progress, pace};
use crate::terminal::{say, shown};
use miette::{IntoDiagnostic, Result, WrapErr};
use robhaz_record::{FigureSink, Summary, SummarySink, TableFormat, TableSink, comparison_table};
use robhaz_run::{Run, RunEnd, RunError, Sink};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;
use tracing::info;

/// Arguments of every command that leaves the folder of a run.
#[derive(Clone, clap::Args)]
pub struct Args {
    /// Folder for the results; by default in `runs/`, with the name of the scene, or with that of
    /// the log and `-estimate`.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the tables.
    #[arg(long, value_parser = choice(FORMATS), default_value = "parquet")]
    format: TableFormat,
    /// Output for the Rerun viewer: `off` none; `save` the file run.rrd; `live` this file, and the
    /// run is shown while it goes on, in the viewer on this machine, which is started if need be;
    /// `live=HOST:PORT` the same in a viewer that listens there.
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
pub const FORMATS: &[Choice<TableFormat>] = choices! {
    "parquet", "Apache Parquet, units in the field metadata" => TableFormat::Parquet;
    "csv", "Comma-separated text" => TableFormat::Csv;
};

/// What a command writes beside the results of its run.
pub struct Job<'a> {
    /// Start of the command.
    pub start: Instant,
    /// Name of the run, for messages.
    pub name: &'a str,
    /// Name of the folder in `runs/`.
    pub folder: String,
    /// What took the time of the run, for the last line.
    pub work: &'static str,
    /// Files of the folder that exist before the run: names and contents.
    pub files: Vec<(String, Vec<u8>)>,
}

impl Args {
    /// The same for one of several runs: its folder is in that of `--out`.
    pub fn below(&self, folder: &str) -> Self {
        let out = self.out.as_ref().map(|out| out.join(folder));
        Self {
            out,
            ..self.clone()
        }
    }

    /// The folder for the results.
    pub fn target(&self, job: &Job<'_>) -> PathBuf {
        let default = || Path::new("runs").join(&job.folder);
        self.out.clone().unwrap_or_else(default)
    }
}

/// Runs to the end, writes the results, prints the table. Returns the document of the run for
/// `--json`: `name`, `folder`, `command_s` (time of the command) and `summary`, the content of
/// `summary.json`.
pub fn write(run: Run, job: &Job<'_>, args: &Args) -> Result<Value> {
    let target = args.target(job);
    let mut viewing = Viewing::open(&args.rerun)?;
    interrupt::listen()?;
    let folder = OutputFolder::create(&target, args.force)?;
    for (name, content) in &job.files {
        folder.write(name, content)?;
    }
    viewing.record(folder.path())?;
    let mut sink = SummarySink::new();
    info!(folder = %folder.path().display(), "results go to");
    let recording = Instant::now();
    let done = record(run, args, &folder, &mut sink, &mut viewing);
    let seconds = recording.elapsed().as_secs_f64();
    info!(seconds, "simulated, estimated, wrote tables and figures");
    let table = |summary: &Summary| say(&comparison_table(&[(job.name, summary)]));
    if let Err(error) = done {
        // A run without a record has no summary. The first error is reported, not those that follow
        // from it.
        let is_stopped = matches!(error, RunError::Stopped { .. });
        if is_stopped && sink.summary().is_err() {
            folder.discard()?;
            let title = format!("{} has no record yet; nothing was written", job.name);
            return Err(error).into_diagnostic().wrap_err(title);
        }
        let mut title = format!("{} broke off", job.name);
        if let Ok(summary) = sink.summary() {
            title.push_str(&format!(" at {:.3} s", summary.duration_s));
            if summary.write(folder.path()).is_ok() && is_stopped {
                table(&summary)?;
            }
        }
        let left = folder.path().display();
        title.push_str(&format!("; what it recorded is in {left}"));
        folder.release();
        return Err(error).into_diagnostic().wrap_err(title);
    }
    let summary = sink.summary().into_diagnostic()?;
    summary.write(folder.path()).into_diagnostic()?;
    table(&summary)?;
    if let Some(words) = summary.control.as_ref().and_then(|c| c.in_words()) {
        say(&words)?;
    }
    for test in &summary.friction_tests {
        say(&test.in_words())?;
    }
    let complete = format!("the complete run is in {}", folder.path().display());
    let path = folder.finish().wrap_err(complete)?;
    let command_s = job.start.elapsed().as_secs_f64();
    say(&format!(
        "Results in {}; the whole command took {command_s:.2} s, of which {} {:.2} s",
        path.display(),
        job.work,
        summary.wall_s,
    ))?;
    viewing.finish(&path)?;
    Ok(json!({
        "name": job.name,
        "folder": shown(&path),
        "command_s": command_s,
        "summary": serde_json::to_value(&summary).into_diagnostic()?,
    }))
}

fn record(
    run: Run,
    args: &Args,
    folder: &OutputFolder,
    summary: &mut SummarySink,
    viewing: &mut Viewing,
) -> Result<RunEnd, RunError> {
    let mut tables = TableSink::new(folder.path(), args.format);
    let mut figures = FigureSink::new(&folder.path().join("figures"));
    let mut progress = Progress::new();
    let mut pace = pace(args.pace);
    let mut sinks: Vec<&mut dyn Sink> = vec![summary, &mut figures, &mut progress];
    sinks.extend(viewing.sinks());
    sinks.push(&mut tables);
    sinks.push(&mut pace);
    run.until(&mut sinks, &interrupt::cause)
}

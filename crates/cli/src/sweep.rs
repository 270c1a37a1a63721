//! `robhaz sweep`: a study file from its runs to its dataset.

use crate::interrupt::Interrupt;
use crate::terminal::{Output, shown, tell, warn_of};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use miette::Result;
use robhaz_run::Run;
use robhaz_scene::Setting;
use robhaz_sweep::{Done, JOURNAL, Job, RunRecord, Shard, Sweep, Watch, compute};
use serde_json::json;
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tracing::{debug, info};

/// Runs that `--dry-run` lists.
const LISTED: u64 = 20;
/// Runs that `--dry-run` times, spread over the study.
const TIMED: u64 = 3;
/// Time between two lines of progress where standard error is no terminal, as in the log of a cluster's job.
const LINE_TIME: Duration = Duration::from_secs(60);

/// Arguments of `robhaz sweep`.
#[derive(clap::Args)]
pub struct Args {
    /// Study file (TOML).
    study: PathBuf,
    /// Folder of the sweep; without it `runs/NAME`. A sweep that was stopped goes on in its folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads, at most 1024; without it one a core.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Computes only every N-th run, from the I-th on: one of N parts, I from 1 on. `robhaz merge` puts the parts together.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// Lists the runs and estimates the time from a few of them. Writes nothing.
    #[arg(long)]
    dry_run: bool,
}

/// `2/8`
fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(part, of)| Some((part.parse().ok()?, of.parse().ok()?)));
    let shard = parts.and_then(|(part, of)| Shard::new(part, of));
    shard.ok_or_else(|| "allowed: I/N with I from 1 to N, such as 1/8".to_owned())
}

/// Computes the runs that are missing.
pub fn run(args: &Args, interrupt: &Interrupt) -> Result<()> {
    let sweep = Sweep::load(&args.study)?;
    let warnings = sweep.warnings().iter();
    warnings.for_each(|warning| warn_of(&sweep.study().name, warning));
    let shard = args.shard.unwrap_or(Shard::ALL);
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    // A thread without a run is of no use.
    let runs = usize::try_from(shard.count(sweep.runs())).unwrap_or(usize::MAX);
    let jobs = args.jobs.map_or_else(cores, usize::from).min(runs).max(1);
    if args.dry_run {
        return dry_run(&sweep, shard, jobs);
    }
    info!(
        study = sweep.study().name,
        runs = sweep.runs(),
        jobs,
        "sweep"
    );
    interrupt.listen()?;
    let named = || PathBuf::from("runs").join(&sweep.study().name);
    let folder = args.out.clone().unwrap_or_else(named);
    let job = Job {
        folder: &folder,
        shard,
        jobs,
    };
    let progress = Progress::new(Output::get().quiet);
    let watch = Watch {
        begin: &|done, runs| progress.begin(done, runs),
        finished: &|record| progress.finished(record),
        stop: &|| interrupt.cause(),
    };
    let start = Instant::now();
    let done = compute(&sweep, &job, &watch);
    progress.bar.finish_and_clear();
    let done = done?;
    let wall = start.elapsed().as_secs_f64();
    let failed = progress.failures();
    tell(
        &summary(&done, &folder, failed, jobs, wall),
        &json!({
            "name": sweep.study().name,
            "folder": shown(&folder),
            "dataset": done.dataset.as_deref().map(shown),
            "runs": done.runs,
            "computed": done.computed,
            "failed": failed,
            "damaged": done.damaged,
            "jobs": jobs,
            "wall_s": wall,
        }),
    )
}

/// What was computed, and where it is.
fn summary(done: &Done, folder: &std::path::Path, failed: u64, jobs: usize, wall: f64) -> String {
    let mut text = match done.computed {
        0 => format!("All {} runs are done.", done.runs),
        computed => format!(
            "{computed} of {} runs computed in {wall:.1} s on {jobs} threads, {:.2} runs a second.",
            done.runs,
            computed as f64 / wall
        ),
    };
    // Writing into a text cannot fail.
    if done.damaged > 0 {
        let _ = write!(
            text,
            "\nLines of {} with a wrong checksum: {}. Their runs were computed again.",
            folder.join(JOURNAL).display(),
            done.damaged
        );
    }
    if failed > 0 {
        let _ = write!(text, "\n{failed} of them failed: see the column error.");
    }
    let _ = match &done.dataset {
        Some(dataset) => write!(text, "\nDataset: {}", dataset.display()),
        None => write!(
            text,
            "\nThis part is complete. robhaz merge {} OTHER... --out DIR makes the dataset.",
            folder.display()
        ),
    };
    text
}

/// Lists the runs and estimates the time.
fn dry_run(sweep: &Sweep, shard: Shard, jobs: usize) -> Result<()> {
    let runs: Vec<u64> = (0..sweep.runs()).filter(|run| shard.has(*run)).collect();
    let overrides = |run: u64| -> Vec<String> {
        let settings = sweep.settings(run);
        settings.iter().map(Setting::as_override).collect()
    };
    let mut text = String::new();
    for run in runs.iter().take(LISTED as usize) {
        let _ = writeln!(text, "run {run}: {}", overrides(*run).join(" "));
    }
    let count = runs.len() as u64;
    if count > LISTED {
        let _ = writeln!(text, "... and {} more", count - LISTED);
    }
    let timed: Vec<u64> = (0..TIMED.min(count)).map(|i| i * count / TIMED).collect();
    let start = Instant::now();
    for place in &timed {
        let run = usize::try_from(*place).ok().and_then(|i| runs.get(i));
        let Some(scene) = run.and_then(|run| sweep.scene(*run).ok()) else {
            continue;
        };
        // A run that fails is a row of the dataset, and takes its time here, too.
        let _ = Run::new(&scene).and_then(|run| run.until(&mut [], &|| None));
    }
    let each = start.elapsed().as_secs_f64() / timed.len().max(1) as f64;
    let total = each * count as f64 / jobs as f64;
    let _ = write!(
        text,
        "{count} runs, {each:.2} s each (mean of {}): about {} on {jobs} threads.",
        timed.len(),
        duration(total)
    );
    let listed = runs.iter().take(LISTED as usize);
    let listed: Vec<_> = listed
        .map(|run| json!({"run": run, "set": overrides(*run)}))
        .collect();
    tell(
        &text,
        &json!({"runs": count, "run_s": each, "total_s": total, "jobs": jobs, "first": listed}),
    )
}

/// `12 s`, `3.4 min`, `5.6 h`, `7.8 d`
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.1} min", s / 60.0),
        s if s < 48.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} d", s / 86400.0),
    }
}

/// A bar on a terminal, else a line a minute.
struct Progress {
    bar: ProgressBar,
    quiet: bool,
    failed: AtomicU64,
    /// Start, runs done before it, and time of the last line; `None` on a terminal.
    lines: Mutex<Option<(Instant, u64, Instant)>>,
}

impl Progress {
    fn new(quiet: bool) -> Self {
        let bar = ProgressBar::hidden();
        let terminal = std::io::stderr().is_terminal();
        if terminal && !quiet {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        let now = Instant::now();
        Self {
            bar,
            quiet,
            failed: AtomicU64::new(0),
            lines: Mutex::new((!terminal && !quiet).then_some((now, 0, now))),
        }
    }

    fn begin(&self, done: u64, runs: u64) {
        self.bar.set_length(runs);
        self.bar.set_position(done);
        // What an earlier call has computed says nothing about the rate.
        self.bar.reset_eta();
        let style = "{wide_bar} {pos}/{len} runs  {per_sec}  {eta} left";
        if let Ok(style) = ProgressStyle::with_template(style) {
            self.bar.set_style(style);
        }
        if let Ok(mut lines) = self.lines.lock()
            && let Some((_, before, _)) = lines.as_mut()
        {
            *before = done;
        }
        if done > 0 && done < runs && !self.quiet {
            self.bar
                .suspend(|| eprintln!("{done} of {runs} runs are done already."));
        }
    }

    fn finished(&self, record: &RunRecord) {
        self.bar.inc(1);
        match &record.error {
            None => debug!(run = record.run, "run done"),
            Some(error) => info!(run = record.run, error, "run failed"),
        }
        if record.error.is_some() {
            self.failed.fetch_add(1, Ordering::Relaxed);
        }
        let Ok(mut lines) = self.lines.lock() else {
            return;
        };
        let Some((start, before, last)) = lines.as_mut() else {
            return;
        };
        if last.elapsed() < LINE_TIME {
            return;
        }
        *last = Instant::now();
        let (done, runs) = (self.bar.position(), self.bar.length().unwrap_or(0));
        let rate = (done - *before) as f64 / start.elapsed().as_secs_f64();
        let left = duration((runs - done) as f64 / rate);
        eprintln!("{done} of {runs} runs, {rate:.2} a second, {left} left");
    }

    fn failures(&self) -> u64 {
        self.failed.load(Ordering::Relaxed)
    }
}

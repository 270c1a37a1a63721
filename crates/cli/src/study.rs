//! `robhaz study`: a scene with many seeds, or a study file, from its runs to its dataset and its
//! report.

use crate::interrupt;
use crate::progress::bar;
use crate::terminal::{Output, print, print_json, shown, tell, warn_of};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, bail};
use robhaz_record::Dataset;
use robhaz_scene::{Scene, Setting};
use robhaz_study::{Done, Report, RunRecord, Shard, Study, Watch, compute_dataset};
use serde_json::{Value, json};

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tracing::{debug, info};

/// Runs that `--dry-run` lists.
const LISTED: u64 = 20;
/// Most runs of which the report is printed: it needs the dataset in memory.
const MOST_REPORTED: u64 = 100_000;
/// Time between two lines of progress where standard error is no terminal, as in the log of a
/// cluster's job.
const LINE_TIME: Duration = Duration::from_secs(60);

/// Arguments of `robhaz study`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file, which is simulated once and observed with many seeds, or study file (TOML).
    file: PathBuf,
    /// Number of seeds of a scene, from its own on; 10 without it. Fewer than 5 give no verdict.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: Option<u64>,
    /// Sets a key of the scene, in place of the file's value: `--set sensors.grade=typical`. Can be
    /// repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Engine that computes the truth: `rapier` or `direct`; short for `--set engine.kind=...`.
    #[arg(long, value_name = "KIND")]
    engine: Option<String>,
    /// Studies the ablation ladder instead of the scene's estimators: from the paper's to `kalman`.
    /// From the fourth on each has one method more than the one above. The last two are given no
    /// contact angles.
    #[arg(long)]
    ladder: bool,
    /// Folder of the dataset, in which a study that was stopped goes on. Without it, that of a
    /// study file is `runs/NAME`, and a scene writes nothing.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of threads, at most 1024; without it one a core.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Computes only every N-th run, from the I-th on: one of N parts, I from 1 on. The same
    /// command without --shard makes the dataset of all parts in the folder, and computes what is
    /// missing.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// Lists the runs, their number and simulated time. Computes and writes nothing.
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

/// Whether a file is a study file: it names its scene, or has an axis. One that cannot be read is
/// taken for a scene.
fn is_study(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().any(|line| {
        let key = line.split('=').next().unwrap_or(line).trim();
        line.trim().starts_with("[[axis]]") || (key == "scene" && line.contains('='))
    })
}

impl Args {
    /// The study, and the folder of its dataset.
    fn study(&self) -> Result<(Study, Option<PathBuf>)> {
        if is_study(&self.file) {
            // What a study file says itself.
            let of_scene = self.seeds.is_some() || self.engine.is_some() || self.ladder;
            if of_scene || !self.set.is_empty() {
                bail!(
                    "{} is a study file: its axes and its key set say what --seeds, --set, --engine and --ladder say of a scene",
                    self.file.display()
                );
            }
            let study = Study::load(&self.file)?;
            let named = || PathBuf::from("runs").join(&study.choice.name);
            let folder = self.out.clone().unwrap_or_else(named);
            return Ok((study, Some(folder)));
        }
        if self.shard.is_some() && self.out.is_none() {
            bail!("the shard of a scene needs a folder: --out DIR");
        }
        let mut overrides = self.set.clone();
        overrides.extend(self.engine.iter().map(|kind| format!("engine.kind={kind}")));
        let scene = Scene::load(&self.file, &overrides)?;
        let study = Study::of_scene(&scene, self.seeds.unwrap_or(10), self.ladder)?;
        Ok((study, self.out.clone()))
    }
}

/// Computes the runs that are missing, and reports.
pub fn run(args: &Args) -> Result<()> {
    let (study, folder) = args.study()?;
    let name = &study.choice.name;
    let warnings = study.warnings();
    warnings.iter().for_each(|warning| warn_of(name, warning));
    let shard = args.shard.unwrap_or(Shard::ALL);
    if args.dry_run {
        return dry_run(&study, shard);
    }
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    // A thread without a run is of no use.
    let runs = usize::try_from(shard.count(study.plan.runs())).unwrap_or(usize::MAX);
    let jobs = args.jobs.map_or_else(cores, usize::from).min(runs).max(1);
    let (all, truths) = (study.plan.runs(), study.plan.truths());
    info!(study = name, runs = all, truths, jobs, "study");
    interrupt::listen()?;
    let progress = Progress::new();
    let watch = Watch {
        begin: &|done, runs| progress.begin(done, runs),
        finished: &|record| progress.finished(record),
        stop: &interrupt::cause,
    };
    let start = Instant::now();
    let compute = || -> Result<(Option<Done>, Option<Dataset>)> {
        let Some(folder) = folder.as_deref() else {
            return Ok((None, Some(compute_dataset(&study, jobs, &watch)?)));
        };
        let done = robhaz_study::compute(&study, folder, shard, jobs, &watch)?;
        let dataset = done.dataset.as_ref();
        let dataset = dataset.filter(|_| study.plan.runs() <= MOST_REPORTED);
        let data = dataset.map(|path| Dataset::read(path)).transpose();
        Ok((Some(done), data.into_diagnostic()?))
    };
    let computed = compute();
    progress.bar.finish_and_clear();
    let (done, data) = computed?;
    let wall = start.elapsed().as_secs_f64();
    let failed = progress.failed.load(Ordering::Relaxed);
    let report = data.map(|data| Report::of(&study, &data)).transpose()?;
    let mut document = match &report {
        Some(report) => serde_json::to_value(report).into_diagnostic()?,
        None => json!({"runs": runs, "failed": failed}),
    };
    add_call(&mut document, &study, folder.as_deref(), done.as_ref());
    document["jobs"] = json!(jobs);
    document["wall_s"] = json!(wall);
    let mut lines: Vec<String> = report.iter().map(Report::text).collect();
    if let (Some(done), Some(folder)) = (&done, &folder) {
        lines.extend(summary(done, folder, failed, jobs, wall));
    }
    tell(&lines.join("\n"), &document)
}

/// Adds to the document what was computed, and where it is.
fn add_call(document: &mut Value, study: &Study, folder: Option<&Path>, done: Option<&Done>) {
    let dataset = done.and_then(|done| done.dataset.as_deref());
    document["name"] = json!(study.choice.name);
    document["folder"] = json!(folder.map(shown));
    document["dataset"] = json!(dataset.map(shown));
    document["computed"] = json!(done.map_or(study.plan.runs(), |done| done.computed));
    document["damaged"] = json!(done.map_or(0, |done| done.damaged));
}

/// What was computed, and where it is.
fn summary(done: &Done, folder: &Path, failed: u64, jobs: usize, wall: f64) -> Vec<String> {
    let (runs, damaged) = (done.runs, done.damaged);
    let mut lines = vec![match done.computed {
        0 => format!("All {runs} runs are done."),
        computed => format!(
            "{computed} of {runs} runs computed in {wall:.1} s on {jobs} threads, {:.2} runs a second.",
            computed as f64 / wall
        ),
    }];
    if damaged > 0 {
        lines.push(format!(
            "Lines of runs*.jsonl with a wrong checksum (damaged, or of another study): {damaged}. Their runs were computed again."
        ));
    }
    if failed > 0 {
        lines.push(format!("{failed} of them failed: see the column error."));
    }
    lines.push(match &done.dataset {
        Some(dataset) => format!("Dataset: {}", dataset.display()),
        None => format!(
            "This part is complete. With all parts in {} the same command without --shard makes the dataset.",
            folder.display()
        ),
    });
    lines
}

/// Lists the runs, how many there are, and the time that they simulate.
fn dry_run(study: &Study, shard: Shard) -> Result<()> {
    let runs = (0..study.plan.runs()).filter(|run| shard.has(*run));
    let overrides = |run: u64| -> Vec<String> {
        let settings = study.plan.settings(run);
        settings.iter().map(Setting::as_override).collect()
    };
    let listed = runs.take(LISTED as usize).map(|run| (run, overrides(run)));
    let listed: Vec<(u64, Vec<String>)> = listed.collect();
    let line = |(run, set): &(u64, Vec<String>)| format!("run {run}: {}", set.join(" "));
    let mut lines: Vec<String> = listed.iter().map(line).collect();
    let count = shard.count(study.plan.runs());
    if count > LISTED {
        lines.push(format!("... and {} more", count - LISTED));
    }
    let durations = study.scenes.iter().map(|scene| scene.record.duration);
    let shortest = durations.clone().fold(f64::INFINITY, f64::min);
    let longest = durations.fold(0.0, f64::max);
    let each = match longest > shortest {
        true => format!("{shortest} to {longest} s"),
        false => format!("{longest} s"),
    };
    let truths = study.plan.truths().min(count);
    let shared = match truths < count {
        // A drive that takes readings differs for each seed.
        true => format!("at least {truths} simulated, the others observe one of these"),
        false => "each simulated".to_owned(),
    };
    lines.push(format!("{count} runs of {each}; {shared}."));
    // A plan is what was asked for: also with --quiet.
    match Output::get().json {
        true => print_json(&json!({
            "runs": count,
            "truths": truths,
            "shortest_s": shortest,
            "longest_s": longest,
            "first": listed.iter().map(|(run, set)| json!({"run": run, "set": set})).collect::<Vec<_>>(),
        })),
        false => print(&lines.join("\n")),
    }
}

/// A bar on a terminal, else a line a minute.
struct Progress {
    bar: ProgressBar,
    failed: AtomicU64,
    /// Time of the last line; `None` on a terminal.
    line: Mutex<Option<Instant>>,
}

impl Progress {
    fn new() -> Self {
        let has_lines = !std::io::stderr().is_terminal() && !Output::get().quiet;
        Self {
            bar: bar(ProgressBar::new(0)),
            failed: AtomicU64::new(0),
            line: Mutex::new(has_lines.then(Instant::now)),
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
        if done > 0 && done < runs && !Output::get().quiet {
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
        if let Ok(mut line) = self.line.lock()
            && line.is_some_and(|last| last.elapsed() >= LINE_TIME)
        {
            *line = Some(Instant::now());
            let (bar, left) = (&self.bar, HumanDuration(self.bar.eta()));
            let (done, runs) = (bar.position(), bar.length().unwrap_or(0));
            let rate = bar.per_sec();
            eprintln!("{done} of {runs} runs, {rate:.2} a second, {left} left");
        }
    }
}

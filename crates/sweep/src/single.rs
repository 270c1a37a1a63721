//! One run and its scores.

use crate::error::{SweepError, io_error};
use crate::files;
use crate::journal::{Row, RunRecord};
use crate::scores::ScoreColumn;
use crate::sweep::Sweep;
use robhaz_record::{EstimatorSummary, Summary, SummarySink, TableFormat, TableSink};
use robhaz_run::{RunError, Stop, run_until};
use robhaz_scene::{Scene, SceneError};
use std::error::Error;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Computes a run. Its full tables go to `tables`, if given. `None` when `stop` named a cause.
///
/// # Errors
/// [`SweepError`] where the tables cannot be written. A run that fails for another reason is a record with this reason.
pub fn compute(
    sweep: &Sweep,
    run: u64,
    tables: Option<&Path>,
    stop: Stop<'_>,
) -> Result<Option<RunRecord>, SweepError> {
    // A panic is a mistake of ours. It ends its run, not the study.
    let computed = catch_unwind(AssertUnwindSafe(|| scores(sweep, run, tables, stop)));
    let failed = |reason: String| RunRecord {
        run,
        error: Some(reason),
        rows: vec![Row {
            estimator: None,
            scores: Vec::new(),
        }],
    };
    Ok(match computed {
        Ok(Ok(summary)) => Some(RunRecord {
            run,
            error: None,
            rows: rows(&summary),
        }),
        Ok(Err(Failure::Stopped)) => None,
        Ok(Err(Failure::Run(reason))) => Some(failed(reason)),
        Ok(Err(Failure::Sweep(error))) => return Err(error),
        Err(_) => Some(failed("internal error: the run panicked".to_owned())),
    })
}

/// Why a run has no scores.
enum Failure {
    Stopped,
    /// The reason, for the dataset.
    Run(String),
    Sweep(SweepError),
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        Self::Sweep(error)
    }
}

fn scores(
    sweep: &Sweep,
    run: u64,
    tables: Option<&Path>,
    stop: Stop<'_>,
) -> Result<Summary, Failure> {
    let scene = sweep.scene(run);
    let scene = scene.map_err(|error| Failure::Run(of_scene(&error)))?;
    let mut summary = SummarySink::new();
    let ended = match tables {
        None => run_until(&scene, &mut [&mut summary], stop),
        Some(folder) => {
            let temporary = prepare(sweep, &scene, folder)?;
            let mut table_sink = TableSink::new(&temporary, TableFormat::Parquet);
            let ended = run_until(&scene, &mut [&mut summary, &mut table_sink], stop);
            if !matches!(ended, Err(RunError::Stopped { .. } | RunError::Sink(_))) {
                files::settle(&temporary, folder)?;
            }
            ended
        }
    };
    match ended {
        Ok(_) => summary
            .summary()
            .map_err(|error| Failure::Run(in_one_line(&error))),
        Err(RunError::Stopped { .. }) => Err(Failure::Stopped),
        // Of the two sinks only that of the tables can fail: the disk.
        Err(RunError::Sink(error)) => {
            let cannot = io_error("write tables to", tables.unwrap_or(Path::new("")));
            Err(Failure::Sweep(cannot(std::io::Error::other(error))))
        }
        Err(error) => Err(Failure::Run(in_one_line(&error))),
    }
}

/// An empty folder for the tables of a run, with its scene and tracks.
fn prepare(sweep: &Sweep, scene: &Scene, folder: &Path) -> Result<PathBuf, SweepError> {
    let temporary = files::partial(folder);
    for old in [folder, &temporary] {
        // Of a run that was killed before its line was in the journal.
        if old.exists() {
            fs::remove_dir_all(old).map_err(io_error("remove", old))?;
        }
    }
    fs::create_dir_all(&temporary).map_err(io_error("create", &temporary))?;
    let version = &sweep.identity().version;
    let text = scene.to_toml(version).into_bytes();
    let tracks = scene.terrain.tracks.iter();
    let tracks = tracks.map(|track| (track.file_name(), track.bytes.to_vec()));
    for (name, content) in std::iter::once(("scene.toml".to_owned(), text)).chain(tracks) {
        let path = temporary.join(name);
        fs::write(&path, content).map_err(io_error("write", &path))?;
    }
    Ok(temporary)
}

fn rows(summary: &Summary) -> Vec<Row> {
    let row = |estimator: Option<&EstimatorSummary>| Row {
        estimator: estimator.map(|e| e.name.clone()),
        scores: ScoreColumn::all()
            .iter()
            .map(|column| column.value(summary, estimator))
            .collect(),
    };
    match summary.estimators.as_slice() {
        [] => vec![row(None)],
        estimators => estimators.iter().map(|e| row(Some(e))).collect(),
    }
}

/// The problems of a scene without the names of files, which differ between machines.
fn of_scene(error: &SceneError) -> String {
    let problems = error.problems().map(|p| match p.key() {
        "" => p.message().to_owned(),
        key => format!("{key}: {}", p.message()),
    });
    problems.collect::<Vec<_>>().join("; ")
}

/// An error with its causes.
fn in_one_line(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

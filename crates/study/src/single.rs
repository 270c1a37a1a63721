//! The truth of a scene, which several runs may share; one run and its scores.

use crate::error::Result;
use crate::folder::settle;
use crate::journal::{Row, RunRecord};
use crate::study::{Study, seen_by_plant};
use robhaz_record::{
    EstimatorSummary, ScoreColumn, Summary, SummarySink, TableFormat, TableSink, io_error,
};
use robhaz_run::{
    DrivenPlant, Frame, MOST_KEPT, Run, RunError, Sink, SinkError, Stop, in_one_line,
};
use robhaz_scene::{FileError, PlantFailure, Scene};
use robhaz_score::{Bound, Inclusion, Rule, SampleNoise};
use robhaz_sim::Truth;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The truth at every sample of a scene's sensors, kept in memory. One run serves all seeds:
/// without a control that takes readings it does not depend on sensor noise; with one it is the run
/// of the scene's own seed, which other seeds observe without driving.
#[derive(Clone, Debug)]
pub struct TruthRun(Arc<[Truth]>);

impl TruthRun {
    /// Simulates a scene with its engine.
    ///
    /// # Errors
    /// [`RunError`]: it is too long, cannot start or does not reach its end.
    pub fn of(scene: &Scene) -> Result<Self, RunError> {
        Self::simulate(scene, &|| None)
    }

    /// The same; `stop` is asked at every sample.
    pub(crate) fn simulate(scene: &Scene, stop: Stop<'_>) -> Result<Self, RunError> {
        let found = (scene.record.count() - 1) * scene.samples_per_record() + 1;
        if found > MOST_KEPT {
            let (of, who) = ("samples", "a study");
            return Err(RunError::TooLong { found, of, who });
        }
        let mut plant = DrivenPlant::new(scene, &scene.plant_setup())?;
        let next = |_| match stop() {
            Some(cause) => Err(RunError::Stopped { cause }),
            None => Ok(plant.next_truth().map_err(PlantFailure::from)?),
        };
        Ok(Self((0..found).map(next).collect::<Result<_, _>>()?))
    }

    /// Every sample.
    pub fn samples(&self) -> impl Iterator<Item = &Truth> {
        self.0.iter()
    }
}

/// What the runs of one truth share.
#[derive(Debug)]
pub enum SharedTruth {
    /// Nothing: each simulates its own.
    None,
    /// The truth, and what of its scene it depends on; `None` where it is that of all runs.
    Kept(TruthRun, Option<Box<Scene>>),
    /// The reason why there is none.
    Failed(String),
}

impl SharedTruth {
    /// Simulates the truth of several runs of a study, of which `run` is one. Without memory or
    /// without success each run simulates its own and has its reason.
    pub fn simulate(study: &Study, run: u64, stop: Stop<'_>) -> Self {
        let simulated = catch_unwind(AssertUnwindSafe(|| match study.driven() {
            Some(scene) => match TruthRun::simulate(scene, stop) {
                Ok(truth) => Self::Kept(truth, None),
                Err(error) => Self::Failed(in_one_line(&error)),
            },
            None => {
                let scene = study.scene(run).ok();
                let truth = scene.and_then(|scene| {
                    let truth = TruthRun::simulate(&scene, stop).ok()?;
                    Some((truth, Box::new(seen_by_plant(&scene))))
                });
                truth.map_or(Self::None, |(truth, seen)| Self::Kept(truth, Some(seen)))
            }
        }));
        simulated.unwrap_or(Self::None)
    }

    /// The run of a scene.
    fn run(&self, scene: &Scene) -> Result<Run, RunError> {
        let is_it = |seen: &Scene| *seen == seen_by_plant(scene);
        match self {
            Self::Kept(truth, seen) if seen.as_deref().is_none_or(is_it) => {
                Run::observing(scene, Arc::clone(&truth.0))
            }
            _ => Run::new(scene),
        }
    }
}

/// Computes a run. Its full tables go to `tables`, if given. `None` when `stop` named a cause.
///
/// # Errors
/// [`StudyError`] where the tables cannot be written. A run that fails for another reason is a
/// record with this reason.
pub fn compute(
    study: &Study,
    run: u64,
    truth: &SharedTruth,
    tables: Option<&Path>,
    stop: Stop<'_>,
) -> Result<Option<RunRecord>> {
    // The scores of the run, or why it has none.
    let outcome = || -> Result<Result<Vec<Row>, String>> {
        if let SharedTruth::Failed(reason) = truth {
            return Ok(Err(reason.clone()));
        }
        let scene = match study.scene(run) {
            Ok(scene) => scene,
            Err(error) => return Ok(Err(of_scene(&error))),
        };
        let temporary = tables.map(|folder| prepare(study, &scene, folder));
        let temporary = temporary.transpose()?;
        let table = |folder: &PathBuf| TableSink::new(folder, TableFormat::Parquet);
        let (mut summary, mut bound) = (SummarySink::new(), BoundSink::new(&scene));
        let mut table_sink = temporary.as_ref().map(table);
        let mut sinks: Vec<&mut dyn Sink> = vec![&mut summary, &mut bound];
        sinks.extend(table_sink.iter_mut().map(|sink| sink as &mut dyn Sink));
        let ready = truth.run(&scene);
        let ended = ready.and_then(|run| run.until(&mut sinks, stop));
        if let (Some(temporary), Some(folder)) = (&temporary, tables) {
            match ended {
                // Of the sinks only that of the tables can fail: the disk.
                Err(RunError::Sink(error)) => {
                    return Err(io_error("write tables to", folder)(error).into());
                }
                Err(RunError::Stopped { .. }) => {}
                _ => settle(temporary, folder)?,
            }
        }
        let summary = summary.summary().map_err(|error| in_one_line(&error));
        Ok(match ended {
            Ok(_) => summary.map(|summary| rows(&summary, bound.0.nrmse())),
            Err(error) => Err(in_one_line(&error)),
        })
    };
    // A panic is a mistake of ours. It ends its run, not the study.
    let computed = catch_unwind(AssertUnwindSafe(outcome));
    let panicked = |_| Ok(Err("internal error: the run panicked".to_owned()));
    let (error, rows) = match computed.unwrap_or_else(panicked)? {
        Ok(rows) => (None, rows),
        Err(_) if stop().is_some() => return Ok(None),
        Err(reason) => (Some(reason), vec![Row::default()]),
    };
    Ok(Some(RunRecord { run, error, rows }))
}

/// A sink for the Cramer-Rao bound.
pub struct BoundSink(pub Bound, Rule);

impl BoundSink {
    /// For a run of a scene.
    pub fn new(scene: &Scene) -> Self {
        let compare_from = scene.record.compare_from;
        let noise = SampleNoise::of(&scene.sensors.spec, scene.drive.gear_friction);
        let bound = Bound::new(noise, scene.robot.robot.clone());
        Self(bound, Rule { compare_from })
    }
}

impl Sink for BoundSink {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(truth) = frame.truth
            && let Inclusion::Included(compared) = self.1.judge(truth)
        {
            self.0.add(truth, &compared);
        }
        Ok(())
    }
}

/// An empty folder for the tables of a run, with its scene and tracks.
fn prepare(study: &Study, scene: &Scene, folder: &Path) -> Result<PathBuf> {
    let temporary = folder.with_added_extension("partial");
    for old in [folder, &temporary] {
        // Of a run that was killed before its line was in the journal.
        if old.exists() {
            fs::remove_dir_all(old).map_err(io_error("remove", old))?;
        }
    }
    fs::create_dir_all(&temporary).map_err(io_error("create", &temporary))?;
    for (name, content) in scene.files(&study.identity.version) {
        let path = temporary.join(name);
        fs::write(&path, content).map_err(io_error("write", &path))?;
    }
    Ok(temporary)
}

fn rows(run: &Summary, bound: Option<f64>) -> Vec<Row> {
    let row = |estimator: Option<(&String, &EstimatorSummary)>| Row {
        estimator: estimator.map(|(name, _)| name.clone()),
        scores: (ScoreColumn::all().iter())
            .map(|column| column.value(run, bound, estimator.map(|(_, e)| e)))
            .collect(),
    };
    match run.estimators.is_empty() {
        true => vec![row(None)],
        false => run.estimators.iter().map(|e| row(Some(e))).collect(),
    }
}

/// The problems of a scene without the names of files, which differ between machines.
fn of_scene(error: &FileError) -> String {
    let problems = error.problems.iter().map(|p| match p.key.as_str() {
        "" => p.message.clone(),
        key => format!("{key}: {}", p.message),
    });
    problems.collect::<Vec<_>>().join("; ")
}

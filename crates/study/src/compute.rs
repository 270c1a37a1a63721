//! The runs of a shard, on several threads.

use crate::dataset;
use crate::error::{Result, StudyError};
use crate::folder::{DATASET, Folder, Shard};
use crate::journal::{Journal, RunRecord, scan};
use crate::single::{self, SharedTruth};
use crate::study::Study;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use robhaz_record::{Dataset, io_error};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Callbacks of a computation: its progress, and a cause to stop it.
pub struct Watch<'a> {
    /// Called once with the number of runs of the shard that are done already, and of all.
    pub begin: &'a (dyn Fn(u64, u64) + Sync),
    /// Called after every run.
    pub finished: &'a (dyn Fn(&RunRecord) + Sync),
    /// A cause to stop, or `None` to go on. Runs in flight are given up.
    pub stop: &'a (dyn Fn() -> Option<&'static str> + Sync),
}

impl Watch<'_> {
    /// Hears of nothing and never stops.
    pub const SILENT: Self = Self {
        begin: &|_, _| {},
        finished: &|_| {},
        stop: &|| None,
    };
}

/// A shard without runs left.
#[derive(Clone, Debug)]
pub struct Done {
    /// Runs of the shard.
    pub runs: u64,
    /// Runs that this call has computed.
    pub computed: u64,
    /// Damaged lines of the journals, whose runs were computed again.
    pub damaged: u64,
    /// The dataset; `None` of a shard.
    pub dataset: Option<PathBuf>,
}

/// Computes the missing runs of a shard in the folder of its study, on `jobs` threads, at least 1.
/// With all runs of the study it makes the dataset, of whichever shards have computed them in its
/// folder.
///
/// # Errors
/// [`StudyError`]; [`StudyError::Stopped`] when the caller stopped it. Finished runs stay in the
/// folder.
pub fn compute(
    study: &Study,
    folder: &Path,
    shard: Shard,
    jobs: usize,
    watch: &Watch<'_>,
) -> Result<Done> {
    let folder = Folder::open(folder, &study.identity)?;
    let (dataset, hash) = (folder.dataset(), &study.identity.sha256);
    let runs = shard.count(study.plan.runs());
    let done = |computed, damaged, dataset| Done {
        runs,
        computed,
        damaged,
        dataset,
    };
    if dataset.exists() {
        folder.tidy()?;
        (watch.begin)(runs, runs);
        return Ok(done(0, 0, Some(dataset)));
    }
    let own = folder.journal(shard);
    let mut finished = HashSet::new();
    let mut add = |record: RunRecord| {
        finished.insert(record.run);
    };
    let (journal, scanned) = Journal::open(&own, hash, &mut add)?;
    let mut damaged = scanned.damaged;
    // Where the dataset is made of other shards' journals, no process may have one open.
    let mut others = Vec::new();
    for path in folder.journals()?.iter().filter(|path| **path != own) {
        if shard == Shard::ALL {
            let (journal, scanned) = Journal::open(path, hash, &mut add)?;
            damaged += scanned.damaged;
            others.push(journal);
        } else {
            damaged += scan(path, hash, &mut add)?.damaged;
        }
    }
    let work = Work {
        study,
        folder: &folder,
        is_pending: &|run| shard.has(run) && !finished.contains(&run),
        journal: Mutex::new(journal),
        watch,
    };
    let computed = work.run(jobs, runs);
    lock(&work.journal).sync()?;
    let computed = computed?;
    if shard != Shard::ALL {
        return Ok(done(computed, damaged, None));
    }
    dataset::write(study, &folder)?;
    folder.tidy()?;
    Ok(done(computed, damaged, Some(dataset)))
}

/// Computes all runs on `jobs` threads, in a temporary folder. Returns the dataset.
///
/// # Errors
/// As [`compute`]. When the caller stopped it, nothing stays.
pub fn compute_dataset(study: &Study, jobs: usize, watch: &Watch<'_>) -> Result<Dataset> {
    let folder = tempfile::tempdir().map_err(io_error("create", &std::env::temp_dir()))?;
    let mut done = compute(study, folder.path(), Shard::ALL, jobs, watch);
    if let Err(StudyError::Stopped { after, .. }) = &mut done {
        *after = "nothing was written; with --out DIR the same command goes on where it stopped";
    }
    done?;
    Ok(Dataset::read(&folder.path().join(DATASET))?)
}

/// What the threads share.
struct Work<'a> {
    study: &'a Study,
    /// Where tables go.
    folder: &'a Folder,
    is_pending: &'a (dyn Fn(u64) -> bool + Sync),
    journal: Mutex<Journal>,
    watch: &'a Watch<'a>,
}

impl Work<'_> {
    /// Computes the pending ones of `runs` runs on `jobs` threads. Returns how many were computed.
    fn run(&self, jobs: usize, runs: u64) -> Result<u64> {
        let left = (0..self.study.plan.runs()).filter(|run| (self.is_pending)(*run));
        let left = left.count() as u64;
        (self.watch.begin)(runs - left, runs);
        let pool = ThreadPoolBuilder::new().num_threads(jobs).build()?;
        let truths = (0..self.study.plan.truths()).into_par_iter();
        let computed = pool.install(|| sum(truths.map(|truth| self.of_truth(truth))))?;
        match (self.watch.stop)().filter(|_| computed < left) {
            None => Ok(computed),
            Some(cause) => Err(StudyError::Stopped {
                cause,
                done: runs - left + computed,
                runs,
                after: "the same command goes on where it stopped",
            }),
        }
    }

    /// Computes the pending runs of one truth. Returns how many.
    fn of_truth(&self, truth: u64) -> Result<u64> {
        let plan = &self.study.plan;
        let runs = || (0..plan.runs_of_truth()).map(|place| plan.run(truth, place));
        let mut pending = runs().filter(|run| (self.is_pending)(*run));
        let (Some(first), second) = (pending.next(), pending.next()) else {
            return Ok(0);
        };
        if (self.watch.stop)().is_some() {
            return Ok(0);
        }
        // The truth of a single run is not kept, but for a scene, whose control may be driven by
        // another seed.
        let shared = match second.is_some() || self.study.driven().is_some() {
            true => SharedTruth::simulate(self.study, first, self.watch.stop),
            false => SharedTruth::None,
        };
        let places = (0..plan.runs_of_truth()).into_par_iter();
        let pending = places.map(|place| plan.run(truth, place));
        let pending = pending.filter(|run| (self.is_pending)(*run));
        sum(pending.map(|run| self.one(run, &shared).map(u64::from)))
    }

    /// Whether a run was computed; otherwise it was stopped.
    fn one(&self, run: u64, truth: &SharedTruth) -> Result<bool> {
        let stop = self.watch.stop;
        if stop().is_some() {
            return Ok(false);
        }
        let keeps = self.study.choice.tables.keeps(run);
        let tables = keeps.then(|| self.folder.tables(run));
        let record = single::compute(self.study, run, truth, tables.as_deref(), stop)?;
        let Some(record) = record else {
            return Ok(false);
        };
        (self.watch.finished)(&record);
        lock(&self.journal).append(&record)?;
        Ok(true)
    }
}

/// The sum of counts; after an error no further one is begun.
fn sum(counts: impl ParallelIterator<Item = Result<u64>>) -> Result<u64> {
    counts.try_reduce(|| 0, |a, b| Ok(a + b))
}

/// A panic of another thread leaves no half-changed value behind: all changes are single calls.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

//! The runs of a shard, on several threads.

use crate::dataset::{self, Finished};
use crate::error::SweepError;
use crate::folder::Folder;
use crate::journal::{Journal, RunRecord, Scanned, scan};
use crate::single;
use crate::sweep::Sweep;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A part of the runs, for one of several machines: every `of`-th run from the `part`-th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u64,
    of: NonZeroU64,
}

impl Shard {
    /// All runs.
    pub const ALL: Self = Self {
        part: 1,
        of: NonZeroU64::MIN,
    };

    /// Part `part` of `of`, from 1 on; `None` if there is no such part.
    pub fn new(part: u64, of: u64) -> Option<Self> {
        let of = NonZeroU64::new(of)?;
        (1..=of.get()).contains(&part).then_some(Self { part, of })
    }

    /// Whether a run belongs to it.
    pub fn has(&self, run: u64) -> bool {
        run % self.of == self.part - 1
    }

    /// How many of `runs` runs belong to it.
    pub fn count(&self, runs: u64) -> u64 {
        (runs + self.of.get() - self.part) / self.of
    }
}

/// What is to be computed, and where it is written.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// Folder of the sweep.
    pub folder: &'a Path,
    /// Its part of the runs.
    pub shard: Shard,
    /// Number of threads, at least 1.
    pub jobs: usize,
}

/// What the caller hears of, and how it stops.
pub struct Watch<'a> {
    /// Called once with the number of runs of the shard that are done already, and of all.
    pub begin: &'a (dyn Fn(u64, u64) + Sync),
    /// Called after every run.
    pub finished: &'a (dyn Fn(&RunRecord) + Sync),
    /// A cause to stop, or `None` to go on. Runs in flight are given up.
    pub stop: &'a (dyn Fn() -> Option<&'static str> + Sync),
}

/// A shard without runs left.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// Runs of the shard.
    pub runs: u64,
    /// Runs that this call has computed.
    pub computed: u64,
    /// Damaged lines of the journal, whose runs were computed again.
    pub damaged: u64,
    /// The dataset; `None` where runs of other shards are missing in this folder.
    pub dataset: Option<PathBuf>,
}

/// Computes the missing runs of a shard. When the folder has all runs of the study, it makes the dataset.
///
/// # Errors
/// [`SweepError`]; [`SweepError::Stopped`] when the caller stopped it. Finished runs stay.
pub fn compute(sweep: &Sweep, job: &Job<'_>, watch: &Watch<'_>) -> Result<Done, SweepError> {
    let folder = Folder::open(job.folder, sweep.identity())?;
    let runs = job.shard.count(sweep.runs());
    if folder.dataset().exists() {
        let dataset = Some(folder.dataset());
        folder.tidy()?;
        (watch.begin)(runs, runs);
        return Ok(Done {
            runs,
            computed: 0,
            damaged: 0,
            dataset,
        });
    }
    let Scanned {
        places,
        length,
        damaged,
    } = scan(&folder.journal())?;
    let mut finished = Finished::new(sweep.runs());
    finished.add(0, &places);
    drop(places);
    let pending = || (0..sweep.runs()).filter(|run| job.shard.has(*run) && !finished.has(*run));
    let left = pending().count() as u64;
    (watch.begin)(runs - left, runs);
    let journal = Mutex::new(Journal::open(&folder.journal(), length)?);
    let computed = work(
        sweep,
        &folder,
        job.jobs,
        &Mutex::new(pending()),
        &journal,
        watch,
    )?;
    if let Some(cause) = (watch.stop)().filter(|_| computed < left) {
        return Err(SweepError::Stopped {
            cause,
            done: runs - left + computed,
            runs,
        });
    }
    let dataset = match dataset::merge(sweep.identity(), sweep.plan(), &folder) {
        Ok(path) => Some(path),
        Err(SweepError::Incomplete { .. }) => None,
        Err(error) => return Err(error),
    };
    if dataset.is_some() {
        folder.tidy()?;
    }
    Ok(Done {
        runs,
        computed,
        damaged,
        dataset,
    })
}

/// Computes pending runs on `jobs` threads. Returns how many were finished.
fn work(
    sweep: &Sweep,
    folder: &Folder,
    jobs: usize,
    pending: &Mutex<impl Iterator<Item = u64> + Send>,
    journal: &Mutex<Journal>,
    watch: &Watch<'_>,
) -> Result<u64, SweepError> {
    // The first error ends all threads.
    let failure: Mutex<Option<SweepError>> = Mutex::new(None);
    let stop = || match lock(&failure).is_some() {
        true => Some("an error"),
        false => (watch.stop)(),
    };
    let one = |run: u64| -> Result<bool, SweepError> {
        let tables = sweep.study().tables.keeps(run).then(|| folder.tables(run));
        let Some(record) = single::compute(sweep, run, tables.as_deref(), &stop)? else {
            return Ok(false);
        };
        lock(journal).append(&record)?;
        (watch.finished)(&record);
        Ok(true)
    };
    let worker = || {
        let mut computed = 0;
        while stop().is_none() {
            let Some(run) = lock(pending).next() else {
                break;
            };
            match one(run) {
                Ok(true) => computed += 1,
                Ok(false) => break,
                Err(error) => {
                    lock(&failure).get_or_insert(error);
                    break;
                }
            }
        }
        computed
    };
    let computed = std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for i in 0..jobs.max(1) {
            let builder = std::thread::Builder::new().name(format!("run-{i}"));
            threads.push(
                builder
                    .spawn_scoped(scope, worker)
                    .map_err(SweepError::Thread)?,
            );
        }
        let mut computed = 0;
        for thread in threads {
            computed += thread.join().map_err(|_| SweepError::Panic)?;
        }
        Ok::<u64, SweepError>(computed)
    })?;
    lock(journal).sync()?;
    let failure = failure.into_inner().unwrap_or_else(PoisonError::into_inner);
    failure.map_or(Ok(computed), Err)
}

/// A panic of another thread leaves no half-changed value behind: all changes are single calls.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: every run belongs to one shard, and the shards count right.
    #[test]
    fn shards_share_all_runs() {
        for (runs, of) in [(0, 1), (1, 3), (10, 3), (12, 4), (5, 7)] {
            let shards: Vec<Shard> = (1..=of).filter_map(|part| Shard::new(part, of)).collect();
            assert_eq!(shards.len() as u64, of);
            for shard in &shards {
                let count = (0..runs).filter(|run| shard.has(*run)).count() as u64;
                assert_eq!(count, shard.count(runs), "{shard:?} of {runs}");
            }
            for run in 0..runs {
                assert_eq!(shards.iter().filter(|shard| shard.has(run)).count(), 1);
            }
        }
        assert_eq!((Shard::new(0, 3), Shard::new(4, 3)), (None, None));
        assert_eq!(Shard::new(1, 0), None);
    }
}

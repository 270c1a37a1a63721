//! From samples to records: in one loop, or on several threads, so that source, estimation and sinks
//! do not wait for each other.
//!
//! Several threads take a source that does not depend on the estimates: recorded readings, or a
//! simulation whose control takes none. Samples pass from thread to thread in batches and in their
//! order, and the estimators of a run work at the same time, each on its own samples in order: the
//! estimates have the bits of one loop.
//!
//! ```text
//! source --samples--> estimators and clearance, side by side --records--> sinks
//! ```

use crate::clearance::TruthClearance;
use crate::driver::Driver;
use crate::error::{Result, RunError};
use crate::estimators::Estimators;
use crate::record::{BothFrame, EstimatedTerrain, Frame};
use crate::source::{Sample, Source};
use crate::ticker::Ticker;
use rayon::{ThreadPool, ThreadPoolBuilder};
use robhaz_estimator::whole::WholeEstimate;
use robhaz_estimator::{Estimate, EstimateError, GroundPoint};
use robhaz_model::WheelCommand;
use robhaz_sim::clearance::Clearances;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Most samples of a batch: a tenth of a second at 1 kHz, and some MB of estimates.
const BATCH: usize = 100;
/// Most samples of a batch in one loop without a control: their estimates stay in the cache of a core.
const FEW: usize = 8;
/// Time from one record with the ground in the memory of the estimators to the next, s. Such a
/// record ends its batch.
const GROUND_PERIOD: f64 = 0.2;
/// Batches that wait before each thread.
const WAITING: usize = 1;

/// Samples that were read together, and what follows from them. The batch goes back to the source
/// when its records have been handed on: so its memory, some MB, is taken from the system once and
/// not for each batch.
#[derive(Default)]
struct Batch {
    samples: Vec<Sample>,
    /// Whether the last sample is a record with the ground in memory.
    ends_with_ground: bool,
    /// Why there are no more samples.
    failure: Option<RunError>,
    /// Estimates of one sample after the other.
    estimates: Vec<Result<Estimate, EstimateError>>,
    /// Of the control, in one loop.
    commands: Option<[WheelCommand; 3]>,
    /// Estimates of both sides, one a sample of a log of both.
    wholes: Vec<Option<WholeEstimate>>,
    /// Clearances of one record after the other; none for recorded readings.
    clearances: Vec<Clearances>,
    /// Points of the ground that each estimator has completed.
    completed: Vec<Vec<GroundPoint>>,
    /// Points in the memory of each estimator, for the last sample; none where it does not have
    /// them.
    memory: Vec<Vec<GroundPoint>>,
}

/// What computes the records of a run.
pub(crate) struct Work {
    pub source: Box<dyn Source + Send>,
    pub estimators: Estimators,
    /// The control, where it takes readings.
    pub driver: Option<Driver>,
    /// At records alone. `None` for recorded readings.
    pub clearance: Option<TruthClearance>,
    /// Time of source, estimation and control; on several threads that of the slower one.
    pub wall: Duration,
}

impl Work {
    /// Hands every record of the source with its estimates to `hand_on`, in order of time, until the
    /// source ends or `hand_on` fails. Points of the ground that no record has had stay with the
    /// estimators. The control drives the source.
    ///
    /// # Errors
    /// That of the source, after the samples before it, or that of `hand_on`.
    pub fn in_one_loop(&mut self, mut hand_on: impl FnMut(&[Frame<'_>]) -> Result) -> Result {
        let (mut batch, mut next_ground) = (Batch::default(), Ticker::new(GROUND_PERIOD));
        let mut left = vec![Vec::new(); self.estimators.count()];
        let (mut result, mut is_last) = (Ok(()), false);
        // Commands act from the next sample on.
        let most = if self.driver.is_some() { 1 } else { FEW };
        while result.is_ok() && !is_last {
            let start = Instant::now();
            is_last = batch.fill(most, self.source.as_mut(), &mut next_ground);
            batch.estimate(&mut self.estimators, self.clearance.as_mut(), None);
            if let (Some(driver), Some(sample)) = (&mut self.driver, batch.samples.first()) {
                let commands = driver.commands(&sample.sensors, &batch.estimates);
                self.source.command(commands);
                batch.commands = Some(commands);
            }
            self.wall += start.elapsed();
            result = batch.hand_on(&mut hand_on, &mut left);
        }
        self.estimators.completed = left;
        result
    }

    /// The same on several threads, without the control.
    ///
    /// # Errors
    /// As [`Self::in_one_loop`]; [`RunError::Threads`].
    pub fn on_threads(&mut self, mut hand_on: impl FnMut(&[Frame<'_>]) -> Result) -> Result {
        // Its own threads: those of a study may all wait for runs like this one.
        let pool = ThreadPoolBuilder::new().build()?;
        let is_over = AtomicBool::new(false);
        let mut result = Ok(());
        let mut left = vec![Vec::new(); self.estimators.count()];
        thread::scope(|scope| {
            let (samples, read) = sync_channel(WAITING);
            let (batches, estimated) = sync_channel(WAITING);
            let (used, spare) = channel();
            let (is_over, source) = (&is_over, self.source.as_mut());
            let (estimators, clearance) = (&mut self.estimators, self.clearance.as_mut());
            let reading = scope.spawn(move || read_all(source, &spare, &samples, is_over));
            let estimation =
                scope.spawn(move || estimate_all(&pool, estimators, clearance, &read, &batches));
            // To the end of both threads, so that none waits for ever.
            for mut batch in estimated {
                if result.is_ok() {
                    result = batch.hand_on(&mut hand_on, &mut left);
                    is_over.store(result.is_err(), Ordering::Relaxed);
                } else {
                    keep(&mut left, &mut batch.completed);
                }
                // At the end the source has gone.
                let _ = used.send(batch);
            }
            let times = [reading.join(), estimation.join()].map(|end| match end {
                Ok(time) => time,
                Err(panic) => std::panic::resume_unwind(panic),
            });
            self.wall += times[0].max(times[1]);
        });
        self.estimators.completed = left;
        result
    }
}

/// Takes samples to the end of the source, or until the run is over. Returns the time that it took.
fn read_all(
    source: &mut dyn Source,
    spare: &Receiver<Batch>,
    out: &SyncSender<Batch>,
    is_over: &AtomicBool,
) -> Duration {
    let mut time = Duration::ZERO;
    let mut next_ground = Ticker::new(GROUND_PERIOD);
    while !is_over.load(Ordering::Relaxed) {
        let start = Instant::now();
        let mut batch = spare.try_recv().unwrap_or_default();
        let is_last = batch.fill(BATCH, source, &mut next_ground);
        time += start.elapsed();
        if out.send(batch).is_err() || is_last {
            break;
        }
    }
    time
}

/// Estimates all samples on the threads of `pool`. Returns the time that it took.
fn estimate_all(
    pool: &ThreadPool,
    estimators: &mut Estimators,
    mut clearance: Option<&mut TruthClearance>,
    read: &Receiver<Batch>,
    out: &SyncSender<Batch>,
) -> Duration {
    let mut time = Duration::ZERO;
    for mut batch in read {
        let start = Instant::now();
        batch.estimate(estimators, clearance.as_deref_mut(), Some(pool));
        time += start.elapsed();
        if out.send(batch).is_err() {
            break;
        }
    }
    time
}

impl Batch {
    /// Takes the next samples of a source, at most `most`. Returns whether they are the last.
    fn fill(&mut self, most: usize, source: &mut dyn Source, next_ground: &mut Ticker) -> bool {
        self.samples.clear();
        self.ends_with_ground = false;
        while self.samples.len() < most && !self.ends_with_ground {
            match source.next_sample() {
                Ok(Some(sample)) => {
                    self.ends_with_ground = sample.is_record && next_ground.is_due(sample.time);
                    self.samples.push(sample);
                }
                Ok(None) => return true,
                Err(error) => {
                    self.failure = Some(error);
                    return true;
                }
            }
        }
        false
    }

    /// Estimates its samples, on the threads of a pool if there is one.
    fn estimate(
        &mut self,
        estimators: &mut Estimators,
        clearance: Option<&mut TruthClearance>,
        pool: Option<&ThreadPool>,
    ) {
        let (samples, clearances) = (&self.samples, &mut self.clearances);
        clearances.clear();
        let measure = || {
            let records = samples.iter().filter(|sample| sample.is_record);
            let truths = records.filter_map(|sample| sample.truth.as_ref());
            let measured = clearance.map(|c| truths.map(|truth| c.at(truth)));
            clearances.extend(measured.into_iter().flatten());
        };
        let (estimates, wholes) = (&mut self.estimates, &mut self.wholes);
        let mut update = || estimators.update_all(samples, estimates, wholes, pool.is_some());
        match pool {
            Some(pool) => drop(pool.join(update, measure)),
            None => {
                update();
                measure();
            }
        }
        // Empty since its records were handed on.
        self.completed.resize(estimators.count(), Vec::new());
        std::mem::swap(&mut self.completed, &mut estimators.completed);
        self.memory = match self.ends_with_ground {
            true => estimators.memory(),
            false => Vec::new(),
        };
    }

    /// Hands its records on. The points of the ground go with the last one.
    fn hand_on(
        &mut self,
        to: &mut impl FnMut(&[Frame<'_>]) -> Result,
        left: &mut [Vec<GroundPoint>],
    ) -> Result {
        let (samples, count) = (&self.samples, left.len());
        let last = samples.iter().rposition(|sample| sample.is_record);
        keep(left, &mut self.completed);
        let mut clearances = self.clearances.iter();
        let ground = EstimatedTerrain {
            memory: &self.memory,
            completed: left,
        };
        let recorded = samples.iter().enumerate().filter(|(_, s)| s.is_record);
        let estimates = |k: usize| self.estimates.get(k * count..(k + 1) * count);
        let frames: Vec<Frame<'_>> = recorded
            .map(|(k, sample)| Frame {
                time: sample.time,
                truth: sample.truth.as_ref(),
                clearances: clearances.next().copied(),
                sensors: &sample.sensors,
                both: sample.both.as_deref().map(|sides| BothFrame {
                    sides,
                    estimate: self.wholes.get(k).and_then(Option::as_ref),
                }),
                estimates: estimates(k).unwrap_or_default(),
                commands: self.commands,
                ground: match last == Some(k) {
                    true => ground,
                    false => EstimatedTerrain::default(),
                },
            })
            .collect();
        if !frames.is_empty() {
            to(&frames)?;
            left.iter_mut().for_each(Vec::clear);
        }
        self.failure.take().map_or(Ok(()), Err)
    }
}

/// Adds completed points to those that no record has had.
fn keep(left: &mut [Vec<GroundPoint>], completed: &mut [Vec<GroundPoint>]) {
    for (left, completed) in left.iter_mut().zip(completed) {
        left.append(completed);
    }
}

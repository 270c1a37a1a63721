//! A run on several threads: source, estimation and sinks do not wait for each other.
//!
//! This takes a source that does not depend on the estimates: recorded readings, or a simulation
//! whose control takes none. Samples pass from thread to thread in batches and in their order, and
//! the estimators of a run work at the same time, each on its own samples in order: the estimates
//! have the bits of one loop.
//!
//! ```text
//! source --samples--> estimators and clearance, side by side --records--> sinks
//! ```

use crate::both::BothFrame;
use crate::clearance::TruthClearance;
use crate::error::{Result, RunError};
use crate::estimators::Estimators;
use crate::ground::EstimatedTerrain;
use crate::sink::Frame;
use crate::source::{Sample, Source};
use crate::ticker::Ticker;
use rayon::{ThreadPool, ThreadPoolBuilder};
use robhaz_estimator::whole::WholeEstimate;
use robhaz_estimator::{Estimate, EstimateError, GroundPoint};
use robhaz_sim::clearance::Clearances;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Most samples of a batch: a tenth of a second at 1 kHz, and some MB of estimates.
const BATCH: usize = 100;
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
    /// Estimates of both sides, one a sample of a log of both.
    wholes: Vec<Option<WholeEstimate>>,
    /// Clearances of one record after the other, where a sink needs them; none for recorded
    /// readings.
    clearances: Vec<Option<Clearances>>,
    /// Points of the ground that each estimator has completed.
    completed: Vec<Vec<GroundPoint>>,
    /// Points in the memory of each estimator, for the last sample; none where it does not have
    /// them.
    memory: Vec<Vec<GroundPoint>>,
}

/// Hands every record of a source with its estimates to `hand_on`, some at once and in order of
/// time, until the source ends or `hand_on` fails. Points of the ground that no record has had stay
/// with the estimators. Adds the time of the slower one of source and estimation to `wall`.
///
/// # Errors
/// That of the source, after the samples before it, or that of `hand_on`; [`RunError::Threads`].
pub(crate) fn run(
    source: &mut (dyn Source + Send),
    estimators: &mut Estimators,
    clearance: Option<&mut TruthClearance>,
    wall: &mut Duration,
    mut hand_on: impl FnMut(&[Frame<'_>]) -> Result,
) -> Result {
    let count = estimators.count();
    // Its own threads: those of a study may all wait for runs like this one.
    let pool = ThreadPoolBuilder::new().build()?;
    let is_over = AtomicBool::new(false);
    let mut result = Ok(());
    let mut left = vec![Vec::new(); count];
    thread::scope(|scope| {
        let (samples, read) = sync_channel(WAITING);
        let (batches, estimated) = sync_channel(WAITING);
        let (used, spare) = channel();
        let is_over = &is_over;
        let estimators = &mut *estimators;
        let reading = scope.spawn(move || read_all(source, &spare, &samples, is_over));
        let estimation =
            scope.spawn(move || estimate_all(&pool, estimators, clearance, &read, &batches));
        // To the end of both threads, so that none waits for ever.
        for mut batch in estimated {
            if result.is_ok() {
                result = records(&mut batch, count, &mut hand_on, &mut left);
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
        *wall += times[0].max(times[1]);
    });
    estimators.completed = left;
    result
}

/// Takes samples to the end of the source, or until the run is over. Returns the time that it took.
fn read_all(
    source: &mut (dyn Source + Send),
    spare: &Receiver<Batch>,
    out: &SyncSender<Batch>,
    is_over: &AtomicBool,
) -> Duration {
    let mut time = Duration::ZERO;
    let mut next_ground = Ticker::new(GROUND_PERIOD);
    while !is_over.load(Ordering::Relaxed) {
        let start = Instant::now();
        let mut batch = spare.try_recv().unwrap_or_default();
        let is_last = fill(&mut batch, source, &mut next_ground);
        time += start.elapsed();
        if out.send(batch).is_err() || is_last {
            break;
        }
    }
    time
}

/// Puts the next samples of a source into a batch. Returns whether they are the last.
fn fill(batch: &mut Batch, source: &mut dyn Source, next_ground: &mut Ticker) -> bool {
    batch.samples.clear();
    batch.ends_with_ground = false;
    while batch.samples.len() < BATCH && !batch.ends_with_ground {
        match source.next_sample() {
            Ok(Some(sample)) => {
                batch.ends_with_ground = sample.is_record && next_ground.is_due(sample.time);
                batch.samples.push(sample);
            }
            Ok(None) => return true,
            Err(error) => {
                batch.failure = Some(error);
                return true;
            }
        }
    }
    false
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
        let Batch {
            samples,
            estimates,
            wholes,
            clearances,
            ..
        } = &mut batch;
        match clearance.as_mut() {
            None => pool.install(|| estimators.update_all(samples, estimates, wholes)),
            Some(clearance) => {
                let records = samples.iter().filter(|sample| sample.is_record);
                let truths = records.filter_map(|sample| sample.truth.as_ref());
                let of_truths = truths.map(|truth| clearance.for_sinks(truth));
                clearances.clear();
                pool.join(
                    || estimators.update_all(samples, estimates, wholes),
                    || clearances.extend(of_truths),
                );
            }
        }
        time += start.elapsed();
        let none = vec![Vec::new(); estimators.count()];
        batch.completed = std::mem::replace(&mut estimators.completed, none);
        batch.memory = match batch.ends_with_ground {
            true => estimators.memory(),
            false => Vec::new(),
        };
        if out.send(batch).is_err() {
            break;
        }
    }
    time
}

/// Hands the records of a batch on. The points of the ground go with the last one.
fn records(
    batch: &mut Batch,
    count: usize,
    hand_on: &mut impl FnMut(&[Frame<'_>]) -> Result,
    left: &mut [Vec<GroundPoint>],
) -> Result {
    let samples = &batch.samples;
    let last = samples.iter().rposition(|sample| sample.is_record);
    keep(left, &mut batch.completed);
    let mut clearances = batch.clearances.iter();
    let ground = EstimatedTerrain {
        estimators: &[],
        copies: &batch.memory,
        completed: left,
    };
    let recorded = samples.iter().enumerate().filter(|(_, s)| s.is_record);
    let estimates = |k: usize| batch.estimates.get(k * count..(k + 1) * count);
    let frames: Vec<Frame<'_>> = recorded
        .map(|(k, sample)| Frame {
            time: sample.time,
            truth: sample.truth.as_ref(),
            clearances: clearances.next().copied().flatten(),
            sensors: &sample.sensors,
            both: sample.both.as_deref().map(|sides| BothFrame {
                sides,
                estimate: batch.wholes.get(k).and_then(Option::as_ref),
            }),
            estimates: estimates(k).unwrap_or_default(),
            commands: None,
            ground: match last == Some(k) {
                true => ground,
                false => EstimatedTerrain::default(),
            },
        })
        .collect();
    if !frames.is_empty() {
        hand_on(&frames)?;
        left.iter_mut().for_each(Vec::clear);
    }
    batch.failure.take().map_or(Ok(()), Err)
}

/// Adds completed points to those that no record has had.
fn keep(left: &mut [Vec<GroundPoint>], completed: &mut [Vec<GroundPoint>]) {
    for (left, completed) in left.iter_mut().zip(completed) {
        left.append(completed);
    }
}

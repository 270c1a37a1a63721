//! Recorded readings on several threads: reading, estimation and sinks do not wait for each other.
//!
//! Recorded readings do not depend on what follows from them. Samples pass from thread to thread in batches and in their
//! order, and the estimators of a run work at the same time, each on its own samples in order: the estimates have the bits
//! of one loop.
//!
//! ```text
//! reading --samples--> estimators, side by side --estimates--> sinks
//! ```

use crate::error::RunError;
use crate::estimators::Estimators;
use crate::source::{Sample, Source};
use robhaz_estimator::{Estimate, EstimateError, GroundPoint};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Samples of a batch: a quarter of a second at 1 kHz, and some MB of estimates.
const BATCH: usize = 256;
/// Batches that wait before each thread.
const WAITING: usize = 2;

/// Samples that were read together.
struct Samples {
    samples: Vec<Sample>,
    /// Why there are no more.
    failure: Option<RunError>,
}

/// Samples and their estimates.
struct Batch {
    samples: Samples,
    /// Estimates of one sample after the other.
    estimates: Vec<Result<Estimate, EstimateError>>,
    /// Points of the ground that each estimator has completed.
    completed: Vec<Vec<GroundPoint>>,
}

/// A sample, its estimates, and the points of the ground that each estimator has completed since the last record.
pub(crate) type Record<'a> = (
    &'a Sample,
    &'a [Result<Estimate, EstimateError>],
    &'a [Vec<GroundPoint>],
);

/// Hands every sample of a source with its estimates to `record`, in order of time, until the source ends or `record` fails.
/// Points of the ground that no record has had stay with the estimators. Adds the time of the slower one of reading and
/// estimation to `wall`.
///
/// # Errors
/// That of the source, after the samples before it, or that of `record`.
pub(crate) fn run(
    source: &mut (dyn Source + Send),
    estimators: &mut Estimators,
    wall: &mut Duration,
    mut record: impl FnMut(Record<'_>) -> Result<(), RunError>,
) -> Result<(), RunError> {
    let count = estimators.count();
    let is_over = AtomicBool::new(false);
    let mut result = Ok(());
    let mut left = vec![Vec::new(); count];
    thread::scope(|scope| {
        let (samples, read) = sync_channel(WAITING);
        let (batches, estimated) = sync_channel(WAITING);
        let is_over = &is_over;
        let estimators = &mut *estimators;
        let reading = scope.spawn(move || read_all(source, &samples, is_over));
        let estimation = scope.spawn(move || estimate_all(estimators, &read, &batches));
        // To the end of both threads, so that none waits for ever.
        for batch in estimated {
            if result.is_ok() {
                result = records(batch, count, &mut record, &mut left);
                is_over.store(result.is_err(), Ordering::Relaxed);
            } else {
                keep(&mut left, batch.completed);
            }
        }
        let times = [reading.join(), estimation.join()].map(|end| match end {
            Ok(time) => time,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        *wall += times[0].max(times[1]);
    });
    estimators.set_completed(left);
    result
}

/// Reads the source to its end, or until the run is over. Returns the time that it took.
fn read_all(
    source: &mut (dyn Source + Send),
    out: &SyncSender<Samples>,
    is_over: &AtomicBool,
) -> Duration {
    let mut time = Duration::ZERO;
    while !is_over.load(Ordering::Relaxed) {
        let start = Instant::now();
        let mut samples = Vec::with_capacity(BATCH);
        let mut failure = None;
        while samples.len() < BATCH {
            match source.next_sample() {
                Ok(Some(sample)) => samples.push(sample),
                Ok(None) => break,
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            }
        }
        time += start.elapsed();
        let is_last = samples.len() < BATCH;
        let sent = out.send(Samples { samples, failure });
        if is_last || sent.is_err() {
            break;
        }
    }
    time
}

/// Estimates all samples. Returns the time that it took.
fn estimate_all(
    estimators: &mut Estimators,
    read: &Receiver<Samples>,
    out: &SyncSender<Batch>,
) -> Duration {
    let mut time = Duration::ZERO;
    for samples in read {
        let start = Instant::now();
        let estimates = estimators.update_all(&samples.samples);
        time += start.elapsed();
        let completed = estimators.take_completed();
        let batch = Batch {
            samples,
            estimates,
            completed,
        };
        if out.send(batch).is_err() {
            break;
        }
    }
    time
}

/// Hands the samples of a batch on. The points of the ground go with the last one.
fn records(
    batch: Batch,
    count: usize,
    record: &mut impl FnMut(Record<'_>) -> Result<(), RunError>,
    left: &mut [Vec<GroundPoint>],
) -> Result<(), RunError> {
    let samples = &batch.samples.samples;
    for (k, sample) in samples.iter().enumerate() {
        let estimates = batch.estimates.get(k * count..(k + 1) * count);
        let is_last = k + 1 == samples.len();
        let completed: &[_] = if is_last { &batch.completed } else { &[] };
        if let Err(error) = record((sample, estimates.unwrap_or_default(), completed)) {
            keep(left, batch.completed);
            return Err(error);
        }
    }
    batch.samples.failure.map_or(Ok(()), Err)
}

/// Adds points that no record has had.
fn keep(left: &mut [Vec<GroundPoint>], completed: Vec<Vec<GroundPoint>>) {
    for (left, completed) in left.iter_mut().zip(completed) {
        left.extend(completed);
    }
}

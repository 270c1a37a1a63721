//! Rows that come in bursts, as over USB or from a buffer: their stamps are those of their arrival.

use crate::Channel;
use crate::order::GAP;
use crate::survey::{count_gaps, period};
use robhaz_score::signals::smooth;

/// Step over the mean one up to which a row comes in one burst with the row before.
const TOGETHER: f64 = 0.5;

/// Spreads the rows of each burst evenly over the time since the burst before, and says so: the last one of a burst
/// came as it was read, the others had to wait. Of the first burst, whose others are older than the log, the last
/// counts.
pub fn spread(channel: &mut Channel) -> Option<String> {
    let (even, true) = period(&channel.times)? else {
        return None;
    };
    let instants = instants(channel, even);
    let count = instants.last()?.instant + 1;
    // Rows of several topics that are close in time.
    if count == instants.last()?.burst + 1 {
        return None;
    }
    let mut bursts: Vec<Burst> = Vec::new();
    for (row, time) in instants.iter().zip(&channel.times) {
        bursts.resize_with(row.burst + 1, || Burst {
            first: row.instant,
            ..Burst::default()
        });
        let burst = &mut bursts[row.burst];
        burst.last = row.instant;
        if row.is_first {
            burst.arrival = *time;
        }
    }
    let at = |row: &Instant| {
        let burst = &bursts[row.burst];
        let before = row
            .burst
            .checked_sub(1)
            .map(|before| bursts[before].arrival);
        // Counts of instants.
        let (rows, behind) = (burst.last + 1 - burst.first, burst.last - row.instant);
        let step = before.map(|before| (burst.arrival - before) / rows as f64);
        // A longer one is a gap.
        let step = step.filter(|step| *step < GAP * even).unwrap_or(even);
        burst.arrival - step * behind as f64
    };
    let old = bursts[0].last;
    let kept = |row: &&Instant| row.instant >= old;
    let first = instants.iter().filter(|row| row.instant < old).count();
    let mut times: Vec<f64> = instants.iter().filter(kept).map(at).collect();
    smooth_clock(&mut times, even);
    // Rows of one instant keep their order.
    for k in 1..times.len() {
        times[k] = times[k].max(times[k - 1] + 1e-6);
    }
    // The first frame is that of the stamps.
    times[0] = channel.times[0];
    let columns = channel.cells.len() / channel.times.len();
    channel.cells.drain(..first * columns);
    channel.times = times;
    channel.report.before_start += first as u64;
    count_gaps(&channel.times, &mut channel.report);
    Some(format!(
        "{}: rows come in bursts, of {:.1} in the mean, with the stamps of their arrival: they count at even times since the burst before, {:.1} ms apart",
        channel.name,
        count as f64 / bursts.len() as f64,
        1e3 * even,
    ))
}

/// Evens out how late the bursts arrived: what the times differ by from an even clock, averaged between gaps.
fn smooth_clock(times: &mut [f64], even: f64) {
    /// Time over which it is averaged, s: clocks drift within minutes.
    const TIME: f64 = 1.0;
    // A count of rows.
    let half = (0.5 * TIME / even) as usize;
    for part in times.chunk_by_mut(|a, b| b - a < GAP * even) {
        let clock = |k: usize| even * k as f64;
        let late: Vec<f64> = part.iter().enumerate().map(|(k, t)| t - clock(k)).collect();
        let end = |late: Option<&f64>| vec![late.copied().unwrap_or(0.0); half];
        let padded = [end(late.first()), late.clone(), end(late.last())].concat();
        let mean = smooth(&padded, half);
        for (k, (time, late)) in part.iter_mut().zip(&mean[half..]).enumerate() {
            *time = late + clock(k);
        }
    }
}

/// A burst: its first and last instant, and when the last one came, s.
#[derive(Clone, Copy, Default)]
struct Burst {
    first: usize,
    last: usize,
    arrival: f64,
}

/// Which burst and which instant a row is of, and whether it is the first of the instant.
struct Instant {
    burst: usize,
    instant: usize,
    is_first: bool,
}

/// Of each row. Rows with cells that all others of an instant lack are of it: of another topic.
fn instants(channel: &Channel, even: f64) -> Vec<Instant> {
    let mut known: Vec<bool> = Vec::new();
    let (mut burst, mut instant) = (0, 0);
    let mut last: Option<f64> = None;
    let of_row = |(row, time): (&[f64], &f64)| {
        let is_behind = last.is_some_and(|last| time - last <= TOGETHER * even);
        let is_there: Vec<bool> = row.iter().map(|cell| !cell.is_nan()).collect();
        let adds = |(is, was): (&bool, &bool)| *is && !*was;
        let is_first = !(is_behind && is_there.iter().zip(&known).any(adds));
        if last.is_some() {
            burst += usize::from(!is_behind);
            instant += usize::from(is_first);
        }
        last = Some(*time);
        match is_first {
            true => known = is_there,
            false => known
                .iter_mut()
                .zip(is_there)
                .for_each(|(was, is)| *was |= is),
        }
        Instant {
            burst,
            instant,
            is_first,
        }
    };
    channel.rows().zip(&channel.times).map(of_row).collect()
}

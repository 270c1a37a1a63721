//! Rows that come in bursts, as from a buffer or over USB: their stamps are those of their arrival.

use crate::Channel;
use crate::order::GAP;
use crate::survey::count_gaps;
use robhaz_score::signals::{median, smooth};

/// Step over the mean one up to which a row comes in one burst with the row before.
const TOGETHER: f64 = 0.5;
/// The same of the usual step within bursts: stamps that only err are further apart.
const AT_ONCE: f64 = 0.2;
/// Fewest instants of a burst in the mean, and fewest bursts.
const LEAST: f64 = 1.9;
const LEAST_BURSTS: usize = 10;
/// Rows over which the mean step is taken, so that gaps do not count.
const MANY: usize = 200;
/// Least time between two rows, s, twice what estimators refuse.
const APART: f64 = 1e-6;

/// Spreads the rows of each burst evenly over the time since the burst before, and says so: the last one of a burst
/// came as it was read, the others had to wait. Of the first burst, whose others are older than the log, the last
/// counts.
pub fn spread(channel: &mut Channel) -> Option<String> {
    if channel.truth.is_some() {
        return None;
    }
    let many = MANY.min(channel.times.len().saturating_sub(1)).max(1);
    let steps = channel.times.windows(many + 1);
    // A count of rows.
    let step = median(steps.map(|w| (w[many] - w[0]) / many as f64).collect())?;
    let (mut instants, bursts) = bursts(channel, step);
    let (count, first) = (instants.last()? + 1, bursts.first()?.last);
    // Counts of instants.
    let mean = count as f64 / bursts.len() as f64;
    let period = period(&bursts)?;
    let within = channel.times.windows(2).map(|w| w[1] - w[0]);
    let within = median(within.filter(|w| *w <= TOGETHER * step).collect())?;
    if bursts.len() < LEAST_BURSTS || mean < LEAST || within > AT_ONCE * period {
        return None;
    }
    let mut clock: Vec<f64> = (first..count)
        .map(|k| time_of(k, &bursts, period))
        .collect();
    smooth_clock(&mut clock, period);
    instants.retain(|instant| *instant >= first);
    let old = channel.times.len() - instants.len();
    let times = instants.iter().map(|instant| clock[instant - first]);
    let mut times: Vec<f64> = times.collect();
    // Rows of one instant keep their order.
    for k in 1..times.len() {
        times[k] = times[k].max(times[k - 1] + APART);
    }
    let columns = channel.cells.len() / channel.times.len();
    channel.cells.drain(..old * columns);
    channel.times = times;
    let report = &mut channel.report;
    report.before_start += old as u64;
    report.period = period;
    count_gaps(&channel.times, report);
    Some(format!(
        "{}: rows come in bursts of {mean:.1} in the mean, with the stamps of their arrival: the rows of each burst are spread evenly over the time since the burst before, {:.1} ms apart",
        channel.name,
        1e3 * period,
    ))
}

/// A burst: its first and last instant, and when its last row came, s.
#[derive(Clone, Copy)]
struct Burst {
    first: usize,
    last: usize,
    arrival: f64,
}

impl Burst {
    /// A count of instants.
    fn count(&self) -> f64 {
        (self.last + 1 - self.first) as f64
    }
}

/// The instant of each row, and the bursts in order of time; `step` is the mean time between rows, s. Topics that are close
/// in time are of one instant: a row with cells that its other rows lack, or whose changed cells none of them has
/// changed.
fn bursts(channel: &Channel, step: f64) -> (Vec<usize>, Vec<Burst>) {
    let columns = channel.columns.len();
    // What the cells of the instant have, what of it is new, and the last values.
    let (mut there, mut changed) = (vec![false; columns], vec![false; columns]);
    let mut last = vec![f64::NAN; columns];
    let (mut instants, mut bursts) = (Vec::new(), Vec::<Burst>::new());
    for (row, time) in channel.rows().zip(&channel.times) {
        let cell = |k: usize| row.get(k).copied().filter(|cell| !cell.is_nan());
        let is_new = |k: usize| cell(k).is_some_and(|cell| cell.to_bits() != last[k].to_bits());
        let adds = (0..columns).any(|k| cell(k).is_some() && !there[k]);
        let changes = (0..columns).any(&is_new);
        let is_apart = changes && !(0..columns).any(|k| is_new(k) && changed[k]);
        let burst = bursts.last_mut();
        let burst = burst.filter(|burst| time - burst.arrival <= TOGETHER * step);
        let is_first = burst.is_none() || !(adds || is_apart);
        let before = instants.last().copied();
        let instant = before.map_or(0, |before| before + usize::from(is_first));
        instants.push(instant);
        match burst {
            Some(burst) => (burst.last, burst.arrival) = (instant, *time),
            None => bursts.push(Burst {
                first: instant,
                last: instant,
                arrival: *time,
            }),
        }
        for k in 0..columns {
            let (was, had) = (changed[k] && !is_first, there[k] && !is_first);
            changed[k] = was || is_new(k);
            there[k] = had || cell(k).is_some();
        }
        for (last, cell) in last.iter_mut().zip((0..columns).map(cell)) {
            *last = cell.unwrap_or(*last);
        }
    }
    (instants, bursts)
}

/// Time from one instant to the next, s: that from burst to burst over the instants of the later one, without the
/// gaps. `None` of a single burst.
fn period(bursts: &[Burst]) -> Option<f64> {
    let since = |w: &[Burst]| w[1].arrival - w[0].arrival;
    let steps = || bursts.windows(2).map(|w| since(w) / w[1].count());
    let usual = median(steps().collect())?;
    let whole = bursts.windows(2).zip(steps());
    let whole = whole.filter(|(_, step)| *step < GAP * usual);
    let sums = whole.map(|(w, _)| (since(w), w[1].count()));
    let (time, count) = sums.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    (count > 0.0).then(|| time / count)
}

/// Time of an instant, s.
fn time_of(instant: usize, bursts: &[Burst], period: f64) -> f64 {
    let at = bursts.partition_point(|burst| burst.last < instant);
    let Some(burst) = bursts.get(at) else {
        return f64::NAN;
    };
    let before = at.checked_sub(1).and_then(|before| bursts.get(before));
    let step = before.map(|before| (burst.arrival - before.arrival) / burst.count());
    // A longer one is a gap.
    let step = step.filter(|step| *step < GAP * period).unwrap_or(period);
    // A count of instants.
    burst.arrival - step * (burst.last - instant) as f64
}

/// Evens out how late the bursts arrived: what the times differ by from an even clock, averaged between gaps, and
/// mirrored at their ends.
fn smooth_clock(times: &mut [f64], period: f64) {
    /// Time over which it is averaged, s: clocks drift within minutes.
    const TIME: f64 = 1.0;
    for part in times.chunk_by_mut(|a, b| b - a < GAP * period) {
        // A count of instants.
        let half = ((0.5 * TIME / period) as usize).min(part.len() - 1);
        let clock = |k: usize| period * k as f64;
        let late: Vec<f64> = part.iter().enumerate().map(|(k, t)| t - clock(k)).collect();
        let end = late.len() - 1;
        let before = (1..=half).rev().map(|k| 2.0 * late[0] - late[k]);
        let behind = (1..=half).map(|k| 2.0 * late[end] - late[end - k]);
        let padded: Vec<f64> = before.chain(late.iter().copied()).chain(behind).collect();
        let mean = smooth(&padded, half);
        for (k, (time, late)) in part.iter_mut().zip(&mean[half..]).enumerate() {
            *time = late + clock(k);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Rows;
    use crate::mcap_events::Clock;
    use robhaz_run::ChannelReport;
    use std::path::Path;

    /// A table with these times, s, and cells.
    fn table(times: &[f64], cells: Vec<Vec<f64>>) -> Channel {
        let columns = cells.first().map_or(1, Vec::len);
        let rows = Rows::Topic(String::new(), Clock::Log);
        Channel {
            columns: (0..columns).map(|k| k.to_string()).collect(),
            times: times.to_vec(),
            cells: cells.concat(),
            report: ChannelReport::default(),
            ..Channel::new("log".to_owned(), Path::new("log.csv"), rows)
        }
    }

    /// Rows of 10 ms whose stamps are those of bursts of `size`, late by up to `late`, s; each burst with its rows
    /// 0.1 ms apart.
    fn in_bursts(rows: usize, size: usize, late: f64) -> Vec<f64> {
        let last = |k: usize| (k - k % size + size - 1).min(rows - 1);
        // A count of rows.
        let of = |k: usize| {
            let by = late * ((last(k) / size * 7 + 3) % 5) as f64 / 4.0;
            1e-2 * last(k) as f64 + by + 1e-4 * (k % size) as f64
        };
        (0..rows).map(of).collect()
    }

    /// Bursts of any size have the times of their rows: within the mean lateness and what half a second averages of
    /// the rest, and in order. Of the first burst the last row is left.
    #[test]
    fn bursts_of_any_size_are_spread() {
        for size in [2, 3, 5, 8, 12, 25, 40, 50] {
            for late in [0.0, 4e-3] {
                let times = in_bursts(2000, size, late);
                let cells = (0..2000).map(|k| vec![f64::from(k)]).collect();
                let mut channel = table(&times, cells);
                let said = spread(&mut channel);
                assert!(said.is_some(), "{size}");
                assert!(
                    (channel.report.period - 1e-2).abs() < 2e-5,
                    "{size}: {:?}",
                    channel.report
                );
                assert_eq!(channel.report.before_start, size as u64 - 1);
                assert_eq!(channel.times.len(), 2001 - size);
                assert!(channel.times.windows(2).all(|w| w[1] > w[0]));
                for (row, time) in channel.rows().zip(&channel.times) {
                    // The last row of a burst comes some time after its first one.
                    let [error, behind] = [time - 1e-2 * row[0], 1e-4 * (size - 1) as f64];
                    let allowed = behind - 1e-3..behind + late + 1e-3;
                    assert!(allowed.contains(&error), "{size}, {}: {error}", row[0]);
                }
                assert_eq!(channel.report.gaps, 0, "{size}");
            }
        }
    }

    /// A gap of half a second stays one, and no row moves into it.
    #[test]
    fn a_gap_between_bursts_stays() {
        let mut times = in_bursts(1000, 5, 0.0);
        for time in &mut times[500..] {
            *time += 0.5;
        }
        let cells = (0..1000).map(|k| vec![f64::from(k)]).collect();
        let mut channel = table(&times, cells);
        assert!(spread(&mut channel).is_some());
        assert_eq!(channel.report.gaps, 1);
        let longest = channel.report.longest_gap.expect("a gap");
        assert!((longest - 0.51).abs() < 1e-3, "{longest}");
    }

    /// Rows of two topics, 1 ms apart every 20 ms, are no bursts: with empty cells, and filled with the last values.
    #[test]
    fn topics_that_are_close_in_time_are_no_bursts() {
        let times: Vec<f64> = (0..1000)
            .map(|k| 0.02 * f64::from(k / 2) + 1e-3 * f64::from(k % 2))
            .collect();
        for filled in [false, true] {
            let row = |k: u32| {
                let (one, other) = (f64::from(k / 2), f64::from(k.saturating_sub(1) / 2));
                match (filled, k % 2) {
                    (false, 0) => vec![one, f64::NAN],
                    (false, _) => vec![f64::NAN, one],
                    (true, _) => vec![one, other],
                }
            };
            let mut channel = table(&times, (0..1000).map(row).collect());
            assert!(spread(&mut channel).is_none(), "{filled}");
            assert_eq!(channel.times, times);
        }
    }

    /// Even rows, rows with jitter, and logs of one row or none are left as they are.
    #[test]
    fn other_logs_are_left() {
        let even: Vec<f64> = (0..500).map(|k| 1e-2 * f64::from(k)).collect();
        let jitter: Vec<f64> = (0..500)
            .map(|k| 1e-2 * f64::from(k) + 4e-3 * f64::from(k * 7 % 5) / 4.0)
            .collect();
        for times in [even, jitter, vec![0.0], Vec::new()] {
            let cells = (0..times.len()).map(|k| vec![k as f64]).collect();
            let mut channel = table(&times, cells);
            assert!(spread(&mut channel).is_none());
            assert_eq!(channel.times, times);
        }
    }
}

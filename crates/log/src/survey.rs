//! The rows of a log, read once and kept: order of their time stamps, duration, rates. Nothing is
//! written before it succeeds.

use crate::order::{Accept, GAP, Order, SHORTEST_STEP};
use crate::{Channel, Channels, Clock, LogError, Place, Row, Rows, Stamp, TimeUnit};
use robhaz_run::ChannelReport;
use robhaz_score::signals::median;

/// A channel while it is read.
#[derive(Default)]
struct Course {
    stamps: Vec<Stamp>,
    cells: Vec<f64>,
    order: Order,
    /// Place of the last row that counts.
    last: Option<Place>,
    /// Time stamp of the last row before the largest step back.
    set_back_at: Option<Stamp>,
    /// Why the order of the rows cannot be used, as found at the first one.
    jump_back: Option<LogError>,
    /// Stamp of the row before, whether it counts or not, and number of rows that are earlier than the one before.
    before: Option<Stamp>,
    earlier: u64,
    /// Number of messages whose header has no stamp: 0.
    unset: u64,
    /// Number of rows with the time of the one before and other values.
    other: u64,
    report: ChannelReport,
}

/// A stamp in the header beyond this is a date, s: a clock that starts at 0 is far below.
const DATE: f64 = 1e8;

/// Share of the rows with the time of the one before and other values from which on the clock is too coarse:
/// single ones are rows that are late.
const OF_COARSE_CLOCK: f64 = 0.1;

/// Share of the rows that are earlier than the row before from which on they are in no order.
const IN_NO_ORDER: f64 = 0.1;
/// As many may be jumps of a clock, in a log of a few rows.
const FEW: u64 = 2;

/// Takes the cells of a row with the time of the last one where this has none. Whether others differ.
fn join(cells: &mut [f64], row: &[f64]) -> bool {
    let from = cells.len().saturating_sub(row.len());
    let mut differ = false;
    for (known, new) in cells[from..].iter_mut().zip(row) {
        if known.is_nan() {
            *known = *new;
        }
        differ |= !new.is_nan() && known.to_bits() != new.to_bits();
    }
    differ
}

/// Reads all rows of all channels. Returns the stamp of the first frame, and the time from it to the last one, s.
///
/// # Errors
/// [`LogError`]: a file that cannot be read, a time that jumps back, a channel without rows, or
/// channels whose times have nothing in common.
pub fn survey(channels: &mut Channels) -> Result<(Stamp, f64), LogError> {
    let mut courses: Vec<Course> = channels.all.iter().map(|_| Course::default()).collect();
    let cut_off = channels.read(|i, row| courses[i].add(&channels.all[i], &row))?;
    for (course, channel) in courses.iter_mut().zip(&channels.all) {
        course.check_order(channel)?;
        course.check_stamps(channel)?;
    }
    for ((course, cut_off), channel) in courses.iter_mut().zip(cut_off).zip(&channels.all) {
        if course.stamps.is_empty() {
            return Err(match &cut_off {
                Some(why) => channel.problem(format!("has no complete row: cut off at {why}")),
                None => channel.problem("has no row"),
            });
        }
        course.report.cut_off = cut_off;
    }
    let base = courses.first().map_or(&[][..], |base| &base.stamps);
    let (Some(&origin), Some(&end)) = (base.first(), base.last()) else {
        return Err(LogError::whole(&channels.source, "has no channel"));
    };
    let duration = end.since(origin);
    if duration <= 0.0 {
        let message = "has one row only, allowed: at least two with different times";
        return Err(channels.all[0].problem(message));
    }
    for (i, course) in courses.into_iter().enumerate() {
        course.finish(channels, i, origin, duration);
        let channel = &channels.all[i];
        let (from, to) = (channel.times[0], channel.times[channel.times.len() - 1]);
        if to < -channel.report.period || from > duration {
            let base = &channels.all[0].name;
            let remedy = match channel.truth {
                None => "set the channel's `offset`",
                Some(_) => {
                    "state a [[channel]] with name = \"truth\" and its `offset`, without table or topic,"
                }
            };
            return Err(channel.problem(format!(
                "has times from {from:.3} to {to:.3} s after the start of {base}, which lasts {duration:.3} s: no row in common; \
                 {remedy} if its clock differs"
            )));
        }
    }
    Ok((origin, duration))
}

impl Course {
    fn add(&mut self, channel: &Channel, row: &Row) -> Result<(), LogError> {
        let first = self.stamps.first().copied().unwrap_or(row.stamp);
        if matches!(channel.rows, Rows::Topic(..)) && self.is_of_last(row) {
            join(&mut self.cells, &row.cells);
            return Ok(());
        }
        let is_header = matches!(channel.rows, Rows::Topic(_, Clock::Header));
        let is_unset = is_header && row.stamp == Stamp::Nanoseconds(0);
        self.unset += u64::from(is_unset);
        let before = self.before.replace(row.stamp);
        self.earlier += u64::from(before.is_some_and(|before| row.stamp.since(before) < 0.0));
        let report = &mut self.report;
        report.rows += 1;
        match self.order.accept(row.stamp.since(first)) {
            Accept::Use => {
                self.stamps.push(row.stamp);
                self.cells.extend(&row.cells);
                self.last = Some(row.place);
            }
            Accept::Duplicate => {
                report.duplicates += 1;
                self.other += u64::from(join(&mut self.cells, &row.cells));
            }
            Accept::Late => report.late += 1,
            Accept::SetBack(by) => {
                report.set_back += 1;
                report.late += 1;
                if report.largest_set_back.is_none_or(|most| by > most) {
                    report.largest_set_back = Some(by);
                    self.set_back_at = self.stamps.last().copied();
                }
            }
            Accept::JumpBack(_) if is_unset && first.seconds() > DATE => {
                return Err(LogError::place(&channel.path, row.place, UNSET));
            }
            Accept::JumpBack(by) => {
                let before = self.last.map_or(String::new(), |p| format!(" after {p}"));
                let message = format!(
                    "the time jumps back by {by:.3} s{before}: a clock that was set, or two recordings in one; split the log there"
                );
                let error = || LogError::place(&channel.path, row.place, message);
                self.jump_back.get_or_insert_with(error);
            }
        }
        Ok(())
    }

    /// Refuses rows whose time jumps back.
    fn check_order(&mut self, channel: &Channel) -> Result<(), LogError> {
        let Some(error) = self.jump_back.take() else {
            return Ok(());
        };
        let (rows, earlier) = (self.report.rows, self.earlier);
        // Counts of rows.
        if earlier > FEW && earlier as f64 > IN_NO_ORDER * rows as f64 {
            return Err(channel.problem(format!(
                "{earlier} of {rows} rows are earlier than the row before, allowed: rows in the order of their times; sort them by time"
            )));
        }
        Err(error)
    }

    /// Whether a row is within half a microsecond of the last one and has other cells alone: joints of one time in messages of their own.
    fn is_of_last(&self, row: &Row) -> bool {
        let from = self.cells.len().saturating_sub(row.cells.len());
        let mut cells = self.cells[from..].iter().zip(&row.cells);
        let has_other = row.cells.iter().any(|cell| !cell.is_nan());
        let is_apart = cells.all(|(a, b)| a.is_nan() || b.is_nan());
        let last = self.stamps.last();
        let is_same = last.is_some_and(|last| row.stamp.since(*last).abs() < SHORTEST_STEP);
        is_same && has_other && is_apart
    }

    /// Refuses stamps that are no times.
    fn check_stamps(&self, channel: &Channel) -> Result<(), LogError> {
        let (Some(first), Some(last)) = (self.stamps.first(), self.stamps.last()) else {
            return Ok(());
        };
        let rows = self.report.rows;
        let unset = match self.unset {
            all if all == rows && rows > 1 => format!("all {rows}"),
            some @ 1.. if last.seconds() > DATE => format!("{some} of {rows}"),
            _ => String::new(),
        };
        if !unset.is_empty() {
            let message = format!("{unset} messages have the stamp 0 in their header: {UNSET}");
            return Err(channel.problem(message));
        }
        if rows > 1 && last.since(*first) <= 0.0 && self.report.duplicates + 1 == rows {
            let (what, of_topic) = match channel.rows {
                Rows::Topic(..) => ("messages", "; time = \"log\" takes that of the recorder"),
                Rows::Table(..) => ("rows", ""),
            };
            let message = format!(
                "all {rows} {what} have the time {} s, allowed: times that increase{of_topic}",
                first.seconds()
            );
            return Err(channel.problem(message));
        }
        // Counts of rows.
        if channel.truth.is_none() && self.other as f64 > OF_COARSE_CLOCK * rows as f64 {
            let message = format!(
                "{} of {rows} rows have the time of the row before and other values, so the clock of the stamps is coarser than the rows are apart; allowed: stamps of a finer clock, with more digits",
                self.other
            );
            return Err(channel.problem(message));
        }
        Ok(())
    }

    /// The rows of channel `i` of a log that starts at `origin`. Without two rows its period is the
    /// duration of the log.
    fn finish(self, channels: &mut Channels, i: usize, origin: Stamp, duration: f64) {
        let channel = &channels.all[i];
        let difference = channel.offset - channels.all[0].offset;
        let time = |stamp: &Stamp| {
            let time = stamp.since(origin);
            // Adding zero would change the sign of a zero.
            let is_same = difference == 0.0;
            if is_same { time } else { time + difference }
        };
        let times: Vec<f64> = self.stamps.iter().map(time).collect();
        let period = period(&times).unwrap_or(duration);
        let mut report = ChannelReport {
            name: channel.name.clone(),
            period,
            offset: channel.offset,
            largest_set_back_at: self.set_back_at.as_ref().map(time),
            units_in_second: match &channel.rows {
                Rows::Table(_, time) if time.unit != TimeUnit::SECOND => Some(time.unit.0 as f64),
                _ => None,
            },
            ..self.report
        };
        count_gaps(&times, &mut report);
        let channel = &mut channels.all[i];
        (channel.times, channel.cells, channel.report) = (times, self.cells, report);
    }
}

/// Counts the gaps between rows, and those that are lost in them, anew.
pub fn count_gaps(times: &[f64], report: &mut ChannelReport) {
    let period = report.period;
    (report.gaps, report.lost) = (0, 0);
    (report.longest_gap, report.longest_gap_at) = (None, None);
    let steps = times.windows(2).map(|w| (w[1] - w[0], w[0]));
    for (k, (step, start)) in steps.enumerate() {
        if step <= GAP * period {
            continue;
        }
        let lost = ((step / period).round() - 1.0).min(lacking(times, k, period));
        if lost < 1.0 {
            continue;
        }
        report.gaps += 1;
        // The cast saturates; the number is positive.
        report.lost += lost as u64;
        if report.longest_gap.is_none_or(|longest| step > longest) {
            (report.longest_gap, report.longest_gap_at) = (Some(step), Some(start));
        }
    }
    // Where the steps show no period, rows are lost if their number says so.
    if let [first, .., last] = times
        && report.lost > 0
        && is_irregular(times, period)
    {
        let all = ((last - first) / period).round() + 1.0;
        // The cast saturates.
        report.lost = report
            .lost
            .min((all as u64).saturating_sub(times.len() as u64));
        report.gaps = report.gaps.min(report.lost);
        if report.lost == 0 {
            (report.longest_gap, report.longest_gap_at) = (None, None);
        }
    }
}

/// Whether steps are no whole numbers of a period (s): the errors of their stamps are as large.
fn is_irregular(times: &[f64], period: f64) -> bool {
    /// Share of the steps that are near a whole number of periods; of any steps it is a half.
    const REGULAR: f64 = 0.75;
    let steps = times.windows(2).map(|w| (w[1] - w[0]) / period);
    let near = |step: &f64| *step > 0.5 && (step - step.round()).abs() < 0.25;
    let near = steps.filter(near).count();
    // Counts of steps.
    (near as f64) < REGULAR * (times.len() - 1) as f64
}

/// Time from one row to the next, s: the usual step, or, where rows come in bursts or as those of several
/// topics, or where their stamps err by as much, the mean step.
pub fn period(times: &[f64]) -> Option<f64> {
    /// Rows over which bursts are evened out.
    const MANY: usize = 20;
    /// Of the steps of rows that come one by one the mean is the usual one, but for gaps.
    const OF_BURSTS: f64 = 2.0;
    /// The same of stamps that err by as much as the rows are apart.
    const OF_JITTER: f64 = 1.1;
    let step_over = |rows: usize| {
        let steps = times.windows(rows + 1);
        median(steps.map(|w| (w[rows] - w[0]) / rows as f64).collect())
    };
    let usual = step_over(1)?;
    let is_other = |even: &f64| {
        *even > OF_BURSTS * usual || *even > OF_JITTER * usual && is_irregular(times, usual)
    };
    let even = step_over(MANY).filter(is_other);
    Some(even.unwrap_or(usual))
}

/// Number of rows that are lacking at step `k`, by the mean times of as many rows before as after it:
/// stamps that jitter make long steps and short ones, and no row is lost.
fn lacking(times: &[f64], k: usize, period: f64) -> f64 {
    /// Rows before and after, at most.
    const NEAR: usize = 20;
    let (before, after) = times.split_at(k + 1);
    let near = NEAR.min(before.len()).min(after.len());
    let ends = before.iter().rev().zip(after).take(near);
    let apart: f64 = ends.map(|(before, after)| after - before).sum();
    // A count of rows. Without a gap row i after is 2 i + 1 periods from row i before.
    let count = near as f64;
    (apart / (count * period) - count).round()
}

/// What to do about a header without a stamp.
const UNSET: &str =
    "the publisher sets none; state time = \"log\" of the channel, the time of the recorder";

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_sim::random::Stream;

    fn report(times: &[f64]) -> ChannelReport {
        let mut report = ChannelReport {
            period: period(times).unwrap_or(0.0),
            ..ChannelReport::default()
        };
        count_gaps(times, &mut report);
        report
    }

    /// Rows at 100 Hz whose stamps err by 15 ms, in their order, and of which none is lost: the rate is their number over
    /// the time, to 2 %, and nearly no gap shows. Of rows that are lost with right stamps each is counted.
    #[test]
    fn stamps_that_err_by_a_period_lose_no_row() {
        let mut random = Stream::new(1, "stamps");
        let mut times: Vec<f64> = (0..1200).map(|k| 0.01 * f64::from(k)).collect();
        let kept: Vec<f64> = times
            .iter()
            .copied()
            .enumerate()
            .filter(|(k, _)| k % 7 != 3)
            .map(|(_, t)| t)
            .collect();
        let lost = report(&kept);
        assert_eq!(
            (lost.lost as usize, lost.gaps as usize),
            (1200 - kept.len(), 1200 - kept.len())
        );
        times
            .iter_mut()
            .for_each(|time| *time += 0.015 * random.normal());
        times.sort_by(f64::total_cmp);
        let found = report(&times);
        assert!((found.period / 0.01 - 1.0).abs() < 0.02, "{found:?}");
        assert!(found.lost < 5, "{found:?}");
    }
}

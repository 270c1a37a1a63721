//! Channels with clocks and rates of their own, brought onto the times of the first one.
//!
//! A reading belongs to a frame if it is new since the last frame. Of several new ones the newest
//! counts, as it was at the time of the frame: on the straight line from its row to the next one. A
//! log can look ahead; an estimator on a robot cannot, and needs the age of its readings in
//! `budget.jitter`.

use crate::truth::FoundTruth;
use crate::{Channel, Channels, Formula, Jitter, Stamp};
use robhaz_estimator::SensorFrame;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::BodyMount;
use robhaz_run::{BothSides, ChannelReport, LogReport, RunError, Sample, Source};
use robhaz_scene::{Reading, Values, frame, whole_frame};
use std::path::Path;

/// Rows of two channels that differ by less have the same time, s: a time in seconds since 1970 is
/// rounded by 0.12 us, and an offset rounds it again.
const ROUNDING: f64 = 0.5e-6;

/// A row is joined to the next one if that is nearer than this, in periods.
const LONGEST_STEP: f64 = 2.5;
/// A row of the truth counts for the frames that are nearer than this, in periods of the frames: for one
/// frame where the truth is slower, and a frame has one wherever the truth is as fast, whatever its stamp.
const NEAR: f64 = 0.6;
/// Changes of the slope beyond this many times the usual ones are jumps: there a reading stays as it
/// was read, so that a wrong one spoils one frame alone.
const JUMP: f64 = 10.0;

/// A log as a source of readings, frame by frame.
pub struct Frames {
    channels: Channels,
    /// Time stamp of the first frame.
    origin: Stamp,
    /// Of each reading of each channel but the first, the change of the difference between rows that
    /// is a jump.
    jumps: Vec<Vec<f64>>,
    taken: Taken,
    /// Makes readings of the links of those of the body.
    mount: Option<BodyMount>,
}

/// What was taken of a log so far.
#[derive(Default)]
struct Taken {
    channels: Vec<TakenOfChannel>,
    /// Number of frames without each reading.
    missing: Vec<u64>,
}

#[derive(Clone, Default)]
struct TakenOfChannel {
    /// Number of rows: the next one.
    rows: usize,
    /// Sum (s) and number of the ages of its rows at the frames.
    age: f64,
    ages: u64,
    before_start: u64,
    superseded: u64,
}

impl Frames {
    /// Starts at the first row.
    pub fn new(channels: Channels, origin: Stamp, mount: Option<BodyMount>) -> Self {
        Self {
            mount,
            jumps: (channels.all.iter().enumerate()).map(jumps_of).collect(),
            taken: Taken::nothing(&channels),
            channels,
            origin,
        }
    }

    /// Whether there is a truth to compare with.
    pub fn has_truth(&self) -> bool {
        self.channels.all.iter().any(|c| c.truth.is_some())
    }

    /// The file or folder of the log.
    pub fn source(&self) -> &Path {
        &self.channels.source
    }

    /// Leaves out gaps that are none: steps of a coarse clock, between which the wheels turn evenly.
    pub fn leave_out_gaps(&mut self, jitter: &Jitter) {
        let report = &mut self.channels.all[0].report;
        let unit = jitter.unit.filter(|_| jitter.sigma > 0.0);
        let by_clock = unit.map_or(0.0, |unit| report.period + 1.5 * unit);
        if report.longest_gap.is_some_and(|longest| longest < by_clock) {
            (report.gaps, report.lost) = (0, 0);
            (report.longest_gap, report.longest_gap_at) = (None, None);
        }
    }

    /// All frames of each side, of a log of both without links.
    pub fn of_sides(&self) -> Vec<Vec<SensorFrame>> {
        if !self.channels.is_of_both() {
            return vec![self.all_of_links()];
        }
        let all = self.all_of_both();
        let side = |side: usize| all.iter().map(|frame| side_frame(frame, side)).collect();
        vec![side(0), side(1)]
    }

    /// All frames of one side, with readings of the links that are made of those of the body.
    pub fn all_of_links(&self) -> Vec<SensorFrame> {
        let mut mount = self.mount.clone();
        self.each(|time, values| frame(time, values, mount.as_mut()))
    }

    /// All frames of a log of both sides.
    pub fn all_of_both(&self) -> Vec<WholeFrame> {
        self.each(whole_frame)
    }

    /// What `of` makes of the time (s) and the readings of each frame.
    fn each<T>(&self, mut of: impl FnMut(f64, &Values) -> T) -> Vec<T> {
        let mut taken = Taken::nothing(&self.channels);
        let mut all = Vec::new();
        while let Some((time, values, _)) = self.next_values(&mut taken) {
            all.push(of(time, &values));
        }
        all
    }

    /// Moves the readings of a row of channel `i` to the `time` (s) of a frame, if they do not jump
    /// there. Contact angles do. Returns the row's age, s.
    fn move_to(&self, time: f64, i: usize, row: usize, values: &mut Values) -> f64 {
        let channel = &self.channels.all[i];
        let times = &channel.times;
        let age = time - times[row];
        if age.is_nan() || age <= ROUNDING {
            return 0.0;
        }
        let longest = LONGEST_STEP * channel.report.period;
        let step = times.get(row + 1).map(|next| next - times[row]);
        let Some(step) = step.filter(|step| *step <= longest) else {
            return age;
        };
        for ((reading, formula), jump) in channel.readings.iter().zip(&self.jumps[i]) {
            let value = |row: usize| formula.value(channel.row(row)?);
            let change = |row: usize| Some(value(row + 1)? - value(row)?);
            let Some((now, by)) = value(row).zip(change(row)) else {
                continue;
            };
            let around = [row.checked_sub(1).and_then(change), change(row + 1)];
            let mut around = around.iter().flatten();
            let is_smooth = around.all(|other| (by - other).abs() <= *jump);
            if is_smooth && !reading.is_contact_angle() {
                values[reading.index()] = Some(now + by * age / step);
            }
        }
        age
    }

    /// The row of the truth nearest to a time (s), and, where it lies between two, the other one and the
    /// share of the way to it. `None` where no row is near.
    fn rows_of_truth(&self, truth: &Channel, time: f64) -> Option<(usize, Option<(usize, f64)>)> {
        let times = &truth.times;
        let after = times.partition_point(|at| *at <= time + ROUNDING);
        let away = |row: usize| times.get(row).map_or(f64::INFINITY, |at| (at - time).abs());
        let before = after.checked_sub(1);
        let (near, far) = match before {
            Some(before) if away(before) <= away(after) => (before, Some(after)),
            _ => (after, before),
        };
        if away(near) > NEAR * self.channels.all[0].report.period {
            return None;
        }
        let step = far.map_or(f64::INFINITY, |far| away(near) + away(far));
        let is_between = away(near) > ROUNDING && step <= LONGEST_STEP * truth.report.period;
        let far = far.filter(|_| is_between);
        Some((near, far.map(|far| (far, away(near) / step))))
    }

    /// The truth at the time of a frame, s.
    fn truth_at(&self, truth: &Channel, time: f64) -> Option<FoundTruth> {
        let (near, far) = self.rows_of_truth(truth, time)?;
        let (columns, cells) = (truth.truth.as_ref()?, truth.row(near)?);
        match far.and_then(|(far, share)| Some((truth.row(far)?, share))) {
            Some((far, share)) => columns.found(&columns.between(cells, far, share), time),
            None => columns.found(cells, time),
        }
    }

    /// Number of the frames from a time (s) on, and of those with a row of the truth; `None` without
    /// truth.
    pub fn frames_with_truth(&self, from: f64) -> Option<(usize, usize)> {
        let truth = self.channels.all.iter().find(|c| c.truth.is_some())?;
        let times = self.channels.all[0].times.iter();
        let counted = times.filter(|time| **time >= from);
        let with = |time: &&f64| self.rows_of_truth(truth, **time).is_some();
        Some((counted.clone().count(), counted.filter(with).count()))
    }

    /// Time (s), readings and truth of the next frame.
    fn next_values(&self, taken: &mut Taken) -> Option<(f64, Values, Option<FoundTruth>)> {
        let base = &self.channels.all[0];
        let first = taken.channels[0].rows;
        let (time, mut values) = (*base.times.get(first)?, base.values(base.row(first)?));
        taken.channels[0].rows += 1;
        let mut truth = None;
        for (i, channel) in self.channels.all.iter().enumerate().skip(1) {
            if channel.truth.is_some() {
                truth = self.truth_at(channel, time);
                continue;
            }
            let (own, mut new) = (&mut taken.channels[i], 0);
            let due = |at: &f64| *at <= time + ROUNDING;
            let is_due = |row: usize| channel.times.get(row).is_some_and(due);
            while is_due(own.rows) {
                let row = own.rows;
                own.rows += 1;
                let mut content = channel.values(channel.row(row)?);
                if !is_due(row + 1) {
                    own.ages += 1;
                    own.age += self.move_to(time, i, row, &mut content);
                }
                // Before the first frame a row is as new as one period of its channel.
                if first == 0 && channel.times[row] <= time - channel.report.period {
                    own.before_start += 1;
                    continue;
                }
                for (value, found) in values.iter_mut().zip(content) {
                    *value = found.or(*value);
                }
                new += 1;
            }
            own.superseded += u64::saturating_sub(new, 1);
        }
        for (count, value) in taken.missing.iter_mut().zip(&values) {
            *count += u64::from(value.is_none());
        }
        Some((time, values, truth))
    }
}

impl Taken {
    fn nothing(channels: &Channels) -> Self {
        Self {
            channels: vec![TakenOfChannel::default(); channels.all.len()],
            missing: vec![0; Reading::COUNT],
        }
    }
}

/// The wheels of one side (0 left, 1 right), without links.
pub fn side_frame(whole: &WholeFrame, side: usize) -> SensorFrame {
    let of = |wheels: &[Option<f64>; 6]| [0, 1, 2].map(|i| wheels[3 * side + i]);
    SensorFrame {
        time: whole.time,
        wheel_angle: of(&whole.wheel_angle),
        motor_torque: of(&whole.motor_torque),
        ..SensorFrame::default()
    }
}

/// See [`Frames::jumps`].
fn jumps_of((i, channel): (usize, &Channel)) -> Vec<f64> {
    let rows = if i == 0 { 0 } else { channel.times.len() };
    let of = |(_, formula): &(Reading, Formula)| {
        let value = |row: usize| formula.value(channel.row(row)?);
        let change = |row: usize| {
            let [a, b, c] = [value(row)?, value(row + 1)?, value(row + 2)?];
            Some((c - 2.0 * b + a).abs()).filter(|change| *change > 0.0)
        };
        let mut changes: Vec<f64> = (0..rows).filter_map(change).collect();
        changes.sort_by(f64::total_cmp);
        // Nine of ten are not larger.
        let usual = changes.get(changes.len() * 9 / 10);
        usual.map_or(0.0, |usual| JUMP * usual)
    };
    channel.readings.iter().map(of).collect()
}

impl Source for Frames {
    fn next_sample(&mut self) -> Result<Option<Sample>, RunError> {
        let mut taken = std::mem::take(&mut self.taken);
        let next = self.next_values(&mut taken);
        self.taken = taken;
        let Some((time, values, truth)) = next else {
            return Ok(None);
        };
        let (of_plane, of_both) = truth.unwrap_or_default();
        let both = self.channels.is_of_both().then(|| BothSides {
            readings: whole_frame(time, &values),
            truth: of_both,
        });
        Ok(Some(Sample {
            time,
            truth: of_plane,
            sensors: match &both {
                Some(both) => side_frame(&both.readings, 0),
                None => frame(time, &values, self.mount.as_mut()),
            },
            both: both.map(Box::new),
            is_record: true,
        }))
    }

    fn mean_step(&self) -> Option<f64> {
        None
    }

    /// What became of the rows so far.
    fn log_report(&self) -> Option<LogReport> {
        let Taken { channels, missing } = &self.taken;
        let frames = channels.first().map_or(0, |base| base.rows as u64);
        // A column of steering without a value is of a wheel that is not steered.
        let is_empty = |r: &Reading| r.is_optional() && missing[r.index()] == frames;
        let present = Reading::all().filter(|r| self.channels.has(*r) && !is_empty(r));
        let missing = present.map(|r| (r.name().to_owned(), missing[r.index()]));
        let report = |(channel, taken): (&Channel, &TakenOfChannel)| ChannelReport {
            // A count of rows.
            age: taken.age / taken.ages.max(1) as f64,
            before_start: channel.report.before_start + taken.before_start,
            superseded: taken.superseded,
            ..channel.report.clone()
        };
        let absent = match self.channels.is_of_both() {
            // Steering alone may be missing, and then is 0.
            true => Vec::new(),
            false => self.channels.absent(),
        };
        Some(LogReport {
            source: self.channels.source.display().to_string(),
            start: self.origin.seconds() + self.channels.all[0].offset,
            channels: self.channels.all.iter().zip(channels).map(report).collect(),
            missing: missing.collect(),
            absent: absent.iter().map(|r| r.name().to_owned()).collect(),
        })
    }
}

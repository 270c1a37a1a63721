//! Channels with clocks and rates of their own, brought onto the times of the first one.
//!
//! A reading belongs to a frame if it is new since the last frame. Of several new ones the newest
//! counts, as it was at the time of the frame: on the straight line from its row to the next one. A
//! log can look ahead; an estimator on a robot cannot, and needs the age of its readings in
//! `budget.jitter`.

use crate::formula::Formula;
use crate::plan::Plan;
use crate::readings::{self, Reading, Values, frame, side_frame, whole_frame};
use crate::survey::{Channel, Survey};
use crate::truth::FoundTruth;
use robhaz_estimator::SensorFrame;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::BodyMount;
use robhaz_run::{BothSides, ChannelReport, LogReport, RunError, Sample, Source};
use std::path::PathBuf;

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
    plan: Plan,
    survey: Survey,
    /// The next row of each channel.
    next: Vec<usize>,
    /// Of each reading of each channel but the first, the change of the difference between rows that
    /// is a jump.
    jumps: Vec<Vec<f64>>,
    /// Of each channel, sum (s) and number of the ages of its rows at the frames.
    ages: Vec<(f64, u64)>,
    /// Number of frames without each reading.
    missing: [u64; readings::COUNT],
    /// Makes readings of the links of those of the body.
    mount: Option<BodyMount>,
}

impl Frames {
    /// Starts at the first row.
    pub fn new(plan: Plan, survey: Survey, mount: Option<BodyMount>) -> Self {
        let count = plan.channels.len();
        let mut frames = Self {
            mount,
            next: vec![0; count],
            jumps: Vec::new(),
            ages: vec![(0.0, 0); count],
            plan,
            survey,
            missing: [0; readings::COUNT],
        };
        frames.jumps = (0..count).map(|channel| frames.jumps_of(channel)).collect();
        frames
    }

    /// Whether there is a truth to compare with.
    pub fn has_truth(&self) -> bool {
        self.survey.truth.is_some()
    }

    /// The file or folder of the log.
    pub fn source(&self) -> PathBuf {
        self.plan.source.clone()
    }

    /// All frames, without readings of the body; of a log of both sides the wheels of one (0 left, 1
    /// right).
    pub fn all(&mut self, side: usize) -> Vec<SensorFrame> {
        match self.plan.is_of_both() {
            true => self.each(|time, values| side_frame(&whole_frame(time, values), side)),
            false => self.each(|time, values| frame(time, values, None)),
        }
    }

    /// All frames of a log of both sides.
    pub fn all_of_both(&mut self) -> Vec<WholeFrame> {
        self.each(whole_frame)
    }

    /// What `of` makes of the time (s) and the readings of each frame. It starts at the first row again.
    fn each<T>(&mut self, of: impl Fn(f64, &Values) -> T) -> Vec<T> {
        let reports: Vec<_> = self
            .survey
            .channels
            .iter()
            .map(|c| c.report.clone())
            .collect();
        let mut all = Vec::new();
        while let Some((time, values, _)) = self.next_values() {
            all.push(of(time, &values));
        }
        self.next.fill(0);
        self.ages.fill((0.0, 0));
        self.missing = [0; readings::COUNT];
        for (channel, report) in self.survey.channels.iter_mut().zip(reports) {
            channel.report = report;
        }
        all
    }

    /// The cells of a row of a channel; `None` beyond its ends.
    fn cells(&self, channel: usize, row: usize) -> Option<&[f64]> {
        let columns = self.plan.channels[channel].columns.len();
        self.survey.channels[channel]
            .cells
            .get(row * columns..(row + 1) * columns)
    }

    /// See [`Self::jumps`].
    fn jumps_of(&self, channel: usize) -> Vec<f64> {
        let rows = if channel == 0 {
            0
        } else {
            self.survey.channels[channel].times.len()
        };
        let of = |(_, formula): &(Reading, Formula)| {
            let value = |row: usize| formula.value(self.cells(channel, row)?);
            let change = |row: usize| {
                let [a, b, c] = [value(row)?, value(row + 1)?, value(row + 2)?];
                Some((c - 2.0 * b + a).abs()).filter(|change| *change > 0.0)
            };
            let mut changes: Vec<f64> = (0..rows).filter_map(change).collect();
            changes.sort_by(f64::total_cmp);
            // Nine of ten are not larger.
            changes
                .get(changes.len() * 9 / 10)
                .map_or(0.0, |usual| JUMP * usual)
        };
        self.plan.channels[channel]
            .readings
            .iter()
            .map(of)
            .collect()
    }

    /// Moves the readings of a row of a channel to the `time` (s) of a frame, if they do not jump
    /// there. Contact angles do.
    fn move_to(&mut self, time: f64, channel: usize, row: usize, values: &mut Values) {
        let times = &self.survey.channels[channel].times;
        let age = time - times[row];
        if age.is_nan() || age <= ROUNDING {
            return;
        }
        self.ages[channel].0 += age;
        let Some(step) = times.get(row + 1).map(|next| next - times[row]) else {
            return;
        };
        if step > LONGEST_STEP * self.survey.channels[channel].report.period {
            return;
        }
        let plan = &self.plan.channels[channel];
        for ((reading, formula), jump) in plan.readings.iter().zip(&self.jumps[channel]) {
            let value = |row: usize| formula.value(self.cells(channel, row)?);
            let change = |row: usize| Some(value(row + 1)? - value(row)?);
            let Some((now, by)) = value(row).zip(change(row)) else {
                continue;
            };
            let around = [row.checked_sub(1).and_then(change), change(row + 1)];
            let is_smooth = around
                .iter()
                .flatten()
                .all(|other| (by - other).abs() <= *jump);
            if is_smooth && !reading.is_contact_angle() {
                values[reading.index()] = Some(now + by * age / step);
            }
        }
    }

    /// The row of the truth nearest to a time (s), and, where it lies between two, the other one and the
    /// share of the way to it. `None` where no row is near.
    fn rows_of_truth(&self, channel: usize, time: f64) -> Option<(usize, Option<(usize, f64)>)> {
        let Channel { times, report, .. } = &self.survey.channels[channel];
        let after = times.partition_point(|at| *at <= time + ROUNDING);
        let away = |row: usize| times.get(row).map_or(f64::INFINITY, |at| (at - time).abs());
        let before = after.checked_sub(1);
        let (near, far) = match before {
            Some(before) if away(before) <= away(after) => (before, Some(after)),
            _ => (after, before),
        };
        if away(near) > NEAR * self.survey.channels[0].report.period {
            return None;
        }
        let step = far.map_or(f64::INFINITY, |far| away(near) + away(far));
        let is_between = away(near) > ROUNDING && step <= LONGEST_STEP * report.period;
        Some((
            near,
            far.filter(|_| is_between)
                .map(|far| (far, away(near) / step)),
        ))
    }

    /// The truth at the time of a frame, s.
    fn truth_at(&self, channel: usize, time: f64) -> Option<FoundTruth> {
        let (near, far) = self.rows_of_truth(channel, time)?;
        let columns = self.plan.channels[channel].truth.as_ref()?;
        let cells = self.cells(channel, near)?;
        match far.and_then(|(far, share)| Some((self.cells(channel, far)?, share))) {
            Some((far, share)) => columns.found(&columns.between(cells, far, share), time),
            None => columns.found(cells, time),
        }
    }

    /// Number of the frames from a time (s) on, and of those with a row of the truth; `None` without
    /// truth.
    pub fn frames_with_truth(&self, from: f64) -> Option<(usize, usize)> {
        let channel = self.plan.channels.iter().position(|c| c.truth.is_some())?;
        let times = self.survey.channels[0].times.iter();
        let counted = times.filter(|time| **time >= from);
        let with = |time: &&f64| self.rows_of_truth(channel, **time).is_some();
        Some((counted.clone().count(), counted.filter(with).count()))
    }

    /// Time of the next row of a channel, s.
    fn next_time(&self, channel: usize) -> Option<f64> {
        let times = &self.survey.channels[channel].times;
        times.get(self.next[channel]).copied()
    }

    /// Goes past the next row of a channel.
    fn take(&mut self, channel: usize) -> Values {
        let plan = &self.plan.channels[channel];
        let (row, columns) = (self.next[channel], plan.columns.len());
        self.next[channel] += 1;
        plan.values(&self.survey.channels[channel].cells[row * columns..(row + 1) * columns])
    }

    /// Time (s), readings and truth of the next frame.
    fn next_values(&mut self) -> Option<(f64, Values, Option<FoundTruth>)> {
        let time = self.next_time(0)?;
        let is_first = self.next[0] == 0;
        let (mut values, mut truth) = ([None; readings::COUNT], None);
        let mut add = |readings: Values| {
            for (own, new) in values.iter_mut().zip(readings) {
                *own = new.or(*own);
            }
        };
        add(self.take(0));
        for i in 1..self.plan.channels.len() {
            if self.plan.channels[i].truth.is_some() {
                truth = self.truth_at(i, time);
                continue;
            }
            let mut taken = 0;
            while let Some(at) = self.next_time(i).filter(|at| *at <= time + ROUNDING) {
                let row = self.next[i];
                let mut content = self.take(i);
                let is_newest = self.next_time(i).is_none_or(|at| at > time + ROUNDING);
                if is_newest {
                    self.ages[i].1 += 1;
                    self.move_to(time, i, row, &mut content);
                }
                let report = &mut self.survey.channels[i].report;
                // Before the first frame a row is as new as one period of its channel.
                if is_first && at <= time - report.period {
                    report.before_start += 1;
                } else {
                    add(content);
                    taken += 1;
                }
            }
            self.survey.channels[i].report.superseded += u64::saturating_sub(taken, 1);
        }
        for (count, value) in self.missing.iter_mut().zip(&values) {
            *count += u64::from(value.is_none());
        }
        Some((time, values, truth))
    }
}

impl Source for Frames {
    fn next_sample(&mut self) -> Result<Option<Sample>, RunError> {
        let Some((time, values, truth)) = self.next_values() else {
            return Ok(None);
        };
        let (mut of_plane, mut of_both) = (None, None);
        match truth {
            Some(FoundTruth::Plane(truth)) => of_plane = Some(*truth),
            Some(FoundTruth::Both(truth)) => of_both = Some(*truth),
            None => {}
        }
        let both = self.plan.is_of_both().then(|| BothSides {
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
        let frames = self.next.first().map_or(0, |next| *next as u64);
        // A column of steering without a value is of a wheel that is not steered.
        let is_empty = |r: &Reading| r.is_optional() && self.missing[r.index()] == frames;
        let present = Reading::all().filter(|r| self.plan.has(*r) && !is_empty(r));
        let missing = present.map(|r| (r.name().to_owned(), self.missing[r.index()]));
        let report = |(channel, (sum, count)): (&Channel, &(f64, u64))| ChannelReport {
            // A count of rows.
            age: if *count > 0 { sum / *count as f64 } else { 0.0 },
            ..channel.report.clone()
        };
        let channels = self.survey.channels.iter();
        let absent = match self.plan.is_of_both() {
            // Steering alone may be missing, and then is 0.
            true => Vec::new(),
            false => self.plan.absent(),
        };
        Some(LogReport {
            source: self.plan.source.display().to_string(),
            start: self.survey.origin.seconds() + self.plan.channels[0].offset,
            channels: channels.zip(&self.ages).map(report).collect(),
            missing: missing.collect(),
            absent: absent.iter().map(|r| r.name().to_owned()).collect(),
        })
    }
}

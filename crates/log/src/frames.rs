//! Channels with clocks and rates of their own, brought onto the times of the first one.
//!
//! A reading belongs to a frame if it is new since the last frame. Of several new ones the newest
//! counts.

use crate::plan::Plan;
use crate::readings::{self, Reading, Values, frame};
use crate::survey::Survey;
use robhaz_model::BodyMount;
use robhaz_run::{LogReport, RunError, Sample, Source};
use robhaz_sim::Truth;

/// Rows of two channels that differ by less have the same time, s: a time in seconds since 1970 is
/// rounded by 0.12 us, and an offset rounds it again.
const ROUNDING: f64 = 0.5e-6;

/// A log as a source of readings, frame by frame.
pub struct Frames {
    plan: Plan,
    survey: Survey,
    /// The next row of each channel.
    next: Vec<usize>,
    /// Number of frames without each reading.
    missing: [u64; readings::COUNT],
    /// Makes readings of the links of those of the body.
    mount: Option<BodyMount>,
}

impl Frames {
    /// Starts at the first row.
    pub fn new(plan: Plan, survey: Survey, mount: Option<BodyMount>) -> Self {
        Self {
            mount,
            next: vec![0; plan.channels.len()],
            plan,
            survey,
            missing: Default::default(),
        }
    }

    /// Time of the next row of a channel, s.
    fn next_time(&self, channel: usize) -> Option<f64> {
        let times = &self.survey.channels[channel].times;
        times.get(self.next[channel]).copied()
    }

    /// Goes past the next row of a channel.
    fn take(&mut self, channel: usize) -> (Values, Option<Truth>) {
        let plan = &self.plan.channels[channel];
        let (row, columns) = (self.next[channel], plan.columns.len());
        self.next[channel] += 1;
        plan.content(&self.survey.channels[channel].cells[row * columns..(row + 1) * columns])
    }
}

impl Source for Frames {
    fn next_sample(&mut self) -> Result<Option<Sample>, RunError> {
        let Some(time) = self.next_time(0) else {
            return Ok(None);
        };
        let is_first = self.next[0] == 0;
        let (mut values, mut truth) = (Values::default(), None);
        let mut add = |(readings, found): (Values, Option<Truth>)| {
            truth = found.or(truth);
            for (own, new) in values.iter_mut().zip(readings) {
                *own = new.or(*own);
            }
        };
        add(self.take(0));
        for i in 1..self.plan.channels.len() {
            let mut taken = 0;
            while let Some(at) = self.next_time(i).filter(|at| *at <= time + ROUNDING) {
                let content = self.take(i);
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
        Ok(Some(Sample {
            time,
            truth: truth.map(|truth| Truth { time, ..truth }),
            sensors: frame(time, &values, self.mount.as_mut()),
            is_record: true,
        }))
    }

    fn mean_step(&self) -> Option<f64> {
        None
    }

    /// What became of the rows so far.
    fn log_report(&self) -> Option<LogReport> {
        let present = Reading::all().filter(|r| self.plan.has(*r));
        let missing = present.map(|r| (r.name().to_owned(), self.missing[r.index()]));
        let (channels, absent) = (self.survey.channels.iter(), self.plan.absent());
        Some(LogReport {
            source: self.plan.source.display().to_string(),
            start: self.survey.origin.seconds() + self.plan.channels[0].offset,
            channels: channels.map(|c| c.report.clone()).collect(),
            missing: missing.collect(),
            absent: absent.iter().map(|r| r.name().to_owned()).collect(),
        })
    }
}

//! Channels with clocks and rates of their own, brought onto the times of the first one.
//!
//! A reading belongs to a frame if it is new since the last frame. Of several new ones the newest counts.

use crate::error::LogError;
use crate::events::Events;
use crate::kept::Kept;
use crate::order::{Accept, GAP, Order};
use crate::plan::{Content, Plan};
use crate::readings::Values;
use crate::survey::Survey;
use robhaz_run::{ChannelReport, LogReport};
use robhaz_sim::Truth;
use std::collections::VecDeque;

/// Time for which frames wait for a slower channel, s. Channels of one file may be written one after another.
const LONGEST_WAIT: f64 = 10.0;
/// Rows of two channels that differ by less have the same time, s: a time in seconds since 1970 is rounded by 0.12 us, and an
/// offset rounds it again.
const ROUNDING: f64 = 0.5e-6;

/// A frame.
#[derive(Clone, Debug)]
pub struct LogFrame {
    /// Time since the first frame, s.
    pub time: f64,
    /// The readings that are new.
    pub values: Values,
    /// The truth, if it is new.
    pub truth: Option<Truth>,
}

/// One channel while it is read.
struct Channel {
    order: Order,
    /// Rows that no frame has had, with their times, s.
    waiting: VecDeque<(f64, Content)>,
    /// Time of the newest row, s.
    newest: f64,
    ended: bool,
    report: ChannelReport,
}

/// Reads a log frame by frame.
pub struct Frames {
    plan: Plan,
    survey: Survey,
    events: Box<dyn Events>,
    channels: Vec<Channel>,
    /// Time of the last frame, s.
    last: Option<f64>,
    /// Number of frames without each reading.
    missing: [u64; crate::readings::COUNT],
}

impl Frames {
    /// Starts at the first row: of those that the survey has kept, else of the files.
    pub fn new(plan: Plan, survey: Survey, kept: Option<Kept>) -> Result<Self, LogError> {
        let events = match kept {
            Some(kept) => Box::new(kept),
            None => plan.open()?,
        };
        let channel = |(plan, period): (&crate::plan::ChannelPlan, &f64)| Channel {
            order: Order::default(),
            waiting: VecDeque::new(),
            newest: f64::NEG_INFINITY,
            ended: false,
            report: ChannelReport {
                name: plan.name.clone(),
                period: *period,
                offset: plan.offset,
                ..ChannelReport::default()
            },
        };
        let channels = plan.channels.iter().zip(&survey.periods).map(channel);
        Ok(Self {
            channels: channels.collect(),
            plan,
            survey,
            events,
            last: None,
            missing: Default::default(),
        })
    }

    /// The next frame; `None` at the end of the log.
    ///
    /// # Errors
    /// [`LogError`]
    pub fn next_frame(&mut self) -> Result<Option<LogFrame>, LogError> {
        loop {
            let Some(&(time, _)) = self.channels[0].waiting.front() else {
                if self.channels[0].ended {
                    return Ok(None);
                }
                self.pull(0)?;
                continue;
            };
            let waited = self.channels[0].newest - time > LONGEST_WAIT;
            let behind = |c: &Channel| !(c.ended || c.newest > time + ROUNDING);
            match self.channels.iter().skip(1).position(behind) {
                Some(i) if !waited => self.pull(i + 1)?,
                _ => return Ok(self.take()),
            }
        }
    }

    /// Reads one row, of the wanted channel or of one that comes before it.
    fn pull(&mut self, wanted: usize) -> Result<(), LogError> {
        let Some(event) = self.events.next_event(wanted)? else {
            let channel = &mut self.channels[wanted];
            channel.ended = true;
            channel.report.cut_off = self.events.cut_off(wanted).map(str::to_owned);
            return Ok(());
        };
        let (plan, channel) = (
            &self.plan.channels[event.channel],
            &mut self.channels[event.channel],
        );
        let time = self
            .plan
            .time(event.channel, event.row.stamp, self.survey.origin);
        let report = &mut channel.report;
        report.rows += 1;
        match channel.order.accept(time) {
            Accept::Use(step) => {
                if let Some(step) = step.filter(|step| *step > GAP * report.period) {
                    note_gap(report, step, channel.newest);
                }
                channel.newest = time;
                channel
                    .waiting
                    .push_back((time, plan.content(&event.row.cells)));
            }
            Accept::Duplicate => report.duplicates += 1,
            Accept::SetBack(by) => {
                report.set_back += 1;
                report.late += 1;
                if report.largest_set_back.is_none_or(|most| by > most) {
                    report.largest_set_back = Some(by);
                    report.largest_set_back_at = Some(channel.newest);
                }
            }
            // The first reading has refused a clock that was set.
            Accept::Late | Accept::JumpBack(_) => report.late += 1,
        }
        Ok(())
    }

    /// The frame of the first waiting row of the time base.
    fn take(&mut self) -> Option<LogFrame> {
        let (time, content) = self.channels[0].waiting.pop_front()?;
        let mut frame = LogFrame {
            time,
            values: Values::default(),
            truth: None,
        };
        frame.add(content);
        let before = self.last.unwrap_or(time);
        for (channel, period) in self.channels.iter_mut().zip(&self.survey.periods).skip(1) {
            // Before the first frame a row is as new as one period of its channel.
            let oldest = if self.last.is_some() {
                before
            } else {
                before - period
            };
            let mut taken = 0;
            while channel
                .waiting
                .front()
                .is_some_and(|(at, _)| *at <= time + ROUNDING)
            {
                let Some((at, content)) = channel.waiting.pop_front() else {
                    break;
                };
                if at > oldest {
                    frame.add(content);
                    taken += 1;
                } else if self.last.is_none() {
                    channel.report.before_start += 1;
                } else {
                    channel.report.late += 1;
                }
            }
            channel.report.superseded += u64::saturating_sub(taken, 1);
        }
        for (count, value) in self.missing.iter_mut().zip(&frame.values) {
            *count += u64::from(value.is_none());
        }
        self.last = Some(time);
        Some(frame)
    }

    /// What became of the rows so far.
    pub fn report(&self) -> LogReport {
        let present = crate::readings::Reading::all().filter(|r| self.plan.has(*r));
        LogReport {
            source: self.plan.source.display().to_string(),
            start: self.survey.origin.seconds() + self.plan.channels[0].offset,
            channels: self.channels.iter().map(|c| c.report.clone()).collect(),
            missing: present
                .map(|r| (r.name().to_owned(), self.missing[r.index()]))
                .collect(),
            absent: self
                .plan
                .absent()
                .iter()
                .map(|r| r.name().to_owned())
                .collect(),
        }
    }
}

impl LogFrame {
    /// Adds what a row gives; what it lacks stays.
    fn add(&mut self, content: Content) {
        match content {
            Content::Truth(truth) => {
                self.truth = Some(Truth {
                    time: self.time,
                    ..*truth
                });
            }
            Content::Readings(values) => {
                for (own, new) in self.values.iter_mut().zip(values) {
                    *own = new.or(*own);
                }
            }
        }
    }
}

/// Counts a gap of a channel that starts at `start` (s).
fn note_gap(report: &mut ChannelReport, step: f64, start: f64) {
    report.gaps += 1;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates; the number is positive"
    )]
    let lost = (step / report.period).round() as u64;
    report.lost += lost.saturating_sub(1);
    if report.longest_gap.is_none_or(|longest| step > longest) {
        report.longest_gap = Some(step);
        report.longest_gap_at = Some(start);
    }
}

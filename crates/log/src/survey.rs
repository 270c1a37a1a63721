//! The first reading of a log: duration, rates and order of its time stamps. Nothing is written before it succeeds.

use crate::error::LogError;
use crate::events::{Event, Events};
use crate::kept::Kept;
use crate::order::{Accept, MedianStep, Order};
use crate::plan::Plan;
use crate::rows::Place;
use crate::stamp::Stamp;
use crate::truth::TruthRows;

/// What the first reading found.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// Time stamp of the first frame.
    pub origin: Stamp,
    /// Time from the first frame to the last, s.
    pub duration: f64,
    /// Median time between rows of each channel, s.
    pub periods: Vec<f64>,
    /// Which rows of the truth can be compared with; `None` without truth.
    pub truth: Option<TruthRows>,
}

/// The course of one channel.
#[derive(Default)]
struct Course {
    first: Option<Stamp>,
    last: Option<(Stamp, Place)>,
    order: Order,
    steps: MedianStep,
}

/// Reads all channels once: their time stamps, and whether every cell is a number. Returns the rows, too, where there is room
/// for them.
///
/// # Errors
/// [`LogError`]: a file that cannot be read, a time that jumps back, a channel without rows, or channels whose times
/// have nothing in common.
pub fn survey(plan: &Plan) -> Result<(Survey, Option<Kept>), LogError> {
    let mut events = plan.open()?;
    let mut kept = Kept::new(plan);
    let mut courses: Vec<Course> = plan.channels.iter().map(|_| Course::default()).collect();
    let of_truth = plan.channels.iter().find(|channel| channel.is_truth);
    let mut truth = of_truth.map(|channel| TruthRows::new(&channel.columns));
    for channel in 0..plan.channels.len() {
        while let Some(event) = events.next_event(channel)? {
            add(plan, &mut courses, &event)?;
            kept.add(&event);
            if let Some(truth) = truth
                .as_mut()
                .filter(|_| plan.channels[event.channel].is_truth)
            {
                truth.add(event.row.stamp, &event.row.cells);
            }
        }
    }
    let mut spans = Vec::new();
    for (i, course) in courses.iter().enumerate() {
        let (Some(first), Some((last, _))) = (course.first, course.last) else {
            return Err(empty(plan, i, events.as_ref()));
        };
        spans.push((first, last));
    }
    let Some(&(origin, end)) = spans.first() else {
        return Err(LogError::whole(&plan.source, "has no channel"));
    };
    let duration = end.since(origin);
    let periods = courses.into_iter().map(|c| c.steps.median());
    let periods: Vec<f64> = periods.map(|median| median.unwrap_or(duration)).collect();
    if duration <= 0.0 {
        let message = "has one row only, allowed: at least two with different times";
        return Err(problem(plan, 0, message));
    }
    for (i, (first, last)) in spans.iter().enumerate().skip(1) {
        let (from, to) = (plan.time(i, *first, origin), plan.time(i, *last, origin));
        if to < -periods[i] || from > duration {
            let base = &plan.channels[0].name;
            let message = format!(
                "has times from {from:.3} to {to:.3} s after the start of {base}, which lasts {duration:.3} s: no row in common; \
                 set the channel's `offset` if its clock differs"
            );
            return Err(problem(plan, i, message));
        }
    }
    let survey = Survey {
        origin,
        duration,
        periods,
        truth,
    };
    Ok((survey, kept.at_end(events.as_ref())))
}

fn add(plan: &Plan, courses: &mut [Course], event: &Event) -> Result<(), LogError> {
    let (course, row) = (&mut courses[event.channel], &event.row);
    let first = *course.first.get_or_insert(row.stamp);
    match course.order.accept(row.stamp.since(first)) {
        Accept::JumpBack(by) => {
            let before = course
                .last
                .map_or(String::new(), |(_, place)| format!(" after {place}"));
            let message = format!(
                "the time jumps back by {by:.3} s{before}: a clock that was set, or two recordings in one; split the log there"
            );
            let path = plan.channels[event.channel].place.path();
            return Err(LogError::place(path, row.place.to_string(), message));
        }
        Accept::Use(step) => {
            step.into_iter().for_each(|step| course.steps.add(step));
            course.last = Some((row.stamp, row.place));
        }
        Accept::Duplicate | Accept::Late | Accept::SetBack(_) => {}
    }
    Ok(())
}

fn empty(plan: &Plan, channel: usize, events: &dyn Events) -> LogError {
    let message = match events.cut_off(channel) {
        Some(why) => format!("has no complete row: cut off at {why}"),
        None => "has no row".to_owned(),
    };
    problem(plan, channel, message)
}

fn problem(plan: &Plan, channel: usize, message: impl Into<String>) -> LogError {
    let channel = &plan.channels[channel];
    LogError::place(
        channel.place.path(),
        format!("channel {}", channel.name),
        message,
    )
}

impl Plan {
    /// Time of a channel's stamp since the first frame, s. `origin` is the stamp of the first frame.
    pub fn time(&self, channel: usize, stamp: Stamp, origin: Stamp) -> f64 {
        let offset = |i: usize| self.channels.get(i).map_or(0.0, |c| c.offset);
        let difference = offset(channel) - offset(0);
        let time = stamp.since(origin);
        // Adding zero would change the sign of a zero.
        if difference == 0.0 {
            time
        } else {
            time + difference
        }
    }
}

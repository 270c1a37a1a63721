//! The progress bar of a run, on a terminal only; the speed at which a run is played.

use crate::interrupt::{self, POLL_TIME};
use crate::terminal::Output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::time::{Duration, Instant};

/// The bar, hidden with `--quiet`.
pub fn bar(bar: ProgressBar) -> ProgressBar {
    if Output::get().quiet {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    bar
}

/// A sink that shows the progress of the simulated time. Hidden if standard error is not a
/// terminal.
pub struct Progress {
    bar: ProgressBar,
    /// Number of records between two updates of the bar: an update for each would cost more than
    /// the estimators.
    every: u64,
    count: u64,
}

impl Progress {
    /// A bar that has not started.
    pub fn new() -> Self {
        Self {
            bar: ProgressBar::hidden(),
            every: 1,
            count: 0,
        }
    }
}

impl Sink for Progress {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let total = run.record.count();
        self.every = (total / 500).max(1);
        self.bar = bar(ProgressBar::new(total));
        let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %  {eta} left")?;
        self.bar.set_style(style);
        self.bar.set_message(run.name.clone());
        Ok(())
    }

    fn frame(&mut self, _frame: &Frame<'_>) -> Result<(), SinkError> {
        self.count += 1;
        if self.count.is_multiple_of(self.every) {
            self.bar.set_position(self.count);
        }
        Ok(())
    }

    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.bar.finish_and_clear();
        Ok(())
    }
}

/// Speed of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Pace {
    /// As fast as possible.
    Fast,
    /// Not faster than real time.
    RealTime,
}

/// A sink that delays a run until the real time of each record, from the first one on. An interrupt
/// ends the delay.
pub fn pace(pace: Pace) -> impl FnMut(&Frame<'_>) -> Result<(), SinkError> {
    let mut start = None;
    move |frame| {
        let start = *start.get_or_insert_with(Instant::now);
        let due = match pace {
            Pace::Fast => Duration::ZERO,
            Pace::RealTime => Duration::from_secs_f64(frame.time),
        };
        loop {
            let left = due.saturating_sub(start.elapsed());
            if left.is_zero() || interrupt::cause().is_some() {
                return Ok(());
            }
            std::thread::sleep(left.min(POLL_TIME));
        }
    }
}

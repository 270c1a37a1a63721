//! How fast a run may go.

use crate::interrupt::{Interrupt, POLL_TIME};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::time::{Duration, Instant};

/// How fast a run may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Pace {
    /// As fast as it can.
    Fast,
    /// No faster than the clock.
    RealTime,
}

/// A sink that holds a run back until the clock has come to each record.
pub struct PaceSink {
    pace: Pace,
    start: Instant,
    interrupt: Interrupt,
}

impl PaceSink {
    /// A sink whose clock starts with the run. An interrupt ends its waiting.
    pub fn new(pace: Pace, interrupt: &Interrupt) -> Self {
        Self {
            pace,
            start: Instant::now(),
            interrupt: interrupt.clone(),
        }
    }
}

impl Sink for PaceSink {
    fn begin(&mut self, _run: &RunDescription) -> Result<(), SinkError> {
        self.start = Instant::now();
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if self.pace == Pace::RealTime {
            let due = Duration::from_secs_f64(frame.time);
            loop {
                let left = due.saturating_sub(self.start.elapsed());
                if left.is_zero() || self.interrupt.cause().is_some() {
                    break;
                }
                std::thread::sleep(left.min(POLL_TIME));
            }
        }
        Ok(())
    }

    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

//! Speed of a run.

use crate::interrupt::{Interrupt, POLL_TIME};
use robhaz_run::{Frame, RunDescription, Sink, SinkError};
use std::time::{Duration, Instant};

/// Speed of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Pace {
    /// As fast as possible.
    Fast,
    /// Not faster than real time.
    RealTime,
}

/// A sink that delays a run until the real time of each record.
pub struct PaceSink {
    pace: Pace,
    start: Instant,
    interrupt: Interrupt,
}

impl PaceSink {
    /// A sink whose clock starts with the run. An interrupt ends the delay.
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
}

//! A log as a source of readings.

use crate::error::LogError;
use crate::frames::Frames;
use crate::readings::frame;
use robhaz_run::{LogReport, RunError, Sample, Source};

/// A log as a source of readings.
pub struct LogSource {
    frames: Frames,
}

impl LogSource {
    /// The source of a log's frames.
    pub(crate) fn new(frames: Frames) -> Self {
        Self { frames }
    }
}

impl Source for LogSource {
    fn next_sample(&mut self) -> Result<Option<Sample>, RunError> {
        let failed = |error: LogError| RunError::Readings(Box::new(error));
        let next = self.frames.next_frame().map_err(failed)?;
        Ok(next.map(|found| Sample {
            time: found.time,
            truth: found.truth,
            sensors: frame(found.time, &found.values),
            is_record: true,
        }))
    }

    fn mean_step(&self) -> Option<f64> {
        None
    }

    fn log_report(&self) -> Option<LogReport> {
        Some(self.frames.report())
    }
}

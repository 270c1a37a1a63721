//! A sink that writes a run as a Rerun recording.

use crate::ViewerError;
use crate::layout::Playing;
use crate::rates::{rates, thinning};
use crate::recorder::{Recorder, Sampler, Ticker};
use crate::writer::{Background, RrdFile};
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use std::fs::File;
use std::path::Path;

/// Simulated time between two writes without thinning, s. A killed run loses at most that time, and what still waits to be
/// encoded.
const CHUNK_TIME: f64 = 2.0;

/// Writes a run as a Rerun recording, with the layout of its views.
///
/// New records are written every two simulated seconds, so that a run that breaks off or is killed leaves a readable
/// file. The animation has 60 Hz, the time series have 125 Hz. A run of more than 120 s is thinned in time: its recording has
/// as many frames and rows as one of 120 s. Events are detected at every record.
pub struct RecordingSink {
    destination: String,
    /// The empty file, until the run begins.
    file: Option<File>,
    /// Factor by which the run is thinned in time.
    thinning: f64,
    run: Option<Run>,
}

impl RecordingSink {
    /// A sink for a new file at `path`. An older file of that name is replaced immediately.
    ///
    /// # Errors
    /// [`ViewerError::Create`]
    pub fn save(path: &Path) -> Result<Self, ViewerError> {
        Ok(Self {
            destination: path.display().to_string(),
            file: Some(RrdFile::create(path)?),
            thinning: 1.0,
            run: None,
        })
    }

    /// Rates of the time series and of the animation (Hz of simulated time), if the run is so long that they are reduced.
    pub fn reduced_rates(&self) -> Option<[f64; 2]> {
        (self.thinning > 1.0).then(|| rates(self.thinning))
    }
}

impl Sink for RecordingSink {
    fn clearance_need(&self) -> ClearanceNeed {
        ClearanceNeed::AtChanges
    }

    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let destination = &self.destination;
        let file = self.file.take().ok_or_else(|| ViewerError::Used {
            destination: destination.clone(),
        })?;
        let file = RrdFile::begin(file).map_err(ViewerError::write(destination))?;
        self.thinning = thinning(run);
        self.run = Some(Run::begin(destination, file, run, self.thinning)?);
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let run = self.run.as_mut().ok_or_else(|| ViewerError::NotBegun {
            destination: self.destination.clone(),
        })?;
        Ok(run.frame(frame)?)
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // A run that has not begun needs no end.
        match self.run.take() {
            Some(run) => Ok(run.end(end)?),
            None => Ok(()),
        }
    }
}

/// The run that is being written.
struct Run {
    recorder: Recorder,
    sampler: Sampler,
    next_chunk: Ticker,
}

impl Run {
    fn begin(
        destination: &str,
        file: RrdFile,
        run: &RunDescription,
        thinning: f64,
    ) -> Result<Self, ViewerError> {
        let mut next_chunk = Ticker::new(thinning * CHUNK_TIME);
        next_chunk.is_due(0.0);
        let target = Background::start(file)?;
        Ok(Self {
            recorder: Recorder::begin(
                destination,
                Box::new(target),
                run,
                0,
                Playing::FromStart,
                thinning,
            )?,
            sampler: Sampler::new(run, thinning),
            next_chunk,
        })
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), ViewerError> {
        if let Some(due) = self.sampler.select(frame) {
            self.recorder.push(frame, due);
        }
        if self.next_chunk.is_due(frame.time) {
            self.recorder.flush(self.sampler.take())?;
        }
        Ok(())
    }

    fn end(mut self, end: Option<&RunEnd>) -> Result<(), ViewerError> {
        self.recorder.flush(self.sampler.end(end))?;
        self.recorder.finish()
    }
}

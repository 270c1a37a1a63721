//! A sink that writes a run as a Rerun recording.

use crate::ViewerError;
use crate::layout::Playing;
use crate::rates::{rates, thinning};
use crate::recorder::{Destination, Recorder, Ticker};
use crate::writer::RrdFile;
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use std::fs::File;
use std::path::Path;
use std::time::Duration;

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
    /// The run that is being written, and the time of its next write.
    run: Option<(Recorder, Ticker)>,
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
        let name = self.destination.clone();
        let file = self.file.take().ok_or_else(|| ViewerError::Used {
            destination: name.clone(),
        })?;
        let to = Destination {
            target: RrdFile::begin(file).map_err(ViewerError::write(&name))?,
            name,
            patience: Duration::MAX,
            playing: Playing::FromStart,
            salt: 0,
        };
        self.thinning = thinning(run);
        let mut next_write = Ticker::new(self.thinning * CHUNK_TIME);
        next_write.is_due(0.0);
        self.run = Some((Recorder::begin(to, run, self.thinning)?, next_write));
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let (recorder, next_write) = self.run.as_mut().ok_or_else(|| ViewerError::NotBegun {
            destination: self.destination.clone(),
        })?;
        recorder.push(frame, true);
        if next_write.is_due(frame.time) {
            recorder.flush()?;
            recorder.out.send_all()?;
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // A run that has not begun needs no end.
        if let Some((mut recorder, _)) = self.run.take() {
            recorder.end(end)?;
            recorder.out.finish(0)?;
        }
        Ok(())
    }
}

//! A sink that makes a Rerun recording of a run, in a file or in a viewer.

use crate::error::{Result, ViewerError};
use crate::explain::thinning;
use crate::program::{DEFAULT_PORT, Started, listens};
use crate::recorder::{Recorder, Recording};
use crate::target::Target;
use crate::whole::WholeRecorder;
use crate::writer::Writer;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError, Ticker};
use std::error::Error as _;
use std::ffi::OsStr;
use std::path::Path;
use std::time::{Duration, Instant};

/// Simulated time between two writes of a file without thinning, s. A killed run loses at most that
/// time, and what still waits to be encoded.
const CHUNK_TIME: f64 = 2.0;
/// Wall-clock time between two batches of a live run.
const BATCH_TIME: Duration = Duration::from_millis(50);

/// Makes a Rerun recording of a run, with the layout of its views: in a file, or in a viewer while
/// the run goes on.
///
/// New records are written to a file every two simulated seconds, so that a run that breaks off or
/// is killed leaves a readable file, and sent to a viewer every 50 ms. The animation has 60 Hz, the
/// time series have 125 Hz. A run of more than 120 s is thinned in time: its recording has as many
/// frames and rows as one of 120 s. Events are detected at every record. A viewer that is slow,
/// reads nothing or closes the connection neither delays nor stops the run.
pub struct RecordingSink {
    /// File or address.
    destination: String,
    /// Until the run begins.
    target: Option<Target>,
    /// The run that is being written, and the simulated time of its next write.
    run: Option<(Box<dyn Recording>, Ticker)>,
    /// When the next batch is sent to a viewer; `None` of a file.
    next_batch: Option<Instant>,
    lost: Option<String>,
}

impl RecordingSink {
    /// A sink for a new file at `path`. An older file of that name is replaced immediately.
    ///
    /// # Errors
    /// [`ViewerError::Io`]
    pub fn save(path: &Path) -> Result<Self> {
        let target = Target::create(path)?;
        Ok(Self::new(path.display().to_string(), target, None))
    }

    fn new(destination: String, target: Target, next_batch: Option<Instant>) -> Self {
        Self {
            destination,
            target: Some(target),
            run: None,
            next_batch,
            lost: None,
        }
    }

    /// A sink for the viewer that listens at an address: `HOST:PORT` or
    /// `rerun+http://HOST:PORT/proxy`.
    ///
    /// # Errors
    /// [`ViewerError::Address`], [`ViewerError::NoViewerListens`]
    pub fn connect(address: &str) -> Result<Self> {
        let (viewer, plain) = Target::connect(address)?;
        Ok(Self::new(plain, viewer, Some(Instant::now())))
    }

    /// A sink for the viewer that listens at the default port of this machine, or else for a new
    /// one. The viewer stays open after the run.
    ///
    /// # Errors
    /// [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`], [`ViewerError::Start`],
    /// [`ViewerError::NoViewerListens`]
    pub fn live() -> Result<Self> {
        if !listens(DEFAULT_PORT) {
            Started::at(DEFAULT_PORT, &[OsStr::new("--expect-data-soon")])?;
        }
        Self::connect(&format!("127.0.0.1:{DEFAULT_PORT}"))
    }

    /// After a live run whose viewer did not get all of it: the viewer's address, and the reason.
    pub fn lost(&self) -> Option<(&str, &str)> {
        self.lost.as_deref().map(|why| (&*self.destination, why))
    }

    /// Starts the recording of a run.
    fn start(&mut self, target: Target, run: &RunDescription) -> Result {
        let thinning = thinning(run);
        let out = Writer::start(&self.destination, target, run)?;
        let mut next_write = Ticker::new(thinning * CHUNK_TIME);
        next_write.is_due(0.0);
        let rover = run.both.as_ref().and(run.robot.whole_rover());
        let recording: Box<dyn Recording> = match rover {
            Some(rover) => Box::new(WholeRecorder::begin(out, rover, run, thinning)?),
            None => Box::new(Recorder::begin(out, run, thinning)?),
        };
        self.run = Some((recording, next_write));
        Ok(())
    }

    /// Keeps the failure of a viewer, and returns that of a file. Nothing more is recorded.
    fn fail(&mut self, error: ViewerError) -> Result<(), SinkError> {
        self.run = None;
        if self.next_batch.is_none() {
            return Err(error.into());
        }
        let cause = error.source().map(ToString::to_string);
        self.lost = Some(cause.unwrap_or_else(|| error.to_string()));
        Ok(())
    }
}

impl Sink for RecordingSink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let used = || ViewerError::Used(self.destination.clone());
        let target = self.target.take().ok_or_else(used)?;
        self.start(target, run).or_else(|error| self.fail(error))
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let Some((recorder, next_write)) = &mut self.run else {
            return Ok(());
        };
        recorder.push(frame);
        let is_due = match &mut self.next_batch {
            Some(next) if Instant::now() < *next => false,
            Some(next) => {
                *next = Instant::now() + BATCH_TIME;
                true
            }
            None => next_write.is_due(frame.time),
        };
        match is_due.then(|| recorder.flush()) {
            Some(Err(error)) => self.fail(error),
            _ => Ok(()),
        }
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // A run that has not begun needs no end.
        match self.run.take().map(|(mut recorder, _)| recorder.end(end)) {
            Some(Err(error)) => self.fail(error),
            _ => Ok(()),
        }
    }
}

//! A run on its way into a recording: what is kept of each record, and when it is logged.

use crate::ViewerError;
use crate::about;
use crate::event_log::EventLog;
use crate::events::{Found, Watch};
use crate::key;
use crate::layout::{self, Playing};
use crate::scene_view::SceneView;
use crate::series::Series;
use crate::writer::{Target, Writer};
use rerun::EntityPath;
use rerun::archetypes::{RecordingInfo, TextDocument};
use rerun::components::MediaType;
use robhaz_run::{EstimatorDescription, Frame, RunDescription};

/// Frames of the animation a simulated second, Hz.
const FRAME_RATE: f64 = 60.0;
/// Rows of the time series a simulated second, Hz. A record at 1 kHz is thinned to every eighth.
const SERIES_RATE: f64 = 125.0;
/// The estimator that is drawn in the scene, by its place: the last that knows its own errors, or else the last.
pub(crate) fn chosen(run: &RunDescription) -> Option<usize> {
    let estimators = &run.estimators;
    let knows = |e: &EstimatorDescription| e.settings.states_covariance();
    let preferred = estimators.iter().rposition(knows);
    preferred.or(estimators.len().checked_sub(1))
}

/// What a record is kept for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Due {
    /// A frame of the animation.
    pub(crate) view: bool,
    /// A row of the time series.
    pub(crate) series: bool,
}

/// Looks at every record of a run and thins them.
pub(crate) struct Sampler {
    watch: Watch,
    next_frame: Ticker,
    next_row: Ticker,
}

impl Sampler {
    /// A sampler before the first record of a run.
    pub(crate) fn new(run: &RunDescription) -> Self {
        Self {
            watch: Watch::new(run),
            next_frame: Ticker::new(1.0 / FRAME_RATE),
            next_row: Ticker::new(1.0 / SERIES_RATE),
        }
    }

    /// Looks at a record; says what to keep it for, if anything.
    pub(crate) fn look(&mut self, frame: &Frame<'_>) -> Option<Due> {
        self.watch.look(frame);
        let time = frame.time;
        let due = Due {
            view: self.next_frame.is_due(time),
            series: self.next_row.is_due(time),
        };
        (due.view || due.series).then_some(due)
    }

    /// Hands over the events found since the last time.
    pub(crate) fn take(&mut self) -> Found {
        self.watch.take()
    }

    /// The run has ended, or broken off: hands over what is left.
    pub(crate) fn end(&mut self, complete: bool) -> Found {
        self.watch.end(complete);
        self.take()
    }
}

/// Writes the recording of one run.
pub(crate) struct Recorder {
    out: Writer,
    /// `None` for recorded readings: nothing says where the robot is.
    view: Option<SceneView>,
    series: Series,
    log: EventLog,
}

impl Recorder {
    /// Starts a recording: layout, explanations, all that does not move. `salt` tells recordings of the same scene apart.
    pub(crate) fn begin(
        destination: &str,
        target: Box<dyn Target>,
        run: &RunDescription,
        salt: u64,
        playing: Playing,
    ) -> Result<Self, ViewerError> {
        let chosen = chosen(run);
        let world = run.world.as_ref();
        let view = world.map(|world| SceneView::new(run, world, chosen));
        let series = Series::new(run, chosen);
        let log = EventLog::new(run);

        // Two runs of one name must not mix in the viewer.
        let fingerprint = run.fingerprint ^ salt;
        let mut out = Writer::start(destination, target, &run.name, fingerprint)?;
        layout::run::log(&mut out, run, playing)?;
        out.constant(
            EntityPath::properties(),
            &RecordingInfo::update_fields().with_name(run.name.as_str()),
        )?;
        let page = TextDocument::new(about::page(run, chosen));
        out.constant("about", &page.with_media_type(MediaType::markdown()))?;
        key::log(&mut out, "key", &key::of_run(run))?;
        if let Some(view) = &view {
            view.declare(&mut out)?;
        }
        log.declare(&mut out)?;
        Ok(Self {
            out,
            view,
            series,
            log,
        })
    }

    /// Adds one record to what is kept.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, due: Due) {
        if let (Some(view), Some(truth), true) = (&mut self.view, frame.truth, due.view) {
            view.push(frame, truth);
        }
        if due.series {
            self.series.push(frame);
        }
    }

    /// Logs what has come since the last time, with the events found.
    pub(crate) fn flush(&mut self, found: Found) -> Result<(), ViewerError> {
        if let Some(view) = &mut self.view {
            view.flush(&mut self.out)?;
        }
        self.series.flush(&mut self.out)?;
        self.log.log(found, &mut self.out)
    }

    /// Closes the recording.
    pub(crate) fn finish(mut self) -> Result<(), ViewerError> {
        self.out.finish()
    }
}

/// Thins records to a period: due at the first record of each.
pub(crate) struct Ticker {
    period: f64,
    next: f64,
}

impl Ticker {
    /// A ticker (s) that is due at the first record.
    pub(crate) fn new(period: f64) -> Self {
        Self { period, next: 0.0 }
    }

    /// Is it due at a time, s?
    pub(crate) fn is_due(&mut self, time: f64) -> bool {
        // Times are sums of steps: what is due now must not wait for a rounding error.
        let periods = (time / self.period + 1e-6).floor();
        let due = periods >= self.next;
        if due {
            self.next = periods + 1.0;
        }
        due
    }
}

/// A number that tells texts apart (FNV-1a), the same in every version.
pub(crate) fn hash(text: &str) -> u64 {
    text.bytes().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 1 kHz record is thinned to exactly 60 frames and 200 rows a second, first and last record included.
    #[test]
    fn records_are_thinned_evenly() {
        for (rate, expected) in [(60.0, 121), (200.0, 401), (1000.0, 2001), (4000.0, 2001)] {
            let mut ticker = Ticker::new(1.0 / rate);
            let mut time = 0.0;
            let mut count = 0;
            for _ in 0..=2000 {
                count += i32::from(ticker.is_due(time));
                time += 1e-3;
            }
            assert_eq!(count, expected, "{rate} Hz");
        }
    }
}

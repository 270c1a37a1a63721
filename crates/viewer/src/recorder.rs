//! Turns the records of a run into a recording: selects the records to keep, and logs them.

use crate::ViewerError;
use crate::about;
use crate::event_log::EventLog;
use crate::events::{Found, Watch};
use crate::felt::{self, FeltCollector};
use crate::friction_tests::{self, TestPlaces};
use crate::key;
use crate::layout::{self, Playing};
use crate::rates::rates;
use crate::scene_view::SceneView;
use crate::series::Series;
use crate::writer::{Target, Writer};
use rerun::EntityPath;
use rerun::archetypes::{RecordingInfo, TextDocument};
use rerun::components::MediaType;
use robhaz_run::{EstimatorDescription, Frame, RunDescription, RunEnd};

/// Rate at which the ground that was found is drawn, Hz of simulated time.
const GROUND_RATE: f64 = 5.0;

/// Index of the estimator that the animation shows: the last that states a covariance, or else the last.
/// `None`: the run has no estimator.
pub(crate) fn chosen(run: &RunDescription) -> Option<usize> {
    let estimators = &run.estimators;
    let states_covariance = |e: &EstimatorDescription| e.settings.states_covariance();
    let preferred = estimators.iter().rposition(states_covariance);
    preferred.or(estimators.len().checked_sub(1))
}

/// The uses of a kept record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Due {
    /// A frame of the animation.
    pub(crate) view: bool,
    /// A row of the time series.
    pub(crate) series: bool,
}

/// Selects the records to keep, and detects events at every record.
pub(crate) struct Sampler {
    watch: Watch,
    felt: FeltCollector,
    tests: TestPlaces,
    next_frame: Ticker,
    next_row: Ticker,
    next_ground: Ticker,
}

impl Sampler {
    /// A sampler before the first record of a run, with all rates divided by `thinning`.
    pub(crate) fn new(run: &RunDescription, thinning: f64) -> Self {
        let [series, frames] = rates(thinning);
        Self {
            watch: Watch::new(run),
            felt: FeltCollector::new(run, chosen(run)),
            tests: TestPlaces::new(run),
            next_frame: Ticker::new(1.0 / frames),
            next_row: Ticker::new(1.0 / series),
            next_ground: Ticker::new(thinning / GROUND_RATE),
        }
    }

    /// Checks a record for events, and returns its uses. `None`: it is not kept.
    pub(crate) fn select(&mut self, frame: &Frame<'_>) -> Option<Due> {
        self.watch.sample(frame);
        if let Some(truth) = frame.truth {
            self.tests.sample(truth);
        }
        let time = frame.time;
        self.felt.sample(frame, self.next_ground.is_due(time));
        let due = Due {
            view: self.next_frame.is_due(time),
            series: self.next_row.is_due(time),
        };
        (due.view || due.series).then_some(due)
    }

    /// Takes the events since the last call.
    pub(crate) fn take(&mut self) -> Found {
        Found {
            felt: self.felt.take(),
            ..self.watch.take()
        }
    }

    /// Takes the remaining events at the end of the run, and the results of the friction tests.
    pub(crate) fn end(&mut self, end: Option<&RunEnd>) -> Found {
        self.watch.end(end);
        let results = end.map_or(&[][..], |end| &end.friction_tests);
        Found {
            tests: self.tests.marks(results),
            ..self.take()
        }
    }
}

/// Writes the recording of one run.
pub(crate) struct Recorder {
    out: Writer,
    /// `None` for recorded readings, which do not contain the robot's position.
    view: Option<SceneView>,
    series: Series,
    log: EventLog,
}

impl Recorder {
    /// Starts a recording with its layout, explanations, and everything that does not move. `salt` distinguishes
    /// recordings of the same run; `thinning` is that of the [`Sampler`].
    pub(crate) fn begin(
        destination: &str,
        target: Box<dyn Target>,
        run: &RunDescription,
        salt: u64,
        playing: Playing,
        thinning: f64,
    ) -> Result<Self, ViewerError> {
        let chosen = chosen(run);
        let world = run.world.as_ref();
        let view = world.map(|world| SceneView::new(run, world, chosen));
        let series = Series::new(run, chosen);
        let log = EventLog::new(run);

        // The viewer would mix two runs with the same identifier.
        let fingerprint = run.fingerprint ^ salt;
        let mut out = Writer::start(destination, target, &run.name, fingerprint)?;
        layout::run::log(&mut out, run, playing)?;
        out.constant(
            EntityPath::properties(),
            &RecordingInfo::update_fields().with_name(run.name.as_str()),
        )?;
        let page = TextDocument::new(about::page(run, chosen, thinning));
        out.constant("about", &page.with_media_type(MediaType::markdown()))?;
        key::log(&mut out, "key", &key::of_run(run))?;
        if let Some(view) = &view {
            view.declare(&mut out)?;
            if let Some(estimator) =
                chosen.filter(|k| run.estimators[*k].settings.states_covariance())
            {
                felt::declare(&mut out, estimator)?;
            }
        }
        log.declare(&mut out)?;
        Ok(Self {
            out,
            view,
            series,
            log,
        })
    }

    /// Keeps a record for its uses.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, due: Due) {
        if let (Some(view), Some(truth), true) = (&mut self.view, frame.truth, due.view) {
            view.push(frame, truth);
        }
        if due.series {
            self.series.push(frame);
        }
    }

    /// Logs the records that were kept since the last call, and events.
    pub(crate) fn flush(&mut self, found: Found) -> Result<(), ViewerError> {
        if let Some(view) = &mut self.view {
            view.flush(&mut self.out)?;
        }
        self.series.flush(&mut self.out)?;
        felt::log(&mut self.out, &found.felt)?;
        friction_tests::log(&mut self.out, &found.tests)?;
        self.log.log(found, &mut self.out)
    }

    /// Closes the recording.
    pub(crate) fn finish(mut self) -> Result<(), ViewerError> {
        self.out.finish()
    }
}

/// Selects the first record of each period.
pub(crate) struct Ticker {
    period: f64,
    next: f64,
}

impl Ticker {
    /// A ticker with a period (s), due at the first record.
    pub(crate) fn new(period: f64) -> Self {
        Self { period, next: 0.0 }
    }

    /// Whether the record at a time (s) is the first of its period.
    pub(crate) fn is_due(&mut self, time: f64) -> bool {
        // Times are sums of steps: a rounding error must not postpone a record to the next one.
        let periods = (time / self.period + 1e-6).floor();
        let due = periods >= self.next;
        if due {
            self.next = periods + 1.0;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: of 2 s at 1 kHz a ticker selects its rate times 2 s and the first record, at most all.
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

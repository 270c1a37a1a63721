//! Turns the records of a run into a recording: selects the records to keep, and logs them.

use crate::error::Result;
use crate::estimated_terrain::Terrain;
use crate::events::Events;
use crate::explain::{log_key, page, rates};
use crate::friction_tests;
use crate::layout;
use crate::scene_view::SceneView;
use crate::series::Series;
use crate::writer::Writer;
use robhaz_run::{EstimatorDescription, Frame, RunDescription, RunEnd, Ticker};

/// Rate at which the ground that was found is drawn, Hz of simulated time.
const GROUND_RATE: f64 = 5.0;

/// Index of the estimator that the animation shows: the last that states a covariance, or else the
/// last. `None`: the run has no estimator.
fn chosen(run: &RunDescription) -> Option<usize> {
    let estimators = &run.estimators;
    let states_covariance = |e: &EstimatorDescription| e.settings.states_covariance();
    let preferred = estimators.iter().rposition(states_covariance);
    preferred.or(estimators.len().checked_sub(1))
}

/// What a recording keeps of the records of a run.
pub(crate) trait Recording: Send {
    /// Takes a record.
    fn push(&mut self, frame: &Frame<'_>);

    /// Sends what was kept since the last call.
    fn flush(&mut self) -> Result;

    /// Logs the rest, and closes the recording.
    fn end(&mut self, end: Option<&RunEnd>) -> Result;
}

/// Writes the recording of one run.
pub(crate) struct Recorder {
    out: Writer,
    /// `None` for recorded readings, which do not contain the robot's position.
    view: Option<SceneView>,
    series: Series,
    events: Events,
    estimated_terrain: Terrain,

    next_frame: Ticker,
    next_row: Ticker,
    next_ground: Ticker,
}

impl Recorder {
    /// Starts a recording, with its layout, explanations, and everything that does not move. All
    /// rates are divided by `thinning`.
    pub(crate) fn begin(mut out: Writer, run: &RunDescription, thinning: f64) -> Result<Self> {
        let chosen = chosen(run);
        layout::log(&mut out, run)?;
        out.about(page(run, chosen, thinning))?;
        log_key(&mut out, run)?;
        let [series, frames] = rates(thinning);
        let world = run.world.as_ref();
        let mut recorder = Self {
            view: world.map(|world| SceneView::new(run, world, chosen)),
            series: Series::new(run, chosen),
            events: Events::new(run),
            estimated_terrain: Terrain::new(run, chosen),

            next_frame: Ticker::new(1.0 / frames),
            next_row: Ticker::new(1.0 / series),
            next_ground: Ticker::new(thinning / GROUND_RATE),
            out,
        };
        let out = &mut recorder.out;
        if let Some(view) = &recorder.view {
            view.declare(out)?;
        }
        recorder.estimated_terrain.declare(out)?;
        recorder.events.declare(out)?;
        Ok(recorder)
    }
}

impl Recording for Recorder {
    /// Keeps a frame of the animation, and a row of the time series.
    fn push(&mut self, frame: &Frame<'_>) {
        let time = frame.time;
        self.events.sample(frame);
        let is_ground = self.next_ground.is_due(time);
        self.estimated_terrain.sample(frame, is_ground);
        let is_frame = self.next_frame.is_due(time);
        if let (Some(view), Some(truth), true) = (&mut self.view, frame.truth, is_frame) {
            view.push(frame, truth);
        }
        if self.next_row.is_due(time) {
            self.series.push(frame);
        }
    }

    fn flush(&mut self) -> Result {
        let out = &mut self.out;
        if let Some(view) = &mut self.view {
            view.flush(out)?;
        }
        self.series.flush(out)?;
        self.estimated_terrain.flush(out)?;
        self.events.flush(out)
    }

    /// Logs the results of the friction tests, too.
    fn end(&mut self, end: Option<&RunEnd>) -> Result {
        self.events.end(end);
        self.flush()?;
        if let Some((view, end)) = self.view.as_ref().zip(end) {
            let radius = view.robot.geometry.wheel_radius;
            friction_tests::log(&mut self.out, &view.ground.terrain, radius, end)?;
        }
        self.out.finish()
    }
}

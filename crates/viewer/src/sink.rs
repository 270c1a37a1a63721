//! A sink that writes a run as a Rerun recording.

use crate::ViewerError;
use crate::about;
use crate::events::Events;
use crate::layout;
use crate::rrd::RrdWriter;
use crate::scene_view::SceneView;
use crate::series::Series;
use re_sdk::EntityPath;
use re_sdk_types::archetypes::{RecordingInfo, TextDocument};
use re_sdk_types::components::MediaType;
use robhaz_run::{Frame, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Frames of the animation a simulated second, Hz.
const FRAME_RATE: f64 = 60.0;
/// Rows of the time series a simulated second, Hz. A record at 1 kHz is thinned to every fourth.
const SERIES_RATE: f64 = 250.0;
/// Simulated time between two writes, s: what a killed run can lose.
const CHUNK_TIME: f64 = 2.0;
/// The estimator whose forces are drawn in the scene, where the scene has it.
const PREFERRED: &str = "true-mass";

/// Writes a run as a Rerun recording, with the layout that shows it.
///
/// Every two simulated seconds what has come is written; a run that breaks off or is killed leaves a readable file.
/// Geometry is kept at 60 Hz, time series at 250 Hz; events are looked for at every record.
pub struct RecordingSink {
    path: PathBuf,
    /// The empty file, until the run begins.
    file: Option<File>,
    run: Option<Run>,
}

impl RecordingSink {
    /// A recording to be written to `path`; an older file of that name is replaced at once.
    ///
    /// # Errors
    /// [`ViewerError::Create`]
    pub fn save(path: &Path) -> Result<Self, ViewerError> {
        let file = File::create(path).map_err(|source| ViewerError::Create {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            file: Some(file),
            run: None,
        })
    }

    fn run(&mut self) -> Result<&mut Run, ViewerError> {
        self.run.as_mut().ok_or_else(|| ViewerError::NotBegun {
            path: self.path.clone(),
        })
    }
}

impl Sink for RecordingSink {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        let file = self.file.take().ok_or_else(|| ViewerError::Used {
            path: self.path.clone(),
        })?;
        self.run = Some(Run::begin(&self.path, file, scene)?);
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        Ok(self.run()?.frame(frame)?)
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // Without a beginning there is nothing to end.
        match self.run.take() {
            Some(run) => Ok(run.end(end.is_some())?),
            None => Ok(()),
        }
    }
}

/// A run while it is being written.
struct Run {
    out: RrdWriter,
    /// The estimator drawn in the scene, by its place.
    chosen: Option<usize>,
    view: SceneView,
    series: Series,
    events: Events,
    next_frame: Ticker,
    next_row: Ticker,
    next_chunk: Ticker,
}

impl Run {
    fn begin(path: &Path, file: File, scene: &Scene) -> Result<Self, ViewerError> {
        let names: Vec<&str> = scene.estimators.iter().map(|e| e.name.as_str()).collect();
        let chosen = names
            .iter()
            .position(|name| *name == PREFERRED)
            .or(names.len().checked_sub(1));
        let view = SceneView::new(scene);
        let series = Series::new(scene, chosen);

        let mut out = RrdWriter::start(path, file, &scene.name, fingerprint(scene))?;
        let shown = layout::Shown {
            ground: view.ground_box(),
            mu_s: scene.friction.mu_s,
        };
        layout::log(&mut out, &shown)?;
        out.constant(
            EntityPath::properties(),
            &RecordingInfo::update_fields().with_name(scene.name.as_str()),
        )?;
        let page = about::page(scene, view.scale(), chosen);
        let page = TextDocument::new(page).with_media_type(MediaType::markdown());
        out.constant("about", &page)?;
        view.declare(&mut out, chosen.map(|k| names[k]))?;
        series.declare(&mut out)?;

        let mut next_chunk = Ticker::new(CHUNK_TIME);
        next_chunk.is_due(0.0);
        Ok(Self {
            out,
            chosen,
            view,
            series,
            events: Events::new(scene),
            next_frame: Ticker::new(1.0 / FRAME_RATE),
            next_row: Ticker::new(1.0 / SERIES_RATE),
            next_chunk,
        })
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), ViewerError> {
        let time = frame.truth.time;
        self.events.push(frame);
        if self.next_frame.is_due(time) {
            self.view.push(frame, self.chosen);
        }
        if self.next_row.is_due(time) {
            self.series.push(frame, self.chosen);
        }
        if self.next_chunk.is_due(time) {
            self.flush()?;
        }
        Ok(())
    }

    fn end(mut self, complete: bool) -> Result<(), ViewerError> {
        self.events.end(complete);
        self.flush()?;
        self.out.finish()
    }

    fn flush(&mut self) -> Result<(), ViewerError> {
        self.view.flush(&mut self.out)?;
        self.series.flush(&mut self.out)?;
        self.events.flush(&mut self.out)
    }
}

/// Thins records to a period: due at the first record of each.
struct Ticker {
    period: f64,
    next: f64,
}

impl Ticker {
    fn new(period: f64) -> Self {
        Self { period, next: 0.0 }
    }

    fn is_due(&mut self, time: f64) -> bool {
        // Times are sums of steps: what is due now must not wait for a rounding error.
        let periods = (time / self.period + 1e-6).floor();
        let due = periods >= self.next;
        if due {
            self.next = periods + 1.0;
        }
        due
    }
}

/// A number that tells scenes apart (FNV-1a of everything a scene holds), so that two runs of one name do not mix in the viewer.
fn fingerprint(scene: &Scene) -> u64 {
    format!("{scene:?}")
        .bytes()
        .fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 1 kHz record is thinned to exactly 60 frames and 250 rows a second, first and last record included.
    #[test]
    fn records_are_thinned_evenly() {
        for (rate, expected) in [(60.0, 121), (250.0, 501), (1000.0, 2001), (4000.0, 2001)] {
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

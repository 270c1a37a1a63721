//! Figures of a run for print: Figs. 5 to 8 of the paper, N of every other estimator, and the robot on the
//! ground. All else is in the recording for the viewer.

mod page;
mod panel;
mod paper;
mod path;
mod run;
pub mod style;
mod trace;

pub use page::{Entry, Mark, Page, Scale, write_figure};
pub use panel::{Axis, Layer, Panel};
pub use path::{SPACING, Strip};
pub use robhaz_score::extremes;
pub use trace::{Estimated, Trace};

use crate::error::{Result, create_folder};
use rayon::prelude::*;
use robhaz_model::Suspension;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use run::RunTraces;
use std::path::{Path, PathBuf};

/// Draws a run. Each figure is an SVG file.
///
/// | file | shows |
/// |---|---|
/// | `fig5_linkage` | pins P, R and S from Q, true and estimated |
/// | `fig6_forces` | N and T of every wheel, true and estimated |
/// | `fig7_NAME`, `fig8_NAME` | N of every wheel, true and estimated by the presets `paper-body`, `paper-wheels` |
/// | `normal_force_NAME` | the same of any other estimator; with a covariance also the error, and two standard deviations |
/// | `path` | the robot on the ground, and N over the position of the wheels |
///
/// Figs. 5 and 6 show the preset `true-mass`, if the run has it, otherwise the last estimator; of a log of
/// both sides Fig. 6 shows both. A
/// run that breaks off is drawn as far as it went. Records are reduced to the resolution of the
/// figures. Without truth the figures show the estimates alone, and there is no `path`.
pub struct FigureSink {
    folder: PathBuf,
    run: Option<RunTraces>,
}

/// File names in the order of a page; the label of an estimator follows after `_`.
pub(crate) const NAMES: [&str; 7] = [
    "path",
    "needed_friction",
    "fig5_linkage",
    "fig6_forces",
    "fig7_",
    "fig8_",
    "normal_force_",
];

impl FigureSink {
    /// A sink for a folder, which is created where it does not exist.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_path_buf(),
            run: None,
        }
    }

    /// Whether a file of this name can be a figure of a run with these estimators.
    pub fn can_write(file: &str, estimators: &[&str]) -> bool {
        let Some((stem, "svg")) = file.rsplit_once('.') else {
            return false;
        };
        NAMES.iter().any(|name| match name.ends_with('_') {
            true => (stem.strip_prefix(name)).is_some_and(|e| estimators.contains(&e)),
            // That of a judged path is of no run.
            false => stem == *name && stem != "needed_friction",
        })
    }
}

impl Sink for FigureSink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        create_folder(&self.folder)?;
        self.run = Some(RunTraces::new(run));
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(run) = &mut self.run {
            run.add(frame);
        }
        Ok(())
    }

    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        let Some(mut run) = self.run.take().filter(|run| run.end > 0.0) else {
            return Ok(());
        };
        run.finish();
        let run = &run;
        let mut figures: Vec<(String, Page)> = Vec::new();
        if run.has_truth || !run.estimators.is_empty() {
            if run.geometry.suspension == Suspension::FourBar {
                figures.push(("fig5_linkage".to_owned(), paper::linkage(run)));
            }
            figures.push(("fig6_forces".to_owned(), paper::forces(run)));
        }
        for e in &run.estimators {
            figures.push((e.figure.0.clone(), paper::normal_forces(run, e)));
        }
        if let Some(ground) = run.ground.as_ref().filter(|_| !run.poses.is_empty()) {
            figures.push(("path".to_owned(), path::path(run, ground)));
        }
        // On all cores: all of them, and the first failure.
        let write = |(stem, page): &(String, Page)| write_figure(&self.folder, stem, page);
        let written: Vec<_> = figures.par_iter().map(write).collect();
        Ok(written.into_iter().collect::<Result>()?)
    }
}

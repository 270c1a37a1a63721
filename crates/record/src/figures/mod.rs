//! Figures of a run: Figs. 5 to 8 of the paper, all estimators, and the robot on the ground.

mod clip;
mod comparison;
mod files;
mod ground;
mod header;
mod helvetica;
mod kind;
mod needed_friction;
mod page;
mod panel;
mod paper;
mod path;
mod run;
mod strips;
mod style;
mod trace;

use crate::error::{RecordError, check_name, io_error};
use files::Picture;
use ground::GroundTraces;
use needed_friction::NeededFriction;
use rayon::prelude::*;
use robhaz_path::{PathReport, PathSetup};
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use run::{EstimatorTraces, RunTraces};
use std::path::{Path, PathBuf};

/// Draws a run. Each figure is an SVG file.
///
/// | file | shows |
/// |---|---|
/// | `fig5_linkage` | pins P, R and S from Q, true and estimated |
/// | `fig6_forces` | N and T of every wheel, true and estimated |
/// | `fig7_NAME`, `fig8_NAME` | N of every wheel, true and estimated by the presets `paper-body`, `paper-wheels` |
/// | `normal_force_NAME` | the same of any other estimator; with a covariance also the error, and two standard deviations |
/// | `needed_friction_NAME` | needed friction T/N of every wheel, of an estimator that states its standard deviation |
/// | `comparison` | errors of N of all estimators |
/// | `ground_NAME` | the ground that an estimator has found, its errors, and two standard deviations |
/// | `path` | the robot on the ground, and N over the position of the wheels |
///
/// Figs. 5 and 6 show the preset `true-mass`, if the run has it, otherwise the last estimator. A run that breaks off
/// is drawn as far as it went. Records are reduced to the resolution of the figures. Without truth the figures show
/// the estimates alone, and there is no `comparison` and no `path`.
pub struct FigureSink {
    folder: PathBuf,
    run: Option<RunTraces>,
}

/// Start of the names of the figures of the needed friction.
const NEEDED_FRICTION: &str = "needed_friction_";

/// Draws and writes one figure. They do not depend on each other, and are drawn on all cores.
type Figure<'a> = Box<dyn Fn() -> Result<(), RecordError> + Send + Sync + 'a>;

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
        // Earlier versions wrote each figure as PDF, too.
        let Some((stem, "svg" | "pdf")) = file.rsplit_once('.') else {
            return false;
        };
        let of_all = ["fig5_linkage", "fig6_forces", "comparison", "path"];
        let of_one = [
            "fig7_",
            "fig8_",
            "normal_force_",
            NEEDED_FRICTION,
            "ground_",
        ];
        let estimator = of_one.iter().find_map(|start| stem.strip_prefix(start));
        of_all.contains(&stem) || estimator.is_some_and(|e| estimators.contains(&e))
    }

    fn draw(&mut self, end: Option<&RunEnd>) -> Result<(), RecordError> {
        let Some(mut run) = self.run.take().filter(|run| run.end > 0.0) else {
            return Ok(());
        };
        run.finish(end);
        let (run, folder) = (&run, self.folder.as_path());
        let mut figures: Vec<Figure<'_>> = Vec::new();
        if run.has_truth() || run.shown.is_some() {
            figures.push(Box::new(|| {
                write_picture(folder, "fig5_linkage", &paper::linkage(run))
            }));
            figures.push(Box::new(|| {
                write_picture(folder, "fig6_forces", &paper::forces(run))
            }));
        }
        for estimator in &run.estimators {
            let (stem, _) = estimator.kind.names(&estimator.name);
            let write = move || write_picture(folder, &stem, &paper::normal_forces(run, estimator));
            figures.push(Box::new(write));
        }
        let states = |e: &&EstimatorTraces| e.needed_band.iter().any(|band| !band.is_empty());
        for estimator in run.estimators.iter().filter(states) {
            let stem = format!("{NEEDED_FRICTION}{}", estimator.name);
            let write =
                move || write_picture(folder, &stem, &paper::needed_friction(run, estimator));
            figures.push(Box::new(write));
        }
        if run.has_truth() && !run.estimators.is_empty() {
            let write = || write_picture(folder, "comparison", &comparison::comparison(run));
            figures.push(Box::new(write));
        }
        for (k, estimator) in run.estimators.iter().enumerate() {
            figures.push(Box::new(move || {
                let points = run.felt.compared(k, run.ground.as_ref());
                match GroundTraces::new(&estimator.name, &points) {
                    Some(traces) => write_picture(folder, &traces.stem(), &traces.page(run)),
                    None => Ok(()),
                }
            }));
        }
        figures.push(Box::new(|| match path::path(run) {
            Some(path) => write_picture(folder, "path", &path),
            None => Ok(()),
        }));
        // All of them, and the first failure.
        let written: Vec<_> = figures.par_iter().map(|write| write()).collect();
        written.into_iter().collect()
    }
}

/// Writes a figure into a folder.
fn write_picture(folder: &Path, stem: &str, picture: &impl Picture) -> Result<(), RecordError> {
    let path = folder.join(format!("{stem}.svg"));
    let bytes = files::svg(picture).map_err(|reason| RecordError::Figure {
        path: path.clone(),
        reason,
    })?;
    std::fs::write(&path, bytes).map_err(io_error("write", &path))
}

/// Writes the figure `needed_friction` of a judged path into an existing folder. Without a place there is none.
pub fn write_needed_friction(
    folder: &Path,
    setup: &PathSetup,
    report: &PathReport,
) -> Result<(), RecordError> {
    match NeededFriction::new(setup, report) {
        Some(picture) => write_picture(folder, "needed_friction", &picture),
        None => Ok(()),
    }
}

impl Sink for FigureSink {
    fn clearance_need(&self) -> ClearanceNeed {
        ClearanceNeed::Never
    }

    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        for estimator in &run.estimators {
            check_name(&estimator.label, &self.folder)?;
        }
        std::fs::create_dir_all(&self.folder).map_err(io_error("create", &self.folder))?;
        self.run = Some(RunTraces::new(run));
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(run) = &mut self.run {
            run.add(frame);
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(self.draw(end)?)
    }
}

#[cfg(test)]
mod tests;

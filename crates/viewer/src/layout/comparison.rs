//! The layout of a comparison: animations side by side, true forces in the same plots, errors side by side.

use super::{ContainerKind, Layout, Part, Playing, parts};
use crate::ViewerError;
use crate::ground::Ground;
use crate::key::of_run as key_of_run;
use crate::series::WHEEL_NAMES;
use crate::writer::Writer;
use rerun::components::Range1D;
use robhaz_run::RunDescription;
use std::path::Path;

/// A run to be compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparedRun<'a> {
    /// Name of the run in the comparison.
    pub label: &'a str,
    /// Its description.
    pub description: &'a RunDescription,
    /// Its recording, written by [`crate::RecordingSink`].
    pub recording: &'a Path,
}

/// The entity above those of a run, by the index of the run: `/run1/` for 0.
pub(crate) fn root(index: usize) -> String {
    format!("/run{}/", index + 1)
}

/// Logs the layout and makes it the active one. `largest_error` is the largest RMS error of N of the wheels in any run,
/// N.
pub(crate) fn log(
    out: &mut Writer,
    runs: &[ComparedRun<'_>],
    largest_error: f64,
) -> Result<(), ViewerError> {
    let mut layout = Layout::new(out);
    let scenes = side_by_side(&mut layout, "Scenes", runs, |layout, run, root| {
        let mut views = Vec::new();
        if let Some(world) = &run.description.world {
            let ground = Ground::new(run.description, world);
            let name = format!("{}: whole run [m]", run.label);
            views.push((parts::overview(layout, &name, root, &ground)?, 1.7));
            let name = format!("{} [m]", run.label);
            views.push((parts::following(layout, &name, root, true)?, 2.4));
        }
        layout.container(ContainerKind::Vertical, run.label, &views)
    })?;
    let key = parts::key(&mut layout, "/compared/key", runs.len())?;
    // One scene with corners sets the range of all runs.
    let range = |from, to| {
        let mut ranges = runs.iter();
        ranges.find_map(|run| parts::range_of_loads(run.description, from, to))
    };
    let errors = range(0.0, 1.0).unwrap_or(Range1D::new(0.0, 1.05 * largest_error));
    let errors = (largest_error > 0.0).then_some(errors);
    let mut truth = Vec::new();
    for (i, wheel) in WHEEL_NAMES.iter().enumerate() {
        let contents = [format!("+ /compared/normal_force/wheel{}/**", i + 1)];
        let name = format!("True N, {wheel} wheel [N]");
        truth.push((layout.plot(&name, &contents, range(-0.5, 3.0))?, 1.0));
    }
    let truth = layout.container(ContainerKind::Horizontal, "True N", &truth)?;
    let forces = side_by_side(
        &mut layout,
        "True and estimated N",
        runs,
        |layout, run, root| {
            parts::normal_force(layout, &format!("{}: N", run.label), root, run.description)
        },
    )?;
    let events = side_by_side(&mut layout, "Events", runs, |layout, run, root| {
        layout.text_log(&format!("{}: events", run.label), &format!("{root}events"))
    })?;
    let forces = layout.tabs("Forces", &[truth, forces, events])?;
    let error_plots = side_by_side(&mut layout, "Errors", runs, |layout, run, root| {
        let key = parts::key(
            layout,
            &format!("{root}key"),
            key_of_run(run.description).len(),
        )?;
        let scale = errors.map_or(0.0, |range| range.0.0[1]);
        let title = format!(
            "{}: error of N, RMS of the wheels [N], 0 to {scale:.1}",
            run.label
        );
        let rms = parts::plot(layout, &title, root, "error_of_normal_force/rms", errors)?;
        let views = [(key, 0.7), (rms, 1.6)];
        layout.container(ContainerKind::Vertical, run.label, &views)
    })?;
    let root = layout.container(
        ContainerKind::Vertical,
        "robhaz",
        &[(scenes, 2.1), (key, 0.4), (forces, 1.5), (error_plots, 1.6)],
    )?;
    layout.finish(root, Playing::FromStart)
}

/// One part for each run, side by side.
fn side_by_side(
    layout: &mut Layout<'_>,
    name: &str,
    runs: &[ComparedRun<'_>],
    mut part: impl FnMut(&mut Layout<'_>, &ComparedRun<'_>, &str) -> Result<Part, ViewerError>,
) -> Result<Part, ViewerError> {
    let mut parts = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        parts.push((part(layout, run, &root(k))?, 1.0));
    }
    layout.container(ContainerKind::Horizontal, name, &parts)
}

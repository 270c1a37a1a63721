//! The layout of a comparison: animations side by side, true forces in the same plots, errors side by side.

use super::{ContainerKind, Part, parts};
use crate::ground::Ground;
use crate::key::of_run as key_of_run;
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

/// The layout. `largest_error` is the largest RMS error of N of the wheels in any run, N.
pub(crate) fn layout(runs: &[ComparedRun<'_>], largest_error: f64) -> Part {
    let scenes = side_by_side("Scenes", runs, |run, root| {
        let mut views = Vec::new();
        if let Some(world) = &run.description.world {
            let ground = Ground::new(run.description, world);
            let name = format!("{}: whole run [m]", run.label);
            views.push((parts::overview(&name, root, &ground), 1.7));
            let name = format!("{} [m]", run.label);
            views.push((parts::following(&name, root, true), 2.4));
        }
        Part::column(run.label, views)
    });
    // One scene with corners sets the range of all runs.
    let range = |from, to| {
        let mut ranges = runs.iter();
        ranges.find_map(|run| parts::range_of_loads(run.description, from, to))
    };
    let truth = parts::per_wheel(
        ContainerKind::Horizontal,
        "True N",
        "/compared/normal_force",
        range(-0.5, 3.0),
    );
    let forces = side_by_side("True and estimated N", runs, |run, root| {
        parts::normal_force(&format!("{}: N", run.label), root, run.description)
    });
    let events = side_by_side("Events", runs, |run, root| {
        Part::text_log(&format!("{}: events", run.label), &format!("{root}events"))
    });
    let errors = range(0.0, 1.0).unwrap_or(Range1D::new(0.0, 1.05 * largest_error));
    let errors = (largest_error > 0.0).then_some(errors);
    let scale = errors.map_or(0.0, |range| range.0.0[1]);
    let error_plots = side_by_side("Errors", runs, |run, root| {
        let entries = key_of_run(run.description).len();
        let key = parts::key(&format!("{root}key"), entries);
        let label = run.label;
        let title = format!("{label}: error of N, RMS of the wheels [N], 0 to {scale:.1}");
        let entity = format!("{root}series/error_of_normal_force/rms");
        let views = vec![(key, 0.7), (Part::plot(&title, &entity, errors), 1.6)];
        Part::column(label, views)
    });
    let rows = vec![
        (scenes, 2.1),
        (parts::key("/compared/key", runs.len()), 0.4),
        (Part::tabs("Forces", vec![truth, forces, events]), 1.5),
        (error_plots, 1.6),
    ];
    Part::column("robhaz", rows)
}

/// One part for each run, side by side.
fn side_by_side(
    name: &str,
    runs: &[ComparedRun<'_>],
    part: impl Fn(&ComparedRun<'_>, &str) -> Part,
) -> Part {
    let parts = runs.iter().enumerate().map(|(k, run)| part(run, &root(k)));
    Part::equal(ContainerKind::Horizontal, name, parts)
}

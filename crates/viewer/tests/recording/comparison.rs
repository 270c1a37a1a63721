//! Comparisons of recorded runs.

use crate::common;
use crate::reading::{chunks, record, scalars};
use rerun::log::Chunk;
use robhaz_run::RunDescription;
use robhaz_viewer::{ComparedRun, save_comparison};
use std::path::Path;

/// Conservation: a comparison has every row of both runs, and the true N of both in common plots.
#[test]
fn a_comparison_holds_both_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b, both] = ["a.rrd", "b.rrd", "both.rrd"].map(|name| folder.path().join(name));
    let first = common::smooth(0.6);
    let mut second = common::smooth(0.4);
    second.engine.kind = robhaz_scene::EngineKind::Direct;
    record(&first, &a);
    record(&second, &b);
    let [first, second] =
        [&first, &second].map(|scene| RunDescription::of(scene).expect("a robot"));
    let run = |label, description, recording| ComparedRun {
        label,
        description,
        recording,
    };
    let runs = [
        run("rapier", &first, a.as_path()),
        run("direct", &second, b.as_path()),
    ];
    save_comparison(&runs, &both, &|| None).expect("a comparison");

    let compared = chunks(&both);
    for (k, path) in [&a, &b].into_iter().enumerate() {
        let own = chunks(path);
        for (entity, list) in own.iter().filter(|(e, _)| !e.starts_with("/__properties")) {
            let there = &compared[&format!("/run{}{entity}", k + 1)];
            let count = |list: &[Chunk]| list.iter().map(Chunk::num_rows).sum::<usize>();
            assert_eq!(count(there), count(list), "{entity}");
        }
    }
    let [front_a, front_b] =
        [&a, &b].map(|path| scalars(&chunks(path), "/series/normal_force/wheel1/actual"));
    assert_eq!(
        scalars(&compared, "/compared/normal_force/wheel1/run1"),
        front_a
    );
    assert_eq!(
        scalars(&compared, "/compared/normal_force/wheel1/run2"),
        front_b
    );
    let error = save_comparison(&runs[..1], &both, &|| None).expect_err("one run");
    assert!(error.to_string().contains("two runs"), "{error}");
    let missing = run("missing", &first, Path::new("/nowhere/run.rrd"));
    let error = save_comparison(&[runs[0], missing], &both, &|| None).expect_err("no recording");
    assert!(error.to_string().contains("/nowhere/run.rrd"), "{error}");
}

//! Recordings are read back from their files, and compared with the run. A defect of a recording
//! would otherwise remain unnoticed until someone opens it in a viewer.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

#[path = "../common/mod.rs"]
mod common;
mod events;
mod logs;
mod reading;
mod whole;

use re_log_types::LogMsg;
use re_sdk_types::archetypes::{Arrows2D, LineStrips2D, Transform3D};
use re_sdk_types::components::{Color, LineStrip2D, Text, Translation3D, Vector2D};
use reading::{changed, chunks, messages, record, recorded, rows, scalars};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_sim::friction::Stretch;
use robhaz_sim::{ContactList, ContactTruth};
use robhaz_viewer::{RecordingSink, ViewerError, recording_end};
use std::path::Path;

/// A run of 3 s gives 376 rows of each series (125 Hz), 181 frames (60 Hz), and an active layout.
#[test]
fn a_run_is_recorded_with_its_layout() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    record(&common::smooth(3.0), &path);

    let chunks = chunks(&path);
    for wheel in 1..=3 {
        for (source, lines) in [("actual", 1), ("estimated", 3)] {
            let entity = format!("/series/normal_force/wheel{wheel}/{source}");
            let forces = scalars(&chunks, &entity);
            assert_eq!(forces.len(), 376);
            assert!(forces.iter().all(|(_, row)| row.len() == lines));
            let last = forces.last().expect("rows");
            assert!((last.0 - 3.0).abs() < 1e-9);
        }

        let entity = format!("/world/robot/wheel{wheel}");
        let component = Transform3D::descriptor_translation().component;
        let poses = rows::<Translation3D>(&chunks, &entity, component);
        assert_eq!(poses.len(), 181);
    }
    for (entity, series) in [
        ("traction/wheel1", 4),
        ("error_of_normal_force/wheel3/error", 3),
        ("error_of_normal_force/rms", 3),
        ("contact_angle", 6),
        ("friction", 6),
        ("slip_margin", 6),
        ("residual/force", 2),
        ("residual/moment", 2),
    ] {
        let found = scalars(&chunks, &format!("/series/{entity}"));
        assert_eq!(found.len(), 376, "{entity}");
        assert!(found.iter().all(|(_, row)| row.len() == series), "{entity}");
    }
    for entity in [
        "/about",
        "/world/ground",
        "/world/robot/body",
        "/world/robot/link1",
        "/world/robot/link3",
        "/world/robot/pins",
        "/world/robot/contacts",
        "/world/robot/wheel2/spokes",
        "/world/robot/link2/stops",
        "/wheels/front",
        "/trust/true-mass",
        "/key/3/0",
        "/world/forces/true/normal",
        "/world/forces/true/traction",
        "/world/forces/estimated/normal",
        "/world/forces/estimated/traction",
        "/world/trails",
        "/world/follow",
    ] {
        assert!(chunks.contains_key(entity), "{entity}");
    }
    // The paper's estimators state no covariance: no band, no bar, no parity residual.
    for absent in ["/two_sigma", "/band/", "/parity/"] {
        let rows = chunks.iter().filter(|(entity, _)| entity.contains(absent));
        let mut with_time = rows
            .flat_map(|(_, chunks)| chunks)
            .filter(|c| !c.is_static());
        assert!(with_time.next().is_none(), "{absent}");
    }

    let messages = messages(&path);
    let activated = messages
        .iter()
        .find_map(|message| match message {
            LogMsg::BlueprintActivationCommand(command) => Some(command),
            _ => None,
        })
        .expect("an activated layout");
    assert!(activated.make_active && activated.make_default);
    let parts = messages
        .iter()
        .filter(|m| m.store_id() == &activated.blueprint_id);
    assert!(parts.count() > 50);
}

/// Acceptance: a recording of the main scene (20 s at 1 kHz, four estimators) is smaller than 5 MB.
#[test]
fn twenty_seconds_take_less_than_five_megabytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::with_kalman(20.0);
    scene.engine.kind = robhaz_scene::EngineKind::Direct;
    record(&scene, &path);
    let size = std::fs::metadata(&path).expect("a file").len();
    assert!(size < 5_000_000, "{size} bytes");
    assert!((recording_end(&path).expect("a recording").expect("rows") - 20.0).abs() < 1e-9);
}

/// The ground that `kalman` has found is drawn where the true ground is, level here: from behind the
/// rear wheel to the front wheel, with both bounds beside it. Exact readings leave less than 1 mm.
#[test]
fn the_ground_that_was_found_is_drawn() {
    let mut scene = common::with_kalman(4.0);
    scene.terrain.profile = robhaz_terrain::Profile::Flat;
    scene.engine.kind = robhaz_scene::EngineKind::Direct;
    let chunks = recorded(&scene);
    let component = LineStrips2D::descriptor_strips().component;
    let strips = |entity: &str| rows::<LineStrip2D>(&chunks, entity, component);
    let memory = strips("/world/estimated_terrain/memory");
    // Five a second, after the robot has started at 0.8 s.
    assert!((10..=17).contains(&memory.len()), "{}", memory.len());
    assert_eq!(
        strips("/world/estimated_terrain/memory/two_sigma").len(),
        memory.len()
    );
    let (time, last) = &memory[memory.len() - 1];
    let points: Vec<_> = last.iter().flat_map(|strip| strip.0.clone()).collect();
    assert!(
        points.iter().all(|p| p.y().abs() < 1e-3),
        "{time} {points:?}"
    );
    let front = points.iter().map(|p| p.x()).fold(f32::MIN, f32::max);
    let travel = 0.2 * (time - 0.8 - 0.3);
    assert!(
        (f64::from(front) - (0.3 + travel)).abs() < 0.03,
        "{front} {travel}"
    );
    let left = strips("/world/estimated_terrain/left");
    assert!(left.len() > 3, "{}", left.len());
}

/// Equivalence of animation and time series: the arrow of the true N has the length of the plotted
/// N, at 0.15 m for the mean wheel load.
#[test]
fn arrows_have_the_length_of_the_plotted_force() {
    let scene = common::smooth(2.0);
    let chunks = recorded(&scene);
    let component = Arrows2D::descriptor_vectors().component;
    let arrows = rows::<Vector2D>(&chunks, "/world/forces/true/normal", component);
    let scale = 0.15 / scene.robot.robot.mean_wheel_load();
    let mut compared = 0;
    for (time, forces) in scalars(&chunks, "/series/normal_force/wheel2/actual") {
        let Some((_, row)) = arrows.iter().find(|(t, _)| (t - time).abs() < 1e-9) else {
            continue;
        };
        let length = f64::from(row[1].0.x().hypot(row[1].0.y()));
        // Single precision of lengths below 1 m.
        assert!((length - scale * forces[0]).abs() < 1e-6, "t = {time}");
        compared += 1;
    }
    assert!(compared >= 20, "{compared}");
}

/// A wheel with two contacts has two arrows of N and two of T, in its colour; a wheel without
/// contact has none.
#[test]
fn each_contact_has_its_arrows() {
    let chunks = changed(&common::smooth(0.2), |record| {
        let [without, with, _] = &mut record.truth.wheels;
        without.contact_list = ContactList::default();
        let first = with.contact_list[0];
        with.contact_list.push(ContactTruth {
            normal_force: 2.0 * first.normal_force,
            ..first
        });
    });
    for force in ["normal", "traction"] {
        let entity = format!("/world/forces/true/{force}");
        let component = Arrows2D::descriptor_vectors().component;
        let arrows = rows::<Vector2D>(&chunks, &entity, component);
        assert!(arrows.iter().all(|(_, row)| row.len() == 3));
        if force == "normal" {
            let lengths = |row: &[Vector2D]| [0, 1].map(|i| row[i].0.x().hypot(row[i].0.y()));
            for (_, row) in &arrows {
                let [first, second] = lengths(row);
                assert!(first > 0.05 && (second - 2.0 * first).abs() < 1e-6);
            }
        }
        let component = Arrows2D::descriptor_colors().component;
        let colours = rows::<Color>(&chunks, &entity, component);
        assert!(!colours.is_empty());
        for (_, row) in colours {
            assert!(row[0] == row[1] && row[1] != row[2]);
        }
    }
}

/// Determinism: the same scene gives the same messages in the same order. Another scene of the same
/// name gets another identifier.
#[test]
fn the_same_scene_gives_the_same_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["a", "b", "c"].map(|name| folder.path().join(name));
    record(&common::smooth(0.5), &paths[0]);
    record(&common::smooth(0.5), &paths[1]);
    let mut other = common::smooth(0.5);
    other.drive.speed = 0.3;
    record(&other, &paths[2]);

    let [a, b, c] = paths.map(|path| messages(&path));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        match (a, b) {
            (LogMsg::ArrowMsg(store_a, a), LogMsg::ArrowMsg(store_b, b)) => {
                assert_eq!(store_a, store_b);
                assert_eq!(a.chunk_id, b.chunk_id);
                assert_eq!(a.batch, b.batch);
            }
            _ => assert_eq!(format!("{a:?}"), format!("{b:?}")),
        }
    }
    assert_ne!(a[0].store_id(), c[0].store_id());
}

/// The recording of a killed run has no index at its end. It can be read up to the last multiple of
/// two seconds.
#[test]
fn a_killed_run_can_be_read() {
    struct Killed(RecordingSink);
    impl Sink for Killed {
        fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
            self.0.begin(run)
        }
        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            self.0.frame(frame)
        }
        fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
            Ok(())
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut sink = Killed(RecordingSink::save(&path).expect("a file"));
    robhaz_run::run(&common::smooth(2.5), &mut [&mut sink]).expect("a run");
    // Dropping the sink would close the file.
    std::mem::forget(sink);

    // Messages are written by a thread of their own, which such a run leaves behind.
    let start = std::time::Instant::now();
    let written = || recording_end(&path).ok().flatten();
    while written().is_none_or(|end| end < 2.0 - 1e-9) || chunks(&path).len() < 10 {
        assert!(
            start.elapsed().as_secs() < 60,
            "two seconds are not written"
        );
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let forces = scalars(&chunks(&path), "/series/normal_force/wheel1/actual");
    assert_eq!(forces.len(), 251);
    assert!((forces[250].0 - 2.0).abs() < 1e-9);
    assert!((recording_end(&path).expect("a recording").expect("rows") - 2.0).abs() < 1e-9);
}

/// Friction stretches are drawn at their place with their coefficients as label. The slip margin
/// uses their coefficients.
#[test]
fn stretches_of_friction_are_distinguished() {
    let mut scene = common::smooth(0.3);
    let stretch = |from, to, mu_s| Stretch {
        from,
        to,
        mu_s,
        mu_d: mu_s,
    };
    // One lies below the rear wheel alone, the other outside of the drawn ground.
    scene.terrain.stretches = vec![stretch(-0.5, -0.1, 0.25), stretch(500.0, 501.0, 0.1)];
    let chunks = recorded(&scene);
    let drawn = &chunks["/world/ground/stretches"][0];
    let strips: Vec<_> = drawn
        .iter_component::<LineStrip2D>(LineStrips2D::descriptor_strips().component)
        .flat_map(|row| row.as_slice().to_vec())
        .collect();
    assert_eq!(strips.len(), 1);
    let x = strips[0].0.iter().map(|p| p.x());
    let (from, to) = x.fold((f32::MAX, f32::MIN), |(a, b), x| (a.min(x), b.max(x)));
    assert!(
        (from + 0.5).abs() < 1e-6 && (to + 0.1).abs() < 1e-6,
        "{from} to {to}"
    );
    let labels: Vec<String> = drawn
        .iter_component::<Text>(LineStrips2D::descriptor_labels().component)
        .flat_map(|row| {
            row.as_slice()
                .iter()
                .map(|text| text.0.to_string())
                .collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(labels, ["mu_s 0.25, mu_d 0.25"]);

    let needed = scalars(&chunks, "/series/friction");
    for ((_, margin), (_, needed)) in scalars(&chunks, "/series/slip_margin").iter().zip(needed) {
        for (i, mu_s) in [0.8, 0.8, 0.25, 0.8, 0.8, 0.25].into_iter().enumerate() {
            assert!(
                (margin[i] - (mu_s - needed[i].abs())).abs() < 1e-12,
                "line {i}"
            );
        }
    }
}

/// A scene without estimators is recorded, with the true lines alone.
#[test]
fn a_scene_without_estimators_is_recorded() {
    let mut scene = common::smooth(0.1);
    scene.estimators.clear();
    let chunks = recorded(&scene);
    let forces = scalars(&chunks, "/series/normal_force/wheel1/actual");
    assert!(!forces.is_empty() && forces.iter().all(|(_, row)| row.len() == 1));
    assert!(!chunks.contains_key("/series/normal_force/wheel1/estimated"));
}

/// Errors name their file.
#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("missing").join("run.rrd");
    let error = RecordingSink::save(&missing).err().expect("no folder");
    assert!(matches!(error, ViewerError::Io { .. }));
    assert!(error.to_string().contains("run.rrd"), "{error}");

    let path = folder.path().join("run.rrd");
    let mut sink = RecordingSink::save(&path).expect("a file");
    let scene = common::smooth(0.01);
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    let error = robhaz_run::run(&scene, &mut [&mut sink]).expect_err("a second run");
    assert!(error.to_string().contains("already holds a run"), "{error}");
}

/// A full disk is an error before the run.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let error = RecordingSink::save(Path::new("/dev/full"));
    let error = error.err().expect("no room");
    assert!(error.to_string().contains("/dev/full"), "{error}");
}

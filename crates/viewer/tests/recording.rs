//! What a recording holds is read back from its file: a viewer that cannot show a run is noticed by nobody until it is needed.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

mod common;

use re_sdk::external::re_log_encoding::Decoder;
use re_sdk::log::{Chunk, LogMsg};
use re_sdk::{Component, ComponentIdentifier, StoreKind};
use re_sdk_types::archetypes::{Arrows2D, Scalars, TextLog, Transform3D};
use re_sdk_types::components::{Scalar, Text, Translation3D, Vector2D};
use robhaz_estimator::EstimateError;
use robhaz_run::{Frame, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use robhaz_viewer::{RecordingSink, ViewerError};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

fn record(scene: &Scene, path: &Path) {
    let mut sink = RecordingSink::save(path).expect("a file");
    robhaz_run::run(scene, &mut [&mut sink]).expect("a run");
}

fn messages(path: &Path) -> Vec<LogMsg> {
    let file = BufReader::new(File::open(path).expect("the recording"));
    Decoder::decode_eager(file)
        .expect("a header")
        .map(|message| message.expect("a readable message"))
        .collect()
}

/// The chunks of the recording itself, by entity.
fn chunks(path: &Path) -> BTreeMap<String, Vec<Chunk>> {
    let mut found: BTreeMap<String, Vec<Chunk>> = BTreeMap::new();
    for message in messages(path) {
        if let LogMsg::ArrowMsg(store, message) = message
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message).expect("a chunk");
            let entity = chunk.entity_path().to_string();
            found.entry(entity).or_default().push(chunk);
        }
    }
    found
}

/// Every row of a component of an entity, with its time in s.
fn rows<C: Component>(
    chunks: &BTreeMap<String, Vec<Chunk>>,
    entity: &str,
    component: ComponentIdentifier,
) -> Vec<(f64, Vec<C>)> {
    let mut found = Vec::new();
    for chunk in chunks.get(entity).expect("the entity") {
        let Some(times) = chunk.timelines().values().next() else {
            continue;
        };
        let times = times.times_raw().iter().map(|ns| *ns as f64 * 1e-9);
        let values = chunk.iter_component::<C>(component);
        found.extend(times.zip(values.map(|row| row.as_slice().to_vec())));
    }
    found
}

fn scalars(chunks: &BTreeMap<String, Vec<Chunk>>, entity: &str) -> Vec<(f64, Vec<f64>)> {
    rows::<Scalar>(chunks, entity, Scalars::descriptor_scalars().component)
        .into_iter()
        .map(|(time, row)| (time, row.iter().map(|s| s.0.0).collect()))
        .collect()
}

fn events(chunks: &BTreeMap<String, Vec<Chunk>>) -> Vec<(f64, String)> {
    rows::<Text>(chunks, "/events", TextLog::descriptor_text().component)
        .into_iter()
        .map(|(time, row)| (time, row[0].to_string()))
        .collect()
}

/// 3 s at 1 kHz are 751 rows of each series and 181 frames, in less than 1 MB; the layout is there and active.
#[test]
fn a_run_is_recorded_with_its_layout() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    record(&common::smooth(3.0), &path);
    assert!(std::fs::metadata(&path).expect("a file").len() < 1_000_000);

    let chunks = chunks(&path);
    for wheel in 1..=3 {
        let forces = scalars(&chunks, &format!("/series/normal_force/wheel{wheel}"));
        assert_eq!(forces.len(), 751);
        // True, paper-body, paper-wheels, true-mass.
        assert!(forces.iter().all(|(_, row)| row.len() == 4));
        let last = forces.last().expect("rows");
        assert!((last.0 - 3.0).abs() < 1e-9);

        let entity = format!("/world/robot/wheel{wheel}");
        let component = Transform3D::descriptor_translation().component;
        let poses = rows::<Translation3D>(&chunks, &entity, component);
        assert_eq!(poses.len(), 181);
    }
    for (entity, series) in [
        ("traction/wheel1", 4),
        ("error_of_normal_force/wheel3", 3),
        ("error_of_normal_force/rms", 3),
        ("contact_angle", 6),
        ("friction", 6),
    ] {
        let found = scalars(&chunks, &format!("/series/{entity}"));
        assert_eq!(found.len(), 751, "{entity}");
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
        "/world/forces/true/normal",
        "/world/forces/true/traction",
        "/world/forces/estimated/normal",
        "/world/forces/estimated/traction",
        "/world/trails",
        "/world/follow",
    ] {
        assert!(chunks.contains_key(entity), "{entity}");
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

/// The scene and the series tell the same: an arrow of the true N is the plotted N at 0.15 m for the mean wheel load.
#[test]
fn arrows_have_the_length_of_the_plotted_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let scene = common::smooth(1.0);
    record(&scene, &path);
    let chunks = chunks(&path);
    let component = Arrows2D::descriptor_vectors().component;
    let arrows = rows::<Vector2D>(&chunks, "/world/forces/true/normal", component);
    let scale = 0.15 / scene.robot.robot.mean_wheel_load();
    let mut compared = 0;
    for (time, forces) in scalars(&chunks, "/series/normal_force/wheel2") {
        let Some((_, row)) = arrows.iter().find(|(t, _)| (t - time).abs() < 1e-9) else {
            continue;
        };
        let length = f64::from(row[1].0.x().hypot(row[1].0.y()));
        assert!((length - scale * forces[0]).abs() < 1e-6, "t = {time}");
        compared += 1;
    }
    assert!(compared >= 20, "{compared}");
}

/// The same scene gives the same recording, message by message; another scene of the same name gets an identity of its own.
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

/// A killed run has no end of file; what was written up to the last full two seconds can be read.
#[test]
fn a_killed_run_can_be_read() {
    struct Killed(RecordingSink);
    impl Sink for Killed {
        fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
            self.0.begin(scene)
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
    // Dropping would close the file in good order.
    std::mem::forget(sink);

    let forces = scalars(&chunks(&path), "/series/normal_force/wheel1");
    assert_eq!(forces.len(), 501);
    assert!((forces[500].0 - 2.0).abs() < 1e-9);
}

/// Hands on the records of a run with things that ideal rolling does not show.
struct Eventful(RecordingSink);

impl Sink for Eventful {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.0.begin(scene)
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let mut truth = *frame.truth;
        let mut estimates = frame.estimates.to_vec();
        let ms = (truth.time * 1e3).round();
        if (100.0..200.0).contains(&ms) {
            truth.wheels[0].contacts = 0;
            truth.wheels[0].normal_force = 0.0;
            truth.wheels[0].traction = 0.0;
        }
        if (200.0..300.0).contains(&ms) {
            truth.wheels[1].contacts = 2;
        }
        if (300.0..400.0).contains(&ms) {
            truth.stop_torque = -1.0;
        }
        if (300.0..=400.0).contains(&ms) {
            truth.links[0].angle = truth.links[1].angle + 0.62;
        }
        if (400.0..500.0).contains(&ms) {
            let field = "motor_torque";
            estimates[2] = Err(EstimateError::NotFinite { field });
        }
        if ms >= 500.0 {
            truth.wheels[0].position.x += 10.0;
        }
        self.0.frame(&Frame {
            truth: &truth,
            sensors: frame.sensors,
            estimates: &estimates,
        })
    }

    /// The run breaks off.
    fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
        self.0.end(None)
    }
}

/// Events stand at the record at which they happen, a refused estimate leaves a gap in lines and arrows, and ground is drawn
/// wherever the robot gets to.
#[test]
fn events_and_gaps_are_shown_where_they_happen() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut sink = Eventful(RecordingSink::save(&path).expect("a file"));
    robhaz_run::run(&common::smooth(0.6), &mut [&mut sink]).expect("a run");
    let chunks = chunks(&path);

    let events = events(&chunks);
    let expected = [
        (0.0, "scene smooth: 0.6 s"),
        (0.1, "front wheel leaves the ground at x = 0.300 m"),
        (0.2, "front wheel touches the ground again at x = 0.300 m"),
        (0.2, "middle wheel touches at two places at x = 0.000 m"),
        (
            0.3,
            "middle wheel touches at one place again at x = 0.000 m",
        ),
        (
            0.3,
            "pin Q reaches its upper stop: theta1 - theta2 = 35.5 deg",
        ),
        (
            0.4,
            "pin Q leaves its upper stop: theta1 - theta2 = 35.5 deg",
        ),
        (
            0.4,
            "true-mass: no estimate, the reading motor_torque is not a finite number",
        ),
        (0.5, "true-mass: estimates again"),
        (0.6, "the run broke off: this is its last record"),
    ];
    assert_eq!(events.len(), expected.len(), "{events:#?}");
    for ((time, text), (expected_time, expected_text)) in events.iter().zip(expected) {
        assert!((time - expected_time).abs() < 1e-9, "{text} at {time}");
        assert_eq!(text, expected_text);
    }

    assert_eq!(chunks["/world/ground"].len(), 2);
    for (time, row) in scalars(&chunks, "/series/normal_force/wheel1") {
        let refused = (0.4 - 1e-9..0.5 - 1e-9).contains(&time);
        assert_eq!(row[3].is_nan(), refused, "t = {time}");
        assert!(row[..3].iter().all(|n| n.is_finite()));
    }
    for (time, row) in scalars(&chunks, "/series/friction") {
        let in_the_air = (0.1 - 1e-9..0.2 - 1e-9).contains(&time);
        assert_eq!(row[0].is_nan(), in_the_air, "t = {time}");
    }
    let component = Arrows2D::descriptor_vectors().component;
    for (time, row) in rows::<Vector2D>(&chunks, "/world/forces/estimated/normal", component) {
        let refused = (0.4 - 1e-9..0.5 - 1e-9).contains(&time);
        assert_eq!(row.len(), if refused { 0 } else { 3 }, "t = {time}");
    }
}

/// A robot without estimators can be looked at too.
#[test]
fn a_scene_without_estimators_is_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::smooth(0.1);
    scene.estimators.clear();
    record(&scene, &path);
    let forces = scalars(&chunks(&path), "/series/normal_force/wheel1");
    assert!(forces.iter().all(|(_, row)| row.len() == 1));
}

/// Every error names its file.
#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("missing").join("run.rrd");
    let error = RecordingSink::save(&missing).err().expect("no folder");
    assert!(matches!(error, ViewerError::Create { .. }));
    assert!(error.to_string().contains("run.rrd"), "{error}");

    let path = folder.path().join("run.rrd");
    let mut sink = RecordingSink::save(&path).expect("a file");
    let scene = common::smooth(0.01);
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    let error = robhaz_run::run(&scene, &mut [&mut sink]).expect_err("a second run");
    assert!(error.to_string().contains("already holds a run"), "{error}");
}

/// A full disk stops the run instead of losing it in silence.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let mut sink = RecordingSink::save(Path::new("/dev/full")).expect("a device");
    let error = robhaz_run::run(&common::smooth(0.01), &mut [&mut sink]).expect_err("no room");
    assert!(error.to_string().contains("/dev/full"), "{error}");
}

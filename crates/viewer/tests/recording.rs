//! Recordings are read back from their files, and compared with the run. A defect of a recording would otherwise remain
//! unnoticed until someone opens it in a viewer.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

mod common;

use rerun::archetypes::{Arrows2D, LineStrips2D, Scalars, StateChange, TextLog, Transform3D};
use rerun::components::{LineStrip2D, Scalar, Text, Translation3D, Vector2D};
use rerun::external::re_log_encoding::Decoder;
use rerun::log::{Chunk, LogMsg};
use rerun::{Component, ComponentIdentifier, StoreKind};
use robhaz_estimator::{EstimateError, Flags, Parity};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use robhaz_sim::friction::Stretch;
use robhaz_viewer::{ComparedRun, RecordingSink, ViewerError, recording_end, save_comparison};
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

/// The chunks of the recording, without its layout, by entity.
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
    let mut scene = common::with_best(20.0);
    scene.engine.kind = robhaz_scene::EngineKind::Direct;
    record(&scene, &path);
    let size = std::fs::metadata(&path).expect("a file").len();
    assert!(size < 5_000_000, "{size} bytes");
    assert!((recording_end(&path).expect("a recording").expect("rows") - 20.0).abs() < 1e-9);
}

/// Equivalence of animation and time series: the arrow of the true N has the length of the plotted N, at 0.15 m for the
/// mean wheel load.
#[test]
fn arrows_have_the_length_of_the_plotted_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let scene = common::smooth(2.0);
    record(&scene, &path);
    let chunks = chunks(&path);
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

/// Determinism: the same scene gives the same messages in the same order. Another scene of the same name gets another
/// identifier.
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

/// The recording of a killed run has no index at its end. It can be read up to the last multiple of two seconds.
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

    let forces = scalars(&chunks(&path), "/series/normal_force/wheel1/actual");
    assert_eq!(forces.len(), 251);
    assert!((forces[250].0 - 2.0).abs() < 1e-9);
    assert!((recording_end(&path).expect("a recording").expect("rows") - 2.0).abs() < 1e-9);
}

/// Passes on the records of a run after it has changed some, so that they contain every kind of event.
struct Eventful(RecordingSink);

impl Sink for Eventful {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        self.0.begin(run)
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let mut truth = *frame.truth.expect("a simulation");
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
            estimates[2] = Err(EstimateError::Singular);
        }
        if ms >= 500.0 {
            truth.wheels[0].position.x += 10.0;
        }
        if (500.0..550.0).contains(&ms) {
            truth.wheels[2].slip_speed = -0.03;
        }
        if let (Ok(estimate), true) = (&mut estimates[1], ms >= 500.0) {
            estimate.covariance = Some(known_covariance());
            estimate.parity = Some(Parity {
                value: 0.5,
                sigma: 0.25,
            });
            if ms < 550.0 {
                estimate.flags = Flags::WHEEL_UNLOADED[0] | Flags::AT_STOP;
            }
        }
        self.0.frame(&Frame {
            time: frame.time,
            truth: Some(&truth),
            sensors: frame.sensors,
            estimates: &estimates,
        })
    }

    /// Reports a run that broke off.
    fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
        self.0.end(None)
    }
}

/// Events have the time of their record. A missing estimate makes a gap in lines and arrows. Ground is drawn wherever
/// the robot is.
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
            "true-mass: no estimate, the statics are singular in this posture",
        ),
        (0.5, "rear wheel starts to slide at x = -0.300 m"),
        (
            0.5,
            "paper-wheels: flags: wheel 1 unloaded, linkage at a stop",
        ),
        (0.5, "true-mass: estimates again"),
        (0.55, "rear wheel grips again at x = -0.300 m"),
        (0.55, "paper-wheels: no flag any more"),
        (0.6, "the run broke off: this is its last record"),
    ];
    assert_eq!(events.len(), expected.len(), "{events:#?}");
    for ((time, text), (expected_time, expected_text)) in events.iter().zip(expected) {
        assert!((time - expected_time).abs() < 1e-9, "{text} at {time}");
        assert_eq!(text, expected_text);
    }

    assert_eq!(chunks["/world/ground"].len(), 2);
    for (time, row) in scalars(&chunks, "/series/normal_force/wheel1/estimated") {
        let refused = (0.4 - 1e-9..0.5 - 1e-9).contains(&time);
        assert_eq!(row[2].is_nan(), refused, "t = {time}");
        assert!(row[..2].iter().all(|n| n.is_finite()));
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

/// Equivalence of lanes and events. An end stop is highlighted while it is reached.
#[test]
fn lanes_and_stops_follow_the_events() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut sink = Eventful(RecordingSink::save(&path).expect("a file"));
    robhaz_run::run(&common::smooth(0.6), &mut [&mut sink]).expect("a run");
    let chunks = chunks(&path);
    let lane = |entity: &str| {
        let component = StateChange::descriptor_state().component;
        let changes = rows::<Text>(&chunks, entity, component);
        let changes = changes.into_iter();
        changes
            .map(|(time, row)| ((time * 1e3).round() as i64, row[0].to_string()))
            .collect::<Vec<_>>()
    };
    let states = |list: &[(i64, &str)]| -> Vec<(i64, String)> {
        list.iter().map(|(ms, s)| (*ms, (*s).to_owned())).collect()
    };
    let front = [(0, "grips"), (100, "in the air"), (200, "grips")];
    assert_eq!(lane("/wheels/front"), states(&front));
    let rear = [(0, "grips"), (500, "slips"), (550, "grips")];
    assert_eq!(lane("/wheels/rear"), states(&rear));
    let flagged = [
        (0, "trusted"),
        (500, "wheel 1 unloaded, linkage at a stop"),
        (550, "trusted"),
    ];
    assert_eq!(lane("/trust/paper-wheels"), states(&flagged));
    let refusing = [(0, "trusted"), (400, "no estimate"), (500, "trusted")];
    assert_eq!(lane("/trust/true-mass"), states(&refusing));

    let component = LineStrips2D::descriptor_strips().component;
    let stop = rows::<LineStrip2D>(&chunks, "/world/robot/link2/stops/reached", component);
    let drawn: Vec<(bool, usize)> = stop.iter().map(|(t, row)| (*t > 0.35, row.len())).collect();
    assert_eq!(drawn, [(false, 1), (true, 0)]);
}

/// The band of two standard deviations starts with the first covariance of an estimator, and has its centre at zero
/// error. The parity residual has a band of its own.
#[test]
fn two_sigma_is_shown_where_it_is_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::smooth(0.6);
    // The estimator with the covariance gets another label and another index.
    scene.estimators[2].name = "other".to_owned();
    scene.estimators.swap(1, 2);
    let mut sink = Eventful(RecordingSink::save(&path).expect("a file"));
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    let chunks = chunks(&path);
    for wheel in 1..=3 {
        let entity = format!("/series/error_of_normal_force/wheel{wheel}/band/other");
        let band = scalars(&chunks, &entity);
        assert_eq!(band.len(), 13, "from 0.5 s to 0.6 s at 125 Hz");
        assert!(band[0].0 > 0.499);
        for (_, edges) in band {
            assert!((edges[0] - 4.0).abs() < 1e-12 && (edges[1] + 4.0).abs() < 1e-12);
        }
        let of_another = format!("/series/error_of_normal_force/wheel{wheel}/band/paper-body");
        assert!(!chunks.contains_key(&of_another));
    }
    let parity = scalars(&chunks, "/series/parity/other");
    assert!(
        parity.iter().all(|(_, row)| row == &[0.5, 0.5, -0.5]),
        "{parity:?}"
    );
}

/// Closed form: a bar is four standard deviations long, at the scale of the arrows.
#[test]
fn bars_have_the_length_of_two_sigma_to_both_sides() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::smooth(0.6);
    scene.estimators.truncate(2);
    // `Known` changes the second estimator. It is the last, and therefore the one that is drawn.
    struct Known(RecordingSink);
    impl Sink for Known {
        fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
            self.0.begin(run)
        }
        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            let mut estimates = frame.estimates.to_vec();
            if let Ok(estimate) = &mut estimates[1] {
                estimate.covariance = Some(known_covariance());
            }
            self.0.frame(&Frame {
                estimates: &estimates,
                ..*frame
            })
        }
        fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
            self.0.end(end)
        }
    }
    let mut sink = Known(RecordingSink::save(&path).expect("a file"));
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    let chunks = chunks(&path);
    let metres_per_newton = 0.15 / scene.robot.robot.mean_wheel_load();
    for (force, sigma) in [("normal", 2.0), ("traction", 1.0)] {
        let entity = format!("/world/forces/estimated/{force}/two_sigma");
        let component = LineStrips2D::descriptor_strips().component;
        let bars = rows::<LineStrip2D>(&chunks, &entity, component);
        assert_eq!(bars.len(), 37, "0.6 s at 60 Hz");
        for bar in bars.iter().flat_map(|(_, row)| row) {
            // Across, along, across: the third and fourth points are the ends.
            let [near, far] = [bar.0[2], bar.0[3]];
            let length = f64::from((far.x() - near.x()).hypot(far.y() - near.y()));
            assert!(
                (length - 4.0 * sigma * metres_per_newton).abs() < 1e-6,
                "{force}"
            );
        }
    }
}

/// Friction stretches are drawn at their place with their coefficients as label. The slip margin uses their
/// coefficients.
#[test]
fn stretches_of_friction_are_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::smooth(0.3);
    let stretch = |from, to, mu_s| Stretch {
        from,
        to,
        mu_s,
        mu_d: mu_s,
    };
    // One lies below the rear wheel alone, the other outside of the drawn ground.
    scene.terrain.stretches = vec![stretch(-0.5, -0.1, 0.25), stretch(500.0, 501.0, 0.1)];
    record(&scene, &path);
    let chunks = chunks(&path);
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

/// Recorded readings: without truth the recording holds the estimates, and nothing that needs the truth: no robot,
/// ground, errors, slip margin or states of wheels.
#[test]
fn without_truth_the_estimates_are_recorded_alone() {
    struct WithoutTruth(RecordingSink);
    impl Sink for WithoutTruth {
        fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
            self.0.begin(&RunDescription {
                world: None,
                ..run.clone()
            })
        }
        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            self.0.frame(&Frame {
                truth: None,
                ..*frame
            })
        }
        fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
            self.0.end(end)
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let [log, simulated] = ["log.rrd", "run.rrd"].map(|name| folder.path().join(name));
    let scene = common::with_best(0.6);
    let mut sink = WithoutTruth(RecordingSink::save(&log).expect("a file"));
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    record(&scene, &simulated);
    let (log, simulated) = (chunks(&log), chunks(&simulated));
    for entity in log.keys() {
        let unknown = ["/world", "/wheels", "/series/error", "/series/slip_margin"];
        assert!(!unknown.iter().any(|u| entity.starts_with(u)), "{entity}");
        assert!(!entity.ends_with("/actual"), "{entity}");
    }
    for entity in [
        "/series/normal_force/wheel1/estimated",
        "/series/parity/best",
        "/series/residual/force",
    ] {
        let rows = scalars(&log, entity);
        assert!(!rows.is_empty());
        assert_eq!(
            format!("{rows:?}"),
            format!("{:?}", scalars(&simulated, entity))
        );
    }
    // One line for each of four estimators, without the true one.
    let traction = scalars(&log, "/series/traction/wheel1");
    assert!(traction.iter().all(|(_, row)| row.len() == 4));
}

/// Conservation: a comparison has every row of both runs, the true N of both in common plots, and their difference at
/// equal times.
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
    let difference = scalars(&compared, "/compared/difference/wheel1/run2");
    assert_eq!(difference.len(), front_b.len());
    for ((_, found), ((_, a), (_, b))) in difference.iter().zip(front_a.iter().zip(&front_b)) {
        assert!((found[0] - (b[0] - a[0])).abs() < 1e-12);
        // The robot is at rest, and the engines' static loads are within 0.015 N of the closed form
        // (docs/validation.md).
        assert!(found[0].abs() < 0.05, "{found:?}");
    }

    let error = save_comparison(&runs[..1], &both, &|| None).expect_err("one run");
    assert!(error.to_string().contains("two runs"), "{error}");
    let missing = run("missing", &first, Path::new("/nowhere/run.rrd"));
    let error = save_comparison(&[runs[0], missing], &both, &|| None).expect_err("no recording");
    assert!(error.to_string().contains("/nowhere/run.rrd"), "{error}");
}

/// A scene without estimators is recorded, with the true lines alone.
#[test]
fn a_scene_without_estimators_is_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut scene = common::smooth(0.1);
    scene.estimators.clear();
    record(&scene, &path);
    let chunks = chunks(&path);
    let forces = scalars(&chunks, "/series/normal_force/wheel1/actual");
    assert!(!forces.is_empty() && forces.iter().all(|(_, row)| row.len() == 1));
    assert!(!chunks.contains_key("/series/normal_force/wheel1/estimated"));
}

/// A covariance with standard deviations of 1 N for T and 2 N for N.
fn known_covariance() -> [[f64; 6]; 6] {
    let mut covariance = [[0.0; 6]; 6];
    for (i, row) in covariance.iter_mut().enumerate() {
        row[i] = if i % 2 == 0 { 1.0 } else { 4.0 };
    }
    covariance
}

/// Errors name their file.
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

/// A full disk is an error of the run.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let mut sink = RecordingSink::save(Path::new("/dev/full")).expect("a device");
    let error = robhaz_run::run(&common::smooth(0.01), &mut [&mut sink]).expect_err("no room");
    assert!(error.to_string().contains("/dev/full"), "{error}");
}

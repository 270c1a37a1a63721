//! Recordings of a rover with both sides.

use crate::reading::{chunks, messages, rows, scalars};
use re_log_types::LogMsg;
use re_sdk_types::archetypes::{Arrows3D, LineStrips3D, Mesh3D, Transform3D};
use re_sdk_types::components::{LineStrip3D, Position3D, Translation3D, Vector3D};
use robhaz_estimator::whole::{SideReadings, WholeEstimator, WholeFrame};
use robhaz_model::WholeRover;
use robhaz_run::{
    BothDescription, BothFrame, BothSides, BothTruth, EstimatedTerrain, Frame, RunDescription,
    Sink as _,
};
use robhaz_scene::{LogChoice, RecordChoice, RobotChoice};
use robhaz_sim::Truth;
use robhaz_viewer::RecordingSink;
use std::path::{Path, PathBuf};

/// Records a run of the rover of `robots/open-source-rover.toml` in a folder.
fn record(
    folder: &Path,
    has_truth: bool,
    records: impl Fn(&WholeRover) -> Vec<BothSides>,
) -> (WholeRover, PathBuf) {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let mut choice = LogChoice {
        robot: RobotChoice::load(&robots.join("open-source-rover.toml")).expect("a robot"),
        ..LogChoice::default()
    };
    choice.select(&["kalman".to_owned()]).expect("a preset");
    let rover = choice.robot.whole_rover().expect("what lies across");
    let settings = choice.settings(&choice.estimators[0]);
    let mut estimator = WholeEstimator::new(&rover, settings, choice.pin).expect("a rover");
    let record = RecordChoice {
        duration: 4.0,
        rate: 200.0,
        compare_from: 0.0,
    };
    let mut run = RunDescription::of_log("both", 1, record, &choice);
    run.has_truth = has_truth;
    run.both = Some(BothDescription {
        label: "kalman".to_owned(),
        coupling: rover.coupling,
        contradiction: None,
        unconfirmed: Vec::new(),
    });
    let path = folder.join("run.rrd");
    let mut sink = RecordingSink::save(&path).expect("a file");
    sink.begin(&run).expect("a recording");
    let mut readings = SideReadings::new(&rover, 0.0);
    for sides in records(&rover) {
        let estimate = estimator.update(&sides.readings).expect("an estimate");
        let [sensors, _] = readings.frames(&sides.readings);
        let frame = Frame {
            time: sides.readings.time,
            truth: None,
            clearances: None,
            sensors: &sensors,
            both: Some(BothFrame {
                sides: &sides,
                estimate: Some(&estimate),
            }),
            estimates: &[],
            commands: None,
            ground: EstimatedTerrain::default(),
        };
        sink.frame(&frame).expect("it is written");
    }
    sink.end(None).expect("a file");
    (rover, path)
}

/// Readings on level ground.
fn level(time: f64) -> WholeFrame {
    WholeFrame {
        time,
        wheel_angle: [Some(0.0); 6],
        motor_torque: [Some(0.0); 6],
        pins: [Some(0.0); 2],
        coupling: Some(0.0),
        inclination: Some(0.0),
        roll: Some(0.0),
        rates: [Some(0.0); 3],
        ..WholeFrame::default()
    }
}

/// Closed form: wheels that roll at v, with a yaw rate w, lead along a circle of radius v/w, and
/// their tracks end where the wheels stand on the ground. Everything is there, in a layout of its
/// own.
#[test]
fn a_rover_drives_along_a_circle() {
    const SPEED: f64 = 0.2;
    const YAW_RATE: f64 = 0.2;
    let folder = tempfile::tempdir().expect("a folder");
    let (rover, path) = record(folder.path(), false, |rover| {
        let sides = |k| {
            let time = 0.005 * f64::from(k);
            let turn = |i: usize| {
                let y = rover.half_tracks[i % 3] * if i < 3 { 1.0 } else { -1.0 };
                Some((SPEED - YAW_RATE * y) * time / rover.side.geometry.wheel_radius)
            };
            let readings = WholeFrame {
                wheel_angle: std::array::from_fn(turn),
                rates: [Some(0.0), Some(0.0), Some(YAW_RATE)],
                ..level(time)
            };
            BothSides {
                readings,
                truth: None,
            }
        };
        (0..=800).map(sides).collect()
    });

    let chunks = chunks(&path);
    let component = Transform3D::descriptor_translation().component;
    let poses = rows::<Translation3D>(&chunks, "/world/rover", component);
    assert_eq!(poses.len(), 241);
    let (time, last) = poses.last().expect("poses");
    let (sin, cos) = (YAW_RATE * time).sin_cos();
    let expected = [SPEED / YAW_RATE * sin, SPEED / YAW_RATE * (1.0 - cos)];
    // Steps of 5 ms lag by half a step: 1e-3 of the way. Contact angles are estimated to 0.1 deg.
    for (found, expected) in last[0].0.0.iter().zip(expected) {
        assert!(
            (f64::from(*found) - expected).abs() < 2e-3,
            "{last:?} {expected:?}"
        );
    }
    for wheel in ["left_wheel1", "right_wheel3"] {
        assert!(chunks.contains_key(&format!("/world/rover/{wheel}/tyre")));
        let wheel = format!("/world/rover/{wheel}");
        assert_eq!(rows::<Translation3D>(&chunks, &wheel, component).len(), 241);
    }
    let wheelbase = rover.side.geometry.wheelbase();
    let component = Arrows3D::descriptor_vectors().component;
    let arrows = rows::<Vector3D>(&chunks, "/world/rover/forces", component);
    // At rest, a third of the wheelbase a mean load: the six sum to six times that.
    let (_, first) = &arrows[0];
    let sum: f32 = first.iter().map(|v| v.0.0[2]).sum();
    assert!(
        first.len() == 6 && (f64::from(sum) - 2.0 * wheelbase).abs() < 1e-3,
        "{first:?}"
    );
    let component = LineStrips3D::descriptor_strips().component;
    let tracks = rows::<LineStrip3D>(&chunks, "/world/tracks", component);
    let (_, ends) = tracks.last().expect("tracks");
    assert!(
        ends.len() == 6 && ends.iter().all(|s| s.0[1].0[2].abs() < 5e-3),
        "{ends:?}"
    );
    // The ground begins with all of it under the wheels and grows along the circle.
    let component = Mesh3D::descriptor_vertex_positions().component;
    let (mut count, mut ahead) = (0, f32::MIN);
    while chunks.contains_key(&format!("/world/ground/{count}")) {
        let meshes = rows::<Position3D>(&chunks, &format!("/world/ground/{count}"), component);
        // A tenth of the radius below the contacts.
        let below = 0.1 * rover.side.geometry.wheel_radius;
        let is_level = |p: &Position3D| (f64::from(p.0.0[2]) + below).abs() < 5e-3;
        let flat = |row: &[Position3D]| row.iter().all(is_level);
        assert!(meshes.iter().all(|(_, row)| flat(row)), "{count}");
        let places = meshes.iter().flat_map(|(_, row)| row);
        ahead = places.map(|p| p.0.0[0]).fold(ahead, f32::max);
        count += 1;
    }
    // To a row behind the front axle, which is about half of a wheelbase ahead of the middle one.
    let driven = SPEED / YAW_RATE * sin;
    assert!(
        f64::from(ahead) > driven + 0.3 * wheelbase,
        "{ahead} {driven}"
    );
    for (plot, lines) in [
        ("normal_force/left", 9),
        ("traction/right", 9),
        ("attitude", 2),
        ("tip_margin", 1),
    ] {
        let found = scalars(&chunks, &format!("/series/{plot}"));
        assert!(
            found.len() == 241 && found.iter().all(|(_, row)| row.len() == lines),
            "{plot}"
        );
    }
    let active = |m: &LogMsg| matches!(m, LogMsg::BlueprintActivationCommand(c) if c.make_active);
    assert!(messages(&path).iter().any(active));
}

/// True forces are drawn beside those found: an arrow at each contact where the truth has a row, and
/// a line of each wheel, with a gap where it has none.
#[test]
fn true_forces_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let (rover, path) = record(folder.path(), true, |_| {
        let sides = |k| {
            let time = 0.02 * f64::from(k);
            // Wheel i of the truth has (i + 1) N, in every second row.
            let side = |k: usize| {
                let mut truth = Truth {
                    time,
                    ..Truth::default()
                };
                for (i, wheel) in truth.wheels.iter_mut().enumerate() {
                    wheel.normal_force = (3 * k + i + 1) as f64;
                }
                truth
            };
            let truth = BothTruth {
                sides: [side(0), side(1)],
                normal_force: [0.0; 6],
                in_plane: None,
            };
            BothSides {
                readings: level(time),
                truth: (k % 2 == 0).then_some(truth),
            }
        };
        (0..=50).map(sides).collect()
    });

    let chunks = chunks(&path);
    let component = Arrows3D::descriptor_vectors().component;
    let arrows = rows::<Vector3D>(&chunks, "/world/rover/true_forces", component);
    let found = rows::<Vector3D>(&chunks, "/world/rover/forces", component);
    assert_eq!((arrows.len(), found.len()), (26, 51));
    // A third of the wheelbase a mean load.
    let scale = rover.side.geometry.wheelbase() / 3.0 / rover.mean_wheel_load();
    for (i, arrow) in arrows[3].1.iter().enumerate() {
        let expected = scale * (i + 1) as f64;
        // Single precision, and contacts found to some mrad.
        assert!(
            (f64::from(arrow.0.0[2]) - expected).abs() < 1e-3 * expected,
            "{arrow:?}"
        );
    }
    let plot = scalars(&chunks, "/series/normal_force/right");
    assert!(plot.len() == 51 && plot.iter().all(|(_, row)| row.len() == 12));
    let truth = |row: usize| [0, 4, 8].map(|line| plot[row].1[line]);
    let expected = [4.0, 5.0, 6.0].map(f64::to_bits);
    assert_eq!(truth(2).map(f64::to_bits), expected);
    assert!(truth(3).iter().all(|n| n.is_nan()));
}

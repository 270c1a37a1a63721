//! Sensors and model errors in whole runs.

use crate::support::{keep, scene};

const SHORT: [&str; 2] = ["engine.kind=direct", "record.duration=3"];

fn with(overrides: &[&str]) -> robhaz_scene::Scene {
    scene("smooth", &[&SHORT, overrides].concat())
}

/// Equivalence: nothing flows back. Sensors, model errors and the seed leave the truth to the bit as it was.
#[test]
fn sensors_never_change_the_truth() {
    let ideal = keep(&with(&[])).truth;
    for overrides in [
        ["sensors.grade=typical", "seed=1"],
        ["sensors.grade=poor", "model_error.pins=0.002"],
    ] {
        assert!(keep(&with(&overrides)).truth == ideal, "{overrides:?}");
    }
}

/// Determinism: a run with poor sensors repeats to the bit, from its resolved scene too; another seed reads otherwise.
#[test]
fn noisy_runs_repeat_to_the_bit() {
    let first = with(&["sensors.grade=poor", "seed=3"]);
    let text = first.to_toml("x");
    let resolved = robhaz_scene::Scene::parse(&text, "x.toml", "".as_ref(), &[]).unwrap();
    let [a, b] = [&first, &resolved].map(keep);
    assert!(a.sensors == b.sensors && a.estimates == b.estimates);
    let other = keep(&with(&["sensors.grade=poor", "seed=4"]));
    assert!(a.sensors != other.sensors);
}

/// What is told differs from the robot by what the scene says, and the estimators use it: with exact readings at rest, where the
/// statics are exact, the estimate is off by the model error alone. A body told 10 mm farther back or forth moves its weight.
#[test]
fn estimators_are_told_the_wrong_robot() {
    let at_rest = |overrides: &[&str]| {
        let kept = keep(&with(overrides));
        // 0.75 s: settled, and not yet started.
        let (truth, estimate) = (&kept.truth[750], kept.estimates[2][750].unwrap());
        let error = |i: usize| (estimate.normal_force[i] - truth.wheels[i].normal_force).abs();
        (0..3).map(error).fold(0.0, f64::max)
    };
    // The approach to rest is worth some mN.
    let exact = at_rest(&[]);
    assert!(exact < 0.05, "{exact}");
    let cad = at_rest(&["model_error.body_cg='10 mm'", "model_error.pins='2 mm'"]);
    // 5 kg moved by 10 mm on a base of 0.3 to 0.6 m: 0.5 N m over 0.3 m is 1.6 N at most; pins 2 mm: as much again.
    assert!((0.1..4.0).contains(&cad), "{cad}");
}

/// A scene whose model error cannot be a robot breaks off with a reason, even where no file was read.
#[test]
fn impossible_model_errors_stop_the_run() {
    let mut scene = with(&[]);
    scene.model_error.wheel_radius = -1.0;
    let error = robhaz_run::run(&scene, &mut []).unwrap_err();
    assert!(
        matches!(error, robhaz_run::RunError::ModelError(_)),
        "{error}"
    );
}

/// Friction in the reading and friction in the plant are seen alike by who reads: at a steady speed on level ground the
/// motor's reading rises by F, whichever of them it is; the robot's motion is the same.
#[test]
fn friction_in_the_reading_looks_like_friction_in_the_plant() {
    let read = |overrides: &[&str]| {
        let kept = keep(&scene("flat", &[&SHORT, overrides].concat()));
        // 2.9 s: the start is over for 1.5 s, seven times the slowest pole of the drive (Ki/Kp: 0.1 s) and the contact.
        let torque = kept.sensors[2900].motor_torque.map(Option::unwrap);
        torque.iter().sum::<f64>() / 3.0
    };
    let plain = read(&[]);
    let plant = read(&["drive.gear_friction=0.5"]) - plain;
    let reading = read(&["sensors.torque_friction=0.5"]) - plain;
    assert!((reading - 0.5).abs() < 1e-9, "{reading}");
    assert!((plant - 0.5).abs() < 1e-3, "{plant}");
}

/// Lost readings reach the estimators as missing, about as many as the grade says; where none is missing there is an estimate.
#[test]
fn lost_readings_are_missing_not_made_up() {
    let kept = keep(&with(&["sensors.grade=poor"]));
    let mut lost = [0; 13];
    for (sensors, estimate) in kept.sensors.iter().zip(&kept.estimates[0]) {
        let wheels = [
            sensors.wheel_angle,
            sensors.motor_torque,
            sensors.contact_angle,
        ];
        let links = [&sensors.link1, &sensors.link2].map(|l| [l.inclination, l.rate]);
        let all = wheels.as_flattened().iter().chain(links.as_flattened());
        let missing: Vec<bool> = all.map(Option::is_none).collect();
        for (count, missing) in lost.iter_mut().zip(&missing) {
            *count += usize::from(*missing);
        }
        assert!(estimate.is_ok() || missing.contains(&true));
    }
    for count in lost {
        // 1 % of 3001 is 30, with a standard deviation of 5.5: four of them.
        assert!((8..=52).contains(&count), "{lost:?}");
    }
}

//! Sensors and model errors in complete runs.

use crate::support::{keep, scene};

const SHORT: [&str; 2] = ["engine.kind=direct", "record.duration=3"];

fn with(overrides: &[&str]) -> robhaz_scene::Scene {
    scene("smooth", &[&SHORT, overrides].concat())
}

/// Equivalence: sensors, model errors and the seed do not change a bit of the truth.
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

/// Determinism: a run with poor sensors and a run of its resolved scene give the same bits; another
/// seed gives others.
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

/// The nominal robot differs from the simulated one by the scene's model errors, and the estimators
/// use the nominal robot: with exact readings at rest, where the statics are exact, the error of
/// the estimate comes from the model errors alone.
#[test]
fn estimators_use_the_nominal_robot() {
    let at_rest = |overrides: &[&str]| {
        let kept = keep(&with(overrides));
        // 0.75 s: in equilibrium, before the drive starts.
        let (truth, estimate) = (&kept.truth[750], kept.estimates[2][750].unwrap());
        let error = |i: usize| (estimate.normal_force[i] - truth.wheels[i].normal_force).abs();
        (0..3).map(error).fold(0.0, f64::max)
    };
    // The error of settling is a few mN.
    let exact = at_rest(&[]);
    assert!(exact < 0.05, "{exact}");
    let cad = at_rest(&["model_error.body_cg='10 mm'", "model_error.pins='2 mm'"]);
    // 5 kg shifted by 10 mm give 0.5 N m, over a base of at least 0.3 m at most 1.6 N; pins shifted
    // by 2 mm give as much.
    assert!((0.1..4.0).contains(&cad), "{cad}");
}

/// A run with impossible model errors ends with a reason, also if the scene was not read from a
/// file.
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

/// Equivalence: friction in the reading and friction in the plant have the same effect on the
/// readings. At constant speed on level ground either raises the torque reading by F.
#[test]
fn friction_in_the_reading_and_in_the_plant_give_the_same_readings() {
    let read = |overrides: &[&str]| {
        let kept = keep(&scene("flat", &[&SHORT, overrides].concat()));
        // 2.9 s: 1.5 s after the start's ramp, many times the slowest time constants of drive
        // (Kp/Ki = 0.1 s) and contact.
        let torque = kept.sensors[2900].motor_torque.map(Option::unwrap);
        torque.iter().sum::<f64>() / 3.0
    };
    let plain = read(&[]);
    let plant = read(&["drive.gear_friction=0.5"]) - plain;
    let reading = read(&["sensors.torque_friction=0.5"]) - plain;
    assert!((reading - 0.5).abs() < 1e-9, "{reading}");
    assert!((plant - 0.5).abs() < 1e-3, "{plant}");
}

/// Statistics: lost readings are missing in the sensor frames, as many as the grade states. A
/// complete frame always gives an estimate.
#[test]
fn lost_readings_are_missing_and_not_replaced() {
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
        // 1 % of 3001 is 30; four standard deviations of 5.5 on either side.
        assert!((8..=52).contains(&count), "{lost:?}");
    }
}

//! How long `kalman` takes to report faults, on every ground on which the robot rolls; and starts on
//! uneven ground, which must not look like late torques.

use super::common::faults::change_of;
use super::common::{Failure, SOFT, readings, scene, seeds};
use rayon::prelude::*;
use robhaz_estimator::{Channels, EstimateError, Estimator, Flags, SensorFrame};
use robhaz_scene::Scene;
use robhaz_study::TruthRun;

/// The start of the drive in the shipped scenes, s.
const START: f64 = 0.8;

/// Scenes on which the robot rolls all the way.
const ROLLING: [&str; 7] = [
    "smooth", "sine", "rough", "heights", "cosbump", "ramp", "course",
];

/// Faults and a channel that must be faulty.
const TABLE: [(&str, Channels); 7] = [
    ("gyro 1 sign", Channels::GYROSCOPE[0]),
    ("gyro 2 sign", Channels::GYROSCOPE[1]),
    ("inclinations in degrees", Channels::INCLINOMETER[0]),
    ("torques 1 and 2 exchanged", Channels::TORQUE[0]),
    ("torques 2 and 3 exchanged", Channels::TORQUE[1]),
    ("torque 1 stuck", Channels::TORQUE[0]),
    ("torques 20 ms late", Channels::TORQUE[0]),
];

/// Time at which each fault of the table is there, s: readings are stuck from 3 s on.
fn begin(name: &str) -> f64 {
    if name.ends_with("stuck") { 3.0 } else { START }
}

/// Time until a channel is faulty, or the readings are refused, s.
fn reported(
    scene: &Scene,
    estimator: usize,
    frames: &[SensorFrame],
    channels: Channels,
) -> Result<Option<f64>, Failure> {
    let settings = scene.nominal_settings(&scene.estimators[estimator])?;
    let mut estimator = Estimator::new(&scene.nominal_robot()?, settings);
    for frame in frames {
        let is_reported = match estimator.update(frame) {
            Ok(estimate) => {
                let faulty = estimate
                    .kalman
                    .ok_or("kalman states its health")?
                    .health
                    .faulty;
                faulty.contains(channels) || estimate.flags.contains(Flags::SENSOR_ABSURD)
            }
            Err(EstimateError::Linkage(_)) => true,
            Err(_) => false,
        };
        if is_reported {
            return Ok(Some(frame.time));
        }
    }
    Ok(None)
}

/// Times from its begin until a fault is reported, s, with given contact angles and with none, of
/// the seeds from 0 on.
fn times(
    scene: &Scene,
    truth: &TruthRun,
    (name, channels): (&str, Channels),
    seeds: u64,
) -> Result<[Vec<Option<f64>>; 2], Failure> {
    let change = change_of(name).ok_or(name)?;
    let times: Vec<[Option<f64>; 2]> = (0..seeds)
        .into_par_iter()
        .map(|seed| {
            let mut frames = readings(scene, truth, seed);
            change.of(&mut frames);
            let time = |estimator| -> Result<_, Failure> {
                let found = reported(scene, estimator, &frames, channels)?;
                Ok(found.map(|t| t - begin(name)))
            };
            Ok([time(0)?, time(1)?])
        })
        .collect::<Result<_, Failure>>()?;
    Ok([0, 1].map(|k| times.iter().map(|t| t[k]).collect()))
}

/// How many are within 5 s, how many there are, of how many runs; median and largest.
fn in_short(times: &[Option<f64>]) -> String {
    let mut found: Vec<f64> = times.iter().flatten().copied().collect();
    found.sort_by(f64::total_cmp);
    let soon = found.iter().filter(|t| **t <= 5.0).count();
    let counts = format!("{soon:2}/{:2}/{:2}", found.len(), times.len());
    match (found.get(found.len() / 2), found.last()) {
        (Some(median), Some(last)) => format!("{counts} median {median:4.1} last {last:4.1}"),
        _ => counts,
    }
}

/// Each fault is reported within 5 s of driving on each ground, by the PI drive with typical
/// sensors, in 20 seeds, with given contact angles and with none. The one exception: on `cosbump`
/// link 2 turns from 4.65 s on; within 1 s after that. Prints the table: reported within 5 s /
/// reported / runs.
#[test]
#[ignore = "two minutes of two cores"]
fn every_fault_is_reported_on_every_ground() -> Result<(), Failure> {
    // Environment variables make it another one: SEEDS, SCENE, FAULT, GRADE, SOFT (the
    // low-gain drive). Only printed then.
    let stated = |name: &str| std::env::var(name).ok();
    let seeds = seeds(20);
    let grade = stated("GRADE").unwrap_or_else(|| "typical".to_owned());
    let drive: &[&str] = if stated("SOFT").is_some() { &SOFT } else { &[] };
    let is_stated_case = grade == "typical" && drive.is_empty();
    let set = format!("sensors.grade={grade}");
    for name in ROLLING {
        if stated("SCENE").is_some_and(|one| one != name) {
            continue;
        }
        let scene = scene(name, &[drive, &[&set]].concat())?;
        let truth = TruthRun::of(&scene)?;
        for (what, channels) in TABLE {
            if stated("FAULT").is_some_and(|one| one != what) {
                continue;
            }
            let times = times(&scene, &truth, (what, channels), seeds)?;
            for (angles, times) in ["given", "none"].iter().zip(&times) {
                println!("{name:8} {what:26} {angles:6} {}", in_short(times));
                let late_turn = name == "cosbump" && what == "gyro 2 sign";
                let limit = if late_turn { 5.65 } else { 5.0 };
                let soon = |t: &Option<f64>| t.is_some_and(|t| t <= limit);
                assert!(
                    !is_stated_case || times.iter().all(soon),
                    "{name} {what} {times:?}"
                );
            }
        }
    }
    Ok(())
}

/// Late torques are reported within 5 s on a ground where the wheels never work against each other,
/// too: the robot's start tells them, without contact angles, and whatever the control is.
#[test]
fn late_torques_are_reported_on_flat_ground() -> Result<(), Failure> {
    let set = ["sensors.grade=typical", "record.duration=4"];
    let scene = scene("flat", &set)?;
    let truth = TruthRun::of(&scene)?;
    let late = ("torques 20 ms late", Channels::TORQUE[0]);
    for times in times(&scene, &truth, late, 8)? {
        println!("{}", in_short(&times));
        assert!(times.iter().all(|t| t.is_some_and(|t| t < 5.0)));
    }
    Ok(())
}

/// Grounds on which a robot starts: random ones of three classes of ISO 8608, and waves of 20 mm at
/// different phases.
fn uneven_starts() -> Vec<(&'static str, Vec<String>)> {
    let mut grounds = Vec::new();
    for class in ["C", "D", "E"] {
        for seed in 0..6 {
            let set = [
                "terrain.start=-1".to_owned(),
                format!("terrain.class={class}"),
                format!("terrain.seed={seed}"),
            ];
            grounds.push(("rough", set.to_vec()));
        }
    }
    for wavelength in [300, 500, 700] {
        for k in 0..6 {
            let start = -1.5 + f64::from(k * wavelength) / 6000.0;
            let set = [
                format!("terrain.wavelength={wavelength} mm"),
                "terrain.periods=12".to_owned(),
                format!("terrain.start={start}"),
            ];
            grounds.push(("sine", set.to_vec()));
        }
    }
    grounds
}

/// The slope of uneven ground changes the torques of a robot that starts: the fit of the start must
/// not take that for a delay.
#[test]
fn starts_on_uneven_ground_raise_no_alarm() -> Result<(), Failure> {
    for drive in [&[] as &[&str], &SOFT] {
        for (name, ground) in uneven_starts() {
            let ground: Vec<&str> = ground.iter().map(String::as_str).collect();
            let fixed = [
                "sensors.grade=typical",
                "record.duration=2.5",
                "record.compare_from=1",
            ];
            let scene = scene(name, &[drive, &ground, &fixed].concat())?;
            let truth = TruthRun::of(&scene)?;
            for seed in 0..2 {
                let frames = readings(&scene, &truth, seed);
                let late = reported(&scene, 1, &frames, Channels::TORQUE[1])?;
                assert_eq!(late, None, "{drive:?} {ground:?} {seed}");
            }
        }
    }
    Ok(())
}

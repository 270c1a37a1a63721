//! Honest logs of all lengths, rates and speeds: `check` must not call them faulty. A user who gets
//! false alarms ignores the true ones.
//!
//! `cargo test --release -p robhaz --test robhaz check::honest_logs:: -- --ignored --nocapture`
//! runs 2 400 logs and prints each alarm.

use super::common::{Failure, SOFT, checked, drive, readings_of, report, scene};
use rayon::prelude::*;
use robhaz_log::check::{Finding, Report, Verdict};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_study::TruthRun;
use std::collections::BTreeMap;
use std::path::Path;

/// Five grounds, long enough for a minute at 1 m/s where their kind allows it.
const GROUNDS: [(&str, &[&str]); 5] = [
    ("smooth", &[]),
    ("sine", &["terrain.periods=120"]),
    ("rough", &["terrain.extent=60"]),
    ("heights", &[]),
    ("flat", &[]),
];
/// m/s.
const SPEEDS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];
/// Samples of the truth, at 1 kHz, for one of the log: 1000, 200, 100, 50, 20 and 10 Hz.
const STRIDES: [usize; 6] = [1, 5, 10, 20, 50, 100];
/// s.
const LENGTHS: [f64; 4] = [5.0, 10.0, 20.0, 60.0];
/// Longest log, s.
const LONGEST: f64 = 60.0;

/// A log: its name, the number of truth samples for one of its own, its length (s), its sensors.
struct Log {
    stride: usize,
    length: f64,
    grade: &'static str,
    seed: u64,
}

/// The logs of one drive.
fn logs(first_seed: u64) -> Vec<Log> {
    let mut logs = Vec::new();
    for stride in STRIDES {
        for length in LENGTHS {
            for grade in ["typical", "poor"] {
                let seed = first_seed + logs.len() as u64;
                logs.push(Log {
                    stride,
                    length,
                    grade,
                    seed,
                });
            }
        }
    }
    logs
}

/// What `check` says of a log.
fn report_of(
    name: &str,
    overrides: &[&str],
    truth: &[Truth],
    log: &Log,
) -> Result<Report, Failure> {
    let grade = format!("sensors.grade={}", log.grade);
    let scene = scene(name, &[overrides, &[&grade]].concat())?;
    let of_log = truth.iter().step_by(log.stride);
    let of_log = of_log.take_while(|t| t.time <= log.length);
    report(&scene, &readings_of(&scene, of_log, log.seed))
}

/// False alarms: how many logs there are, how many have an alarm, and how often each test alarms.
#[derive(Default)]
struct Alarms {
    logs: usize,
    with_alarm: usize,
    by_test: BTreeMap<String, usize>,
}

impl Alarms {
    fn add(&mut self, what: &str, report: &Report) {
        self.with_alarm += usize::from(report.faults().count() > 0);
        // SHOW=test prints what a test found of each log.
        if let Ok(test) = std::env::var("SHOW") {
            for f in report.findings.iter().filter(|f| f.test == test) {
                println!("{what}: {:?} {} {}", f.verdict, f.channel, f.figure);
            }
        }
        for fault in report.faults() {
            println!(
                "FALSE ALARM {what}: {} | {} | {}",
                fault.test, fault.channel, fault.figure
            );
            let key = format!("{} | {}", fault.test, fault.channel);
            *self.by_test.entry(key).or_default() += 1;
        }
    }
}

/// Checks the logs of one ground, drive and speed.
fn add_drive(
    alarms: &mut Alarms,
    (name, ground): (&str, &[&str]),
    drive: &[&str],
    speed: f64,
    logs: &[Log],
) -> Result<(), Failure> {
    // SEED=5199,5439 repeats these logs.
    let seeds = std::env::var("SEED").ok();
    let is_chosen = |log: &&Log| {
        let is_its = |seed: &str| seed.parse() == Ok(log.seed);
        (seeds.as_ref()).is_none_or(|seeds| seeds.split(',').any(is_its))
    };
    let chosen: Vec<&Log> = logs.iter().filter(is_chosen).collect();
    alarms.logs += logs.len();
    if chosen.is_empty() {
        return Ok(());
    }
    let speed = format!("drive.speed={speed}");
    let duration = format!("record.duration={LONGEST}");
    let overrides = [ground, drive, &[&speed, &duration]].concat();
    let truth = TruthRun::of(&scene(name, &overrides)?)?;
    let truth: Vec<Truth> = truth.samples().copied().collect();
    let reports: Vec<Report> = chosen
        .par_iter()
        .map(|log| report_of(name, &overrides, &truth, log))
        .collect::<Result<_, Failure>>()?;
    for (log, report) in chosen.iter().zip(&reports) {
        let what = format!(
            "{name} {} {speed} {} Hz {} s {} seed {}",
            drive.join(" "),
            1000 / log.stride,
            log.length,
            log.grade,
            log.seed
        );
        alarms.add(&what, report);
    }
    Ok(())
}

/// At most 0.5 % of honest logs have a false alarm: five grounds, both drives, 0.05 to 1 m/s, 10 Hz
/// to 1 kHz, 5 to 60 s, two grades of sensors, 2 400 logs.
#[test]
#[ignore = "twenty minutes of two cores"]
fn honest_logs_have_no_fault() -> Result<(), Failure> {
    let mut alarms = Alarms::default();
    for ground in GROUNDS {
        if std::env::var("SCENE").is_ok_and(|one| one != ground.0) {
            continue;
        }
        for drive in [&[] as &[&str], &SOFT] {
            for speed in SPEEDS {
                let first_seed = 5000 + alarms.logs as u64;
                add_drive(&mut alarms, ground, drive, speed, &logs(first_seed))?;
            }
        }
    }
    for (test, count) in &alarms.by_test {
        println!("{count:5}  {test}");
    }
    let Alarms {
        logs, with_alarm, ..
    } = alarms;
    println!("{with_alarm} of {logs} logs have a false alarm");
    assert!(200 * with_alarm <= logs, "{with_alarm} of {logs}");
    Ok(())
}

/// The figure and verdict of a test.
fn verdict<'a>(report: &'a Report, test: &str) -> Option<(Verdict, &'a str)> {
    let found = report.findings.iter().find(|f| f.test == test)?;
    Some((found.verdict, &found.figure))
}

/// At 40 to 83 Hz and at 0.5 m/s, where a sample takes several steps of the path, the distance is
/// found right.
#[test]
fn the_distance_is_found_at_low_rates_and_high_speeds() -> Result<(), Failure> {
    for (speed, strides) in [("0.2", [25, 20, 12]), ("0.5", [12, 5, 1])] {
        let speed = format!("drive.speed={speed}");
        let overrides = [speed.as_str(), "sensors.grade=typical"];
        let scene = scene("smooth", &overrides)?;
        let truth = TruthRun::of(&scene)?;
        for stride in strides {
            let of_log = truth.samples().step_by(stride);
            let report = report(&scene, &readings_of(&scene, of_log, 3))?;
            let found = verdict(&report, "distance");
            assert!(
                matches!(found, Some((Verdict::Ok, _))),
                "{speed} {stride} {found:?}"
            );
        }
    }
    Ok(())
}

/// Ideal sensors have no fault: noise and zeros that are shown as 0.000 are none, whatever the
/// budget, and no remedy is to state a noise of zero.
#[test]
fn ideal_sensors_have_no_fault() -> Result<(), Failure> {
    let scene = scene("smooth", &["record.duration=8"])?;
    let truth = TruthRun::of(&scene)?;
    let report = report(&scene, &readings_of(&scene, truth.samples(), 0))?;
    let faults: Vec<_> = report.faults().collect();
    assert!(faults.is_empty(), "{faults:?}");
    assert!(
        !report.text(true).contains("= 0.00000"),
        "{}",
        report.text(true)
    );
    Ok(())
}

/// An IMU of 10 Hz that gives both readings in one message has no delay.
#[test]
fn a_slow_imu_has_no_delay() -> Result<(), Failure> {
    let (scene, mut frames) = drive("smooth", &[], 0)?;
    for (k, frame) in frames.iter_mut().enumerate() {
        // Stamps that are rounded to 0.1 ms.
        frame.time += 1e-4 * f64::from(u32::try_from(k % 3)?);
        if k % 10 != 0 {
            for link in [&mut frame.link1, &mut frame.link2] {
                (link.inclination, link.rate) = (None, None);
            }
        }
    }
    let report = report(&scene, &frames)?;
    let faults: Vec<_> = report.faults().collect();
    assert!(faults.is_empty(), "{faults:?}");
    Ok(())
}

/// Short logs in which a delay was found that is none: the example of docs/logs.md, and ground
/// through points.
#[test]
fn short_logs_have_no_delay() -> Result<(), Failure> {
    for (name, duration) in [("smooth", 5), ("heights", 8)] {
        let duration = format!("record.duration={duration}");
        let scene = scene(name, &["sensors.grade=typical", &duration])?;
        let truth = TruthRun::of(&scene)?;
        for seed in 0..7 {
            let report = report(&scene, &readings_of(&scene, truth.samples(), seed))?;
            let faults: Vec<_> = report.faults().collect();
            assert!(faults.is_empty(), "{name} {seed} {faults:?}");
        }
    }
    Ok(())
}

/// Counts of coarse encoders, 25 mrad, look as if the torques came 90 ms early; of 20 000 a turn, torques that
/// come 50 and 120 ms late are found.
#[test]
fn counts_of_encoders_are_no_delay() -> Result<(), Failure> {
    let late = |counts: &str, by: usize| -> Result<Report, Failure> {
        let counts = format!("sensors.encoder_counts={counts}");
        let (scene, mut frames) = drive("smooth", &[&counts], 11)?;
        for k in (by..frames.len()).rev() {
            frames[k].motor_torque = frames[k - by].motor_torque;
        }
        report(&scene, &frames)
    };
    let coarse = late("256", 0)?;
    let faults: Vec<_> = coarse.faults().collect();
    assert!(faults.is_empty(), "{faults:?}");
    for by in [5, 12] {
        let report = late("20000", by)?;
        let mut faults = report.faults().filter(|f| f.test == "delay");
        let delay = faults
            .next()
            .and_then(|f| f.numbers.first())
            .ok_or("a delay")?
            .value;
        assert!(
            (delay - 0.01 * f64::from(u32::try_from(by)?)).abs() < 0.015,
            "{report:?}"
        );
    }
    Ok(())
}

/// Readings that agree far better than their budget says show no wrong wiring, however small the
/// differences between wirings are.
#[test]
fn quiet_readings_on_an_edge_have_no_fault() -> Result<(), Failure> {
    let quiet = scene("step", &["record.duration=6", "engine.kind=rapier"])?;
    let frames = readings_of(&quiet, TruthRun::of(&quiet)?.samples(), 0);
    let report = checked(&quiet, false, &frames)?;
    let mut wiring = report.faults().filter(|f| f.test == "wheels and links");
    assert!(wiring.next().is_none(), "{report:?}");
    Ok(())
}

/// Stairs at 200 Hz: impacts between two readings leave a link's angle to the filters that errs, and raise the mean
/// NIS of the inclinometers to 6. That is no fault of an honest log; a gyroscope of the wrong sign still is one.
#[test]
fn impacts_between_readings_have_no_fault() -> Result<(), Failure> {
    let keys = [
        "engine.kind=rapier",
        "sensors.grade=typical",
        "sensors.rate=200",
        "record.rate=200",
    ];
    let stairs = scene("stairs", &keys)?;
    let truth = TruthRun::of(&stairs)?;
    for seed in 1..=3 {
        let mut frames = readings_of(&stairs, truth.samples(), seed);
        let report = checked(&stairs, false, &frames)?;
        let faults: Vec<_> = report.faults().collect();
        assert!(faults.is_empty(), "{seed} {faults:?}");
        let turned = frames.iter_mut().map(|f| &mut f.link1.rate);
        turned.for_each(|rate| *rate = rate.map(|rate| -rate));
        let report = checked(&stairs, false, &frames)?;
        assert!(report.faults().any(|f| f.test == "sign and unit"), "{seed}");
    }
    Ok(())
}

/// On a long gentle slope the links hardly turn, and the start of the robot is most of what inclinometers show: it is left
/// out, and does not look like a delay. With it gyroscopes explain 80 % of the changes.
#[test]
fn a_start_on_a_long_slope_is_no_delay() -> Result<(), Failure> {
    let keys = [
        "terrain.wavelength=6",
        "terrain.amplitude=0.1",
        "terrain.periods=1",
        "drive.speed=0.3",
        "drive.ramp_time=0.3",
        "record.duration=20",
        "sensors.grade=typical",
        "sensors.rate=100",
        "record.rate=100",
    ];
    let slope = scene("sine", &keys)?;
    let truth = TruthRun::of(&slope)?;
    for seed in 1..=3 {
        let report = report(&slope, &readings_of(&slope, truth.samples(), seed))?;
        let of_links = |f: &&Finding| f.test == "delay" && f.channel.starts_with("inclinometer");
        let delays: Vec<&Finding> = report.findings.iter().filter(of_links).collect();
        assert_eq!(delays.len(), 2);
        for delay in delays {
            let explained = delay.figure.split_whitespace().rev().nth(2);
            let explained: f64 = explained.ok_or("a share")?.parse()?;
            assert!(
                explained > 90.0 && delay.verdict != Verdict::Fault,
                "{delay:?}"
            );
        }
    }
    Ok(())
}

/// A clock that is set forward and one that is set back are named, and raise no other fault: the
/// log is split there.
#[test]
fn a_clock_that_is_set_raises_one_fault() -> Result<(), Failure> {
    let scene = scene("smooth", &["sensors.grade=typical"])?;
    let truth = TruthRun::of(&scene)?;
    let honest = readings_of(&scene, truth.samples(), 0);
    for by in [-0.2, 0.2] {
        let mut latest = f64::NEG_INFINITY;
        let mut frames = honest.clone();
        frames
            .iter_mut()
            .filter(|f| f.time > 10.0)
            .for_each(|f| f.time += by);
        // As when a log is read.
        frames.retain(|f| {
            let is_later = f.time > latest;
            latest = latest.max(f.time);
            is_later
        });
        let report = report(&scene, &frames)?;
        let faults: Vec<_> = report.faults().map(|f| f.test).collect();
        assert_eq!(faults, ["clock"], "{by} {:?}", verdict(&report, "delay"));
    }
    Ok(())
}

/// A rover of 420 kg, stated exactly, that settles on soft ground at the start of its log, as those of
/// other engines do that begin above it: no log of it is a contradiction.
#[test]
fn a_heavy_rover_that_settles_has_no_fault() -> Result<(), Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/curiosity.toml");
    let mut found = Vec::new();
    for (stiffness, damping) in [
        ("5.31e8", "2.5e5"),
        ("1e7", "2e3"),
        ("2e6", "2e4"),
        ("2e6", "1e3"),
    ] {
        for rate in [50, 200] {
            let keys = [
                "engine.kind=direct",
                "engine.start=raw",
                "robot.gravity=earth",
                "robot.mass.body=335",
                "drive.speed=0.1",
                "sensors.imu=links",
                "record.duration=12",
                &format!("contact.stiffness={stiffness}"),
                &format!("contact.damping={damping}"),
                &format!("sensors.rate={rate}"),
                &format!("record.rate={rate}"),
                "estimator=[{name='kalman',label='kalman-no-angles',contact_angles='none'}]",
            ]
            .map(str::to_owned);
            let scene = Scene::load(&path, &keys)?;
            let truth = TruthRun::of(&scene)?;
            let first: Vec<f64> = truth
                .samples()
                .step_by(rate / 25)
                .take(30)
                .map(|t| {
                    t.wheels[0]
                        .equivalent_contact()
                        .map_or(0.0, |c| c.normal_force)
                })
                .collect();
            println!("{first:.0?}");
            for seed in 0..3 {
                let report = report(&scene, &readings_of(&scene, truth.samples(), seed))?;
                let agreement = verdict(&report, "agreement of all");
                println!("{stiffness} {rate} {seed}: {agreement:?}");
                found.extend(report.faults().map(|f| {
                    format!(
                        "{stiffness} {rate} {seed}: {} {} {}",
                        f.test, f.channel, f.figure
                    )
                }));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
    Ok(())
}

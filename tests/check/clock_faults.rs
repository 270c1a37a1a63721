//! Clocks that are set, and gaps: what `kalman` states as trusted stays within what it states.
//!
//! `cargo test --release -p robhaz --test robhaz check::clock_faults:: -- --ignored --nocapture`
//! runs the study.

use super::common::{Errors, Failure, SOFT, drive, readings_of, report, scene};
use rayon::prelude::*;
use robhaz_estimator::{Estimator, Flags, SensorFrame};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_study::TruthRun;
use std::collections::BTreeMap;

/// Time at which the clock is set, s.
const AT: f64 = 8.0;

/// Faults of the clock: by how much it is set (s, back is negative), and for how long readings are
/// lost (s).
const FAULTS: [(f64, f64); 10] = [
    (-0.4, 0.0),
    (-0.2, 0.0),
    (-0.05, 0.0),
    (-0.02, 0.0),
    (0.02, 0.0),
    (0.05, 0.0),
    (0.2, 0.0),
    (0.4, 0.0),
    (1.7e9, 0.0),
    (0.0, 0.3),
];

/// Readings with the truth, of a clock that is set: rows with times that were there are left out,
/// as when a log is read.
fn set<'a>(
    frames: &[SensorFrame],
    truth: &[&'a Truth],
    (by, lost): (f64, f64),
) -> Vec<(SensorFrame, &'a Truth)> {
    let mut latest = f64::NEG_INFINITY;
    let mut found = Vec::new();
    for (frame, truth) in frames.iter().zip(truth) {
        let mut frame = *frame;
        if frame.time > AT && frame.time < AT + lost {
            continue;
        }
        if frame.time > AT {
            frame.time += by;
        }
        if frame.time > latest + 1e-6 {
            latest = frame.time;
            found.push((frame, *truth));
        }
    }
    found
}

/// Samples that count, of those with an estimate.
#[derive(Default, Debug, Clone, Copy)]
struct Count {
    samples: u32,
    /// Without a flag or a contradiction.
    trusted: u32,
    /// Trusted, and off by more than five stated deviations.
    off: u32,
    /// Largest force that is stated, and that without a flag, N.
    largest: f64,
    largest_trusted: f64,
    /// Most deviations by which a force beyond five times the weight is off.
    worst: f64,
}

/// Flags that say that something is wrong.
pub fn is_flagged(flags: Flags) -> bool {
    let warnings = [
        Flags::SENSOR_STALE,
        Flags::SENSOR_ABSURD,
        Flags::OUT_OF_RANGE,
        Flags::CONTRADICTION,
    ];
    warnings.iter().any(|flag| flags.contains(*flag))
}

fn count(scene: &Scene, estimator: usize, log: &[(SensorFrame, &Truth)]) -> Result<Count, Failure> {
    let settings = scene.nominal_settings(&scene.estimators[estimator])?;
    let mut estimator = Estimator::new(&scene.nominal_robot()?, settings);
    let mut count = Count::default();
    for (frame, truth) in log {
        let Ok(estimate) = estimator.update(frame) else {
            continue;
        };
        if truth.time < 2.0 {
            continue;
        }
        let trusted = !is_flagged(estimate.flags);
        let mut off = 0.0_f64;
        for (i, wheel) in Errors::of(&estimate, truth)? {
            off = wheel.in_deviations(1e-3).into_iter().fold(off, f64::max);
            let force = estimate.normal_force[i].max(estimate.traction[i].abs());
            count.largest = count.largest.max(force);
            if trusted {
                count.largest_trusted = count.largest_trusted.max(force);
            }
            if force > LARGEST {
                let [normal, traction] = wheel.in_deviations(0.0);
                count.worst = count.worst.max(normal.max(traction));
            }
        }
        count.samples += 1;
        count.trusted += u32::from(trusted);
        count.off += u32::from(trusted && off > 5.0);
    }
    Ok(count)
}

/// The counts of a scene's logs, with and without given contact angles.
fn counts(
    name: &str,
    overrides: &[&str],
    strides: &[usize],
    seeds: u64,
    faults: &[(f64, f64)],
) -> Result<Vec<(String, Count)>, Failure> {
    let scene = scene(name, overrides)?;
    let truth = TruthRun::of(&scene)?;
    let mut cases = Vec::new();
    for stride in strides {
        for seed in 0..seeds {
            for fault in faults {
                cases.push((*stride, seed, *fault));
            }
        }
    }
    let found: Vec<Vec<(String, Count)>> = cases
        .par_iter()
        .map(|(stride, seed, fault)| {
            let truth: Vec<&Truth> = truth.samples().step_by(*stride).collect();
            let frames = readings_of(&scene, truth.iter().copied(), *seed);
            let log = set(&frames, &truth, *fault);
            let rate = 1000 / stride;
            let mut found = Vec::new();
            for estimator in 0..2 {
                let what =
                    format!("{name} {overrides:?} {rate} Hz seed {seed} {fault:?} {estimator}");
                found.push((what, count(&scene, estimator, &log)?));
            }
            Ok(found)
        })
        .collect::<Result<_, Failure>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// A sum over logs, and their number.
#[derive(Default)]
struct Sum {
    logs: u32,
    /// With more than 1 % of the samples trusted and off.
    bad_logs: u32,
    samples: u32,
    off: u32,
}

impl Sum {
    fn add(&mut self, what: &str, count: &Count) {
        let share = f64::from(count.off) / f64::from(count.samples.max(1));
        let is_bad = share > 0.01 || count.largest_trusted > LARGEST || count.worst > 5.0;
        if is_bad {
            println!("{what}: {:.2} % {count:?}", 100.0 * share);
        }
        self.logs += 1;
        self.bad_logs += u32::from(is_bad);
        self.samples += count.samples;
        self.off += count.off;
    }

    /// Of no log more than 1 % of the samples are trusted although they are off by more than five
    /// stated deviations; no force beyond five times the weight is trusted, nor off by more than
    /// five deviations.
    fn holds(&self) -> bool {
        self.bad_logs == 0
    }
}

/// Five times the weight, N.
const LARGEST: f64 = 687.0;

fn each_holds(counts: Vec<(String, Count)>) {
    for (what, count) in counts {
        let mut sum = Sum::default();
        sum.add(&what, &count);
        assert!(sum.holds(), "{what} {count:?}");
    }
}

/// A clock that is set back by up to 0.4 s, at 1 kHz and at 100 Hz: the study below in small.
#[test]
fn a_clock_that_is_set_back_is_survived() -> Result<(), Failure> {
    let set = [
        SOFT[0],
        SOFT[1],
        "sensors.grade=typical",
        "record.duration=12",
    ];
    each_holds(counts("sine", &set, &[1, 10], 1, &FAULTS[..3])?);
    Ok(())
}

/// A clock that is set forward by years while wheels work against each other: `kalman` starts anew in
/// motion.
#[test]
fn a_clock_that_is_set_forward_is_survived() -> Result<(), Failure> {
    let set = ["sensors.grade=typical", "record.duration=12"];
    each_holds(counts("sine", &set, &[1], 2, &FAULTS[8..9])?);
    Ok(())
}

/// Of no log with a fault of the clock more than 1 % of the samples are trusted although they are
/// off by more than five stated deviations, and no force beyond five times the weight is: five
/// grounds, both drives, 1 kHz and 100 Hz, with contact angles and without, 800 logs.
#[test]
#[ignore = "some minutes of two cores"]
fn nothing_wrong_is_trusted() -> Result<(), Failure> {
    let mut sums: BTreeMap<String, Sum> = BTreeMap::new();
    for name in ["smooth", "sine", "rough", "course", "flat"] {
        for drive in [&[] as &[&str], &SOFT] {
            let fixed = ["sensors.grade=typical", "record.duration=16"];
            let overrides = [drive, &fixed].concat();
            for fault in FAULTS {
                let sum = sums.entry(format!("{fault:?}")).or_default();
                for (what, count) in counts(name, &overrides, &[1, 10], 2, &[fault])? {
                    sum.add(&what, &count);
                }
            }
        }
    }
    for (fault, sum) in &sums {
        let share = 100.0 * f64::from(sum.off) / f64::from(sum.samples);
        let Sum { logs, bad_logs, .. } = sum;
        println!("{fault}: {share:.3} % of the samples, {bad_logs} of {logs} logs beyond 1 %");
    }
    assert!(sums.values().all(Sum::holds));
    Ok(())
}

/// Rows that are lost at 100 Hz, one of 50, behind stamps that are made from the number of the row: named with their
/// number. With the stamps of the rows nothing is wrong.
#[test]
fn rows_that_are_lost_behind_even_stamps_are_named() -> Result<(), Failure> {
    let (scene, mut frames) = drive("rough", &[], 11)?;
    let mut row = 0;
    frames.retain(|_| {
        row += 1;
        row % 50 != 0
    });
    let of_clock = |frames: &[SensorFrame]| -> Result<Vec<f64>, Failure> {
        let report = report(&scene, frames)?;
        let faults = report.faults().filter(|f| f.test == "clock");
        Ok(faults.map(|f| f.numbers[0].value).collect())
    };
    assert_eq!(of_clock(&frames)?, Vec::<f64>::new());
    let lost = (frames.len() / 49) as f64;
    for (k, frame) in frames.iter_mut().enumerate() {
        frame.time = 0.01 * k as f64;
    }
    let found = of_clock(&frames)?;
    // On steep ground the wheels do not turn at one speed before and after.
    assert!(
        matches!(found[..], [rows] if rows > 0.5 * lost && rows <= lost),
        "{found:?} of {lost}"
    );
    Ok(())
}

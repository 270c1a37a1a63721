//! Faults of wiring, units, clocks and sensors against `check`: each must be found by its test, honest readings must not
//! be called faulty.
//!
//! `cargo test --release -p robhaz-check --test study -- --ignored --nocapture` prints the table of
//! `docs/on-your-robot.md`.

mod common;

use common::faults::FAULTS;
use common::{Failure, SOFT, readings, report, scene};
use rayon::prelude::*;
use robhaz_check::Report;
use robhaz_study::TruthRun;
use std::collections::BTreeMap;
use std::ops::Range;

/// Whether each fault was found by its own test, and by any.
type Found = Vec<(bool, bool)>;

/// Faults of a report in words.
fn words(report: &Report) -> Vec<String> {
    let faults = report.faults();
    faults
        .map(|f| format!("{} | {} | {}", f.test, f.channel, f.figure))
        .collect()
}

/// Of one case: how often each fault was found by its test, and by any; false alarms of honest readings.
struct Table {
    found: Vec<(u32, u32)>,
    alarms: BTreeMap<String, u32>,
}

fn table(name: &str, overrides: &[&str], seeds: Range<u64>) -> Result<Table, Failure> {
    let scene = scene(name, overrides)?;
    let truth = TruthRun::of(&scene)?;
    let of_seed = |seed: u64| -> Result<(Found, Vec<String>), Failure> {
        let honest = readings(&scene, &truth, seed);
        let alarms = words(&report(&scene, &honest)?);
        let mut found = Vec::new();
        for fault in FAULTS {
            let mut frames = honest.clone();
            (fault.change)(&mut frames);
            let report = report(&scene, &frames)?;
            let by_its_test = report.faults().any(|f| f.test == fault.test);
            found.push((by_its_test, report.faults().count() > 0));
        }
        Ok((found, alarms))
    };
    let results: Vec<_> = seeds
        .into_par_iter()
        .map(of_seed)
        .collect::<Result<_, Failure>>()?;
    let mut table = Table {
        found: vec![(0, 0); FAULTS.len()],
        alarms: BTreeMap::new(),
    };
    for (found, alarms) in results {
        for (sum, (by_its_test, any)) in table.found.iter_mut().zip(found) {
            sum.0 += u32::from(by_its_test);
            sum.1 += u32::from(any);
        }
        for alarm in alarms {
            println!("FALSE ALARM {name} {}: {alarm}", overrides.join(" "));
            *table.alarms.entry(alarm).or_default() += 1;
        }
    }
    Ok(table)
}

/// Each kind of fault is found by its test on the main scene with typical sensors; honest readings have no fault. The
/// study below in small.
#[test]
fn each_fault_is_found_and_honest_readings_have_none() -> Result<(), Failure> {
    let table = table("smooth", &["sensors.grade=typical"], 0..1)?;
    for (fault, (by_its_test, _)) in FAULTS.iter().zip(&table.found) {
        assert_eq!(*by_its_test, 1, "{}", fault.name);
    }
    assert!(table.alarms.is_empty(), "{:?}", table.alarms);
    Ok(())
}

/// Number of seeds of a study: 20, or of the environment variable SEEDS.
fn seeds() -> u64 {
    let stated = std::env::var("SEEDS").ok();
    stated.and_then(|n| n.parse().ok()).unwrap_or(20)
}

/// First seed of a study: no threshold of `check` was chosen with this or a later one.
const FRESH: u64 = 1000;

/// The table of faults over 20 seeds: found by its test, found by any, false alarms. At least 20 kinds are always found on
/// the main scene with typical sensors, and there is no false alarm.
#[test]
#[ignore = "ten minutes of two cores"]
fn faults_over_twenty_seeds() -> Result<(), Failure> {
    let seeds = seeds();
    let cases: [(&str, &[&str]); 4] = [
        ("typical, PI", &["sensors.grade=typical"]),
        (
            "typical, soft",
            &["sensors.grade=typical", SOFT[0], SOFT[1]],
        ),
        ("poor, PI", &["sensors.grade=poor"]),
        ("poor, soft", &["sensors.grade=poor", SOFT[0], SOFT[1]]),
    ];
    let mut tables = Vec::new();
    for (_, overrides) in cases {
        tables.push(table("smooth", overrides, FRESH..FRESH + seeds)?);
    }
    println!("found by its test / by any, of {seeds} seeds");
    print!("| fault | test |");
    cases.iter().for_each(|(name, _)| print!(" {name} |"));
    println!();
    for (k, fault) in FAULTS.iter().enumerate() {
        print!("| {} | {} |", fault.name, fault.test);
        for table in &tables {
            let (by_its_test, any) = table.found[k];
            print!(" {by_its_test} / {any} |");
        }
        println!();
    }
    print!("| none: false alarms | any |");
    tables
        .iter()
        .for_each(|t| print!(" {} |", t.alarms.values().sum::<u32>()));
    println!();
    let always = tables[0]
        .found
        .iter()
        .filter(|(n, _)| u64::from(*n) == seeds);
    assert!(always.count() >= 20);
    assert!(tables.iter().all(|t| t.alarms.is_empty()));
    Ok(())
}

/// Honest readings of every shipped scene are not called faulty: a log of a kerb, stairs or a slippery course is no fault.
#[test]
#[ignore = "ten minutes of two cores"]
fn honest_readings_of_all_scenes_have_no_fault() -> Result<(), Failure> {
    let seeds = seeds();
    let scenes = [
        "smooth", "flat", "cosbump", "sine", "rough", "heights", "course", "ramp", "ditch", "step",
        "stairs",
    ];
    let mut alarms = 0;
    for name in scenes {
        for drive in [&[] as &[&str], &SOFT] {
            let truth = TruthRun::of(&scene(name, drive)?)?;
            for grade in ["typical", "poor"] {
                let set = format!("sensors.grade={grade}");
                let scene = scene(name, &[drive, &[&set]].concat())?;
                let found: Vec<Vec<String>> = (FRESH..FRESH + seeds)
                    .into_par_iter()
                    .map(|seed| Ok(words(&report(&scene, &readings(&scene, &truth, seed))?)))
                    .collect::<Result<_, Failure>>()?;
                for (seed, faults) in found.iter().enumerate() {
                    for fault in faults {
                        println!(
                            "FALSE ALARM {name} {grade} {} {seed}: {fault}",
                            drive.join(" ")
                        );
                    }
                    alarms += usize::from(!faults.is_empty());
                }
            }
        }
    }
    println!(
        "{alarms} logs with a false alarm, {seeds} seeds of {} scenes, two drives, two grades",
        scenes.len()
    );
    assert_eq!(alarms, 0);
    Ok(())
}

//! Faults of wiring, units, clocks and sensors against `check`: found or not, and false alarms beside.

mod common;

use common::faults::FAULTS;
use common::{Failure, SOFT, readings, scene};
use rayon::prelude::*;
use robhaz_check::{Report, Stated, Verdict, check};
use robhaz_estimator::SensorFrame;
use robhaz_scene::Scene;
use robhaz_study::TruthRun;

fn report(scene: &Scene, frames: &[SensorFrame]) -> Result<Report, Failure> {
    let settings = scene.nominal_settings(&scene.estimators[0])?;
    // Without contact angles: no robot knows them.
    let mut frames = frames.to_vec();
    frames.iter_mut().for_each(|f| f.contact_angle = [None; 3]);
    let stated = Stated {
        robot: &scene.nominal_robot()?,
        budget: settings.budget,
        viscous_damping: settings.viscous_damping,
        compression: settings.compression,
    };
    Ok(check(&frames, &stated))
}

/// Tests that found a fault, in words.
fn found(report: &Report) -> String {
    let faults = report.faults();
    let words = faults.map(|f| format!("{} ({})", f.test, f.channel));
    words.collect::<Vec<_>>().join(", ")
}

/// For development: all findings of honest and of faulty readings.
#[test]
#[ignore = "prints"]
fn print_one() -> Result<(), Failure> {
    let name = std::env::var("SCENE").unwrap_or("smooth".into());
    let grade = std::env::var("GRADE").unwrap_or("typical".into());
    let drive: &[&str] = if std::env::var("SOFT").is_ok() {
        &SOFT
    } else {
        &[]
    };
    let set = format!("sensors.grade={grade}");
    let scene = scene(&name, &[drive, &[&set]].concat())?;
    let truth = TruthRun::of(&scene)?;
    let honest = readings(&scene, &truth, 0);
    println!("{}", report(&scene, &honest)?.text());
    for (fault, change) in FAULTS {
        let mut frames = honest.clone();
        change(&mut frames);
        let report = report(&scene, &frames)?;
        println!("\n=== {fault}");
        for f in report
            .findings
            .iter()
            .filter(|f| f.verdict == Verdict::Fault)
        {
            println!(
                "{} | {} | {} -> {:?}",
                f.test, f.channel, f.figure, f.remedy
            );
        }
    }
    Ok(())
}

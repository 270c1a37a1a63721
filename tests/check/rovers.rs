//! Logs of rovers, whose axles have unequal distances: the ground that all wheels pass tells signs,
//! direction and distance, also of an inertial sensor in the body and the angle of pin Q.

use super::common::{Failure, checked, report};
use robhaz_estimator::SensorFrame;
use robhaz_log::check::{Report, Verdict};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use std::path::Path;

/// Readings of a rover over two bumps, at 200 Hz.
fn drive(rover: &str, imu: &str, speed: f64) -> Result<(Scene, Vec<SensorFrame>), Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let keys = [
        "engine.kind=direct",
        "sensors.rate=200",
        "record.rate=200",
        "record.duration=36",
        "sensors.encoder_counts=160000",
        "sensors.torque_gain=0.02",
        "estimator=[{name='kalman',label='kalman-no-angles',contact_angles='none'}]",
        &format!("sensors.imu={imu}"),
        &format!("drive.speed={speed}"),
    ];
    let keys = keys.map(str::to_owned);
    let scene = Scene::load(&path.join(format!("{rover}.toml")), &keys)?;
    let mut sensors = scene.sensors();
    let mut frames = Vec::new();
    let mut plant = robhaz_run::DrivenPlant::new(&scene, &scene.plant_setup())?;
    while frames.len() < 7200 {
        let truth: Truth = plant.next_truth()?;
        frames.push(sensors.read(&truth));
    }
    Ok((scene, frames))
}

/// Remedies of all faults.
fn faults(report: &Report) -> Vec<String> {
    let faults = report.faults();
    faults
        .map(|f| format!("{}: {}", f.test, f.remedy.clone().unwrap_or_default()))
        .collect()
}

fn changed(frames: &[SensorFrame], change: impl Fn(&mut SensorFrame)) -> Vec<SensorFrame> {
    let mut frames = frames.to_vec();
    frames.iter_mut().for_each(|frame| {
        frame.contact_angle = [None; 3];
        change(frame);
    });
    frames
}

fn negate(x: &mut Option<f64>) {
    *x = x.map(|x| -x);
}

/// Honest readings pass, with all wheels on the same ground; a wrong sign of one inclinometer, of
/// all encoders and torques, and of the pin is found, each with its remedy.
#[test]
fn the_ground_tells_signs_and_direction() -> Result<(), Failure> {
    let (scene, frames) = drive("open-source-rover", "links", 0.2)?;
    let honest = report(&scene, &changed(&frames, |_| ()))?;
    assert_eq!(faults(&honest), Vec::<String>::new());
    for test in ["links on the ground", "distance"] {
        let found = honest.findings.iter().find(|f| f.test == test);
        assert_eq!(found.map(|f| f.verdict), Some(Verdict::Ok), "{test}");
    }
    let inclinometer = changed(&frames, |f| negate(&mut f.link2.inclination));
    let found = faults(&report(&scene, &inclinometer)?);
    assert!(
        found
            .iter()
            .any(|f| f.contains("inclinometer 2 has the wrong sign")),
        "{found:?}"
    );
    // With the inclinometers wrong as well, accelerations and torques agree.
    let backwards = changed(&frames, |f| {
        f.wheel_angle
            .iter_mut()
            .chain(&mut f.motor_torque)
            .for_each(negate);
        for link in [&mut f.link1, &mut f.link2] {
            negate(&mut link.inclination);
            negate(&mut link.rate);
        }
    });
    let found = faults(&report(&scene, &backwards)?);
    assert!(
        found.iter().any(|f| f.contains("all encoders and torques")),
        "{found:?}"
    );

    for (rover, body, speed) in [("open-source-rover", 1, 0.2), ("curiosity", 0, 0.25)] {
        let (scene, frames) = drive(rover, "body", speed)?;
        let honest = checked(&scene, true, &changed(&frames, |_| ()))?;
        assert_eq!(faults(&honest), Vec::<String>::new(), "{rover}");
        let pin = changed(&frames, |f| {
            let [body, other] = match body {
                0 => [f.link1, f.link2],
                _ => [f.link2, f.link1],
            };
            let turned = |body: Option<f64>, x: Option<f64>| Some(2.0 * body? - x?);
            let turned = robhaz_estimator::LinkReading {
                inclination: turned(body.inclination, other.inclination),
                rate: turned(body.rate, other.rate),
                rate_error: body.rate_error.max(other.rate_error),
            };
            match rover {
                "curiosity" => f.link2 = turned,
                _ => f.link1 = turned,
            }
        });
        let report = checked(&scene, true, &pin)?;
        let found = faults(&report);
        assert!(
            found
                .iter()
                .any(|f| f.contains("sign of reading.pin_angle")),
            "{rover}: {found:?}"
        );
    }
    Ok(())
}

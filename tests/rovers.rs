//! The rovers of `robots/`: their truth in both engines, and `best` on ground, speed and sensors that
//! are those of robot A in the rover's own units (Froude: length, mass, gravity).

use crate::support::{Kept, keep, root};
use robhaz_estimator::Flags;
use robhaz_model::{Robot, Units};
use robhaz_run::verify::{Outcome, verify};
use robhaz_scene::Scene;
use robhaz_score::{Rule, Score};

const ROVERS: [&str; 4] = ["open-source-rover", "exomy", "curiosity", "sojourner"];

fn rover(name: &str, overrides: &[String]) -> Scene {
    let path = root().join("robots").join(format!("{name}.toml"));
    Scene::load(&path, overrides).unwrap()
}

/// Units of a rover, and its wheelbase over that of robot A.
struct Size {
    units: Units,
    wheelbase: f64,
}

impl Size {
    fn of(robot: &Robot) -> Self {
        let base = |r: &Robot| r.geometry.axles[0].x - r.geometry.axles[2].x;
        Self {
            units: Units::of(robot),
            wheelbase: base(robot) / base(&Robot::default_a()),
        }
    }

    /// Typical sensors at 1 kHz, the PI or the low-gain drive, and the speed of 0.2 m/s, in these
    /// units, over the whole course.
    fn overrides(&self, low_gain: bool, imu: &str, seed: u64) -> Vec<String> {
        let (time, unit_torque) = (self.units.time, self.units.torque());
        let speed = 0.2 * self.units.speed();
        let duration = (3.7 * self.wheelbase / speed + 1.5 * time).ceil();
        let torque = 0.1 * unit_torque;
        let mut all = vec![
            format!("drive.speed={speed}"),
            format!("drive.start_time={}", 0.8 * time),
            format!("drive.ramp_time={}", 0.6 * time),
            format!("record.duration={duration}"),
            "record.rate=100".to_owned(),
            format!("record.compare_from={}", (2.0 * time).ceil()),
            "sensors.rate=1000".to_owned(),
            format!("sensors.imu={imu}"),
            "sensors.encoder_counts=160000".to_owned(),
            "sensors.torque_gain=0.02".to_owned(),
            format!("sensors.torque_offset={torque}"),
            format!("sensors.torque_noise={torque}"),
            "engine.kind=direct".to_owned(),
            format!("seed={seed}"),
        ];
        if low_gain {
            all.push(format!("drive.kp={}", 2.0 * unit_torque * time));
            all.push("drive.ki=0".to_owned());
        }
        all
    }
}

/// NRMSE of N and the share within two stated deviations of the second estimator, and whether it
/// raised an alarm.
fn judged(kept: &Kept, from: f64) -> (f64, f64, bool) {
    let mut score = Score::new(Rule { compare_from: from });
    for (truth, estimate) in kept.truth.iter().zip(&kept.estimates[1]) {
        score.add(truth, estimate.as_ref().ok());
    }
    let alarm = |e: &robhaz_estimator::Estimate| e.flags.contains(Flags::CONTRADICTION);
    let alarmed = kept.estimates[1].iter().flatten().any(alarm);
    (score.nrmse().unwrap(), score.coverage().unwrap(), alarmed)
}

/// Mean NRMSE of N on a rover in percent; at least 90 % of its errors within two stated deviations,
/// and no alarm.
fn mean_error(name: &str, low_gain: bool, imu: &str, seeds: u64) -> f64 {
    let size = Size::of(&rover(name, &[]).robot.robot);
    let error = |seed| {
        let scene = rover(name, &size.overrides(low_gain, imu, seed));
        let (error, coverage, alarm) = judged(&keep(&scene), scene.record.compare_from);
        let case = format!("{name} {low_gain} {imu} {seed}");
        assert!(coverage > 0.9 && !alarm, "{case}: {coverage} {alarm}");
        100.0 * error
    };
    let mean = (0..seeds).map(error).sum::<f64>() / seeds as f64;
    let drive = if low_gain { "low gain" } else { "PI" };
    println!("{name:<18} {drive:<8} {imu:<5} N {mean:.2} %");
    mean
}

/// Acceptance: N of `best` without contact angles within 1 %, of sensors on the links; with both
/// drives.
#[test]
fn best_holds_on_every_rover() {
    for name in ROVERS {
        for low_gain in [false, true] {
            assert!(mean_error(name, low_gain, "links", 3) < 1.0);
        }
    }
}

/// Acceptance: within 2 %, of an IMU in the body and the angle of pin Q. What the rate of the pin
/// lacks, a filter of its angle, costs up to 0.9 % of N.
#[test]
fn best_holds_with_an_imu_in_the_body() {
    for name in ROVERS {
        assert!(mean_error(name, false, "body", 1) < 2.0);
    }
}

/// Equivalence and conservation: both engines agree on each rover, in momentum, energy and motion.
#[test]
fn the_truth_of_every_rover_holds() {
    for name in ROVERS {
        let size = Size::of(&rover(name, &[]).robot.robot);
        let mut overrides = size.overrides(false, "links", 0);
        // The first bump is enough.
        let duration = (1.5 * size.wheelbase / (0.2 * size.units.speed())).ceil();
        overrides.push(format!("record.duration={duration}"));
        overrides.push("sensors.rate=100".to_owned());
        for verdict in verify(&rover(name, &overrides), &mut |_| {}, &|| None).unwrap() {
            assert_ne!(verdict.outcome, Outcome::Failed, "{name}: {verdict:?}");
        }
    }
}

//! The rovers of `robots/`: their truth in both engines, and `best` on ground, speed and sensors that
//! are those of robot A in the rover's own units (Froude: length, mass, gravity).

use crate::support::{Kept, keep, root};
use robhaz_estimator::Flags;
use robhaz_model::Robot;
use robhaz_run::verify::{Outcome, verify};
use robhaz_scene::Scene;
use robhaz_score::{Rule, Score};

const ROVERS: [&str; 4] = ["open-source-rover", "exomy", "curiosity", "sojourner"];

fn rover(name: &str, overrides: &[String]) -> Scene {
    let path = root().join("robots").join(format!("{name}.toml"));
    Scene::load(&path, overrides).unwrap()
}

/// Units of a robot over those of robot A: length, time and torque; and the wheelbase's.
struct Units {
    length: f64,
    time: f64,
    torque: f64,
    wheelbase: f64,
}

impl Units {
    fn of(robot: &Robot) -> Self {
        let a = Robot::default_a();
        let base = |r: &Robot| r.geometry.axles[0].x - r.geometry.axles[2].x;
        let length = robot.geometry.wheel_radius / a.geometry.wheel_radius;
        let weight = robot.mean_wheel_load() / a.mean_wheel_load();
        Self {
            length,
            time: (length * a.gravity / robot.gravity).sqrt(),
            torque: weight * length,
            wheelbase: base(robot) / base(&a),
        }
    }

    /// Typical sensors at 1 kHz, the PI or the low-gain drive, and the speed of 0.2 m/s, in these
    /// units, over the whole course.
    fn overrides(&self, low_gain: bool, seed: u64) -> Vec<String> {
        let speed = 0.2 * self.length / self.time;
        let duration = (3.7 * self.wheelbase / speed + 1.5 * self.time).ceil();
        let torque = 0.1 * self.torque;
        let mut all = vec![
            format!("drive.speed={speed}"),
            format!("drive.start_time={}", 0.8 * self.time),
            format!("drive.ramp_time={}", 0.6 * self.time),
            format!("record.duration={duration}"),
            "record.rate=100".to_owned(),
            format!("record.compare_from={}", (2.0 * self.time).ceil()),
            "sensors.rate=1000".to_owned(),
            "sensors.encoder_counts=160000".to_owned(),
            "sensors.torque_gain=0.02".to_owned(),
            format!("sensors.torque_offset={torque}"),
            format!("sensors.torque_noise={torque}"),
            "engine.kind=direct".to_owned(),
            format!("seed={seed}"),
        ];
        if low_gain {
            all.push(format!("drive.kp={}", 2.0 * self.torque * self.time));
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

/// Acceptance: N of `best` without contact angles within 1 %, at least 90 % of its errors within two
/// stated deviations, no alarm; with both drives.
#[test]
fn best_holds_on_every_rover() {
    for name in ROVERS {
        let units = Units::of(&rover(name, &[]).robot.robot);
        for low_gain in [false, true] {
            let (mut sum, seeds) = (0.0, 3);
            for seed in 0..seeds {
                let scene = rover(name, &units.overrides(low_gain, seed));
                let (error, coverage, alarm) = judged(&keep(&scene), scene.record.compare_from);
                assert!(
                    coverage > 0.9 && !alarm,
                    "{name} {low_gain} {seed}: {coverage} {alarm}"
                );
                sum += 100.0 * error;
            }
            let mean = sum / seeds as f64;
            println!(
                "{name:<18} {} N {mean:.2} %",
                if low_gain { "low gain" } else { "PI      " }
            );
            assert!(mean < 1.0, "{name} {low_gain}: {mean}");
        }
    }
}

/// Equivalence and conservation: both engines agree on each rover, in momentum, energy and motion.
#[test]
fn the_truth_of_every_rover_holds() {
    for name in ROVERS {
        let units = Units::of(&rover(name, &[]).robot.robot);
        let mut overrides = units.overrides(false, 0);
        // The first bump is enough.
        let duration = (1.5 * units.wheelbase * units.time / (0.2 * units.length)).ceil();
        overrides.push(format!("record.duration={duration}"));
        overrides.push("sensors.rate=100".to_owned());
        for verdict in verify(&rover(name, &overrides), &mut |_| {}, &|| None).unwrap() {
            assert_ne!(verdict.outcome, Outcome::Failed, "{name}: {verdict:?}");
        }
    }
}

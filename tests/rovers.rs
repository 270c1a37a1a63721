//! The rovers of `robots/`: their truth in both engines, and `best` on ground, speed and sensors
//! that are those of robot A in the rover's own units (Froude: length, mass, gravity).

use crate::support::{Kept, keep, root};
use robhaz_control::{FrictionTestEnd, FrictionTestResult};
use robhaz_estimator::Flags;
use robhaz_model::{Robot, Units};
use robhaz_run::verify::{Outcome, verify};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
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

/// Acceptance: with the sensors that these rovers have, at their rates of 8 to 50 Hz, `best` errs
/// by at most 3 %, states no less than it errs, and raises no alarm.
#[test]
fn best_holds_with_the_sensors_of_each_rover() {
    for name in ROVERS {
        for imu in ["links", "body"] {
            let keys = [
                format!("sensors.imu={imu}"),
                "engine.kind=direct".to_owned(),
            ];
            let scene = rover(name, &keys);
            let (error, coverage, alarm) = judged(&keep(&scene), scene.record.compare_from);
            let case = format!("{name} {imu}: {error} {coverage} {alarm}");
            assert!(error < 0.03 && coverage > 0.9 && !alarm, "{case}");
        }
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

/// NRMSE of N (%), RMSE of T over the mean load (%), share within two sigma (%), mean stated sigma
/// (%) and alarms of `best`, means over seeds.
fn row(scenes: impl Iterator<Item = Scene>) -> String {
    let (mut sums, mut count, mut alarms) = ([0.0; 4], 0.0, 0);
    for scene in scenes {
        let kept = keep(&scene);
        let mut score = Score::new(Rule {
            compare_from: scene.record.compare_from,
        });
        for (truth, estimate) in kept.truth.iter().zip(&kept.estimates[1]) {
            score.add(truth, estimate.as_ref().ok());
        }
        let (_, _, alarm) = judged(&kept, scene.record.compare_from);
        let found = [
            score.nrmse().unwrap(),
            score.traction().unwrap().nrmse.unwrap(),
            score.coverage().unwrap(),
            score.stated().unwrap(),
        ];
        for (sum, value) in sums.iter_mut().zip(found) {
            *sum += 100.0 * value;
        }
        count += 1.0;
        alarms += u32::from(alarm);
    }
    let [n, t, within, stated] = sums.map(|sum| sum / count);
    format!("{n:.2} | {t:.2} | {stated:.2} | {within:.0} | {alarms}")
}

/// What `best` reaches without contact angles, with sensors as of a research robot and as these
/// rovers have them.
#[test]
#[ignore = "a study of some minutes"]
fn study_of_sensors() {
    println!(
        "| rover | sensors | drive | N, % | T, % of the mean N | stated, % | within two sigma, % | alarms |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for name in ROVERS {
        let size = Size::of(&rover(name, &[]).robot.robot);
        for imu in ["links", "body"] {
            for low_gain in [false, true] {
                let scenes = (0..4).map(|seed| rover(name, &size.overrides(low_gain, imu, seed)));
                let drive = if low_gain { "low gain" } else { "PI" };
                println!(
                    "| `{name}` | typical, 1 kHz, on the {imu} | {drive} | {} |",
                    row(scenes)
                );
            }
        }
        for imu in ["links", "body"] {
            let scenes = (0..4).map(|seed| {
                let keys = [
                    format!("sensors.imu={imu}"),
                    format!("seed={seed}"),
                    "engine.kind=direct".to_owned(),
                ];
                rover(name, &keys)
            });
            println!(
                "| `{name}` | its own, on the {imu} | PI | {} |",
                row(scenes)
            );
        }
    }
}

/// Keeps the friction tests of a run.
#[derive(Default)]
struct Tests(Vec<FrictionTestResult>);

impl Sink for Tests {
    fn begin(&mut self, _run: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    fn frame(&mut self, _frame: &Frame<'_>) -> Result<(), SinkError> {
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.0 = end.map_or(Vec::new(), |end| end.friction_tests.clone());
        Ok(())
    }
}

/// Errors of mu_max on level ground by friction tests of all wheels, with typical sensors on the
/// links.
fn friction_errors(name: &str, mu: f64, seeds: u64) -> Vec<f64> {
    let size = Size::of(&rover(name, &[]).robot.robot);
    let of_seed = |seed| {
        let mut keys = size.overrides(false, "links", seed);
        let time = size.units.time;
        keys.extend([
            "terrain.kind=flat".to_owned(),
            "drive.kind=friction-test".to_owned(),
            format!("drive.friction_test.start={}", 6.0 * time),
            format!("record.duration={}", (70.0 * time).ceil()),
            format!("contact.mu_s={mu}"),
            format!("contact.mu_d={}", 0.875 * mu),
        ]);
        let mut tests = Tests::default();
        robhaz_run::run(&rover(name, &keys), &mut [&mut tests]).unwrap();
        let ended = tests.0.into_iter().filter(|test| {
            matches!(
                test.end,
                FrictionTestEnd::Slipped | FrictionTestEnd::EitherWheel(_)
            )
        });
        let errors: Vec<f64> = ended.map(|test| test.mu - mu).collect();
        errors
    };
    (0..seeds).flat_map(of_seed).collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

/// Acceptance: friction tests of a rover find mu_max within 4 %, from a scene that states no rate.
#[test]
fn friction_tests_hold_on_every_rover() {
    for name in ROVERS {
        let errors = friction_errors(name, 0.5, 1);
        assert!(
            errors.len() == 3 && rms(&errors) < 0.02,
            "{name}: {errors:?}"
        );
    }
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_friction_tests() {
    println!("| rover | mu_s | found of 12 | mean error | RMS | largest |");
    println!("|---|---|---|---|---|---|");
    for name in ROVERS {
        for mu in [0.05, 0.1, 0.2, 0.3, 0.5, 0.8] {
            let errors = friction_errors(name, mu, 4);
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let largest = errors.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let count = errors.len();
            println!(
                "| `{name}` | {mu} | {count} | {mean:+.4} | {:.4} | {largest:.4} |",
                rms(&errors)
            );
        }
    }
}

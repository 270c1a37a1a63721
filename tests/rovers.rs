//! The rovers of `robots/`: their truth in both engines, and `kalman` on ground, speed and sensors
//! that are those of robot A in the rover's own units (Froude: length, mass, gravity).

use crate::support::{Kept, keep, root};
use robhaz_control::{FrictionTestEnd, FrictionTestResult};
use robhaz_estimator::Flags;
use robhaz_model::{Robot, Units};
use robhaz_run::verify::verify;
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

/// Acceptance: N of `kalman` without contact angles within 1 %, of sensors on the links; with both
/// drives.
#[test]
fn kalman_holds_on_every_rover() {
    for name in ROVERS {
        for low_gain in [false, true] {
            assert!(mean_error(name, low_gain, "links", 3) < 1.0);
        }
    }
}

/// Acceptance: within 2 %, of an IMU in the body and the angle of pin Q. What the rate of the pin
/// lacks, a filter of its angle, costs up to 0.9 % of N.
#[test]
fn kalman_holds_with_an_imu_in_the_body() {
    for name in ROVERS {
        assert!(mean_error(name, false, "body", 1) < 2.0);
    }
}

/// Acceptance: with the sensors that these rovers have, at their rates of 8 to 50 Hz, `kalman` errs
/// by at most 3 %, states no less than it errs, and raises no alarm.
#[test]
fn kalman_holds_with_the_sensors_of_each_rover() {
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
        // The first bump is enough: the rear wheel passes it.
        let duration = (1.2 * size.wheelbase / (0.2 * size.units.speed())).ceil();
        overrides.push(format!("record.duration={duration}"));
        overrides.push("sensors.rate=100".to_owned());
        for verdict in verify(&rover(name, &overrides), &mut |_| {}, &|| None).unwrap() {
            assert_ne!(verdict.passed, Some(false), "{name}: {verdict:?}");
        }
    }
}

/// NRMSE of N (%), RMSE of T over the mean load (%), share within two sigma (%), mean stated sigma
/// (%) and alarms of `kalman`, means over seeds.
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

/// What `kalman` reaches without contact angles, with sensors as of a research robot and as these
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

/// Friction tests of all wheels on level ground.
fn friction_tests(
    name: &str,
    law: &str,
    mu: f64,
    mut keys: Vec<String>,
) -> Vec<FrictionTestResult> {
    keys.extend([
        "terrain.kind=flat".to_owned(),
        "engine.kind=direct".to_owned(),
        "drive.kind=friction-test".to_owned(),
        format!("contact.friction={law}"),
        format!("contact.mu_s={mu}"),
        format!("contact.mu_d={}", 0.875 * mu),
    ]);
    let mut tests = Tests::default();
    robhaz_run::run(&rover(name, &keys), &mut [&mut tests]).unwrap();
    tests.0
}

/// The keys of a rover with typical sensors on the links at 1 kHz.
fn with_typical_sensors(name: &str, seed: u64) -> Vec<String> {
    let size = Size::of(&rover(name, &[]).robot.robot);
    let mut keys = size.overrides(false, "links", seed);
    let time = size.units.time;
    keys.push(format!("drive.friction_test.start={}", 6.0 * time));
    keys.push(format!("record.duration={}", (70.0 * time).ceil()));
    keys
}

/// The keys of a rover with its own sensors at their own rate.
fn with_its_own_sensors(name: &str, seed: u64) -> Vec<String> {
    let time = Size::of(&rover(name, &[]).robot.robot).units.time;
    vec![
        format!("seed={seed}"),
        format!("drive.friction_test.start={}", (6.0 * time).ceil()),
        format!("record.duration={}", (75.0 * time).ceil()),
    ]
}

/// Errors of mu_max, and over the stated deviation, of the tests that found it.
fn friction_errors(tests: &[FrictionTestResult], mu: f64) -> Vec<(f64, f64)> {
    let found = tests.iter().filter(|test| test.ramps > 0);
    let error = |test: &FrictionTestResult| test.mu - mu;
    found
        .map(|test| (error(test), error(test) / test.sigma))
        .collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
}

/// Acceptance: friction tests of a rover find mu_max within 4 %, from a scene that states no rate.
#[test]
fn friction_tests_hold_on_every_rover() {
    for name in ROVERS {
        let tests = friction_tests(name, "adams", 0.5, with_typical_sensors(name, 0));
        let errors: Vec<f64> = friction_errors(&tests, 0.5)
            .iter()
            .map(|(error, _)| *error)
            .collect();
        assert!(
            errors.len() == 3 && rms(&errors) < 0.02,
            "{name}: {errors:?}"
        );
    }
}

/// Acceptance: with the sensors that these rovers have, at 8 to 50 Hz, every wheel's test finds
/// mu_max, within three stated deviations; their mean square is that of a good deviation, at most
/// 1.5. The stated way that the wheel slid, in both ramps and to a stop, is at most six radii.
#[test]
fn friction_tests_hold_with_the_sensors_of_each_rover() {
    for name in ROVERS {
        let radius = rover(name, &[]).robot.robot.geometry.wheel_radius;
        let mut squares = Vec::new();
        for (law, mu, seed) in [("adams", 0.8, 0), ("brush", 0.3, 41), ("rigid", 0.5, 42)] {
            let tests = friction_tests(name, law, mu, with_its_own_sensors(name, seed));
            let errors = friction_errors(&tests, mu);
            assert_eq!(errors.len(), 3, "{name} {law} {mu}: {tests:?}");
            for (error, deviations) in errors {
                assert!(
                    deviations.abs() < 3.0 && error.abs() < 0.3 * mu,
                    "{name} {law} {mu}: {tests:?}"
                );
                squares.push(deviations * deviations);
            }
            let slid = tests.iter().map(|test| test.slipped_distance);
            assert!(
                slid.fold(0.0, f64::max) < 6.0 * radius,
                "{name} {law} {mu}: {tests:?}"
            );
        }
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        assert!(mean < 1.5, "{name}: {squares:?}");
    }
}

/// Readings that hide the slip, at 8 Hz encoders of 30 counts a turn, end a test before the wheel runs away, and nothing
/// is claimed of mu_max but a lower bound that holds.
#[test]
fn readings_that_hide_slip_end_a_friction_test() {
    let mut keys = with_its_own_sensors("curiosity", 3);
    keys.extend(["sensors.encoder_counts=30", "record.rate=8"].map(str::to_owned));
    let tests = friction_tests("curiosity", "adams", 0.5, keys);
    assert_eq!(tests.len(), 3);
    for test in tests {
        let bound = test.mu - 2.0 * test.sigma;
        assert!(
            test.end == FrictionTestEnd::Noise && test.ramps == 0 && bound < 0.5,
            "{test:?}"
        );
    }
}

/// Acceptance: the stock rate of the Open Source Rover, 8 Hz, shows its friction. Of 18 tests the errors are within three
/// stated deviations, and at most a third above the measured 9.5 % in the mean.
#[test]
fn friction_is_found_at_eight_readings_a_second() {
    let mut squares = Vec::new();
    for (mu, seeds) in [(0.3, 3..6), (0.7, 6..9)] {
        for seed in seeds {
            let mut keys = with_its_own_sensors("open-source-rover", seed);
            keys.extend(["sensors.rate=8", "record.rate=8"].map(str::to_owned));
            for test in friction_tests("open-source-rover", "adams", mu, keys) {
                let error = test.mu - mu;
                assert!(test.end == FrictionTestEnd::Slipped, "{test:?}");
                assert!(error.abs() < 3.0 * test.sigma, "{test:?}");
                assert!(test.slipped_distance < 0.5, "{test:?}");
                squares.push(error * error / (mu * mu));
            }
        }
    }
    assert_eq!(squares.len(), 18);
    let mean = 100.0 * f64::sqrt(squares.iter().sum::<f64>() / 18.0);
    assert!(mean < 12.7, "{mean} %");
}

#[test]
#[ignore = "a study of some minutes"]
fn study_of_friction_tests() {
    println!(
        "| rover | sensors | mu_s | found | mean error | RMS | stated | largest | largest, sigma | beyond 3 sigma, % | slid, mm |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    type Keys = fn(&str, u64) -> Vec<String>;
    let sensors: [(&str, Keys, u64); 2] = [
        ("typical, 1 kHz", with_typical_sensors, 4),
        ("its own", with_its_own_sensors, 12),
    ];
    for name in ROVERS {
        for (label, keys, seeds) in sensors {
            for mu in [0.1, 0.2, 0.3, 0.5, 0.7, 0.9] {
                let (mut count, mut errors, mut stated, mut slid) = (0, Vec::new(), 0.0, 0.0_f64);
                for seed in 100..100 + seeds {
                    let law = ["adams", "brush", "rigid"][(seed % 3) as usize];
                    let tests = friction_tests(name, law, mu, keys(name, seed));
                    count += tests.len();
                    errors.extend(friction_errors(&tests, mu));
                    for test in tests.iter().filter(|test| test.ramps > 0) {
                        stated += test.sigma * test.sigma;
                        slid = slid.max(1e3 * test.slipped_distance);
                    }
                }
                let found = errors.len() as f64;
                let (plain, over): (Vec<f64>, Vec<f64>) = errors.into_iter().unzip();
                let largest =
                    |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                let beyond = over.iter().filter(|x| x.abs() > 3.0).count() as f64;
                println!(
                    "| `{name}` | {label} | {mu} | {found} of {count} | {:+.4} | {:.4} | {:.4} | {:.4} | {:.1} | {:.1} | {slid:.0} |",
                    plain.iter().sum::<f64>() / found,
                    rms(&plain),
                    (stated / found).sqrt(),
                    largest(&plain),
                    largest(&over),
                    100.0 * beyond / found,
                );
            }
        }
    }
}

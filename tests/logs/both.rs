//! Logs of both sides of a rover. The drive is of another simulator: `both/README.md`.
#![allow(clippy::float_cmp, reason = "the same bits")]

use super::recorded::{estimated, rewritten};
use crate::support::{assert_contains, columns, robhaz, root, summary, text};
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
use robhaz_scene::LogChoice;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Its errors as they were drawn; the robot is exact.
pub(super) const BUDGET: &str = "[budget]\nbody_cg = 0\nlink_masses = 0\ntorque_noise = 0.034\ntorque_offset = 0.034\n\
                      [record]\ncompare_from = 2.5\n";

pub(super) fn fixture(name: &str) -> PathBuf {
    root().join("tests/logs/both").join(name)
}

pub(super) fn robot() -> String {
    let path = root().join("robots/open-source-rover.toml");
    path.display().to_string()
}

/// A folder with the description.
pub(super) fn folder(description: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.toml"), description).unwrap();
    folder
}

/// `robhaz estimate` with the description and the robot: what it printed.
pub(super) fn estimate(folder: &Path, log: &Path, more: &[&str]) -> String {
    let (log, robot) = (log.display().to_string(), robot());
    let args = [log.as_str(), "--robot", &robot, "--sensors", "mine.toml"];
    estimated(folder, &[&args, more].concat())
}

/// The same into a folder as CSV, in place of an estimate that is there.
pub(super) fn estimate_into(out: &str, folder: &Path, log: &Path) -> String {
    estimate(folder, log, &["--format", "csv", "--out", out, "--force"])
}

/// The table of the estimate, by column.
pub(super) fn forces(folder: &Path, out: &str) -> HashMap<String, Vec<f64>> {
    columns(&folder.join(out).join("estimate-kalman.csv"))
}

/// The columns of N and T of all wheels.
pub(super) fn force_columns() -> Vec<String> {
    let of = |side| move |i| ["normal_force", "traction"].map(|q| format!("{side}_wheel{i}_{q}"));
    let sides = ["left", "right"].into_iter();
    sides.flat_map(|side| (1..=3).flat_map(of(side))).collect()
}

/// Largest difference of N and T of two tables, N.
pub(super) fn difference(a: &HashMap<String, Vec<f64>>, b: &HashMap<String, Vec<f64>>) -> f64 {
    let of_column = |name: String| {
        let pairs = a[&name].iter().zip(&b[&name]);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    force_columns()
        .into_iter()
        .map(of_column)
        .fold(0.0, f64::max)
}

/// `robhaz check` on the fixture: what it printed, and whether it found a fault.
pub(super) fn checked(folder: &Path, log: &Path) -> (bool, String) {
    let mut command = robhaz(folder);
    command.args(["check", "-v"]).arg(log);
    command.args(["--robot", &robot(), "--sensors", "mine.toml"]);
    let output = command.output().unwrap();
    (output.status.success(), text(&output.stdout))
}

/// The longer drive of the estimator's tests: bumps under the left side, 9 s at 50 Hz.
pub(super) fn drive() -> PathBuf {
    root().join("crates/estimator/tests/whole_rover/drive.csv")
}

/// Equivalence: the command's table is what the estimator says of the same readings, to the bit. Acceptance:
/// on uneven ground N is within two stated deviations in 90 %, errs by less than 3 % (2 % over the whole
/// drives of docs/whole-rover.md), and the terminal and the summary say the same.
#[test]
fn the_command_estimates_six_wheels() {
    let folder = folder(BUDGET);
    let truth = fixture("truth.csv").display().to_string();
    let more = ["--truth", &truth, "--format", "csv", "--out", "out"];
    let said = estimate(folder.path(), &fixture("readings.csv"), &more);
    let found = forces(folder.path(), "out");

    let log = columns(&fixture("readings.csv"));
    let described = LogChoice::default().described(
        Some(&folder.path().join("mine.toml")),
        Some(Path::new(&robot())),
    );
    let choice = described.unwrap().0;
    let rover = choice.robot.whole_rover().unwrap();
    let settings = EstimatorSettings {
        viscous_damping: choice.viscous_damping,
        gear_efficiency: choice.gear_efficiency,
        budget: choice.budget,
        ..EstimatorSettings::kalman_without_angles()
    };
    let mut estimator = WholeEstimator::new(&rover, settings, choice.pin).unwrap();
    for (row, time) in log["time"].iter().enumerate() {
        let one = |name: &str| Some(log[name][row]);
        let wheels = |part: &str| {
            core::array::from_fn(|i| {
                one(&format!(
                    "{}_wheel{}_{part}",
                    ["left", "right"][i / 3],
                    i % 3 + 1
                ))
            })
        };
        let estimate = estimator.update(&WholeFrame {
            time: *time,
            wheel_angle: wheels("angle"),
            motor_torque: wheels("motor_torque"),
            steering: [None; 6],
            pins: [one("left_pin_angle"), one("right_pin_angle")],
            coupling: one("differential_angle"),
            inclination: one("body_inclination"),
            roll: one("body_roll"),
            rates: [
                one("body_roll_rate"),
                one("body_rate"),
                one("body_yaw_rate"),
            ],
        });
        let estimate = estimate.unwrap();
        assert_eq!(found["tip_margin"][row], estimate.tip_margin, "{time}");
        assert_eq!(
            found["right_wheel3_normal_force"][row],
            estimate.normal_force[5]
        );
        assert_eq!(found["left_wheel1_traction"][row], estimate.traction[0]);
        let sigma = estimate.sigma_normal(1).unwrap();
        assert_eq!(found["left_wheel2_normal_force_sigma"][row], sigma);
        assert_eq!(found["body_roll"][row], estimate.attitude[1]);
    }

    let both = &summary(&folder.path().join("out"))["both"];
    for (errors, words) in [
        ("in_plane_normal_force", "in the wheels' planes"),
        ("normal_force", "along the ground's normal"),
    ] {
        let number = |key: &str| both[errors][key].as_f64().unwrap();
        let (nrmse, coverage) = (number("nrmse"), number("coverage"));
        assert!(nrmse < 0.03, "{errors}: {nrmse}");
        assert!(coverage > 0.9, "{errors}: {coverage}");
        let line = format!("N {words}: NRMSE {:.2} %", 100.0 * nrmse);
        assert_contains(&said, &line);
    }
    for name in ["kalman-left", "kalman-right"] {
        let means = &summary(&folder.path().join("out"))["estimators"][name]["means"];
        assert!(means["normal_force"][1].as_f64().unwrap() > 20.0, "{means}");
        assert_contains(&said, name);
        let figure = folder
            .path()
            .join(format!("out/figures/normal_force_{name}.svg"));
        let figure = std::fs::read_to_string(figure).unwrap();
        assert!(figure.contains("RMSE over the three wheels") && figure.contains("true"));
    }
}

/// Acceptance: with a noise of the torques that is not stated and pins that are noisier than stated, N is
/// what it is with the true budget within 0.3 N, 1 % of the mean load and less than what is stated; it says
/// which noise counts, and `check` calls the stated one a fault.
#[test]
fn noise_that_is_not_stated_is_that_of_the_log() {
    let stated = folder(BUDGET);
    let log = fixture("readings.csv");
    estimate_into("out", stated.path(), &log);
    let wanted = forces(stated.path(), "out");

    let description = BUDGET.replace("torque_noise = 0.034\n", "pin_noise = \"0.04 deg\"\n");
    let measured = folder(&description);
    let robot = robot();
    let log_name = log.display().to_string();
    let args = [
        "estimate",
        &log_name,
        "--robot",
        &robot,
        "--sensors",
        "mine.toml",
    ];
    let more = ["--format", "csv", "--out", "out"];
    let output = robhaz(measured.path()).args(args).args(more).output();
    let said = text(&output.unwrap().stderr);
    let line = "the noise of the pins' angles is 0.11 deg, measured; budget.pin_noise is 0.04 deg";
    assert_contains(&said, line);
    let apart = difference(&wanted, &forces(measured.path(), "out"));
    assert!(apart < 0.3, "{apart}");
    let (_, said) = checked(measured.path(), &log);
    assert_contains(&said, "white noise while driving");
}

/// A truth as fast as the log is compared with at every frame, whatever the stamps err by: interpolated, N errs as with
/// equal stamps, to a tenth. A slower one is compared with once a row, which is said.
#[test]
fn every_frame_has_its_truth() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let found = |log: &Path, truth: &Path| {
        let truth = truth.display().to_string();
        let said = estimate(path, log, &["--truth", &truth, "--out", "out", "--force"]);
        let summary = summary(&path.join("out"));
        let side = &summary["estimators"]["kalman-right"];
        let nrmse = summary["both"]["in_plane_normal_force"]["nrmse"].as_f64();
        (side["samples"].as_u64().unwrap(), nrmse.unwrap(), said)
    };
    let (log, truth) = (fixture("readings.csv"), fixture("truth.csv"));
    let (all, nrmse, _) = found(&log, &truth);
    // 50 Hz from 2.5 s on.
    assert_eq!(all, 175);
    // Up to 0.4 of a period, as of a driver that waits for a bus.
    let jittered = path.join("jittered.csv");
    rewritten(&log, &jittered, |row, cells| {
        let time: f64 = cells[0].parse().unwrap();
        let off = [0.0, 0.008, -0.008, -0.004, 0.006][row % 5];
        cells[0] = format!("{:?}", time + if row > 0 { off } else { 0.0 });
        true
    });
    let (count, error, _) = found(&jittered, &truth);
    assert!(count.abs_diff(all) <= 1, "{count} of {all}");
    assert!(error < 2.0 * nrmse, "{error} {nrmse}");
    let slow = path.join("slow.csv");
    rewritten(&truth, &slow, |row, _| row % 2 == 0);
    let (count, error, _) = found(&log, &slow);
    assert!(count.abs_diff(all / 2) <= 1, "{count}");
    assert!((error - nrmse).abs() < 0.1 * nrmse, "{error} {nrmse}");
    let mut command = robhaz(path);
    let (log, slow) = (log.display().to_string(), slow.display().to_string());
    command.args([
        "estimate",
        &log,
        "--robot",
        &robot(),
        "--sensors",
        "mine.toml",
    ]);
    command.args([
        "--truth", &slow, "--out", "out", "--force", "--rerun", "off",
    ]);
    let said = text(&command.output().unwrap().stderr);
    assert_contains(&said, "of the 175 frames that count");
}

/// The torques against the weight of the rover: in table and summary, and their ratio is 1 within three of its
/// deviations on a drive over bumps, whose length shows it to a tenth.
#[test]
fn the_weight_of_the_rover_is_compared_with_the_torques() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let said = estimate_into("out", path, &drive());
    let scale = summary(&path.join("out"))["both"]["torque_scale"].clone();
    let [ratio, sigma] = ["ratio", "sigma"].map(|key| scale[key].as_f64().unwrap());
    assert!((ratio - 1.0).abs() < 3.0 * sigma, "{scale}");
    assert_contains(&said, scale["words"].as_str().unwrap());
    let weight = &forces(path, "out")["weight"];
    let state = ["contradicts", "unconfirmed", "confirmed"];
    let last = state[(weight.last().unwrap() + 1.0) as usize];
    assert_eq!(scale["confirmation"], last);
}

/// What a log leaves open is no alarm: a steady turn does not show the sign of the roll, which is said below the table,
/// and not in the first line.
#[test]
fn what_a_log_leaves_open_is_said_below_the_table() {
    let folder = folder(BUDGET);
    let turn = root().join("crates/estimator/tests/whole_rover/turn.csv");
    let said = estimate(folder.path(), &turn, &["--out", "out"]);
    let open = "not confirmed by this log: sign of body_roll";
    let line = said.lines().position(|line| line.contains(open));
    let table = said.lines().position(|line| line.contains("kalman-right"));
    assert!(line > table && table.is_some(), "{said}");
    let unconfirmed = &summary(&folder.path().join("out"))["both"]["unconfirmed"];
    let is_stated = unconfirmed.as_array().is_some_and(|open| !open.is_empty());
    assert!(is_stated, "{unconfirmed}");
}

/// Fig. 6 of both sides has six wheels, each true and estimated.
#[test]
fn figure_6_shows_both_sides() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let truth = fixture("truth.csv").display().to_string();
    estimate(
        path,
        &fixture("readings.csv"),
        &["--truth", &truth, "--out", "out"],
    );
    let figure = std::fs::read_to_string(path.join("out/figures/fig6_forces.svg")).unwrap();
    for panel in [
        "kalman-left: Wheel 1 (front)",
        "kalman-right: Wheel 3 (rear)",
        "true",
    ] {
        assert!(figure.contains(panel), "{panel}");
    }
}

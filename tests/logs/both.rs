//! Logs of both sides of a rover. The drive is of another simulator: `both/README.md`.
#![allow(clippy::float_cmp, reason = "the same bits")]

use super::messages_and_clocks::exported_messages;
use super::recorded::{assert_same_files, estimated, refused, summary};
use crate::support::{columns, robhaz, root, text};
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
use robhaz_scene::LogChoice;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Its errors as they were drawn; the robot is exact.
const BUDGET: &str = "[budget]\nbody_cg = 0\nlink_masses = 0\ntorque_noise = 0.034\ntorque_offset = 0.034\n\
                      [record]\ncompare_from = 2.5\n";

fn fixture(name: &str) -> PathBuf {
    root().join("tests/logs/both").join(name)
}

fn robot() -> String {
    let path = root().join("robots/open-source-rover.toml");
    path.display().to_string()
}

/// A folder with the description.
fn folder(description: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.toml"), description).unwrap();
    folder
}

/// `robhaz estimate` with the description and the robot: what it printed.
fn estimate(folder: &Path, log: &Path, more: &[&str]) -> String {
    let (log, robot) = (log.display().to_string(), robot());
    let args = [log.as_str(), "--robot", &robot, "--sensors", "mine.toml"];
    estimated(folder, &[&args, more].concat())
}

/// The table of the estimate, by column.
fn forces(folder: &Path, out: &str) -> HashMap<String, Vec<f64>> {
    columns(&folder.join(out).join("estimate-kalman.csv"))
}

/// The columns of N and T of all wheels.
fn force_columns() -> Vec<String> {
    let of = |side| move |i| ["normal_force", "traction"].map(|q| format!("{side}_wheel{i}_{q}"));
    let sides = ["left", "right"].into_iter();
    sides.flat_map(|side| (1..=3).flat_map(of(side))).collect()
}

/// Largest difference of N and T of two tables, N.
fn difference(a: &HashMap<String, Vec<f64>>, b: &HashMap<String, Vec<f64>>) -> f64 {
    let of_column = |name: String| {
        let pairs = a[&name].iter().zip(&b[&name]);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    force_columns()
        .into_iter()
        .map(of_column)
        .fold(0.0, f64::max)
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
        assert!(said.contains(&line), "{said}");
    }
    for name in ["kalman-left", "kalman-right"] {
        let means = &summary(&folder.path().join("out"))["estimators"][name]["means"];
        assert!(means["normal_force"][1].as_f64().unwrap() > 20.0, "{means}");
        assert!(said.contains(name), "{said}");
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
    estimate(stated.path(), &log, &["--format", "csv", "--out", "out"]);
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
    assert!(said.contains(line), "{said}");
    let apart = difference(&wanted, &forces(measured.path(), "out"));
    assert!(apart < 0.3, "{apart}");
    let (_, said) = checked(measured.path(), &log);
    assert!(said.contains("white noise while driving"), "{said}");
}

/// Equivalence: columns of other names, units, signs and zeros give the same forces (1e-7 N: rounding of the
/// factors, by differences over time), and the folder of the estimate the same bits. Inclination and roll from the specific force, whose noise is
/// another one, change N by less than a tenth of the mean load, and by 1 % of it in the mean.
#[test]
fn names_units_and_sources_do_not_matter() {
    let folder = folder(BUDGET);
    let path = folder.path();
    estimate(
        path,
        &fixture("readings.csv"),
        &["--format", "csv", "--out", "plain"],
    );
    let plain = forces(path, "plain");

    estimated(path, &["plain", "--format", "csv", "--out", "again"]);
    assert_same_files(
        &path.join("plain"),
        &path.join("again"),
        &["estimate-kalman.csv"],
    );

    let log = columns(&fixture("readings.csv"));
    let mut description = format!("sides = \"both\"\n{BUDGET}[reading]\n");
    let mut names: Vec<&String> = log.keys().collect();
    names.sort();
    let is_mapped = |name: &&&String| **name != "time" && !name.starts_with("body_specific");
    let mapped: Vec<&String> = names.iter().filter(is_mapped).copied().collect();
    for (k, name) in mapped.iter().enumerate() {
        let unit = match name.as_str() {
            name if name.ends_with("torque") => "mN m",
            name if name.ends_with("rate") => "deg/s",
            _ => "deg",
        };
        writeln!(
            description,
            "{name} = {{ column = \"c{k}\", unit = \"{unit}\", sign = \"-\", offset = 0.01 }}"
        )
        .unwrap();
    }
    std::fs::write(path.join("mapped.toml"), description).unwrap();
    let mut table = "time".to_owned();
    (0..mapped.len()).for_each(|k| write!(table, ",c{k}").unwrap());
    for (row, time) in log["time"].iter().enumerate() {
        write!(table, "\n{time:?}").unwrap();
        for name in &mapped {
            let value = -(log[*name][row] + 0.01);
            let column = if name.ends_with("torque") {
                1e3 * value
            } else {
                value.to_degrees()
            };
            write!(table, ",{column:?}").unwrap();
        }
    }
    std::fs::write(path.join("mapped.csv"), table + "\n").unwrap();
    let args = [
        "mapped.csv",
        "--robot",
        &robot(),
        "--sensors",
        "mapped.toml",
    ];
    estimated(
        path,
        &[&args[..], &["--format", "csv", "--out", "mapped"]].concat(),
    );
    let found = forces(path, "mapped");
    assert!(
        difference(&plain, &found) < 1e-7,
        "{}",
        difference(&plain, &found)
    );

    let readings = std::fs::read_to_string(fixture("readings.csv")).unwrap();
    let without = readings
        .replace("body_inclination", "other")
        .replace("body_roll,", "another,");
    std::fs::write(path.join("force.csv"), without).unwrap();
    estimate(
        path,
        &path.join("force.csv"),
        &["--format", "csv", "--out", "force"],
    );
    let found = forces(path, "force");
    assert!(
        difference(&plain, &found) < 2.0,
        "{}",
        difference(&plain, &found)
    );
    for name in force_columns() {
        let mean = |of: &HashMap<String, Vec<f64>>| of[&name].iter().sum::<f64>() / 300.0;
        assert!((mean(&plain) - mean(&found)).abs() < 0.2, "{name}");
    }
}

/// Equivalence: an estimate of both sides as MCAP gives the same bits, with the robot in the file. From its
/// `JointState` and the `Imu` of the body alone, as a rover of ROS 2 records them, N and T differ by less than
/// 1e-7 N: whole nanoseconds and quaternions, by differences over time. `check` says the same of each.
#[test]
fn messages_of_both_sides_give_the_same_table() {
    let folder = folder(BUDGET);
    let path = folder.path();
    estimate(
        path,
        &fixture("readings.csv"),
        &["--format", "csv", "--out", "run"],
    );
    exported_messages(path);
    estimated(
        path,
        &["described.mcap", "--format", "csv", "--out", "again"],
    );
    assert_same_files(
        &path.join("run"),
        &path.join("again"),
        &["estimate-kalman.csv"],
    );

    let mut description = format!(
        "sides = \"both\"\n{BUDGET}[[channel]]\nname = \"joints\"\ntopic = \"/joint_states\"\n\
         [[channel]]\nname = \"imu\"\ntopic = \"/imu/body\"\n\
         [imu.body]\nchannel = \"imu\"\ninclination = \"orientation\"\n[reading]\n"
    );
    for side in ["left", "right"] {
        for (reading, column) in [("angle", "position"), ("motor_torque", "effort")] {
            for i in 1..=3 {
                let wheel = format!("{side}_wheel{i}");
                writeln!(
                    description,
                    "{wheel}_{reading}.column = \"{wheel}.{column}\""
                )
                .unwrap();
            }
        }
        writeln!(
            description,
            "{side}_pin_angle.column = \"{side}_pin.position\""
        )
        .unwrap();
    }
    description += "differential_angle.column = \"differential.position\"\n";
    std::fs::write(path.join("ros.toml"), description).unwrap();
    let of_ros = ["run.mcap", "--robot", &robot(), "--sensors", "ros.toml"];
    estimated(
        path,
        &[&of_ros[..], &["--format", "csv", "--out", "ros"]].concat(),
    );
    let apart = difference(&forces(path, "run"), &forces(path, "ros"));
    assert!(apart < 1e-7, "{apart}");

    // Verdict and test of each line; figures may differ in their last digit, and each channel has a rate.
    let findings = |said: String| -> Vec<String> {
        let verdicts = ["ok", "FAULT", "cannot tell"];
        let is_finding = |line: &&str| verdicts.iter().any(|verdict| line.starts_with(verdict));
        let start = |line: &str| line.chars().take(40).collect();
        let lines = said.lines().filter(is_finding).map(start);
        lines
            .filter(|line: &String| !line.contains(" rate "))
            .collect()
    };
    let mut check = robhaz(path);
    let output = check.arg("check").args(of_ros).output().unwrap();
    let [csv, ros] = [
        checked(path, &fixture("readings.csv")).1,
        text(&output.stdout),
    ]
    .map(findings);
    assert!(csv.len() > 10, "{csv:?}");
    assert_eq!(csv, ros);
}

/// A log that is not of both sides, or a robot that is not: the error says what is missing and what is allowed.
#[test]
fn what_is_missing_is_named() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let log = fixture("readings.csv").display().to_string();
    let readings = std::fs::read_to_string(&log).unwrap();
    std::fs::write(
        path.join("lacks.csv"),
        readings.replace("body_yaw_rate", "yaw"),
    )
    .unwrap();
    let whole = std::fs::read_to_string(robot()).unwrap();
    let across = whole.find("[robot.across]").unwrap();
    let end = whole.find("[drive]").unwrap();
    let without = format!("{}{}", &whole[..across], &whole[end..]);
    std::fs::write(path.join("side.toml"), without).unwrap();
    std::fs::write(path.join("one.toml"), "sides = \"one of two\"\n").unwrap();
    let robot = robot();
    let cases: [(&[&str], &[&str]); 5] = [
        (
            &["lacks.csv", "--robot", &robot],
            &["has no column body_yaw_rate", "docs/logs.md"],
        ),
        (
            &[&log],
            &["the robot A is a four-bar", "suspension.kind = \"bogie\""],
        ),
        (
            &[&log, "--robot", "side.toml"],
            &["has no [robot.across]", "docs/scenes.md#across"],
        ),
        (
            &[&log, "--robot", &robot, "--sensors", "one.toml"],
            &["has no column wheel1_angle", "state sides = \"both\""],
        ),
        (
            &[&log, "--robot", &robot, "--estimator", "paper-body"],
            &["found paper-body", "--estimator kalman"],
        ),
    ];
    for (args, expected) in cases {
        let said = refused(path, args);
        for part in expected {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
}

/// `robhaz check` on the fixture: what it printed, and whether it found a fault.
fn checked(folder: &Path, log: &Path) -> (bool, String) {
    let mut command = robhaz(folder);
    command.arg("check").arg(log);
    command.args(["--robot", &robot(), "--sensors", "mine.toml"]);
    let output = command.output().unwrap();
    (output.status.success(), text(&output.stdout))
}

/// A correct log has no fault in the tests of both sides; with left and right pins, a wheel, or roll and pitch exchanged,
/// the signs of roll or differential turned, the zero of a joint 4.6 deg off, or one without a value or always 0, the test that is meant for it
/// finds it, and no other.
#[test]
fn check_finds_what_is_exchanged() {
    let folder = folder(BUDGET);
    let (path, right) = (
        folder.path(),
        std::fs::read_to_string(fixture("readings.csv")).unwrap(),
    );
    let (_, said) = checked(path, &fixture("readings.csv"));
    for test in [
        "roll and",
        "yaw and",
        "left and right",
        "torques of the sides",
        "zero over the way",
    ] {
        let is_fault = |line: &&str| line.starts_with("FAULT") && line.contains(test);
        assert_eq!(said.lines().find(is_fault), None, "{said}");
    }
    let exchanged = |a: &str, b: &str| right.replace(a, "kept").replace(b, a).replace("kept", b);
    // Readings with another value in these columns.
    let changed = |names: &[&str], change: fn(f64) -> f64| {
        let header: Vec<&str> = right.lines().next().unwrap().split(',').collect();
        let cell = |(name, cell): (&&str, &str)| match names.contains(name) {
            true => format!("{:?}", change(cell.parse().unwrap())),
            false => cell.to_owned(),
        };
        let row = |row: &str| -> String {
            let cells = header.iter().zip(row.split(',')).map(cell);
            cells.collect::<Vec<_>>().join(",") + "\n"
        };
        let rows: String = right.lines().skip(1).map(row).collect();
        format!("{}\n{rows}", header.join(","))
    };
    let turned = |names: &[&str]| changed(names, |x| -x);
    let of_axes = exchanged("body_roll_rate", "body_rate");
    let of_axes = of_axes.replace("body_roll,", "kept,");
    let of_axes = of_axes.replace("body_inclination,", "body_roll,");
    let cases = [
        (
            exchanged("left_pin", "right_pin"),
            "left_pin_angle and right_pin_angle",
        ),
        (
            exchanged("left_wheel2", "right_wheel2"),
            "left_wheel2_angle and right_wheel2_angle",
        ),
        (
            turned(&["body_roll", "body_roll_rate"]),
            "turn the signs of body_roll and body_roll_rate",
        ),
        (
            turned(&["differential_angle"]),
            "turn the sign of differential_angle",
        ),
        (
            changed(&["differential_angle"], |x| x + 0.08),
            "rad from differential_angle",
        ),
        (
            changed(&["right_pin_angle"], |x| x - 0.08),
            "rad from right_pin_angle",
        ),
        (
            of_axes.replace("kept,", "body_inclination,"),
            "exchange the columns of body_inclination and body_roll, and of body_rate and body_roll_rate",
        ),
        (changed(&["differential_angle"], |_| 0.0), "dead from"),
        (
            changed(&["differential_angle"], |_| f64::NAN),
            "differential_angle has no value in",
        ),
    ];
    for (log, expected) in cases {
        std::fs::write(path.join("wrong.csv"), log).unwrap();
        let (is_right, said) = checked(path, &path.join("wrong.csv"));
        assert!(!is_right && said.contains(expected), "{expected}: {said}");
        // A fault that follows from the one that was found is none.
        let faults = said.lines().filter(|line| line.starts_with("FAULT"));
        assert_eq!(faults.count(), 1, "{expected}: {said}");
    }
}

/// The rows of a table, changed by `change` (row, cells), below its header.
fn rewritten(table: &Path, out: &Path, change: impl Fn(usize, &mut Vec<String>) -> bool) {
    let text = std::fs::read_to_string(table).unwrap();
    let mut lines = text.lines();
    let mut kept = lines.next().unwrap().to_owned() + "\n";
    for (row, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if change(row, &mut cells) {
            kept += &(cells.join(",") + "\n");
        }
    }
    std::fs::write(out, kept).unwrap();
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
    assert!(said.contains("of the 175 frames that count"), "{said}");
}

/// The longer drive of the estimator's tests: bumps under the left side, 9 s at 50 Hz.
fn drive() -> PathBuf {
    root().join("crates/estimator/tests/whole_rover/drive.csv")
}

/// An estimate says in its first lines that exchanged sides and wrong signs contradict each other, and nothing of
/// correct readings; summary and terminal say the same.
#[test]
fn an_estimate_says_that_readings_contradict_each_other() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let first = |log: &Path| {
        let said = estimate(path, log, &["--out", "out", "--force"]);
        let first = said.lines().next().unwrap().to_owned();
        let told = &summary(&path.join("out"))["both"]["contradictions"];
        let is_told = told.as_array().is_some_and(|all| !all.is_empty());
        assert_eq!(
            is_told,
            first.contains("READINGS CONTRADICT EACH OTHER"),
            "{first}"
        );
        (is_told, first)
    };
    for right in [fixture("readings.csv"), drive()] {
        let (is_told, said) = first(&right);
        assert!(!is_told, "{said}");
    }
    let drive = std::fs::read_to_string(drive()).unwrap();
    let exchanged = |a: &str, b: &str| drive.replace(a, "kept").replace(b, a).replace("kept", b);
    let wrong = path.join("wrong.csv");
    for (log, expected) in [
        (
            exchanged("left_pin_angle", "right_pin_angle"),
            "exchanged, or a sign turned",
        ),
        (
            exchanged(",left_wheel", ",right_wheel"),
            "exchanged, or a sign turned",
        ),
    ] {
        std::fs::write(&wrong, log).unwrap();
        let (is_told, said) = first(&wrong);
        assert!(is_told && said.contains(expected), "{expected}: {said}");
        assert!(said.contains("`robhaz check`"), "{said}");
    }
    // Motors that are mounted mirror-wise: the right wheels count backwards.
    let right = fixture("readings.csv");
    let text = std::fs::read_to_string(&right).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    rewritten(&right, &wrong, |_, cells| {
        let is_right = |(name, _): &(&&str, &mut String)| name.starts_with("right_wheel");
        for (_, cell) in header.iter().zip(cells).filter(is_right) {
            let value: f64 = cell.parse().unwrap();
            *cell = format!("{:?}", -value);
        }
        true
    });
    let (is_told, said) = first(&wrong);
    assert!(
        is_told && said.contains("turn against each other"),
        "{said}"
    );
}

/// The torques against the weight of the rover: in table and summary, and their ratio is 1 within three of its
/// deviations on a drive over bumps, whose length shows it to a tenth.
#[test]
fn the_weight_of_the_rover_is_compared_with_the_torques() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let said = estimate(path, &drive(), &["--format", "csv", "--out", "out"]);
    let scale = summary(&path.join("out"))["both"]["torque_scale"].clone();
    let [ratio, sigma] = ["ratio", "sigma"].map(|key| scale[key].as_f64().unwrap());
    assert!((ratio - 1.0).abs() < 3.0 * sigma, "{scale}");
    assert!(said.contains(scale["words"].as_str().unwrap()), "{said}");
    let weight = &forces(path, "out")["weight"];
    let state = ["contradicts", "unconfirmed", "confirmed"];
    let last = state[(weight.last().unwrap() + 1.0) as usize];
    assert_eq!(scale["confirmation"], last);
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

/// A log with columns of steering that are empty, as of a rover whose wheels do not steer: an estimate, exported to
/// either format, reads back to the same bits.
#[test]
fn empty_steering_can_be_exported() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let readings = std::fs::read_to_string(fixture("readings.csv")).unwrap();
    let mut lines = readings.lines();
    let mut text = format!(
        "{},left_wheel1_steering,right_wheel3_steering\n",
        lines.next().unwrap()
    );
    lines.for_each(|line| text += &format!("{line},,\n"));
    std::fs::write(path.join("log.csv"), text).unwrap();
    estimate(
        path,
        &path.join("log.csv"),
        &["--format", "csv", "--out", "run"],
    );
    for format in ["mcap", "csv"] {
        let mut export = robhaz(path);
        export.args(["export", "run", "--to", format, "--force"]);
        assert!(export.status().unwrap().success(), "{format}");
        let exported = path.join(format!("run.{format}"));
        estimate(
            path,
            &exported,
            &["--format", "csv", "--out", "again", "--force"],
        );
        assert_same_files(
            &path.join("run"),
            &path.join("again"),
            &["estimate-kalman.csv"],
        );
    }
}

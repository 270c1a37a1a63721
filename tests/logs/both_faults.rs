//! Logs of both sides with faults, and what `check` and `estimate` say of them.

use super::both::{
    BUDGET, checked, difference, drive, estimate, estimate_into, fixture, folder, forces, robot,
};
use super::recorded::{changed, refused, rewritten};
use crate::support::{assert_contains, robhaz, summary, text};
use std::f64::consts::PI;
use std::path::Path;

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
        let (log, out) = (fixture("readings.csv"), path.join("changed.csv"));
        changed(&log, &out, |name| names.contains(&name), |_, x| change(x));
        std::fs::read_to_string(out).unwrap()
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
            "(rad) to offset of differential_angle",
        ),
        (
            changed(&["right_pin_angle"], |x| x - 0.08),
            "(rad) to offset of right_pin_angle",
        ),
        (
            of_axes.replace("kept,", "body_inclination,"),
            "exchange the columns of body_inclination and body_roll, and of body_rate and body_roll_rate",
        ),
        (
            changed(&["differential_angle"], |_| 0.0),
            "differential_angle is 0 in all of",
        ),
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

/// An inclination of the acceleration alone that is stated to measure gravity fits an exchange of the body's axes as well,
/// whose acceleration is lost, too: what is stated is named first.
#[test]
fn check_names_what_an_inclination_measures() {
    let budget = BUDGET.replace("[record]", "inclination_measures = \"gravity\"\n[record]");
    let folder = folder(&budget);
    let (_, said) = checked(folder.path(), &fixture("readings.csv"));
    let mut faults = said.lines().skip_while(|line| !line.starts_with("FAULT"));
    let (fault, remedy) = (faults.next().unwrap(), faults.next().unwrap());
    assert!(fault.contains("left and right"), "{said}");
    let words = "state budget.inclination_measures = \"specific-force\"";
    assert!(remedy.contains(words), "{said}");
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
        let contradictions = &summary(&path.join("out"))["both"]["contradictions"];
        let is_stated = contradictions.as_array().is_some_and(|all| !all.is_empty());
        assert_eq!(
            is_stated,
            first.contains("READINGS CONTRADICT EACH OTHER"),
            "{first}"
        );
        (is_stated, first)
    };
    for right in [fixture("readings.csv"), drive()] {
        let (is_stated, said) = first(&right);
        assert!(!is_stated, "{said}");
    }
    let drive = std::fs::read_to_string(drive()).unwrap();
    let exchanged = |a: &str, b: &str| drive.replace(a, "kept").replace(b, a).replace("kept", b);
    let wrong = path.join("wrong.csv");
    for (log, expected) in [
        (
            exchanged("left_pin_angle", "right_pin_angle"),
            "exchange the columns of left_pin_angle and right_pin_angle",
        ),
        (
            exchanged(",left_wheel", ",right_wheel"),
            "exchange the columns of left_wheel1_angle and right_wheel1_angle",
        ),
    ] {
        std::fs::write(&wrong, log).unwrap();
        let (is_stated, said) = first(&wrong);
        assert!(is_stated && said.contains(expected), "{expected}: {said}");
        assert_contains(&said, "`robhaz check`");
    }
    // Motors that are mounted mirror-wise: the right wheels count backwards.
    let right = fixture("readings.csv");
    let is_right = |name: &str| name.starts_with("right_wheel");
    changed(&right, &wrong, is_right, |_, x| -x);
    let (is_stated, said) = first(&wrong);
    assert!(
        is_stated && said.contains("turn against each other"),
        "{said}"
    );
}

/// No reading shows a zero of the roll: at rest it looks like a cross slope, which is said before the forces.
#[test]
fn a_roll_at_rest_is_said() {
    let folder = folder(BUDGET);
    let readings = fixture("readings.csv");
    let wrong = folder.path().join("tilted.csv");
    let tilted = |_: usize, roll: f64| roll + 5_f64.to_radians();
    changed(&readings, &wrong, |name| name == "body_roll", tilted);
    for (log, is_said) in [(&readings, false), (&wrong, true)] {
        let mut command = robhaz(folder.path());
        command.arg("estimate").arg(log).args(["--rerun", "off"]);
        command.args(["--robot", &robot(), "--sensors", "mine.toml", "--force"]);
        let said = text(&command.output().unwrap().stderr);
        assert_eq!(
            said.contains("at rest body_roll shows 5."),
            is_said,
            "{said}"
        );
    }
}

/// A side that comes later than the other one, and a drive that comes later than the others of its side, are
/// named with their delay: wheels that roll start and stop together.
#[test]
fn readings_of_a_slower_bus_are_named() {
    let folder = folder(BUDGET);
    let readings = drive();
    let table = std::fs::read_to_string(&readings).unwrap();
    let mut rows = table.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let rows: Vec<_> = rows.collect();
    let late = folder.path().join("late.csv");
    for (prefix, channel) in [
        ("right_", "wheels of right after those of left"),
        ("left_wheel2", "left: encoder 2 after the others"),
    ] {
        for (samples, is_late) in [(0_usize, false), (5, true)] {
            rewritten(&readings, &late, |row, cells| {
                let before = &rows[row.saturating_sub(samples)];
                for ((name, cell), before) in header.iter().zip(cells).zip(before) {
                    if name.starts_with(prefix) {
                        *cell = (*before).to_owned();
                    }
                }
                true
            });
            let (is_right, said) = checked(folder.path(), &late);
            assert_eq!(is_right, !is_late, "{prefix}: {said}");
            let mut faults = said.lines().filter(|line| line.starts_with("FAULT"));
            assert_eq!(faults.any(|line| line.contains(channel)), is_late, "{said}");
            // 100 ms, between samples to 20.
            let near = ["offset = -0.09", "offset = -0.10", "offset = -0.11"];
            assert!(
                !is_late || near.iter().any(|near| said.contains(near)),
                "{said}"
            );
        }
    }
}

/// The rate of the roll hangs from 4 s on, while the other numbers of the sensor change: it is no reading, and the forces are
/// those of the log without it within 0.6 N, 2 % of the mean load (read, it moves N by 2 N).
#[test]
fn one_number_of_a_sensor_that_hangs_is_no_reading() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let wrong = path.join("wrong.csv");
    let text = std::fs::read_to_string(drive()).unwrap();
    let of_row = |row: usize| text.lines().nth(row).unwrap().split(',');
    let place = of_row(0).position(|name| name == "body_roll_rate").unwrap();
    let held: f64 = of_row(201).nth(place).unwrap().parse().unwrap();
    let hangs = |row, x| if row < 200 { x } else { held };
    changed(&drive(), &wrong, |name| name == "body_roll_rate", hangs);
    let found = |log: &Path| {
        estimate_into("out", path, log);
        forces(path, "out")
    };
    let apart = difference(&found(&drive()), &found(&wrong));
    assert!(apart < 0.6, "{apart}");
}

/// A sensor that hangs upside down, one that is turned by half a turn, and torques in amperes of a motor with 0.4 N m
/// for each: `estimate` says so in its first line, or has no force where a reading is never within its limits, and `check`
/// says what to state. One with an angle or a rate that never changes is
/// named, and nothing else.
#[test]
fn what_no_rover_can_do_is_said_first() {
    let folder = folder(BUDGET);
    let path = folder.path();
    let (log, wrong) = (fixture("readings.csv"), path.join("wrong.csv"));
    type Change = fn(usize, f64) -> f64;
    let cases: [(&[&str], Change, &str, &str); 3] = [
        (
            &["body_roll"],
            |_, x| x + if x > 0.0 { -PI } else { PI },
            "body_roll: up to 3.1",
            "state up = \"-z\" of imu.body",
        ),
        (
            &[
                "body_roll",
                "body_roll_rate",
                "body_inclination",
                "body_rate",
            ],
            |_, x| -x,
            "the acceleration of the wheels the other way round",
            "state forward = \"-x\" of imu.body",
        ),
        (
            &["motor_torque"],
            |_, x| 0.4 * x,
            "of what the inertias of the robot ask for",
            "torque_constant",
        ),
    ];
    let all = |name: &str| name.ends_with("motor_torque");
    changed(&log, &wrong, all, |_, x| 1000.0 * x);
    let (_, said) = checked(path, &wrong);
    assert_contains(&said, "range of torques");
    assert_contains(&said, "torque_constant");
    for (names, change, said_first, remedy) in cases {
        let is = |name: &str| {
            names.contains(&name) || names == ["motor_torque"] && name.ends_with(names[0])
        };
        changed(&log, &wrong, is, change);
        if names == ["body_roll"] {
            let (log, robot) = (wrong.to_str().unwrap(), robot());
            let said = refused(path, &[log, "--robot", &robot, "--sensors", "mine.toml"]);
            assert_contains(&said, said_first);
        } else {
            let said = estimate(path, &wrong, &["--out", "out", "--force"]);
            let first = said.lines().next().unwrap();
            let says = first.contains("CONTRADICT") && first.contains(said_first);
            assert!(says, "{said}");
        }
        let (is_right, said) = checked(path, &wrong);
        assert!(!is_right && said.contains(remedy), "{remedy}: {said}");
    }
    for name in [
        "body_inclination",
        "body_rate",
        "body_roll",
        "left_pin_angle",
    ] {
        let dead: [(Change, &str); 2] = [
            (|_, _| 0.0, "is 0 in all of"),
            (|row, x| if row < 100 { x } else { 0.0123 }, "dead from"),
        ];
        for (change, expected) in dead {
            changed(&log, &wrong, |of| of == name, change);
            let (_, said) = checked(path, &wrong);
            let faults: Vec<_> = said.lines().filter(|l| l.starts_with("FAULT")).collect();
            assert!(
                faults.len() == 1 && faults[0].contains(name),
                "{name}: {said}"
            );
            assert!(said.contains(expected), "{expected}: {said}");
            let said = estimate(path, &wrong, &["--out", "out", "--force"]);
            let first = said.lines().next().unwrap();
            assert!(
                first.contains("CONTRADICT") && first.contains(name),
                "{said}"
            );
        }
    }
}

/// Encoders in degrees on both sides are the cause, and neither zeros of pins over a way that is none nor the roll on it
/// is a fault.
#[test]
fn encoders_in_degrees_are_the_only_cause() {
    let folder = folder(BUDGET);
    let (path, wrong) = (folder.path(), folder.path().join("wrong.csv"));
    let is_encoder = |name: &str| name.contains("wheel") && name.ends_with("_angle");
    changed(&fixture("readings.csv"), &wrong, is_encoder, |_, x| {
        x.to_degrees()
    });
    let (is_right, said) = checked(path, &wrong);
    let faults: Vec<&str> = said.lines().filter(|l| l.starts_with("FAULT")).collect();
    let is_cause =
        |line: &&str| line.contains("acceleration") || line.contains("encoders, torques");
    assert!(!is_right && faults.iter().all(is_cause), "{said}");
    assert_contains(&said, "in their units");
}

/// Parts of a correct drive, from its start, and in motion, have no fault.
#[test]
fn a_short_log_has_no_fault() {
    let folder = folder(BUDGET);
    let part = folder.path().join("part.csv");
    for (from, to) in [
        (0, 80),
        (0, 125),
        (150, 200),
        (150, 250),
        (150, 300),
        (250, 400),
    ] {
        rewritten(&drive(), &part, |row, _| (from..to).contains(&row));
        let (is_right, said) = checked(folder.path(), &part);
        assert!(is_right, "{from} to {to}: {said}");
    }
}

/// Readings between which the wheels turn by more than the filters know of have the excuse of one side up to a mean NIS that
/// no honest log has: an inclination with four times its noise. With eight times its noise they contradict each other.
#[test]
fn readings_far_apart_may_contradict_each_other() {
    let folder = folder(BUDGET);
    let right = fixture("readings.csv");
    let wrong = folder.path().join("wrong.csv");
    for (noise, expected) in [
        (0.4_f64, "readings may contradict each other"),
        (0.8, "READINGS CONTRADICT EACH OTHER"),
    ] {
        let noisy = |row: usize, x| x + (2.4 * row as f64).sin().signum() * noise.to_radians();
        changed(&right, &wrong, |name| name == "body_inclination", noisy);
        let said = estimate(folder.path(), &wrong, &["--out", "out", "--force"]);
        assert!(said.contains(expected), "{noise}: {said}");
    }
}

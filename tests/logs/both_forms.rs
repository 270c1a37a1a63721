//! Logs of both sides in other forms: other names, units and sources, messages, without steering.

use super::both::{
    BUDGET, checked, difference, estimate_into, fixture, folder, force_columns, forces, robot,
};
use super::messages_and_clocks::exported_messages;
use super::recorded::{assert_same_files, estimated};
use crate::support::{columns, robhaz, root, text};
use robhaz_scene::LogChoice;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Equivalence: columns of other names, units, signs and zeros give the same forces (1e-7 N: rounding of the
/// factors, by differences over time), and the folder of the estimate the same bits. Inclination and roll from the specific force, whose noise is
/// another one, change N by less than a tenth of the mean load, and by 1 % of it in the mean.
#[test]
fn names_units_and_sources_do_not_matter() {
    let folder = folder(BUDGET);
    let path = folder.path();
    estimate_into("plain", path, &fixture("readings.csv"));
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
    let apart = difference(&plain, &found);
    assert!(apart < 1e-7, "{apart}");

    let readings = std::fs::read_to_string(fixture("readings.csv")).unwrap();
    let without = readings
        .replace("body_inclination", "other")
        .replace("body_roll,", "another,");
    std::fs::write(path.join("force.csv"), without).unwrap();
    estimate_into("force", path, &path.join("force.csv"));
    let found = forces(path, "force");
    let apart = difference(&plain, &found);
    assert!(apart < 2.0, "{apart}");
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
    estimate_into("run", path, &fixture("readings.csv"));
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

    // The force of the ground on a wheel: T, what `axial_share` of N pushes to the left, N.
    let table = forces(path, "run");
    let bytes = std::fs::read(path.join("run.mcap")).unwrap();
    let mut wrenches = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = &message.channel.topic;
        let Some(wheel) = topic.strip_prefix("/robhaz/wrench/kalman/") else {
            continue;
        };
        // The last six numbers: force, and no moment.
        let numbers = message.data[message.data.len() - 48..].chunks_exact(8);
        let numbers = numbers.map(|x| f64::from_le_bytes(x.try_into().unwrap()));
        let force: Vec<f64> = numbers.take(3).collect();
        let of = |name: &str| table[&format!("{wheel}_{name}")].iter();
        let (normal, traction) = (of("normal_force"), of("traction"));
        let rows = normal.zip(traction).zip(&table["axial_share"]);
        let mut rows = rows.map(|((n, t), share)| [*t, share * n, *n]);
        assert!(rows.any(|row| row[..] == force[..]), "{wheel}: {force:?}");
        assert!(force[1] != 0.0, "{wheel}: {force:?}");
        wrenches += 1;
    }
    assert!(wrenches > 1000, "{wrenches}");

    // The columns of the example, with the joints' names and signs of the exported file.
    let example = root().join("examples/logs/rover-ros2.toml");
    LogChoice::load(&example, LogChoice::default()).unwrap();
    let example = std::fs::read_to_string(example).unwrap();
    let columns = example.find("[[channel]]").unwrap();
    let mut description = example[columns..].replace(", sign = \"-\"", "");
    for (name, exported) in [
        ("fl", "left_wheel1"),
        ("ml", "left_wheel2"),
        ("rl", "left_wheel3"),
        ("fr", "right_wheel1"),
        ("mr", "right_wheel2"),
        ("rr", "right_wheel3"),
    ] {
        description = description.replace(&format!("wheel_{name}."), &format!("{exported}."));
    }
    for side in ["left", "right"] {
        description = description.replace(&format!("bogie_{side}."), &format!("{side}_pin."));
    }
    let mapped = description
        .lines()
        .filter(|line| !line.contains("_steering"));
    let mapped = mapped.map(|line| format!("{line}\n"));
    let description = BUDGET.to_owned() + &mapped.collect::<String>();
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
    let output = check.args(["check", "-v"]).args(of_ros).output().unwrap();
    let [csv, ros] = [
        checked(path, &fixture("readings.csv")).1,
        text(&output.stdout),
    ]
    .map(findings);
    assert!(csv.len() > 10, "{csv:?}");
    assert_eq!(csv, ros);
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
    estimate_into("run", path, &path.join("log.csv"));
    for format in ["mcap", "csv"] {
        let mut export = robhaz(path);
        export.args(["export", "run", "--to", format, "--force"]);
        assert!(export.status().unwrap().success(), "{format}");
        let exported = path.join(format!("run.{format}"));
        estimate_into("again", path, &exported);
        assert_same_files(
            &path.join("run"),
            &path.join("again"),
            &["estimate-kalman.csv"],
        );
    }
}

//! Clocks of recorded logs: `robhaz check` names their faults first of all, and `robhaz estimate`
//! survives them.

use crate::support::{assert_contains, columns, refused, robhaz, succeeded, text, with_run, words};
use std::fs;
use std::path::Path;

/// A folder, and the table `sensors` of eight seconds of `smooth`, as lines.
fn recorded() -> (tempfile::TempDir, Vec<String>) {
    let sets = ["sensors.grade=typical", "record.duration=8"];
    let dir = with_run(&["--format", "csv", "--set", sets[0], "--set", sets[1]]);
    let table = fs::read_to_string(dir.path().join("run/sensors.csv")).unwrap();
    let lines = table.lines().map(str::to_owned).collect();
    (dir, lines)
}

/// Writes the lines as a log, each with a changed time, s.
fn write(folder: &Path, lines: &[String], clock: impl Fn(f64) -> f64) {
    let mut log = lines[0].clone() + "\n";
    for line in &lines[1..] {
        let (time, rest) = line.split_once(',').unwrap();
        log += &format!("{},{rest}\n", clock(time.parse().unwrap()));
    }
    fs::write(folder.join("log.csv"), log).unwrap();
}

/// The findings of `robhaz check`, as lines.
fn checked(folder: &Path) -> Vec<String> {
    let output = robhaz(folder)
        .args(["check", "-v", "log.csv"])
        .output()
        .unwrap();
    text(&output.stdout).lines().map(str::to_owned).collect()
}

/// The line of a fault of a test. Faults of the time stamps come before all others.
fn fault<'a>(lines: &'a [String], test: &str) -> &'a str {
    let of_test = |line: &&String| {
        let mut words = line.split_whitespace();
        words.next() == Some("FAULT") && words.next() == Some(test)
    };
    lines
        .iter()
        .find(of_test)
        .unwrap_or_else(|| panic!("{test}: {lines:#?}"))
}

/// A clock that is set back by 0.2 s: `check` names it before all else; `kalman` states no force
/// beyond five times the weight, 687 N, and starts anew once, with the flag.
#[test]
fn a_clock_that_is_set_back_is_named_and_survived() {
    let (dir, lines) = recorded();
    let folder = dir.path();
    write(folder, &lines, |t| if t > 5.0 { t - 0.2 } else { t });
    let said = checked(folder);
    assert_contains(&said[0], "8001 rows at 1000 Hz");
    let clock = fault(&said, "clock");
    assert_contains(clock, "set back by 0.200 s at 5.000 s");
    let first = said.iter().find(|line| line.starts_with("FAULT"));
    assert_eq!(first.map(String::as_str), Some(clock));

    let mut command = robhaz(folder);
    command.args(words("estimate log.csv --estimator kalman --rerun off"));
    let output = succeeded(command.args(["--format", "csv", "--out", "out"]));
    assert!(text(&output.stdout).contains("set back by 0.200 s"));
    let estimate = columns(&folder.join("out/estimate-kalman.csv"));
    for wheel in 1..=3 {
        let forces = &estimate[&format!("wheel{wheel}_normal_force")];
        let largest = forces.iter().fold(0.0_f64, |a, b| a.max(*b));
        assert!(largest < 687.0, "wheel {wheel}: {largest} N");
    }
    // Flag 32: the new start.
    let started = estimate["flags"].iter().filter(|f| **f as u32 & 32 != 0);
    assert_eq!(started.count(), 1);
}

/// A clock that is set by 54 years after the start, and stamps in milliseconds that are read as
/// seconds: named, without the memory of all these seconds.
#[test]
fn implausible_times_are_named() {
    let (dir, lines) = recorded();
    let folder = dir.path();
    write(folder, &lines, |t| if t > 4.0 { t + 1.7e9 } else { t });
    let said = checked(folder);
    let gaps = fault(&said, "gaps");
    assert_contains(gaps, "the longest 1700000000.001 s at 4.000 s");
    let clock = fault(&said, "clock");
    assert_contains(clock, "set forward by 1700000000.000 s");
    let last = said.last().unwrap();
    assert_contains(last, " 2 with a fault");

    write(folder, &lines, |t| 1e3 * t);
    let said = checked(folder);
    let rate = fault(&said, "rate");
    assert!(
        rate.contains("at 1 Hz, with time_unit = \"ms\" at 1000 Hz")
            && said.iter().any(|line| line.contains("state time_unit")),
        "{said:#?}"
    );
    let last = said.last().unwrap();
    assert_contains(last, " 1 with a fault");
    let error = refused(robhaz(folder).args(["estimate", "log.csv"]));
    assert_contains(&error, "with time_unit = \"ms\" it is 1000.0 Hz");
}

/// Repeated rows and a cut last row are named, too.
#[test]
fn repeated_rows_and_a_cut_are_named() {
    let (dir, mut lines) = recorded();
    let folder = dir.path();
    for k in (100..4000).rev().step_by(20) {
        lines.insert(k, lines[k].clone());
    }
    write(folder, &lines, |t| t);
    let mut log = fs::read_to_string(folder.join("log.csv")).unwrap();
    log.truncate(log.len() - 30);
    fs::write(folder.join("log.csv"), log).unwrap();
    let said = checked(folder);
    let order = fault(&said, "order");
    assert_contains(order, "195 rows with the time of the row before");
    assert!(fault(&said, "end").contains("CUT OFF"));
}

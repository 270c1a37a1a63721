//! Error messages: every problem of a scene on one line, with file, line, key, what was found and
//! what is allowed.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

mod drive;
mod ground;
mod robots;

use miette::Diagnostic;
use robhaz_scene::{FileError, Scene};
use std::path::Path;

fn error(text: &str) -> FileError {
    match Scene::parse(text, "x.toml", Path::new(""), &[]) {
        Err(error) => error,
        Ok(_) => panic!("no error in: {text}"),
    }
}

fn lines(text: &str) -> Vec<String> {
    error(text)
        .problems
        .iter()
        .map(ToString::to_string)
        .collect()
}

/// The text has this one problem.
#[track_caller]
fn one(text: &str, expected: &str) {
    assert_eq!(lines(text), [expected]);
}

/// The text's first problem has this part.
#[track_caller]
fn first(text: &str, part: &str) {
    let found = lines(text);
    assert!(found[0].contains(part), "{found:?}");
}

#[test]
fn out_of_range() {
    one(
        "[drive]\n\n# Nm\ntorque_limit = -3\n",
        "x.toml:4: drive.torque_limit: found -3, allowed: a number above 0 and at most 1e6, in N m",
    );
    one(
        "engine.step = '2 ms'",
        "x.toml:1: engine.step: found '2 ms', allowed: a number above 0 and at most 0.001, in s",
    );
    for bad in ["inf", "nan", "-inf", "1e999"] {
        let lines = lines(&format!("drive.speed = {bad}"));
        assert!(lines[0].contains(&format!("found {bad}, allowed: a number of at least -10")));
    }
}

#[test]
fn wrong_unit() {
    one(
        "[drive]\nspeed = \"20 kg\"",
        "x.toml:2: drive.speed: found \"20 kg\" with the unit kg, allowed units: m/s, cm/s, mm/s, km/h",
    );
    one(
        "[contact]\nmu_s = \"0.8 m\"",
        "x.toml:2: contact.mu_s: found \"0.8 m\" with the unit m, \
         allowed: a number of at least 0 and at most 10, without a unit",
    );
    let lines = lines("[contact]\nstiffness = \"150 N/mm^2.1\"\nv_s = \"0.02\"\nv_d = \"fast\"");
    assert!(lines[0].ends_with("with the unit N/mm^2.1, allowed units: N/m^n"));
    assert!(lines[1].contains("found \"0.02\", a text without a unit, allowed: a number above 0"));
    assert!(lines[2].contains("found \"fast\", allowed: a number above 0"));
    assert!(lines[2].ends_with("in m/s, or a text with a unit (m/s, cm/s, mm/s, km/h)"));
}

#[test]
fn wrong_type() {
    one(
        "drive.kp = true",
        "x.toml:1: drive.kp: found true (a boolean), allowed: a number of at least 0 and at most 1e6, \
         in N m s, or a text with a unit (N m s, mN m s)",
    );
    one("drive = 3", "x.toml:1: drive: found 3, allowed: a table");
    one(
        "terrain = 'flat'",
        "x.toml:1: terrain: found 'flat', allowed: a table",
    );
    one(
        "robot = 'A'",
        "x.toml:1: robot: found 'A', allowed: a table",
    );
    one(
        "[estimator]\nname = 'true-mass'",
        "x.toml:1: estimator: found [estimator] (a table), \
         allowed: an array of tables, each headed [[estimator]]",
    );
    for bad in ["-1", "1.0", "'1'", "18446744073709551616", "1979-05-27"] {
        let lines = lines(&format!("seed = {bad}"));
        assert!(lines[0].contains("allowed: a whole number of at least 0 and below 2^64"));
    }
    for good in ["0", "18446744073709551615", "0xff", "1_000"] {
        Scene::parse(&format!("seed = {good}"), "x.toml", Path::new(""), &[]).unwrap();
    }
}

#[test]
fn unknown_keys_and_sections() {
    one(
        "[drive]\nkp = 3\ntorqe_limit = 3",
        "x.toml:3: drive.torqe_limit: unknown key, allowed: speed, kp, ki, torque_limit, tracking_time, \
         viscous_damping, gear_friction, start_time, ramp_time, kind, estimator, friction_test, scaling; did you mean torque_limit?",
    );
    one(
        "[drives]\nkp = 3",
        "x.toml:1: drives: unknown key, allowed: name, seed, robot, terrain, contact, drive, sensors, \
         model_error, engine, record, estimator; did you mean drive?",
    );
    let found = lines("mu_s = 3\n[[estimator]]\nname = 'true-mass'\npole = 3");
    assert!(
        found[0].ends_with("; mu_s belongs to [contact]"),
        "{}",
        found[0]
    );
    assert!(
        found[1].starts_with("x.toml:4: estimator[0].pole: unknown key, allowed: name, label,")
    );
}

#[test]
fn wrong_words() {
    one(
        "engine.kind = 'rapper'",
        "x.toml:1: engine.kind: found 'rapper', allowed: \"rapier\", \"direct\"; did you mean \"rapier\"?",
    );
    one(
        "sensors.grade = 3",
        "x.toml:1: sensors.grade: found 3, allowed: \"ideal\", \"typical\", \"poor\"",
    );
}

#[test]
fn rules_over_several_keys() {
    one(
        "[contact]\nmu_d = 0.9",
        "x.toml:2: contact.mu_d: found contact.mu_d = 0.9 and contact.mu_s = 0.8, \
         allowed: contact.mu_d not above contact.mu_s",
    );
    one(
        "contact.v_s = '10 cm/s'",
        "x.toml:1: contact.v_s: found contact.v_s = 0.1 and contact.v_d = 0.1, \
         allowed: contact.v_s below contact.v_d",
    );
    one(
        "record.duration = 1",
        "x.toml:1: record.duration: found record.compare_from = 2 and record.duration = 1, \
         allowed: record.compare_from below record.duration",
    );
    one(
        "sensors.rate = 1500",
        "x.toml:1: sensors.rate: found sensors.rate = 1500 and record.rate = 1000, \
         allowed: sensors.rate a whole multiple of record.rate",
    );
    one(
        "sensors.jitter = '1 ms'",
        "x.toml:1: sensors.jitter: found sensors.jitter = 0.001 and sensors.rate = 1000, \
         allowed: sensors.jitter at most 3e-4 s, 0.3 of the time between samples",
    );
    one(
        "[[estimator]]\nname = 'true-mass'\nparity = 'on'",
        "x.toml:3: estimator[0].parity: found 'on', allowed: \"off\" unless filters = \"kalman\"",
    );
    // The Kalman filters have no observer pole: another one than the default would have no effect.
    one(
        "[[estimator]]\nname = 'kalman'\nobserver_pole = 30",
        "x.toml:3: estimator[0].observer_pole: found 30, allowed: 50 unless filters = \"paper\"",
    );
    assert!(
        Scene::parse(
            "[[estimator]]\nname = 'kalman'\nobserver_pole = 50",
            "x.toml",
            Path::new(""),
            &[]
        )
        .is_ok()
    );
    // An explicit drive overshoots in each part of a step where its slope is too great, whichever
    // term makes it.
    for (key, value, longest, most) in [
        ("kp", "10000", "7.36e-5", "736"),
        ("viscous_damping", "950", "7.71e-4", "731"),
        ("gear_friction", "20", "3.67e-4", "7.31"),
    ] {
        one(
            &format!("drive.{key} = {value}\nengine.step = 1e-3"),
            &format!(
                "x.toml:1: drive.{key}: found drive.{key} = {value} and engine.step = 0.001, \
                 allowed: engine.step at most {longest} s or drive.{key} at most {most}, \
                 the drive's slope against wheel, rotor and links; or engine.kind = \"direct\""
            ),
        );
    }
    // Nor may the integral be faster than the slope damps it.
    one(
        "drive.ki = 1e6",
        "x.toml:1: drive.ki: found drive.ki = 1e6 and engine.step = 2e-4, \
         allowed: drive.ki at most 133000, what drive.kp and the losses damp at this step; \
         or engine.kind = \"direct\"",
    );
    first(
        "record.duration = 2.00005",
        "allowed: a whole number of records",
    );
    first("record.duration = 1e6", "allowed: at most 1e8 records");
    // Beyond three times the time constant of a bare wheel on the damping in each part the contact
    // force may diverge.
    assert_eq!(
        lines("contact.damping = 5e5"),
        [
            "x.toml:1: contact.damping: found contact.damping = 500000 and engine.step = 2e-4, \
            allowed: engine.step at most 1.17e-4 s, 39 times the wheel's mass over the damping; or engine.kind = \"direct\""
        ]
    );
    first("contact.v_s = '0.5 mm/s'", "engine.step at most 1.47e-4");
    first("engine.step = 1e-12", "allowed: at most 1e11 steps");
}

/// Counts are whole numbers.
#[test]
fn counts_are_whole_numbers() {
    one(
        "[terrain]\nkind = 'stairs'\ncount = 2.5\n",
        "x.toml:3: terrain.count: found 2.5, allowed: a whole number of at least 1 and at most 1000",
    );
}

/// A limit in a message is one that is allowed, however small: never 0.
#[test]
fn a_limit_is_never_rounded_to_zero() {
    let sets = ["robot.mass.wheel=3e-9", "robot.mass.wheel_inertia=1e-11"].map(str::to_owned);
    let error = Scene::parse("", "x.toml", Path::new(""), &sets).expect_err("a wheel too light");
    let line = error
        .problems
        .iter()
        .map(ToString::to_string)
        .find(|line| line.contains("39 times the wheel's mass over the damping"))
        .expect("the limit");
    let (_, limit) = line.split_once("engine.step at most ").expect("a limit");
    let limit: f64 = limit
        .split(' ')
        .next()
        .expect("a number")
        .parse()
        .expect("a number");
    // 39 x 3e-9 kg / 2e4 N s/m, rounded down to three digits.
    assert!((5.84e-12..=5.85e-12).contains(&limit), "{line}");
}

/// Numbers too large for a double are out of range, with a unit and without.
#[test]
fn numbers_too_large_are_out_of_range() {
    for bad in ["1e400 m/s", "1e400", "-1e999 km/h"] {
        let found = lines(&format!("drive.speed = '{bad}'"));
        let expected = format!("drive.speed: found '{bad}', allowed: a number of at least -10");
        assert!(found[0].contains(&expected), "{found:?}");
    }
}

#[test]
fn estimators() {
    let found = lines("[[estimator]]\nname = 'paper-body'\n[[estimator]]\nname = 'paper-body'");
    assert_eq!(
        found,
        [
            "x.toml:4: estimator[1].label: found 'paper-body', allowed: a label that estimator[0] does not have"
        ]
    );
    let found = lines(
        "[[estimator]]\nlabel = 'a'\n[[estimator]]\nname = 'paper'\n[[estimator]]\nname = 'true-mass'\nlabel = '../x'",
    );
    assert_eq!(found.len(), 3);
    assert!(found[0].starts_with("x.toml:1: estimator[0].name: missing"));
    assert!(
        found[1]
            .starts_with("x.toml:4: estimator[1].name: found 'paper', allowed: \"paper-body\",")
    );
    assert!(
        found[2]
            .starts_with("x.toml:7: estimator[2].label: found '../x', allowed: a text of 1 to 64")
    );
}

/// Of a text that is not TOML only the syntax errors are reported: other problems follow once it
/// can be parsed.
#[test]
fn syntax_errors_come_first() {
    one(
        "[drive]\nkp = 1\nkp = 2",
        "x.toml:3: TOML does not allow this: duplicate key; found: kp = 2",
    );
    assert_eq!(
        lines("[drive]\nspeed = 30 cm/s\n[drive]\nki = -1\n[contact]\nmu_s = 20"),
        [
            "x.toml:2: TOML does not allow this: string values must be quoted, expected literal string; \
             found: speed = 30 cm/s",
            "x.toml:3: TOML does not allow this: duplicate key; found: [drive]",
        ]
    );
    let found = lines("[contact]\nmu_s = 20\n[drive\nkp = 3\n");
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("x.toml:3: TOML does not allow this: unclosed table"));
}

#[test]
fn unreadable_files() {
    let error = Scene::load(Path::new("no/such.toml"), &[]).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such.toml: cannot be read: ")
    );
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("binary.toml");
    std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    let error = Scene::load(&file, &[]).unwrap_err();
    assert!(error.to_string().contains("UTF-8"));
}

#[test]
fn the_report_shows_the_place_of_every_problem() {
    let error = error("[drive]\nkp = -1\nki = -2\nkx = 3");
    assert_eq!(error.problems.len(), 3);
    assert!(
        error
            .to_string()
            .starts_with("x.toml:2: drive.kp: found -1")
    );
    assert!(error.to_string().ends_with("(and 2 more problems)"));
    assert!(error.source_code().is_some());
    assert_eq!(error.related().unwrap().count(), 2);
    for (problem, (line, key)) in error.problems.iter().zip([(2, "kp"), (3, "ki"), (4, "kx")]) {
        assert_eq!(
            (problem.file.as_str(), problem.line),
            ("x.toml", Some(line))
        );
        assert_eq!(problem.key, format!("drive.{key}"));
        let label = problem.labels().unwrap().next().unwrap();
        assert!(label.len() == 2);
    }
}

/// No text makes the reader panic.
#[test]
fn odd_files_make_errors_and_no_panic() {
    for text in [
        "\u{0}",
        "=",
        "[",
        "[[",
        "]]",
        "'",
        "\"\"\"",
        "a.b.c",
        "é = 'ü",
        "[[drive]]\nkp=1",
        "[[robot]]",
        "robot.geometry = []",
        "robot.geometry = [[[[]]]]",
        "robot.geometry = {}",
        "terrain.bumps = 3",
        "terrain = {kind = 'bumps', bumps = 3}",
        "terrain = {kind = 'bumps', bumps = [3]}",
        "estimator = 3",
        "estimator = [3]",
        "estimator = [[]]",
        "name = ''",
        "name = 'A'",
        "drive.kp = 'é m'",
        "drive.kp = ''",
        "robot.geometry = {axles = [1, [1], [1, 2, 3]]}",
        "robot.geometry = {carriers = ['a', 1, 'link1']}",
        "robot.geometry = ''",
        "robot.geometry = '.toml'",
        "robot.geometry = '/.toml'",
    ] {
        assert!(
            error(text)
                .problems
                .iter()
                .all(|p| !p.to_string().contains('\n')),
            "{text}"
        );
    }
}

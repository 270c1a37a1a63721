//! Descriptions of logs: what they state, and their problems with line, key, what was found and
//! what is allowed.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_scene::{FileError, LogChoice, LogSides, RobotChoice, Scene};
use std::path::Path;

fn parse(text: &str) -> Result<LogChoice, FileError> {
    LogChoice::parse(text, "s.toml", Path::new(""), LogChoice::default())
}

fn problems(text: &str) -> Vec<String> {
    let error = parse(text).unwrap_err();
    error.problems.iter().map(ToString::to_string).collect()
}

/// Round trip: the resolved description of a scene's readings reads back as the same, with model
/// errors, an estimator of its own damping and one without contact angles.
#[test]
fn resolved_descriptions_read_back() {
    let text = "[sensors]\ngrade = \"typical\"\n[model_error]\npins = 0.002\n[[estimator]]\nname = \"kalman\"\n\
                contact_angles = \"none\"\n[[estimator]]\nname = \"true-mass\"\nviscous_damping = 0.2\n";
    let scene = Scene::parse(text, "s.toml", Path::new(""), &[]).unwrap();
    let choice = LogChoice::of_scene(&scene).unwrap();
    assert_eq!(choice.robot.robot, scene.nominal_robot().unwrap());
    for (found, listed) in choice.estimators.iter().zip(&scene.estimators) {
        assert_eq!(
            choice.settings(found),
            scene.nominal_settings(listed).unwrap()
        );
    }
    let read = parse(&choice.to_toml("test")).unwrap();
    for (a, b) in read.estimators.iter().zip(&choice.estimators) {
        assert_eq!(read.settings(a), choice.settings(b));
    }
    assert_eq!(read.robot, choice.robot);
    assert_eq!(
        read.to_toml("test"),
        parse(&read.to_toml("test")).unwrap().to_toml("test")
    );
    // What a file does not state stays as in the base.
    let none = LogChoice::parse("", "s.toml", Path::new(""), choice.clone()).unwrap();
    assert_eq!(none, choice);
}

/// A recorded log is of one side of two, a simulated robot is one in the plane; a description states
/// either, a resolved one always does, and estimators run with it.
#[test]
fn a_description_states_what_a_log_is_a_side_of() {
    let sides = |text: &str| parse(text).unwrap().sides;
    assert_eq!(sides(""), LogSides::OneOfTwo);
    assert_eq!(sides("sides = \"plane\""), LogSides::Plane);
    assert_eq!(sides("sides = \"one of two\""), LogSides::OneOfTwo);
    assert_eq!(sides("sides = \"both\""), LogSides::Both);
    let scene = Scene::parse("", "s.toml", Path::new(""), &[]).unwrap();
    let plane = LogChoice::of_scene(&scene).unwrap();
    for (choice, expected) in [
        (plane, LogSides::Plane),
        (LogChoice::default(), LogSides::OneOfTwo),
    ] {
        assert_eq!(sides(&choice.to_toml("test")), expected);
        for estimator in &choice.estimators {
            assert_eq!(choice.settings(estimator).sides, expected.of_side());
        }
    }
    let found = problems("sides = \"left\"");
    assert_eq!(
        found,
        ["s.toml:1: sides: found \"left\", allowed: \"one of two\", \"plane\", \"both\""]
    );
}

/// Closed form: units, sign, gear and constants of a motor make one factor.
#[test]
fn factors_follow_from_units() {
    let missing: Vec<String> = [
        "wheel1_contact_angle",
        "wheel2_angle",
        "wheel2_motor_torque",
    ]
    .iter()
    .chain(&[
        "wheel2_contact_angle",
        "wheel3_angle",
        "wheel3_motor_torque",
    ])
    .chain(&["wheel3_contact_angle", "link2_inclination", "link2_rate"])
    .map(|name| format!("\"{name}\""))
    .collect();
    let text = format!(
        "missing = [{}]\n[reading]\n\
         wheel1_angle = {{ column = \"a\", unit = \"counts\", counts = 2000, gear_ratio = 80, sign = \"-\" }}\n\
         wheel1_motor_torque = {{ column = \"b\", unit = \"mA\", torque_constant = 0.05, gear_ratio = 80, offset = \"20 mN m\" }}\n\
         link1_inclination = {{ column = \"c\" }}\nlink1_rate = {{ column = \"d\", unit = \"deg/s\" }}\n",
        missing.join(", ")
    );
    let mapping = parse(&text).unwrap().mapping.unwrap();
    let factors: Vec<f64> = mapping.readings.iter().map(|r| r.factor).collect();
    let expected = [
        -std::f64::consts::TAU / 160_000.0,
        0.004,
        1.0,
        1.0_f64.to_radians(),
    ];
    for (found, expected) in factors.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 1e-15 * expected.abs(),
            "{found}"
        );
    }
    assert!((mapping.readings[1].offset - 0.02).abs() < 1e-17);
    assert_eq!(mapping.missing.len(), 9);
}

/// Every problem of a description is reported at its line.
#[test]
fn problems_name_line_key_and_remedy() {
    let text = "[[channel]]\nname = \"a\"\n[reading]\n\
                wheel1_angle = { column = \"x\", unit = \"counts\" }\n\
                wheel2_angle = { column = \"x\", unit = \"A\" }\n\
                wheel1_motor_torque = { channel = \"b\", column = \"y\", counts = 3 }\n\
                wheel9_angle = { column = \"x\" }\n\
                link2_inclination = { column = \"q\", gear_ratio = 80 }\nlink1_rate = { column = \"z\" }\n[imu.link1]\nup = \"+x\"\n[budget]\ntorque_nois = 1\n";
    let found = problems(text);
    for expected in [
        "s.toml:4: reading.wheel1_angle.unit: found",
        "with the key counts above 0 beside it",
        "s.toml:5: reading.wheel2_angle.unit: found \"A\", allowed: \"rad\", \"deg\", \"turns\", \"counts\"",
        "s.toml:6: reading.wheel1_motor_torque.channel: found \"b\", allowed: \"a\"",
        "s.toml:6: reading.wheel1_motor_torque.counts: found 3, allowed: no counts",
        "s.toml:7: reading.wheel9_angle: unknown key",
        "s.toml:8: reading.link2_inclination.gear_ratio: found 80, allowed: gear_ratio of a wheel's angle or motor torque only",
        "s.toml:11: imu.link1.up: found \"+x\", allowed: another axis than forward",
        "did you mean torque_noise?",
        "no column for wheel1_contact_angle",
    ] {
        assert!(
            found.iter().any(|line| line.contains(expected)),
            "{expected}\n{found:#?}"
        );
    }
}

/// Estimators are chosen by name; those that need contact angles are left out or converted.
#[test]
fn estimators_are_chosen_by_name() {
    let mut choice = LogChoice::default();
    let error = choice
        .select(&["kalmn".to_owned()])
        .unwrap_err()
        .to_string();
    assert!(error.contains("did you mean kalman?"), "{error}");
    choice
        .select(&["kalman".to_owned(), "paper-body".to_owned()])
        .unwrap();
    let mut given = choice.clone();
    assert!(given.without_contact_angles(false).is_err());
    let error = choice.without_contact_angles(true).unwrap_err();
    assert!(error.to_string().contains("paper-body"), "{error}");
    let mut best = LogChoice::default();
    best.select(&["kalman".to_owned()]).unwrap();
    assert_eq!(best.without_contact_angles(true), Ok(Vec::new()));
    assert!(best.needing_contact_angles().is_empty());
}

/// A robot file is any file with `[robot]`; one without it is refused.
#[test]
fn robots_come_from_files_with_their_section() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.toml");
    std::fs::write(&path, "[robot]\ngeometry = \"B\"\n[drive]\nspeed = 1\n").unwrap();
    assert_eq!(RobotChoice::load(&path).unwrap().geometry_name, "B");
    std::fs::write(&path, "[drive]\nspeed = 1\n").unwrap();
    let error = RobotChoice::load(&path).unwrap_err().to_string();
    assert!(error.contains("has no section [robot]"), "{error}");
}

/// The covariance of a weighed robot is read back to the bit; what is no covariance is refused with
/// its line.
#[test]
fn budgets_take_the_covariance_of_a_weighed_robot() {
    let rows = |changed: f64| {
        let row = |i: usize| {
            let entry = |j: usize| match (i, j) {
                (2, 4) => changed,
                (4, 2) => 1e-5,
                _ if i == j => 1e-4,
                _ => 0.0,
            };
            let cells: Vec<_> = (0..7).map(|j| format!("{:e}", entry(j))).collect();
            format!("[{}]", cells.join(", "))
        };
        let rows: Vec<_> = (0..7).map(row).collect();
        format!(
            "[budget]\nbody_cg = 0\nload_covariance = [{}]\n",
            rows.join(", ")
        )
    };
    let parse = |text: &str| LogChoice::parse(text, "s.toml", Path::new(""), LogChoice::default());
    let choice = parse(&rows(1e-5)).unwrap();
    assert!(choice.budget.load_covariance.is_some());
    let again = parse(&choice.to_toml("test")).unwrap();
    assert_eq!(again.budget, choice.budget);
    for (text, expected) in [
        (
            rows(2e-5),
            "it is no covariance: row 3, column 5 differs from row 5, column 3",
        ),
        (rows(5e-3), "row 3, column 5 differs"),
        (
            "[budget]\nload_covariance = [[1.0]]\n".to_owned(),
            "7 rows of 7 numbers",
        ),
    ] {
        let error = parse(&text).unwrap_err().to_string();
        assert!(
            error.contains("s.toml:") && error.contains(expected),
            "{error}"
        );
    }
}

/// The description in the guide is one, and states the robot.
#[test]
fn the_description_of_the_guide_is_valid() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/log-to-forces.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("```toml\n").unwrap();
    let (text, _) = rest.split_once("```").unwrap();
    let choice = parse(text).unwrap();
    assert!(choice.states("robot") && !LogChoice::default().states("robot"));
    assert!(choice.budget.link_mass > 0.0 && choice.mapping.is_some());
}

//! `robhaz check`, and the way from an unknown log to forces in `docs/log-to-forces.md`.

use crate::support::{
    assert_contains, columns, refused, robhaz, root, succeeded, summary, text, with_run,
};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The commands of `docs/log-to-forces.md`, in their order.
const COMMANDS: [&str; 5] = [
    "robhaz check drive.csv",
    "robhaz check drive.csv --sensors SENSORS.toml",
    "robhaz check drive.csv --sensors SENSORS.toml --json",
    "robhaz estimate drive.csv --sensors SENSORS.toml --estimator kalman",
    "robhaz export runs/drive-estimate --to csv",
];

fn command(folder: &Path, line: &str) -> Command {
    let mut command = robhaz(folder);
    command.args(line.split_whitespace().skip(1));
    command
}

/// A folder with `drive.csv`, a log of a robot with names and units of its own: inclinations in degrees, the second gyroscope
/// mounted the other way round, the first two motor torques exchanged. No contact angles.
fn with_log() -> tempfile::TempDir {
    let sets = [
        "sensors.grade=typical",
        "record.duration=12",
        "record.rate=200",
        "sensors.rate=200",
    ];
    let sets = sets.into_iter().flat_map(|set| ["--set", set]);
    let dir = with_run(
        &["--format", "csv"]
            .into_iter()
            .chain(sets)
            .collect::<Vec<_>>(),
    );
    let folder = dir.path();
    let sensors = columns(&folder.join("run/sensors.csv"));
    let channels = [
        ("t", "time", 1.0),
        ("enc1", "wheel1_angle", 1.0),
        ("enc2", "wheel2_angle", 1.0),
        ("enc3", "wheel3_angle", 1.0),
        ("tau1", "wheel2_motor_torque", 1.0),
        ("tau2", "wheel1_motor_torque", 1.0),
        ("tau3", "wheel3_motor_torque", 1.0),
        ("pitch1", "link1_inclination", 1f64.to_degrees()),
        ("pitch2", "link2_inclination", 1f64.to_degrees()),
        ("gyro1", "link1_rate", 1.0),
        ("gyro2", "link2_rate", -1.0),
    ];
    let mut writer = csv::Writer::from_path(folder.join("drive.csv")).unwrap();
    writer
        .write_record(channels.map(|(name, ..)| name))
        .unwrap();
    let scaled = channels.map(|(_, name, factor)| (&sensors[name], factor));
    for (row, _) in sensors["time"].iter().enumerate() {
        let cell = |(values, factor): (&Vec<f64>, f64)| (values[row] * factor).to_string();
        writer.write_record(scaled.map(cell)).unwrap();
    }
    writer.flush().unwrap();
    dir
}

/// A description with the torques of wheels 1 and 2 in these columns, a unit of the inclinations
/// and a sign of gyro 2.
fn write_description(folder: &Path, torques: [&str; 2], unit: &str, sign: &str) {
    describe(folder, torques, unit, sign, ["", ""]);
}

/// As [`write_description`], with further keys of all encoders and of all torques.
fn describe(folder: &Path, torques: [&str; 2], unit: &str, sign: &str, keys: [&str; 2]) {
    let ([tau1, tau2], [encoder, torque]) = (torques, keys);
    let description = format!(
        r#"
missing = ["wheel1_contact_angle", "wheel2_contact_angle", "wheel3_contact_angle"]
[[channel]]
name = "drive"
time = "t"
[reading]
wheel1_angle = {{ column = "enc1"{encoder} }}
wheel2_angle = {{ column = "enc2"{encoder} }}
wheel3_angle = {{ column = "enc3"{encoder} }}
wheel1_motor_torque = {{ column = "{tau1}"{torque} }}
wheel2_motor_torque = {{ column = "{tau2}"{torque} }}
wheel3_motor_torque = {{ column = "tau3"{torque} }}
link1_inclination = {{ column = "pitch1", unit = "{unit}" }}
link2_inclination = {{ column = "pitch2", unit = "{unit}" }}
link1_rate = {{ column = "gyro1" }}
link2_rate = {{ column = "gyro2", sign = "{sign}" }}
"#
    );
    fs::write(folder.join("SENSORS.toml"), description).unwrap();
}

/// Sum over the wheels of the mean normal force in a table `truth`, N.
fn mean_force(path: &Path) -> f64 {
    let truth = columns(path);
    let mean = |wheel: u32| {
        let forces = &truth[&format!("wheel{wheel}_equivalent_normal_force")];
        forces.iter().sum::<f64>() / forces.len() as f64
    };
    mean(1) + mean(2) + mean(3)
}

/// Whether a finding that tells has its figures as numbers with units.
fn has_numbers(finding: &serde_json::Value) -> bool {
    let figure = finding["figure"].as_str().unwrap();
    let numbers = finding["numbers"].as_array().unwrap();
    let is_number = |n: &serde_json::Value| {
        n["name"].is_string() && n["value"].is_f64() && n["unit"].is_string()
    };
    numbers.iter().all(is_number)
        && (finding["verdict"] == "cannot-tell"
            || !figure.contains(|c: char| c.is_ascii_digit())
            || !numbers.is_empty())
}

/// Encoders in degrees or turns where radians are stated are found by the robot's acceleration, and
/// torques of the motor's side are not called right: their noise is a hundredth of the budget's.
#[test]
fn units_that_fit_each_other_are_found() {
    let dir = with_log();
    let folder = dir.path();
    // Radians times 57.3 are what degrees look like.
    for (scale, unit) in [("57.29578", "deg"), ("0.1591549", "turns")] {
        let encoder = format!(", scale = {scale}");
        describe(folder, ["tau2", "tau1"], "deg", "-", [&encoder, ""]);
        let output = command(folder, COMMANDS[1]).output().unwrap();
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert_contains(&said, "FAULT        acceleration");
        assert_contains(&said, format!("state unit = \"{unit}\""));
    }
    describe(
        folder,
        ["tau2", "tau1"],
        "deg",
        "-",
        ["", ", scale = 0.0125"],
    );
    let said = text(&command(folder, COMMANDS[1]).output().unwrap().stdout);
    let quiet = said
        .matches("suspiciously quiet: check the unit (a torque of the motor's side (gear_ratio)")
        .count();
    assert_eq!(quiet, 3, "{said}");
    // Such torques show no wiring: nothing else is said of them.
    assert!(
        said.contains("they need angles and torques in their units") && !said.contains("exchange"),
        "{said}"
    );
}

/// The guide's commands lead from a log with foreign names, units and wiring to forces: missing
/// names are named, then all three faults at once with what to do; corrected, there is none, and
/// the forces add up to about the weight.
#[test]
fn five_commands_lead_from_an_unknown_log_to_forces() {
    let guide = fs::read_to_string(root().join("docs/log-to-forces.md")).unwrap();
    for command in COMMANDS {
        assert!(guide.lines().any(|line| line == command), "{command}");
    }
    let dir = with_log();
    let folder = dir.path();

    let unnamed = refused(&mut command(folder, COMMANDS[0]));
    assert_contains(unnamed, "wheel1_angle");

    write_description(folder, ["tau1", "tau2"], "rad", "+");
    let wrong = command(folder, COMMANDS[1]).output().unwrap();
    let said = text(&wrong.stdout);
    assert_eq!(wrong.status.code(), Some(1), "{said}");
    for expected in [
        "the inclination is in degrees: state unit = \"deg\"",
        "torque 1 belongs to encoder 2, torque 2 belongs to encoder 1",
        "exchange the columns of wheel1_motor_torque and wheel2_motor_torque",
        "gyro 2 has the wrong sign",
        "reading.link2_rate",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }

    write_description(folder, ["tau2", "tau1"], "deg", "-");
    let right = succeeded(&mut command(folder, COMMANDS[2]));
    let report: serde_json::Value = serde_json::from_str(&text(&right.stdout)).unwrap();
    assert_eq!(report["verdict"], "ok");
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.len() > 30);
    assert!(findings.iter().all(has_numbers), "{findings:#?}");
    // The one exchange that no reading shows is named.
    let exchange = findings
        .iter()
        .find(|f| f["test"] == "wheels and links")
        .unwrap();
    assert_eq!(exchange["verdict"], "cannot-tell");
    let remedy = exchange["remedy"].as_str().unwrap();
    assert_contains(
        remedy,
        "exchange the columns of wheel2_motor_torque and wheel3_motor_torque; exchange the columns of wheel2_angle and wheel3_angle",
    );

    let said = text(&succeeded(&mut command(folder, COMMANDS[3])).stdout);
    assert!(!said.contains("CONTRADICT"), "{said}");
    succeeded(&mut command(folder, COMMANDS[4]));
    let summary = summary(&folder.join("runs/drive-estimate"));
    let means = &summary["estimators"]["kalman"]["means"]["normal_force"];
    let sum: f64 = (0..3).map(|i| means[i].as_f64().unwrap()).sum();
    // More than the weight: wheels that work against each other press on slopes. Within 1 % of the
    // simulation's.
    let truth = mean_force(&folder.join("run/truth.csv"));
    assert!((sum - truth).abs() < 0.01 * truth, "{sum} {truth}");
}

/// A contradiction is reported at the end of an estimate and in its summary: the gyroscope with the
/// wrong sign.
#[test]
fn an_estimate_tells_a_contradiction() {
    let dir = with_log();
    let folder = dir.path();
    write_description(folder, ["tau2", "tau1"], "deg", "+");
    let estimated = command(folder, COMMANDS[3]).output().unwrap();
    let said = text(&estimated.stdout);
    assert_contains(&said, "READINGS CONTRADICT EACH OTHER");
    assert_contains(&said, "gyroscope 2 from");
    let summary = summary(&folder.join("runs/drive-estimate"));
    let faulty = &summary["estimators"]["kalman"]["faulty_channels"]["gyroscope 2"];
    assert!(faulty["records"].as_u64().unwrap() > 1000, "{faulty}");
}

/// A log that does not say how exact the robot is counts as people build them, and both commands
/// say so; a budget of its own, here or in the file of the robot, is silent.
#[test]
fn the_default_budget_of_a_robot_is_named() {
    let dir = with_log();
    let folder = dir.path();
    write_description(folder, ["tau2", "tau1"], "deg", "-");
    let mine = fs::read_to_string(folder.join("SENSORS.toml")).unwrap();
    fs::write(
        folder.join("stated.toml"),
        mine + "[budget]\nbody_cg = \"5 mm\"\n",
    )
    .unwrap();
    fs::write(
        folder.join("robot.toml"),
        "[robot]\ngeometry = \"A\"\n[budget]\nlink_masses = 0.05\n",
    )
    .unwrap();
    let notice = "those of its parts to 3 %, centres of mass to 5 mm, pins to 1 mm";
    for line in [
        "robhaz check drive.csv",
        "robhaz estimate drive.csv --force --rerun off --estimator kalman",
    ] {
        for (description, is_said) in [
            ("--sensors SENSORS.toml", true),
            ("--sensors stated.toml", false),
            ("--sensors SENSORS.toml --robot robot.toml", false),
        ] {
            let output = succeeded(&mut command(folder, &format!("{line} {description}")));
            let said = text(&output.stderr);
            assert_eq!(said.contains(notice), is_said, "{line}: {said}");
        }
    }
}

//! What a log without a channel, of a parked robot, or a wrong unit is said to be, and no more.

use crate::readings::level_drive::{DESCRIPTION, LevelDrive, check, estimate, logged};
use crate::support::{assert_contains, refused, robhaz, text};
use std::fs;
use tempfile::TempDir;

/// A folder with the log of a drive with a change, and what `check` says of it.
fn checked(change: impl FnOnce(&mut LevelDrive)) -> (TempDir, String) {
    let folder = logged(DESCRIPTION, change);
    let said = text(&check(folder.path()).stdout);
    (folder, said)
}

/// The lines of faults.
fn faults(said: &str) -> Vec<&str> {
    said.lines()
        .filter(|line| line.starts_with("FAULT"))
        .collect()
}

/// A channel without a value, or with 0 throughout the drive, has one finding, which names it, and no other finding is
/// of it. `estimate` refuses a reading without a value, and warns of torques that are 0.
#[test]
fn a_dead_channel_has_one_finding() {
    for (column, channel) in [
        ("wheel2_motor_torque", "torque 2"),
        ("wheel3_angle", "encoder 3"),
        ("link1_inclination", "inclinometer 1"),
        ("link2_rate", "gyro 2"),
    ] {
        for value in [f64::NAN, 0.0] {
            let (folder, said) = checked(|drive| drive.change(column, |_, _| value));
            let [fault] = faults(&said)[..] else {
                panic!("{column} {value}: {said}");
            };
            assert_contains(fault, column);
            assert_contains(fault, "601 frames");
            let of_channel = said.lines().filter(|line| line.contains(channel)).count();
            assert_eq!(of_channel, 1, "{column} {value}: {said}");
            let estimated = estimate(folder.path());
            if value.is_nan() {
                let error = text(&estimated.stderr);
                assert!(!estimated.status.success(), "{column}");
                let part = format!("{column} has no value in 601 rows");
                assert_contains(&error, &part);
            }
        }
    }
    let (folder, said) = checked(|drive| drive.change("_motor_torque", |_, _| 0.0));
    assert_contains(&said, "3 with a fault");
    assert!(!said.contains("`scale`"), "{said}");
    let warned = text(&estimate(folder.path()).stderr);
    assert_contains(&warned, "wheel3_motor_torque is 0 in the whole log");
}

/// All encoders at 0 while torques and gyroscopes move are dead, and no zero follows from a rest that was none; of a
/// robot that stands, with noise alone, nothing is said.
#[test]
fn dead_encoders_are_no_rest() {
    for moves in [true, false] {
        let changes: &[(&str, f64)] = match moves {
            true => &[
                ("wheel1_motor_torque", 3.0),
                ("wheel3_motor_torque", -3.0),
                ("link1_rate", 0.1),
            ],
            false => &[],
        };
        let (_, said) = checked(|drive| {
            drive.change("_angle", |_, _| 0.0);
            for (column, size) in changes {
                drive.change(column, |k, x| x + size * (0.005 * k as f64).sin());
            }
        });
        let faults = faults(&said);
        let dead = faults
            .iter()
            .filter(|l| l.contains("while torques and gyroscopes change"));
        let expected = if moves { 3 } else { 0 };
        assert!(
            dead.count() == expected && faults.len() == expected,
            "{said}"
        );
    }
}

/// A measured torque that stays at an extreme is saturated, not dead; one without noise may be at the drive's limit. One
/// that drops to 0 again and again is not measured there.
#[test]
fn a_torque_that_repeats_its_value_says_why() {
    let of = |change: &dyn Fn(usize, f64) -> f64| {
        let (_, said) = checked(|drive| drive.change("wheel2_motor_torque", change));
        let lines = said
            .lines()
            .skip_while(|l| !(l.starts_with("FAULT") && l.contains("torque 2")));
        let fault: Vec<String> = lines.take(2).map(str::to_owned).collect();
        (fault.join("\n"), said)
    };
    // Two seconds and a half at the limit.
    let wave = |k: usize| 3.0 * (0.0125 * k as f64).sin();
    let (fault, said) = of(&|k, x| (wave(k) + x).clamp(-1.5, 1.5));
    assert!(
        fault.contains("saturated at 1.5000") && !said.contains("dead from"),
        "{said}"
    );
    // Half a second and less.
    let wave = |k: usize| 2.0 * (0.05 * k as f64).sin();
    let (fault, said) = of(&|k, _| wave(k).clamp(-1.5, 1.5));
    assert!(
        !fault.contains("saturated") && !fault.contains("again"),
        "{said}"
    );
    assert_contains(&said, "at its limit of");
    let (fault, said) = of(&|k, x| if k > 150 && k % 100 < 50 { 0.0 } else { x });
    assert!(
        fault.contains("reads 0.0000 again and again, 4 times"),
        "{said}"
    );
}

/// A wheel that is not read in the second half of a drive: both its channels say since when.
#[test]
fn a_silent_channel_is_a_fault() {
    let (_, said) = checked(|drive| {
        for column in ["wheel3_angle", "wheel3_motor_torque"] {
            drive.column(column)[300..].fill(f64::NAN);
        }
    });
    let faults = faults(&said);
    let silent = |name: &str| format!("{name} has no value for 3.0 s from 3.0 s on");
    assert!(
        faults.len() == 2
            && faults[0].contains(&silent("encoder 3"))
            && faults[1].contains(&silent("torque 3")),
        "{said}"
    );
}

/// A log of which no row has an estimate ends with an error.
#[test]
fn an_estimate_without_a_force_is_an_error() {
    // No linkage closes at such an angle.
    let folder = logged(DESCRIPTION, |drive| {
        drive.change("link1_inclination", |_, angle| angle + 2.0);
    });
    let output = estimate(folder.path());
    assert!(!output.status.success());
    let error = text(&output.stderr);
    assert_contains(&error, "no estimator found a force");
}

/// Encoders of a parked robot that tick together are no column twice; those of a drive are.
#[test]
fn a_parked_robot_has_no_column_twice() {
    let count = std::f64::consts::TAU / 160_000.0;
    let (_, said) = checked(|drive| {
        drive.change("_angle", |k, _| if k == 0 { 0.0 } else { -count });
        // The torques of standing motors: noise alone.
        for i in 1..=3 {
            let torques = drive.column(&format!("wheel{i}_motor_torque"));
            for k in 90..torques.len() {
                torques[k] = torques[k % 90];
            }
        }
    });
    assert_contains(&said, "the wheels do not turn");
    assert!(faults(&said).is_empty(), "{said}");
    let (_, said) = checked(|drive| {
        let first = drive.column("wheel1_angle").clone();
        *drive.column("wheel2_angle") = first;
    });
    assert_contains(&said, "the same column twice");
}

/// Units that no robot has: a stiffness in N/mm^2.1, inertias in kg cm^2.
#[test]
fn impossible_numbers_name_their_unit() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    let not_run = |scene: &str, parts: &[&str]| {
        fs::write(folder.join("scene.toml"), scene).unwrap();
        let run = ["run", "scene.toml", "--rerun", "off"];
        let error = refused(robhaz(folder).args(run));
        for part in parts {
            assert_contains(&error, part);
        }
    };
    let stiffness = "[terrain]\nkind = \"flat\"\n[contact]\nstiffness = 150\n";
    not_run(
        stiffness,
        &["sink by 0.568 m", "N/m^2.1: 150 N/mm^2.1 is 2.99e8"],
    );
    let linear = "[contact]\nstiffness = 150\nexponent = 1\n";
    not_run(linear, &["sink by 0.305 m", "N/m^1: 150 N/mm^1 is 150000"]);
    let mass = fs::read_to_string(crate::support::root().join("robots/mass-caption.toml")).unwrap();
    for (key, value, found) in [
        ("body_inertia", "760", "760 kg cm^2 are 0.076"),
        ("wheel_inertia", "75", "75 kg cm^2 are 0.0075"),
        ("rotor_inertia", "864", "864 kg cm^2 are 0.0864"),
    ] {
        let lines = mass.lines().map(|line| match line.starts_with(key) {
            true => format!("{key} = {value}\n"),
            false => format!("{line}\n"),
        });
        fs::write(folder.join("mass.toml"), lines.collect::<String>()).unwrap();
        not_run(
            "[robot]\nmass = \"mass.toml\"\n",
            &[key, "the unit is kg m^2", found],
        );
    }
}

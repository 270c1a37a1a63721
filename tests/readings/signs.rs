//! What drivers do to the sign of a torque: `check` names it, `estimate` refuses magnitudes.

use super::level_drive::{DESCRIPTION, check, estimate, logged};
use crate::support::text;

/// What `check` says of the drive with changed torques, and `estimate`, and whether this refuses it.
fn checked(change: impl Fn(f64) -> f64) -> ([String; 2], bool) {
    let dir = logged(DESCRIPTION, |drive| {
        drive.change("_motor_torque", |_, torque| change(torque));
    });
    let folder = dir.path();
    let estimated = estimate(folder);
    let estimated_said = text(&estimated.stderr);
    let refused = estimated_said.contains("their signs are lost");
    assert_eq!(refused, !estimated.status.success());
    ([text(&check(folder).stdout), estimated_said], refused)
}

/// Each way to lose a sign is a fault of all three torques, with its name; signed ones have none.
#[test]
fn a_lost_sign_is_named() {
    for (name, change) in [
        (
            "the sign is lost",
            (|torque| torque.abs()) as fn(f64) -> f64,
        ),
        ("negative numbers are read as unsigned", |torque| {
            torque.rem_euclid(65.536)
        }),
        ("whole numbers of 0.450 N m", |torque| {
            0.45 * (torque / 0.45).trunc()
        }),
    ] {
        let ([said, by_estimate], refused) = checked(change);
        // Whole numbers have signs.
        assert_eq!(refused, !name.starts_with("whole"), "{name}");
        assert_eq!(said.matches(name).count(), 3, "{name}: {said}");
        // What rounding leaves counts.
        let counts = by_estimate.contains(&format!("the torques are {name}"));
        assert_eq!(counts, name.starts_with("whole"), "{by_estimate}");
    }
    // Hundredths of a newton metre are finer than the noise.
    let ([said, by_estimate], _) = checked(|torque| (torque * 100.0).round() / 100.0);
    assert!(!by_estimate.contains("whole numbers"), "{by_estimate}");
    let of_sign = said.lines().find(|line| line.contains("  signed  "));
    assert!(of_sign.is_some_and(|line| line.starts_with("ok")), "{said}");
}

/// Angles in degrees, and those of a motor in front of a gear of 10, without their unit: the torques of the start do not
/// fit. The level drive as it is has no such fault.
#[test]
fn another_unit_shows_in_the_start() {
    for (factor, fits) in [(57.3, false), (0.1, false), (1.0, true)] {
        let dir = logged(DESCRIPTION, |drive| {
            drive.change("_angle", |_, angle| factor * angle);
        });
        let report = text(&check(dir.path()).stdout);
        let named = report.contains("have another unit (degrees 57.3;");
        assert_eq!(named, !fits, "{factor}: {report}");
    }
}

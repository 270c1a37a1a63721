//! Tests of units in the names of columns.

use super::*;

fn unit(name: &str, taken_for: Kind) -> Option<(Kind, f64)> {
    Unit::in_name(name, taken_for).map(|unit| (unit.kind, unit.factor))
}

/// However a unit is written.
#[test]
fn units_are_found_in_names() {
    const DEGREE: f64 = PI / 180.0;
    for name in [
        "angle_deg",
        "angle [deg]",
        "angle (deg)",
        "angle [\u{b0}]",
        "angle degrees",
        "angleDeg",
        "angle / deg",
        "angle in deg",
        "angle, deg",
        "enc1_deg_raw",
        "angle.deg",
        "ANGLE_DEG",
        "angle-degrees",
        "angle{deg}",
    ] {
        assert_eq!(
            unit(name, Kind::Angle),
            Some((Kind::Angle, DEGREE)),
            "{name}"
        );
    }
    for name in [
        "torque_mNm",
        "torque [mN m]",
        "torque (mN\u{b7}m)",
        "torque_mN_m",
        "torque_mnm",
        "torque [mN*m]",
        "torque mNm",
    ] {
        assert_eq!(
            unit(name, Kind::Torque),
            Some((Kind::Torque, 1e-3)),
            "{name}"
        );
    }
    for name in [
        "rate_dps",
        "rate [deg/s]",
        "rate (\u{b0}/s)",
        "gyro_dps_y",
        "rate_deg_s",
        "rate_deg_per_s",
        "gyroYDps",
        "rate [deg s^-1]",
        "rate_degps",
    ] {
        assert_eq!(unit(name, Kind::Rate), Some((Kind::Rate, DEGREE)), "{name}");
    }
    for (name, taken_for, expected) in [
        ("time_ms", Kind::Time, (Kind::Time, 1e-3)),
        ("timeMs", Kind::Time, (Kind::Time, 1e-3)),
        ("t [us]", Kind::Time, (Kind::Time, 1e-6)),
        ("stamp_ns", Kind::Time, (Kind::Time, 1e-9)),
        ("speed_rpm", Kind::Angle, (Kind::Rate, TAU / 60.0)),
        ("rate_rad_s", Kind::Rate, (Kind::Rate, 1.0)),
        ("current_A", Kind::Torque, (Kind::Current, 1.0)),
        ("current_mA", Kind::Torque, (Kind::Current, 1e-3)),
        ("torqueNm", Kind::Torque, (Kind::Torque, 1.0)),
        ("enc1_ticks", Kind::Angle, (Kind::Counts, 1.0)),
        ("torque [%]", Kind::Torque, (Kind::Other, 1.0)),
    ] {
        assert_eq!(unit(name, taken_for), Some(expected), "{name}");
    }
}

/// Words that mean something else.
#[test]
fn other_words_are_no_units() {
    for (name, taken_for) in [
        ("wheel1_angle", Kind::Angle),
        ("moment_rad", Kind::Torque),
        ("rad_vorne_moment", Kind::Torque),
        ("torque_A", Kind::Torque),
        ("torque_a", Kind::Torque),
        ("torque_ma", Kind::Torque),
        ("wheel1_turn", Kind::Angle),
        ("wheel1_rot", Kind::Angle),
        ("motor_m", Kind::Torque),
        ("wheel_s", Kind::Angle),
        ("angle (front)", Kind::Angle),
        ("tick", Kind::Time),
        ("imu/gyro/y", Kind::Rate),
        ("angular_velocity.y", Kind::Rate),
        ("turn_angle", Kind::Angle),
        ("count_left_angle", Kind::Angle),
    ] {
        assert_eq!(unit(name, taken_for), None, "{name}");
    }
}

/// What is stated by `scale` agrees, whatever unit is stated with it.
#[test]
fn a_scale_can_hold_the_unit() {
    let agrees = |kind, factor, scale, column: &str| {
        let stated = Unit {
            name: String::new(),
            kind,
            factor,
        };
        stated.agrees(scale, &Unit::of(column).unwrap())
    };
    let degree = PI / 180.0;
    assert!(!agrees(Kind::Angle, 1.0, 1.0, "deg"));
    assert!(agrees(Kind::Angle, 1.0, degree, "deg"));
    assert!(agrees(Kind::Angle, degree, 1.0 / 80.0, "deg"));
    assert!(agrees(Kind::Torque, 1.0, 0.8, "Nm"));
    assert!(!agrees(Kind::Torque, 1.0, 0.8, "mNm"));
    assert!(!agrees(Kind::Torque, 1.0, 1.0, "A") && agrees(Kind::Torque, 1.0, 0.05, "A"));
    assert!(!agrees(Kind::Current, 1.0, 1.0, "mA") && !agrees(Kind::Current, 1.0, 1.0, "Nm"));
    assert!(agrees(Kind::Rate, degree, 1.0, "deg") && !agrees(Kind::Rate, 1.0, 1.0, "dps"));
    assert!(!agrees(Kind::Angle, 1.0, 1.0, "rpm"));
}

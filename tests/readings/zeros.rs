//! Zeros of the links' sensors: at rest, and by the work of the torques.

use super::level_drive::{LevelDrive, check, estimate, in_the_plane, logged};
use crate::support::{assert_contains, text};

/// What `check` and `estimate` say of a log with a change.
fn said(change: impl FnOnce(&mut LevelDrive)) -> [String; 2] {
    let dir = logged(&in_the_plane(), change);
    let folder = dir.path();
    let estimated = estimate(folder);
    let said = text(&estimated.stdout) + &text(&estimated.stderr);
    [text(&check(folder).stdout), said]
}

fn tilted(drive: &mut LevelDrive, by: f64) {
    drive.change("_inclination", |_, value| value + by.to_radians());
}

/// Sensors that are all mounted with their nose up show a rise which no torque makes: both commands say so. Nose down may
/// be friction: the rest shows it, with what it costs. Right ones are said to be neither.
#[test]
fn sensors_that_are_all_mounted_alike_are_named() {
    const FAULT: &str = "FAULT        zero by the torques";
    const WARNING: &str =
        "READINGS CONTRADICT EACH OTHER: by the work of the torques all inclinometers err by";
    let [checked, estimated] = said(|drive| tilted(drive, 5.0));
    assert_contains(&checked, FAULT);
    assert_contains(&estimated, WARNING);
    let [checked, estimated] = said(|drive| tilted(drive, -5.0));
    assert!(!checked.contains(FAULT), "{checked}");
    let at_rest = "at rest all inclinometers together show a slope of -5.0 deg";
    assert_contains(&estimated, at_rest);
    assert_contains(&estimated, "Each degree is 1.7 % of the weight");
    let [checked, estimated] = said(|_| {});
    assert!(!checked.contains("FAULT"), "{checked}");
    assert!(!estimated.contains("all inclinometers"), "{estimated}");
}

/// Single wrong readings of a gyroscope at rest are none of its zero; an offset is.
#[test]
fn spikes_are_no_zero() {
    const FAULT: &str = "FAULT        zero at rest";
    let [checked, _] = said(|drive| {
        let values = drive.column("link1_rate");
        [20, 45, 80].into_iter().for_each(|k| values[k] += 1.0);
    });
    assert!(!checked.contains(FAULT), "{checked}");
    let [checked, _] = said(|drive| drive.change("link1_rate", |_, value| value + 0.01));
    assert_contains(&checked, FAULT);
}

/// Inclinations from 0 to 360 deg are those from -180 to 180 deg.
#[test]
fn inclinations_may_go_from_0_to_a_turn() {
    let turned = |_: usize, value: f64| value.rem_euclid(std::f64::consts::TAU);
    let [checked, _] = said(|drive| drive.change("_inclination", turned));
    assert!(!checked.contains("FAULT"), "{checked}");
}

/// A torque that is 1 N m off: an estimate says what `check` finds, with its remedy, before its forces; of the right log
/// nothing.
#[test]
fn an_estimate_says_what_check_finds() {
    let off = |drive: &mut LevelDrive| drive.change("wheel2_motor_torque", |_, value| value + 1.0);
    let [checked, estimated] = said(off);
    assert_contains(&checked, "FAULT        zero at rest");
    let line = "FAULT: zero at rest, torque 2: mean 0.99";
    assert_contains(&estimated, line);
    assert_contains(&estimated, " -> zero it with the motors off");
    let [_, estimated] = said(|_| {});
    assert!(!estimated.contains("FAULT"), "{estimated}");
}

/// Magnetic encoders have white noise: it is measured and counts as that of fewer counts, so that N stays right; and no
/// test takes it for something else.
#[test]
fn white_noise_of_encoders_counts() {
    let mut random = super::level_drive::normal(4);
    let mut noisy = |_: usize, angle: f64| angle + 0.05_f64.to_radians() * random();
    let [checked, estimated] = said(|drive| drive.change("_angle", &mut noisy));
    assert!(!checked.contains("FAULT"), "{checked}");
    assert_contains(&estimated, "the encoders have a white noise of 0.05");
    assert!(!estimated.contains("WRONG FORCES"), "{estimated}");
}

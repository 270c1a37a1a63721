//! Single wrong readings, and encoders that count from a new zero.

use super::level_drive::{
    DESCRIPTION, LevelDrive, check, estimate, in_the_plane, largest_error, logged,
};
use crate::support::{assert_contains, text};
use std::fs;

/// Largest error of N of a log with a change, and what `check` and `estimate` say.
fn spoiled(change: impl Fn(&mut LevelDrive)) -> (f64, String, String) {
    let dir = logged(&in_the_plane(), change);
    let folder = dir.path();
    let checked = check(folder);
    let estimated = estimate(folder);
    assert!(estimated.status.success(), "{}", text(&estimated.stderr));
    let said = text(&estimated.stdout) + &text(&estimated.stderr);
    (largest_error(folder), text(&checked.stdout), said)
}

/// Largest error of N, N: that of the clean log, since one lost reading costs nothing.
const LIMIT: f64 = 2.0;

/// A single wrong angle of a wheel is left out, and named with encoder and time; so are several.
#[test]
fn a_single_wrong_angle_changes_nothing() {
    for by in [1.9, -0.2, 6000.0] {
        let (error, checked, _) = spoiled(|drive| drive.column("wheel2_angle")[400] += by);
        assert!(error < LIMIT, "{by}: {error}");
        let named = format!("single wrong readings: {by:+.3} rad at 4.000 s");
        let fault = checked.lines().find(|line| line.contains(&named));
        assert!(
            fault.is_some_and(|line| line.starts_with("FAULT") && line.contains("encoder 2")),
            "{checked}"
        );
        assert!(checked.ends_with("1 with a fault\n"), "{checked}");
    }
    let (error, checked, _) = spoiled(|drive| {
        for k in [250, 300, 450] {
            drive.column("wheel1_angle")[k] += 0.5;
        }
    });
    assert!(error < LIMIT, "{error}");
    assert_contains(
        &checked,
        "at 2.500 s, +0.500 rad at 3.000 s, +0.500 rad at 4.500 s",
    );
}

/// One that restarts by the same angle again and again, at a speed that hides a wrap, is named, too.
#[test]
fn an_encoder_that_restarts_again_and_again_is_named() {
    let (error, checked, _) = spoiled(|drive| {
        // 2 rad a second.
        drive.change("wheel1_angle", |k, angle| {
            angle - 2.0 * (k.saturating_sub(100) / 100) as f64
        });
    });
    assert!(error < LIMIT, "{error}");
    let named = "a new zero: -2.000 rad at 2.000 s, -2.000 rad at 3.000 s, -2.000 rad at 4.000 s and 2 more";
    let fault = checked.lines().find(|line| line.contains(named));
    assert!(
        fault.is_some_and(|line| line.starts_with("FAULT")),
        "{checked}"
    );
    assert_contains(&checked, "was reset");
    assert_contains(&checked, "`wrap`");
    assert!(checked.ends_with("1 with a fault\n"), "{checked}");
}

/// A wrong angle that a wheel could make, but that it leaves again in the next reading, is named, and no delay.
#[test]
fn a_small_wrong_angle_is_named() {
    let (_, checked, _) = spoiled(|drive| {
        for k in [250, 300, 450] {
            drive.column("wheel2_angle")[k] += 0.01;
        }
    });
    let named = "single wrong readings: +0.010 rad at 2.500 s, +0.010 rad at 3.000 s, +0.010 rad at 4.500 s";
    assert_contains(&checked, named);
    assert!(checked.ends_with("1 with a fault\n"), "{checked}");
}

/// Angles of all wheels that start anew at once are no clock that was set: a wheel falls behind by more than the step.
#[test]
fn angles_that_start_anew_together_are_no_set_clock() {
    let (_, checked, _) = spoiled(|drive| {
        for wheel in ["wheel1_angle", "wheel2_angle", "wheel3_angle"] {
            let angles = drive.column(wheel);
            let zero = angles[0];
            let wrapped = |angle: f64| (angle - zero).rem_euclid(2.5);
            angles.iter_mut().for_each(|angle| *angle = wrapped(*angle));
        }
    });
    assert_contains(&checked, "starts anew after a turn or an overflow");
    assert!(!checked.contains("clock was set"), "{checked}");
}

/// An encoder that restarts counts from a new zero; `check` names it and its time, and no clock.
#[test]
fn an_encoder_that_restarts_is_named() {
    let (error, checked, _) = spoiled(|drive| {
        drive.change("wheel2_angle", |k, x| if k < 400 { x } else { x - 2.0 });
    });
    assert!(error < LIMIT, "{error}");
    assert_contains(&checked, "encoder 2");
    assert_contains(&checked, "a new zero: -2.000 rad at 4.000 s");
    assert!(!checked.contains("clock was set"), "{checked}");
}

/// All encoders that restart at once are no clock that was set: the steps of the stamps are even.
#[test]
fn encoders_that_restart_together_are_no_set_clock() {
    let (error, checked, _) = spoiled(|drive| {
        for wheel in ["wheel1_angle", "wheel2_angle", "wheel3_angle"] {
            let angles = drive.column(wheel);
            let zero = angles[400];
            angles[400..].iter_mut().for_each(|angle| *angle -= zero);
        }
    });
    assert!(error < LIMIT, "{error}");
    assert_contains(&checked, "all encoders count from a new zero at 4.000 s");
    assert!(!checked.contains("clock was set"), "{checked}");
    assert!(checked.ends_with("1 with a fault\n"), "{checked}");
}

/// A single wrong reading of each other channel changes nothing either.
#[test]
fn a_single_wrong_reading_of_any_channel_changes_nothing() {
    for (column, by) in [
        ("link2_rate", -3.0),
        ("link1_rate", 0.5),
        ("link1_inclination", -0.26),
        ("link2_inclination", 1.0),
        ("wheel2_motor_torque", 50.0),
        ("wheel3_motor_torque", -4.0),
    ] {
        let (error, ..) = spoiled(|drive| drive.column(column)[400] += by);
        assert!(error < LIMIT, "{column}: {error}");
    }
}

/// Forces of readings that hold in no model are not in the means, and the first line says so.
#[test]
fn a_flood_of_wrong_forces_is_said_first() {
    let (_, _, said) = spoiled(|drive| {
        // A wheel that seems to be thrown to and fro, for a second: its angle jumps by 14 mrad, which a drive could.
        for k in 400..500 {
            drive.column("wheel2_angle")[k] += if k % 8 < 4 { 0.014 } else { 0.0 };
        }
    });
    let first = said.lines().next().unwrap_or_default();
    assert!(first.contains("WRONG FORCES in"), "{said}");
}

/// Angles that start anew after a turn, or after 16 bits of counts: with `wrap` the log is the clean one; without it
/// the forces are right as well, and `check` asks for it.
#[test]
fn angles_that_start_anew_are_continued() {
    let count = std::f64::consts::TAU / 160_000.0;
    for (unit, in_unit, wrap) in [
        ("deg", 180.0 / std::f64::consts::PI, 360.0),
        ("counts", 1.0 / count, 65_536.0),
    ] {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path();
        let mut drive = LevelDrive::new(1);
        let mut with = "missing = [\"wheel1_contact_angle\", \"wheel2_contact_angle\", \"wheel3_contact_angle\"]\n".to_owned()
            + DESCRIPTION
            + "[reading]\n";
        let mut without = with.clone();
        let names: Vec<String> = drive.columns[1..]
            .iter()
            .map(|(name, _)| name.clone())
            .collect();
        for name in names {
            let mut keys = format!("{name} = {{ column = \"{name}\"");
            if name.ends_with("_angle") {
                let angles = drive.column(&name);
                angles
                    .iter_mut()
                    .for_each(|angle| *angle = (*angle * in_unit).rem_euclid(wrap));
                keys += &format!(", unit = \"{unit}\"");
                if unit == "counts" {
                    keys += ", counts = 160000";
                }
                without += &format!("{keys} }}\n");
                with += &format!("{keys}, wrap = {wrap} }}\n");
            } else {
                without += &format!("{keys} }}\n");
                with += &format!("{keys} }}\n");
            }
        }
        drive.write(&folder.join("log.csv"));
        for (description, faults) in [(&with, "0 with a fault"), (&without, "with a fault")] {
            fs::write(folder.join("d.toml"), description).unwrap();
            let checked = text(&check(folder).stdout);
            assert!(checked.trim_end().ends_with(faults), "{unit}: {checked}");
            let estimated = estimate(folder);
            assert!(estimated.status.success(), "{}", text(&estimated.stderr));
            let error = largest_error(folder);
            assert!(error < LIMIT, "{unit}: {error}");
        }
    }
}

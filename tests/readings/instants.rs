//! The instant of a reading: stamps that err, drives with stamps of their own.

use super::level_drive::{
    LevelDrive, check, estimate, estimate_of, in_the_plane, largest_error, logged, normal, sound,
};
use crate::support::{assert_contains, text};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Stamps that err by 1 ms: `check` measures it by the wheels and says the budget, `estimate` takes it.
/// The description that it writes has it, too. Half of the 1 ms of a stamp is 2 mrad of a wheel, 50 counts: N is known to 3 N at most, the clean
/// log's 2 N and what a slower observer costs.
#[test]
fn the_jitter_of_stamps_is_measured_and_counts() {
    let mut random = normal(7);
    errors_of_a_millisecond_are_measured_and_count(|time| time + 1e-3 * random());
}

/// The same of stamps in whole 3 ms: steps of 9, 9 and 12 ms, whose variance is 2 ms^2, that of two stamps.
#[test]
fn errors_of_stamps_that_repeat_are_measured_and_count() {
    errors_of_a_millisecond_are_measured_and_count(|time| 3e-3 * (time / 3e-3 + 1e-6).floor());
}

fn errors_of_a_millisecond_are_measured_and_count(mut stamp: impl FnMut(f64) -> f64) {
    let dir = logged(&in_the_plane(), |drive| {
        drive.change("time", |k, time| if k > 0 { stamp(time) } else { time });
    });
    let folder = dir.path();
    let checked = text(&check(folder).stdout);
    let remedy = checked
        .lines()
        .find(|line| line.contains("budget.jitter = "));
    let remedy = remedy.unwrap_or_else(|| panic!("{checked}"));
    // 460 steady stamps give the deviation to 3 %.
    assert!(
        ["\"0.9 ms\"", "\"1.0 ms\"", "\"1.1 ms\""]
            .iter()
            .any(|ms| remedy.contains(ms)),
        "{remedy}"
    );
    let estimated = estimate(folder);
    assert_contains(text(&estimated.stderr), "the measured one counts");
    let written = fs::read_to_string(folder.join("out/log.toml")).unwrap();
    let jitter = written
        .lines()
        .find_map(|line| line.strip_prefix("jitter = "));
    let jitter: f64 = (jitter.unwrap().split(' ').next().unwrap().parse()).unwrap();
    assert!((jitter - 1e-3).abs() < 1.5e-4, "{jitter}");
    let error = largest_error(folder);
    assert!(error < 3.0, "{error}");
}

/// A table of some columns of the drive, whose rows are at `start` + k `period`: their values are those of
/// the drive at these times, on straight lines between its rows; counts are of the encoders.
fn table(
    folder: &Path,
    name: &str,
    drive: &mut LevelDrive,
    columns: &[&str],
    start: f64,
    period: f64,
) {
    let mut out = format!("time,{}\n", columns.join(","));
    let mut k = 0_u32;
    loop {
        let time = start + period * f64::from(k);
        let row = (100.0 * time).floor();
        if row >= 600.0 {
            break;
        }
        write!(out, "{time:.6}").unwrap();
        for column in columns {
            let values = drive.column(column);
            let (a, b) = (values[row as usize], values[row as usize + 1]);
            // Noise is of its row; an angle turns in between.
            let share = if column.ends_with("_angle") {
                100.0 * time - row
            } else {
                0.0
            };
            write!(out, ",{}", a + share * (b - a)).unwrap();
        }
        out.push('\n');
        k += 1;
    }
    fs::write(folder.join(name), out).unwrap();
}

/// Three drives with exact stamps of their own rates: a row counts as it was at the time of the frame, so
/// that N errs no more than in one table. With rows at the times of the frames it erred by 34 %.
#[test]
fn drives_with_stamps_of_their_own_give_the_forces() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    let mut drive = LevelDrive::new(1);
    let links = [
        "link1_inclination",
        "link2_inclination",
        "link1_rate",
        "link2_rate",
    ];
    table(folder, "imu.csv", &mut drive, &links, 0.0, 0.01);
    let mut description = String::from("time_base = \"imu\"\n") + &in_the_plane();
    let mut readings = String::from("[reading]\n");
    for name in links {
        writeln!(
            readings,
            "{name} = {{ channel = \"imu\", column = \"{name}\" }}"
        )
        .unwrap();
    }
    let mut channels = String::from("[[channel]]\nname = \"imu\"\ntable = \"imu.csv\"\n");
    for (i, rate) in [(1, 100.0), (2, 99.3), (3, 101.1)] {
        let columns = [format!("wheel{i}_angle"), format!("wheel{i}_motor_torque")];
        let name = format!("drive{i}");
        let start = 0.003 * f64::from(i - 1);
        let names = columns.each_ref().map(String::as_str);
        table(
            folder,
            &format!("{name}.csv"),
            &mut drive,
            &names,
            start,
            1.0 / rate,
        );
        write!(
            channels,
            "[[channel]]\nname = \"{name}\"\ntable = \"{name}.csv\"\n"
        )
        .unwrap();
        for column in columns {
            writeln!(
                readings,
                "{column} = {{ channel = \"{name}\", column = \"{column}\" }}"
            )
            .unwrap();
        }
    }
    description =
        "missing = [\"wheel1_contact_angle\", \"wheel2_contact_angle\", \"wheel3_contact_angle\"]\n"
            .to_owned()
            + &description
            + &channels + &readings;
    fs::write(folder.join("d.toml"), description).unwrap();
    let output = estimate_of(folder, ".");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert_contains(
        &said,
        "ms old at the frames on average, moved to their times",
    );
    let error = largest_error(folder);
    assert!(error < 3.0, "{error}");
}

/// Stamps in whole seconds, or of a clock that is coarser than the rows are apart, are refused by both commands. Of one
/// that is finer the steps differ, and no rows are lost between them.
#[test]
fn a_coarse_clock_is_named() {
    for (tick, is_refused) in [(1.0, true), (1.0 / 64.0, true), (0.004, false)] {
        let dir = logged(&in_the_plane(), |drive| {
            drive.change("time", |_, time| (time / tick + 1e-6).floor() * tick);
        });
        let folder = dir.path();
        for output in [check(folder), estimate(folder)] {
            let said = text(&output.stdout) + &text(&output.stderr);
            let words = "the clock of the stamps is coarser than the rows are apart";
            assert_eq!(said.contains(words), is_refused, "{tick}: {said}");
            assert!(!said.contains("rows are lost"), "{tick}: {said}");
        }
    }
}

/// A table that was joined of drives and inertial sensors, each with rows of its own: each counts at its own times. Known
/// to 3 N, as with tables of their own.
#[test]
fn a_table_may_be_made_of_several() {
    let dir = logged(&in_the_plane(), |drive| {
        let of_rows = |own: usize| move |k: usize, x: f64| if k % 2 == own { x } else { f64::NAN };
        for (end, own) in [
            ("_inclination", 1),
            ("_rate", 1),
            ("_angle", 0),
            ("_torque", 0),
        ] {
            drive.change(end, of_rows(own));
        }
    });
    let folder = dir.path();
    sound(folder);
    let estimated = text(&estimate(folder).stderr);
    assert_contains(&estimated, "was made of 2 tables");
    let error = largest_error(folder);
    assert!(error < 3.0, "{error}");
}

/// Drives that are read at 20 Hz, all at once or one after the other, or gyroscopes, or one inclinometer, whose last
/// reading each row repeats: the rows between count as without, and no encoder is said to have jumped. Known to 3 N,
/// as with stamps that err.
#[test]
fn repeated_readings_count_once() {
    let drives = [1, 2, 3].map(|i| [format!("wheel{i}_angle"), format!("wheel{i}_motor_torque")]);
    let gyroscopes = ["link1_rate", "link2_rate"].map(str::to_owned);
    let drives = drives.as_flattened();
    for (held, one_row_later) in [
        (drives, 0),
        (drives, 1),
        (&gyroscopes, 0),
        (&["link1_inclination".to_owned()], 0),
    ] {
        let dir = logged(&in_the_plane(), |drive| {
            for (i, name) in held.iter().enumerate() {
                let values = drive.column(name);
                for k in 0..values.len() {
                    values[k] = values[k.saturating_sub((k + one_row_later * (i / 2)) % 5)];
                }
            }
        });
        let folder = dir.path();
        sound(folder);
        let estimated = text(&estimate(folder).stderr);
        assert!(
            estimated.contains("new in every 5th row only, at 20 Hz"),
            "{held:?}: {estimated}"
        );
        let error = largest_error(folder);
        assert!(error < 3.0, "{held:?} {one_row_later}: {error}");
    }
}

/// Rows that come in bursts of five, 0.2 ms apart, with the stamps of their arrival, late by up to 4 ms: they count at the
/// times at which they were read, and `check` finds nothing. Known to 3 N, as with stamps of their own.
#[test]
fn rows_of_a_burst_count_at_even_times() {
    let dir = logged(&in_the_plane(), |drive| {
        let times = drive.column("time");
        for k in 0..times.len() {
            let last = (k - k % 5 + 4).min(times.len() - 1);
            let late = 1e-3 * (last / 5 * 7 % 5) as f64;
            times[k] = times[last] + late + 2e-4 * (k % 5) as f64;
        }
    });
    let folder = dir.path();
    let [printed, warned] = sound(folder);
    assert_contains(&warned, "in bursts of 5.0 in the mean");
    assert!(!printed.contains("gap(s)"), "{printed}");
    estimate(folder);
    let error = largest_error(folder);
    assert!(error < 3.0, "{error}");
}

/// Angles with four significant digits get coarser as the wheels turn: the counts are those of the coarsest
/// part. Known to 5 N.
#[test]
fn angles_with_few_digits_have_the_counts_of_the_coarsest_part() {
    let rounded = |_: usize, angle: f64| {
        // Powers of two, as of a float of 11 bits.
        let step = angle.abs().max(1e-3).log2().floor().exp2() / 1024.0;
        (angle / step).round() * step
    };
    let dir = logged(&in_the_plane(), |drive| drive.change("_angle", rounded));
    let folder = dir.path();
    sound(folder);
    let estimated = text(&estimate(folder).stderr);
    assert_contains(&estimated, "as their steps show");
    let error = largest_error(folder);
    assert!(error < 5.0, "{error}");
}

//! Text and units: decimal marks, units in the names of columns, time stamps.

use crate::readings::level_drive::{
    DESCRIPTION, LevelDrive, estimate, largest_error, refused, sound,
};
use crate::support::text;
use std::fmt::Write as _;
use std::fs;

/// Every reading has a column of its name in SI; those of wheel 1 and of the time may have others.
fn described(angle: &str, torque: &str, rate: &str, channel: &str) -> String {
    let mut keys = format!(
        "missing = [\"wheel1_contact_angle\", \"wheel2_contact_angle\", \"wheel3_contact_angle\"]\n{DESCRIPTION}{channel}[reading]\n\
         wheel1_angle = {{ {angle} }}\nwheel1_motor_torque = {{ {torque} }}\nlink1_rate = {{ {rate} }}\n"
    );
    for name in [
        "wheel2_angle",
        "wheel3_angle",
        "wheel2_motor_torque",
        "wheel3_motor_torque",
        "link1_inclination",
        "link2_inclination",
        "link2_rate",
    ] {
        writeln!(keys, "{name} = {{ column = \"{name}\" }}").unwrap();
    }
    keys
}

const ANGLE: &str = "column = \"wheel1_angle\"";
const TORQUE: &str = "column = \"wheel1_motor_torque\"";
const RATE: &str = "column = \"link1_rate\"";

/// The drive as text: cells of each row by a function of column and value.
fn table(drive: &LevelDrive, separator: &str, cell: impl Fn(&str, f64) -> String) -> String {
    let names: Vec<&str> = drive
        .columns
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let mut table = names.join(separator) + "\n";
    for row in 0..drive.columns[0].1.len() {
        let cells = drive
            .columns
            .iter()
            .map(|(name, values)| cell(name, values[row]));
        table += &(cells.collect::<Vec<_>>().join(separator) + "\n");
    }
    table
}

/// A whole number with a separator of thousands.
fn grouped(number: f64, separator: &str) -> String {
    let digits = format!("{:.0}", number.abs());
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out += separator;
        }
        out.push(digit);
    }
    if number < 0.0 { format!("-{out}") } else { out }
}

/// Counts with separators of thousands are refused with their cell, whatever the separator and the decimal mark; the
/// same counts without them are right.
#[test]
fn thousands_separators_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    let counts = format!("{ANGLE}, unit = \"counts\", counts = 2000, gear_ratio = 80");
    fs::write(folder.join("d.toml"), described(&counts, TORQUE, RATE, "")).unwrap();
    let drive = LevelDrive::new(1);
    let write = |separator: &str, point: &str, thousands: &str| {
        let quote = |cell: String| match cell.contains(separator) {
            true => format!("\"{cell}\""),
            false => cell,
        };
        let cell = |name: &str, value: f64| match name {
            "wheel1_angle" => {
                let count = (value * 160_000.0 / std::f64::consts::TAU).round();
                quote(grouped(count, thousands))
            }
            _ => quote(value.to_string().replace('.', point)),
        };
        fs::write(folder.join("log.csv"), table(&drive, separator, cell)).unwrap();
    };
    for (separator, point, thousands) in [
        (",", ".", ","),
        (";", ",", "."),
        (";", ".", ","),
        (",", ".", "'"),
        (";", ",", " "),
        ("\t", ".", "\u{202f}"),
        (",", ".", "_"),
    ] {
        write(separator, point, thousands);
        refused(
            folder,
            "log.csv",
            &["log.csv, line ", "column ", "thousands separators"],
        );
    }
    for (separator, point) in [(",", "."), (";", ","), ("\t", ","), (",", ",")] {
        write(separator, point, "");
        let output = estimate(folder);
        assert!(output.status.success(), "{}", text(&output.stderr));
        // As in the drive's own test.
        assert!(largest_error(folder) < 2.0);
    }
}

/// A unit in a column's name that the description contradicts is refused before anything is read; with the key that
/// states it the log is read.
#[test]
fn units_in_names_are_compared() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    let degrees = 1.0_f64.to_degrees();
    for (name, column, factor, own) in [
        (
            "wheel1_angle",
            "wheel1_angle_deg",
            degrees,
            "unit = \"deg\"",
        ),
        ("wheel1_angle", "angle [deg]", degrees, "unit = \"deg\""),
        ("wheel1_angle", "angle (\u{b0})", degrees, "unit = \"deg\""),
        (
            "wheel1_angle",
            "angle in degrees",
            degrees,
            "unit = \"deg\"",
        ),
        ("wheel1_angle", "angleDeg", degrees, "scale = 0.0174532925"),
        ("wheel1_motor_torque", "torque_mNm", 1e3, "unit = \"mN m\""),
        (
            "wheel1_motor_torque",
            "torque [mN\u{b7}m]",
            1e3,
            "unit = \"mN m\"",
        ),
        ("wheel1_motor_torque", "torque (Ncm)", 1e2, "scale = 0.01"),
        ("link1_rate", "rate_dps", degrees, "unit = \"deg/s\""),
        ("link1_rate", "gyro_deg_s", degrees, "unit = \"deg/s\""),
        ("link1_rate", "rate [\u{b0}/s]", degrees, "unit = \"deg/s\""),
        ("time", "time_ms", 1e3, "time_unit = \"ms\""),
        ("time", "t [us]", 1e6, "time_unit = \"us\""),
        ("time", "stampNs", 1e9, "time_unit = \"ns\""),
    ] {
        let mut drive = LevelDrive::new(1);
        drive
            .column(name)
            .iter_mut()
            .for_each(|value| *value *= factor);
        let place = drive.columns.iter().position(|(other, _)| other == name);
        drive.columns[place.unwrap()].0 = column.to_owned();
        drive.write(&folder.join("log.csv"));
        let describe = |key: &str| {
            let key = if key.is_empty() {
                key.to_owned()
            } else {
                format!(", {key}")
            };
            let with = |of: &str, usual: &str| match of == name {
                true => format!("column = \"{column}\"{key}"),
                false => usual.to_owned(),
            };
            let channel = match name == "time" {
                true => format!(
                    "[[channel]]\nname = \"all\"\ntime = \"{column}\"\n{}\n",
                    key.trim_start_matches(", ")
                ),
                false => String::new(),
            };
            let (angle, torque) = (
                with("wheel1_angle", ANGLE),
                with("wheel1_motor_torque", TORQUE),
            );
            let rate = with("link1_rate", RATE);
            fs::write(
                folder.join("d.toml"),
                described(&angle, &torque, &rate, &channel),
            )
            .unwrap();
        };
        describe("");
        refused(
            folder,
            "log.csv",
            &[&format!("column {column}: its unit is "), "allowed: the `"],
        );
        describe(own);
        sound(folder);
    }
}

/// Stamps in two columns, and dates and times of ISO 8601, are the times that they state: the estimate is that of the
/// same times in seconds.
#[test]
fn stamps_are_read_as_they_are_written() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    fs::write(folder.join("d.toml"), DESCRIPTION).unwrap();
    let drive = LevelDrive::new(1);
    let written = |head: &str, separator: &str, stamp: &dyn Fn(u64) -> String| {
        let cell = |name: &str, value: f64| match name {
            "time" => stamp((value * 100.0).round() as u64 * 10),
            _ => value.to_string(),
        };
        let table = table(&drive, separator, cell).replacen("time", head, 1);
        fs::write(folder.join("log.csv"), table).unwrap();
        let output = estimate(folder);
        assert!(output.status.success(), "{head}: {}", text(&output.stderr));
        fs::read_to_string(folder.join("out/estimate-kalman.csv")).unwrap()
    };
    let seconds = |ms: u64| format!("{}.{:03}", ms / 1000, ms % 1000);
    let expected = written("time", ",", &seconds);
    let whole = |ms: u64| format!("{},{}", 1_714_564_800 + ms / 1000, ms % 1000 * 1_000_000);
    for head in [
        "sec,nanosec",
        "stamp.secs,stamp.nsecs",
        "header.stamp.sec,header.stamp.nanosec",
    ] {
        assert!(written(head, ",", &whole) == expected, "{head}");
    }
    let iso = |ms: u64, mark: &str, zone: &str| {
        format!(
            "2024-05-01T12:00:{:02}{mark}{:03}{zone}",
            ms / 1000,
            ms % 1000
        )
    };
    assert!(written("time", ",", &|ms| iso(ms, ".", "Z")) == expected);
    assert!(written("time", ",", &|ms| iso(ms, ".", "+02:00")) == expected);
    assert!(written("time", ";", &|ms| iso(ms, ",", "").replace('T', " ")) == expected);
    // Names of their own are stated.
    let channel = "[[channel]]\nname = \"all\"\ntime = \"a\"\nnanoseconds = \"b\"\n";
    fs::write(
        folder.join("d.toml"),
        described(ANGLE, TORQUE, RATE, channel),
    )
    .unwrap();
    assert!(written("a,b", ",", &whole) == expected);
    // What is no stamp is refused with its cell.
    let wrong = |ms: u64| format!("{},{}", 1_714_564_800 + ms / 1000, ms % 1000 * 10_000_000);
    let cell = |name: &str, value: f64| match name {
        "time" => wrong((value * 100.0).round() as u64 * 10),
        _ => value.to_string(),
    };
    let spoiled = table(&drive, ",", cell).replacen("time", "a,b", 1);
    fs::write(folder.join("log.csv"), spoiled).unwrap();
    refused(
        folder,
        "log.csv",
        &[
            "log.csv, line 12, column b: found \"1000000000\"",
            "whole nanoseconds",
        ],
    );
}

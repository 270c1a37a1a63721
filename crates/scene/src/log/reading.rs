//! `[reading.NAME]`: readings that are numbers in a column.

use super::rows::{ANY, rows};
use crate::json;
use crate::key::{Form, Key, Number, Words};
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::source::{Entry, Node};
use crate::units::{ANGLE, ANGULAR_RATE, Dimension, NONE, TORQUE};
use serde_json::json;
use std::f64::consts::TAU;

/// Name of the section.
pub(super) const READING: &str = "reading";

/// A reading that is a number in a column.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingChoice {
    /// The reading.
    pub name: &'static str,
    /// Its channel. Empty for the first.
    pub channel: String,
    /// Its column.
    pub column: String,
    /// Factor from the column to the reading in SI.
    pub factor: f64,
    /// Subtracted after that, SI.
    pub offset: f64,
}

/// The readings of a frame, by the columns of the table `sensors`, and their dimensions.
pub const READINGS: [&str; 13] = [
    "wheel1_angle",
    "wheel1_motor_torque",
    "wheel1_contact_angle",
    "wheel2_angle",
    "wheel2_motor_torque",
    "wheel2_contact_angle",
    "wheel3_angle",
    "wheel3_motor_torque",
    "wheel3_contact_angle",
    "link1_inclination",
    "link1_rate",
    "link2_inclination",
    "link2_rate",
];

/// The values of the keys of a reading.
struct ReadingKeys {
    channel: String,
    column: String,
    sign: usize,
    scale: f64,
    gear_ratio: f64,
    counts: f64,
    torque_constant: f64,
}

impl ReadingKeys {
    fn standard() -> Self {
        Self {
            channel: String::new(),
            column: String::new(),
            sign: 0,
            scale: 1.0,
            gear_ratio: 1.0,
            counts: 0.0,
            torque_constant: 0.0,
        }
    }
}

const SIGNS: Words = &["+", "-"];

const READING_KEYS: &[Key<ReadingKeys>] = &[
    Key::text(
        "channel",
        |r| &mut r.channel,
        "name of its channel; the first by default",
    ),
    Key::<ReadingKeys>::text(
        "column",
        |r| &mut r.column,
        "its column; of a topic NAME.position, NAME.effort of a joint",
    )
    .required(),
    Key::own(
        "unit",
        "SI",
        Form {
            words: "of an angle rad, deg, turns, counts; of a torque N m, mN m, A, mA; of a rate rad/s, deg/s",
            schema: || json!({"enum": ["rad", "deg", "turns", "counts", "N m", "mN m", "A", "mA", "rad/s", "deg/s"]}),
        },
        "unit of the column",
    ),
    Key::word(
        "sign",
        SIGNS,
        |r| r.sign,
        |r, i| r.sign = i,
        "minus where the column counts backwards",
    ),
    Key::number(
        "scale",
        NONE,
        above(0.0).at_most(1e12),
        |r| &mut r.scale,
        "further factor",
    ),
    Key::number(
        "gear_ratio",
        NONE,
        above(0.0).at_most(1e6),
        |r| &mut r.gear_ratio,
        "of a wheel's angle and motor torque only, where the column is of the motor: turns of the motor in a turn of the wheel; divides an angle, multiplies a torque",
    ),
    Key::number(
        "counts",
        NONE,
        at_least(0.0).at_most(1e12),
        |r| &mut r.counts,
        "counts in a turn; needed with unit = \"counts\"",
    ),
    Key::number(
        "torque_constant",
        NONE,
        at_least(0.0).at_most(1e6),
        |r| &mut r.torque_constant,
        "torque of the motor for a current, N m/A; needed with unit = \"A\" or \"mA\"",
    ),
    Key::own(
        "offset",
        "0",
        Form {
            words: "a number, or a text with a unit",
            schema: || {
                let units = [ANGLE, TORQUE, ANGULAR_RATE].map(json::with_unit);
                json!({"anyOf": [{"type": "number"}, {"anyOf": units}]})
            },
        },
        "value of the reading where it should be 0, in its SI unit: subtracted last",
    ),
];

/// The rows of the keys, as in [`super::reference`].
pub(super) fn keys() -> Vec<[String; 5]> {
    rows("reading.NAME", READING_KEYS, &mut ReadingKeys::standard())
}

/// JSON Schema of a reading.
pub(super) fn schema() -> serde_json::Value {
    json::table(READING_KEYS, Some(&mut ReadingKeys::standard()))
}

/// Reads the section.
pub(super) fn read(reader: &mut Reader, root: &Node) -> Vec<ReadingChoice> {
    let Some(node) = root.get(READING) else {
        return Vec::new();
    };
    let mut readings = Vec::new();
    for entry in reader.entries(node, READING) {
        match READINGS.iter().find(|name| **name == entry.key) {
            Some(name) => readings.push(reading(reader, name, entry)),
            None => reader.unknown(entry, READING, &READINGS),
        }
    }
    readings
}

/// Dimension of a reading, and its further units with their factors.
fn dimension(name: &str) -> (&'static Dimension, Words) {
    match name {
        name if name.ends_with("_motor_torque") => (TORQUE, &["N m", "mN m", "A", "mA"]),
        name if name.ends_with("_rate") => (ANGULAR_RATE, &["rad/s", "deg/s"]),
        _ => (ANGLE, &["rad", "deg", "turns", "counts"]),
    }
}

fn reading(reader: &mut Reader, name: &'static str, entry: &Entry) -> ReadingChoice {
    let (node, path) = (&entry.node, format!("{READING}.{name}"));
    let mut keys = ReadingKeys::standard();
    reader.table(READING_KEYS, node, &path, &mut keys);
    let (dimension, units) = dimension(name);
    let unit = node
        .get("unit")
        .and_then(|n| reader.word(units, n, &join(&path, "unit")));
    let unit = units[unit.unwrap_or(0)];
    let number = Number {
        unit: dimension,
        range: ANY,
    };
    let offset = node
        .get("offset")
        .and_then(|n| reader.number(&number, n, &join(&path, "offset")));
    let mut needs = |key: &str, value: f64, needed: bool| {
        if needed && value <= 0.0 {
            let at = node.get(key).or(node.get("unit")).unwrap_or(node);
            let allowed = format!("{key} above 0, which unit = \"{unit}\" needs");
            reader.refuse(at, &join(&path, key), &allowed);
        } else if !needed && let Some(found) = node.get(key) {
            let allowed = format!("no {key}: unit = \"{unit}\" does not need it");
            reader.refuse(found, &join(&path, key), &allowed);
        }
    };
    needs("counts", keys.counts, unit == "counts");
    needs("torque_constant", keys.torque_constant, unit.ends_with('A'));
    let is_of_motor =
        name.ends_with("_angle") && !name.contains("contact") || name.ends_with("_motor_torque");
    if !is_of_motor && let Some(found) = node.get("gear_ratio") {
        let allowed = "gear_ratio of a wheel's angle or motor torque only: a gear has no part in other readings";
        reader.refuse(found, &join(&path, "gear_ratio"), allowed);
    }
    ReadingChoice {
        name,
        factor: factor(unit, &keys),
        offset: offset.unwrap_or(0.0),
        channel: keys.channel,
        column: keys.column,
    }
}

fn factor(unit: &str, keys: &ReadingKeys) -> f64 {
    let gear = keys.gear_ratio;
    let of_unit = match unit {
        "deg" => 1.0_f64.to_radians() / gear,
        "turns" => TAU / gear,
        "counts" => TAU / keys.counts / gear,
        "rad" => 1.0 / gear,
        "N m" => gear,
        "mN m" => gear / 1e3,
        "A" => keys.torque_constant * gear,
        "mA" => keys.torque_constant * gear / 1e3,
        "deg/s" => 1.0_f64.to_radians(),
        _ => 1.0,
    };
    let sign = if keys.sign == 1 { -1.0 } else { 1.0 };
    sign * keys.scale * of_unit
}

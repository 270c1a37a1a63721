//! `[reading.NAME]`: readings that are numbers in a column.

use super::by_name::{ANY, ByName};
use crate::form::{dependent, word};
use crate::key::{self, keys};
use crate::quantity::{
    ANGLE, ANGULAR_RATE, Dimension, NONE, TORQUE, above, at_least, number, with_unit,
};
use crate::reader::{Reader, join};
use crate::source::Node;
use crate::values::text;
use serde_json::json;
use std::f64::consts::TAU;

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

/// The readings of a frame, by the columns of the table `sensors`; then those of an IMU in the body
/// and of the angle of pin Q, which may stand in place of those of the links.
pub const READINGS: [&str; 16] = [
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
    "body_inclination",
    "body_rate",
    "pin_angle",
];

/// Whether a reading is of the links, or of the body and pin Q in their place; `None` of the wheels.
pub fn is_of_body(name: &str) -> Option<bool> {
    let of_body = name.starts_with("body") || name.starts_with("pin");
    (of_body || name.starts_with("link")).then_some(of_body)
}

/// The values of the keys of a reading.
struct ReadingKeys {
    channel: String,
    column: String,
    sign: f64,
    scale: f64,
    gear_ratio: f64,
    counts: f64,
    torque_constant: f64,
    /// Unit and offset, whose allowed values depend on the reading.
    of_reading: (),
}

impl ReadingKeys {
    fn standard() -> Self {
        Self {
            channel: String::new(),
            column: String::new(),
            sign: 1.0,
            scale: 1.0,
            gear_ratio: 1.0,
            counts: 0.0,
            torque_constant: 0.0,
            of_reading: (),
        }
    }
}

keys! {
    READING_KEYS: ReadingKeys;

    /// name of its channel; the first by default
    channel: text("a text") => channel;

    /// its column; of a topic NAME.position, NAME.effort of a joint
    column (required): text("a text") => column;

    /// unit of the column
    unit ("SI"): dependent(
        "of an angle rad, deg, turns, counts; of a torque N m, mN m, A, mA; of a rate rad/s, deg/s",
        || json!({"enum": [
            "rad", "deg", "turns", "counts", "N m", "mN m", "A", "mA", "rad/s", "deg/s",
        ]}),
    ) => of_reading;

    /// minus where the column counts backwards
    sign: word(&[1.0, -1.0], |sign| if sign < 0.0 { "-" } else { "+" }) => sign;

    /// further factor
    scale: number(NONE, above(0.0).at_most(1e12)) => scale;

    /// of a wheel's angle and motor torque only, where the column is of the motor: turns of the
    /// motor in a turn of the wheel; divides an angle, multiplies a torque
    gear_ratio: number(NONE, above(0.0).at_most(1e6)) => gear_ratio;

    /// counts in a turn; needed with unit = "counts"
    counts: number(NONE, at_least(0.0).at_most(1e12)) => counts;

    /// torque of the motor for a current, N m/A; needed with unit = "A" or "mA"
    torque_constant: number(NONE, at_least(0.0).at_most(1e6)) => torque_constant;

    /// value of the reading where it should be 0, in its SI unit: subtracted last
    offset ("0"): dependent("a number, or a text with a unit", || {
        let units = [ANGLE, TORQUE, ANGULAR_RATE].map(with_unit);
        json!({"anyOf": [{"type": "number"}, {"anyOf": units}]})
    }) => of_reading;
}

/// `[reading.NAME]`
pub(super) const READING: ByName<ReadingChoice> = ByName {
    names: &READINGS,
    placeholder: "NAME",
    read: reading,
    schema: || key::schema(READING_KEYS, Some(&mut ReadingKeys::standard())),
    rows: |rows, path| key::rows(rows, READING_KEYS, path, &mut ReadingKeys::standard()),
};

/// Dimension of a reading, and its further units with their factors.
fn dimension(name: &str) -> (&'static Dimension, &'static [&'static str]) {
    match name {
        name if name.ends_with("_motor_torque") => (TORQUE, &["N m", "mN m", "A", "mA"]),
        name if name.ends_with("_rate") => (ANGULAR_RATE, &["rad/s", "deg/s"]),
        _ => (ANGLE, &["rad", "deg", "turns", "counts"]),
    }
}

fn reading(reader: &mut Reader, name: &'static str, node: &Node, path: &str) -> ReadingChoice {
    let mut keys = ReadingKeys::standard();
    reader.table(READING_KEYS, node, path, &mut keys);
    let (dimension, units) = dimension(name);
    let unit = node
        .get("unit")
        .and_then(|n| reader.word(units, n, &join(path, "unit")));
    let unit = units[unit.unwrap_or(0)];
    let number = number(dimension, ANY);
    let offset = node
        .get("offset")
        .and_then(|n| reader.number(&number, n, &join(path, "offset")));
    let mut needs = |key: &str, value: f64, needed: bool| {
        if needed && value <= 0.0 {
            let at = node.get(key).or(node.get("unit")).unwrap_or(node);
            let allowed = format!("{key} above 0, which unit = \"{unit}\" needs");
            reader.refuse(at, &join(path, key), &allowed);
        } else if !needed && let Some(found) = node.get(key) {
            let allowed = format!("no {key}: unit = \"{unit}\" does not need it");
            reader.refuse(found, &join(path, key), &allowed);
        }
    };
    needs("counts", keys.counts, unit == "counts");
    needs("torque_constant", keys.torque_constant, unit.ends_with('A'));
    let is_of_motor =
        name.ends_with("_angle") && !name.contains("contact") || name.ends_with("_motor_torque");
    if !is_of_motor && let Some(found) = node.get("gear_ratio") {
        let allowed = "gear_ratio of a wheel's angle or motor torque only: a gear has no part in other readings";
        reader.refuse(found, &join(path, "gear_ratio"), allowed);
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
    keys.sign * keys.scale * of_unit
}

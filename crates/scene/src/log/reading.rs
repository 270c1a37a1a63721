//! `[reading.NAME]`: readings that are numbers in a column.

use crate::form::{Form, KeyReference, dependent, object, word};
use crate::key::{self, Key, keys};
use crate::quantity::{
    ANGLE, ANGULAR_RATE, Dimension, NONE, Range, TORQUE, above, at_least, number, with_unit,
};
use crate::reader::{Reader, join};
use crate::source::Node;
use crate::values::text;
use serde_json::{Value as Json, json};
use std::f64::consts::TAU;

/// Any number that is not absurd.
pub(super) const ANY: Range = at_least(-1e12).at_most(1e12);

/// Tables by the names of what they describe.
pub(super) struct ByName<C: 'static> {
    pub names: &'static [&'static str],
    /// Stands for a name in tables of keys.
    pub placeholder: &'static str,
    pub keys: &'static [Key<C>],
    /// What has a name, before its keys are read.
    pub start: fn(&'static str) -> C,
    /// Checks and completes it.
    pub check: fn(&mut Reader, &Node, &str, &mut C),
}

impl<C> Form for ByName<C> {
    type Value = Vec<C>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<C>) {
        for entry in reader.entries(node, path) {
            match self.names.iter().find(|name| **name == entry.key) {
                Some(name) => {
                    let (path, mut value) = (join(path, name), (self.start)(name));
                    reader.table(self.keys, &entry.node, &path, &mut value);
                    (self.check)(reader, &entry.node, &path, &mut value);
                    into.push(value);
                }
                None => reader.unknown(entry, path, self.names),
            }
        }
    }

    fn schema(&self, _defaults: Option<&mut Vec<C>>) -> Json {
        let table = key::schema(self.keys, Some(&mut (self.start)("")));
        let table = |name: &&str| ((*name).to_owned(), table.clone());
        object(self.names.iter().map(table).collect(), &[])
    }

    fn is_section(&self) -> bool {
        true
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Vec<C>) {
        let path = join(path, self.placeholder);
        key::rows(rows, self.keys, &path, &mut (self.start)(""));
    }
}

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
    // The values of its keys.
    sign: f64,
    scale: f64,
    gear_ratio: f64,
    counts: f64,
    torque_constant: f64,
    /// Unit and offset, whose allowed values depend on the reading.
    of_reading: (),
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

keys! {
    READING_KEYS: ReadingChoice;

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
    keys: READING_KEYS,
    start: |name| ReadingChoice {
        name,
        channel: String::new(),
        column: String::new(),
        factor: 1.0,
        offset: 0.0,
        sign: 1.0,
        scale: 1.0,
        gear_ratio: 1.0,
        counts: 0.0,
        torque_constant: 0.0,
        of_reading: (),
    },
    check,
};

/// Dimension of a reading, and its further units with their factors.
fn dimension(name: &str) -> (&'static Dimension, &'static [&'static str]) {
    match name {
        name if name.ends_with("_motor_torque") => (TORQUE, &["N m", "mN m", "A", "mA"]),
        name if name.ends_with("_rate") => (ANGULAR_RATE, &["rad/s", "deg/s"]),
        _ => (ANGLE, &["rad", "deg", "turns", "counts"]),
    }
}

fn check(reader: &mut Reader, node: &Node, path: &str, reading: &mut ReadingChoice) {
    let name = reading.name;
    let (dimension, units) = dimension(name);
    let unit = node.get("unit");
    let unit = unit.and_then(|n| reader.word(units, n, &join(path, "unit")));
    let unit = units[unit.unwrap_or(0)];
    let number = number(dimension, ANY);
    let offset = node.get("offset");
    let offset = offset.and_then(|n| reader.number(&number, n, &join(path, "offset")));
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
    needs("counts", reading.counts, unit == "counts");
    let is_current = unit.ends_with('A');
    needs("torque_constant", reading.torque_constant, is_current);
    let is_of_motor =
        name.ends_with("_angle") && !name.contains("contact") || name.ends_with("_motor_torque");
    if !is_of_motor && let Some(found) = node.get("gear_ratio") {
        let allowed = "gear_ratio of a wheel's angle or motor torque only: a gear has no part in other readings";
        reader.refuse(found, &join(path, "gear_ratio"), allowed);
    }
    reading.factor = factor(unit, reading);
    reading.offset = offset.unwrap_or(0.0);
}

fn factor(unit: &str, keys: &ReadingChoice) -> f64 {
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

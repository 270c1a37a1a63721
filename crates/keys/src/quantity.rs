//! Numbers: unit and range, read, written and described. A bare number is SI, a text such as
//! `"20 cm/s"` carries its own unit.

use crate::error::Problem;
use crate::form::{About, Array, Form};
use crate::reader::Reader;
use crate::source::{Node, Value};
use serde_json::{Value as Json, json};
use std::fmt;

/// The units in which a key may be written: SI first. None for a pure number.
pub struct Dimension {
    /// Names of the units.
    pub names: &'static [&'static str],
    /// How a number in each becomes SI.
    to_si: &'static [fn(f64) -> f64],
}

// Sub-units divide: 35 cm is then exactly the double 0.35, which 35 * 0.01 is not.
macro_rules! dimension {
    ($name:ident: $si:literal $(, $unit:literal => $to_si:expr)*) => {
        #[doc = concat!("In ", $si, $(", ", $unit,)* ".")]
        pub const $name: &Dimension = &Dimension {
            names: &[$si $(, $unit)*],
            to_si: &[|v| v $(, $to_si)*],
        };
    };
}

/// A pure number.
pub const NONE: &Dimension = &Dimension {
    names: &[],
    to_si: &[],
};
dimension!(LENGTH: "m", "cm" => |v| v / 1e2, "mm" => |v| v / 1e3, "um" => |v| v / 1e6);
dimension!(TIME: "s", "ms" => |v| v / 1e3, "us" => |v| v / 1e6);
dimension!(ANGLE: "rad", "deg" => f64::to_radians);
dimension!(SPEED: "m/s", "cm/s" => |v| v / 1e2, "mm/s" => |v| v / 1e3, "km/h" => |v| v * 1e3 / 3600.0);
dimension!(FREQUENCY: "Hz", "kHz" => |v| v * 1e3);
dimension!(ANGULAR_FREQUENCY: "rad/s");
dimension!(ANGULAR_RATE: "rad/s", "deg/s" => f64::to_radians);
dimension!(RATE_WALK: "rad/s/sqrt(s)", "deg/s/sqrt(s)" => f64::to_radians);
dimension!(MASS: "kg", "g" => |v| v / 1e3);
dimension!(INERTIA: "kg m^2", "kg cm^2" => |v| v / 1e4, "g cm^2" => |v| v / 1e7);
dimension!(FORCE: "N", "mN" => |v| v / 1e3, "kN" => |v| v * 1e3);
dimension!(TORQUE: "N m", "mN m" => |v| v / 1e3);
dimension!(TORQUE_RATE: "N m/s", "mN m/s" => |v| v / 1e3);
dimension!(DAMPING: "N s/m", "N s/mm" => |v| v * 1e3);
dimension!(ROTARY_DAMPING: "N m s", "mN m s" => |v| v / 1e3);
dimension!(STOP_STIFFNESS: "N m/rad", "N m/deg" => f64::to_degrees);
dimension!(STOP_DAMPING: "N m s/rad", "N m s/deg" => f64::to_degrees);
// Its unit depends on the exponent n, so that no other one is offered.
dimension!(CONTACT_STIFFNESS: "N/m^n");

/// Longest text that is parsed as a unit, bytes.
const LONGEST_UNIT: usize = 200;

impl Dimension {
    /// Name of the SI unit; empty for a pure number.
    pub fn si(&self) -> &'static str {
        self.names.first().copied().unwrap_or_default()
    }
}

/// The longest start of a text that is a number, and what follows it; infinite where the number is
/// too large for a double.
fn leading_number(text: &str) -> Option<(f64, &str)> {
    /// No number that means anything is written with more characters.
    const LONGEST: usize = 400;
    // No `inf`, `nan` or `infinity`: digits only.
    let is_plain = |c: char| "0123456789+-.eE".contains(c);
    let plain = text.find(|c| !is_plain(c)).unwrap_or(text.len());
    if plain > LONGEST {
        return None;
    }
    (0..=plain).rev().find_map(|end| {
        let (number, rest) = text.split_at(end);
        Some((number.parse::<f64>().ok()?, rest))
    })
}

/// The numbers that a key takes, SI: between two ends, each with whether it belongs to them. Never
/// an infinite one or a NaN.
#[derive(Clone, Copy)]
pub struct Range {
    /// The lower end, and whether it belongs to the range.
    pub low: (f64, bool),
    /// The upper end, and whether it belongs to the range.
    pub high: (f64, bool),
}

/// The lower end of a range.
pub struct LowerEnd(f64, bool);

/// Above a number.
pub const fn above(low: f64) -> LowerEnd {
    LowerEnd(low, false)
}

/// A number or more.
pub const fn at_least(low: f64) -> LowerEnd {
    LowerEnd(low, true)
}

impl LowerEnd {
    /// And at most `high`.
    pub const fn at_most(self, high: f64) -> Range {
        Range {
            low: (self.0, self.1),
            high: (high, true),
        }
    }

    /// And below `high`.
    pub const fn below(self, high: f64) -> Range {
        Range {
            high: (high, false),
            ..self.at_most(high)
        }
    }
}

impl Range {
    /// Whether a number lies in it.
    pub fn contains(self, value: f64) -> bool {
        let is_within = |distance: f64, included| distance > 0.0 || included && distance == 0.0;
        value.is_finite()
            && is_within(value - self.low.0, self.low.1)
            && is_within(self.high.0 - value, self.high.1)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let low = ["above", "of at least"][usize::from(self.low.1)];
        let high = ["below", "at most"][usize::from(self.high.1)];
        let (least, most) = (short(self.low.0), short(self.high.0));
        write!(f, "{low} {least} and {high} {most}")
    }
}

/// A number with three digits, for messages.
pub fn rounded(value: f64) -> String {
    short(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A number in its short form: `0.2`, `20000`, `1.5e-4`. Reads back as the same number.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// The unit and range of a number.
#[derive(Clone, Copy)]
pub struct Number {
    /// The unit.
    pub unit: &'static Dimension,
    /// The allowed numbers, SI.
    pub range: Range,
}

/// A number of a unit, in a range in SI.
pub const fn number(unit: &'static Dimension, range: Range) -> Number {
    Number { unit, range }
}

impl Number {
    /// `a number above 0, in N m`
    pub fn allowed(&self) -> String {
        match self.unit.si() {
            "" => format!("a number {}", self.range),
            si => format!("a number {}, in {si}", self.range),
        }
    }

    /// The same, with the units that a text may have.
    pub(crate) fn allowed_in_full(&self) -> String {
        let (allowed, units) = (self.allowed(), self.unit.names.join(", "));
        match units.is_empty() {
            true => allowed,
            false => format!("{allowed}, or a text with a unit ({units})"),
        }
    }

    /// The SI value of a text such as `20 cm/s`; the error says what was `found` and what is
    /// allowed.
    pub fn parse(&self, text: &str, found: &str) -> Result<f64, String> {
        let (full, names) = (self.allowed_in_full(), self.unit.names);
        let Some((number, rest)) = leading_number(text.trim()) else {
            return Err(format!("found {found}, allowed: {full}"));
        };
        if number.is_infinite() {
            // Too large for a double: the same message as for a bare number.
            return Err(format!("found {found}, allowed: {}", self.allowed()));
        }
        let unit = match rest.len() > LONGEST_UNIT {
            true => "...".to_owned(),
            false => rest.split_whitespace().collect::<Vec<_>>().join(" "),
        };
        match names.iter().position(|name| *name == unit) {
            Some(i) => Ok((self.unit.to_si[i])(number)),
            None if unit.is_empty() => Err(format!(
                "found {found}, a text without a unit, allowed: {full}"
            )),
            None if names.is_empty() => Err(format!(
                "found {found} with the unit {unit}, allowed: {full}, without a unit"
            )),
            None => {
                let units = names.join(", ");
                Err(format!(
                    "found {found} with the unit {unit}, allowed units: {units}"
                ))
            }
        }
    }
}

impl Form for Number {
    type Value = f64;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut f64) {
        if let Some(value) = reader.number(self, node, path) {
            *into = value;
        }
    }

    /// The shortest decimal that reads back as the same bits.
    fn text(&self, value: &mut f64) -> Option<String> {
        Some(format!("{value:?}"))
    }

    fn about(&self) -> About {
        let range = self.range.to_string();
        About {
            allowed: self.allowed_in_full(),
            values: range.trim_start_matches("of ").to_owned(),
            units: self.unit.names,
        }
    }

    /// A number in its range, or a text of a number and a unit. The range of such a text is not in
    /// the schema.
    fn schema(&self, _defaults: Option<&mut f64>) -> Json {
        let bare = bounded(self);
        match self.unit.names.is_empty() {
            true => bare,
            false => json!({"anyOf": [bare, with_unit(self.unit)]}),
        }
    }
}

impl Reader {
    /// A number in SI, within its range.
    pub fn number(&mut self, number: &Number, node: &Node, path: &str) -> Option<f64> {
        let value = match &node.value {
            Value::Float(value) | Value::Integer(_, value) => *value,
            Value::Text(text) => {
                let value = number.parse(text, &node.origin.found());
                self.keep(value.map_err(|message| Problem::at(&node.origin, path, message)))?
            }
            _ => {
                self.refuse(node, path, &number.allowed_in_full());
                return None;
            }
        };
        if number.range.contains(value) {
            return Some(value);
        }
        self.refuse(node, path, &number.allowed());
        None
    }
}

/// A point `[x, y]` of any type that shows its coordinates as an array, in a range, SI.
pub const fn point<V: AsMut<[f64; 2]>>(number: Number) -> Array<Number, V> {
    Array {
        item: number,
        words: "[x, y], each {}",
        count: [2; 2],
        items: |point| point.as_mut(),
        written: |_| 2,
    }
}

/// A text of a number, as the reader takes it, and a unit.
pub fn with_unit(unit: &Dimension) -> Json {
    const NUMBER: &str = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?";
    let units: Vec<String> = unit.names.iter().map(|name| escaped(name)).collect();
    let pattern = format!(r"^\s*{NUMBER}\s*({})\s*$", units.join("|"));
    json!({"type": "string", "pattern": pattern})
}

/// The name of a unit as a regular expression; any blanks between its parts.
fn escaped(unit: &str) -> String {
    let escape = |c: char| match c {
        ' ' => r"\s+".to_owned(),
        c if c.is_ascii_alphanumeric() => c.to_string(),
        c => format!("\\{c}"),
    };
    unit.chars().map(escape).collect()
}

/// A number in its range.
fn bounded(number: &Number) -> Json {
    let mut schema = json!({"type": "number"});
    let names = [
        ["exclusiveMinimum", "minimum"],
        ["exclusiveMaximum", "maximum"],
    ];
    let ends = [number.range.low, number.range.high];
    for ((at, included), names) in ends.into_iter().zip(names) {
        schema[names[usize::from(included)]] = json!(at);
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_literally() {
        assert_eq!(escaped(RATE_WALK.si()), r"rad\/s\/sqrt\(s\)");
        assert_eq!(escaped(INERTIA.si()), r"kg\s+m\^2");
    }

    fn parse(unit: &'static Dimension, text: &str) -> Result<f64, String> {
        number(unit, at_least(-1e9).at_most(1e9)).parse(text, "it")
    }

    #[test]
    fn units_become_si() {
        assert_eq!(parse(SPEED, "20 cm/s"), Ok(0.2));
        assert_eq!(parse(SPEED, "0.72 km/h"), Ok(0.2));
        assert_eq!(parse(ANGLE, "-40 deg"), Ok((-40.0_f64).to_radians()));
        assert_eq!(parse(LENGTH, "0.1 mm"), Ok(1e-4));
        assert_eq!(parse(FREQUENCY, "1 kHz"), Ok(1000.0));
        assert_eq!(parse(TIME, "0.1 ms"), Ok(1e-4));
        assert_eq!(parse(TIME, "1.5e2us"), Ok(1.5e-4));
        assert_eq!(parse(TORQUE, " 1e1   N  m "), Ok(10.0));
        assert_eq!(parse(DAMPING, "20 N s/mm"), Ok(2e4));
        assert_eq!(parse(INERTIA, "135 g cm^2"), Ok(135e-7));
    }

    /// Decimal sub-units give the very double that the same length in metres gives.
    #[test]
    fn decimal_units_round_once() {
        for i in 0..1000 {
            let metres: f64 = format!("{}.{:02}", i / 100, i % 100).parse().unwrap();
            assert_eq!(parse(LENGTH, &format!("{i} cm")), Ok(metres));
        }
    }

    #[test]
    fn what_is_no_number_with_a_unit_is_refused() {
        let allowed = "allowed: a number of at least -1e9 and at most 1e9";
        let of_length = format!("{allowed}, in m, or a text with a unit (m, cm, mm, um)");
        let of_speed = format!("found it, {allowed}, in m/s");
        for (unit, text, message) in [
            (LENGTH, "abc", format!("found it, {of_length}")),
            (LENGTH, "", format!("found it, {of_length}")),
            (LENGTH, "inf m", format!("found it, {of_length}")),
            (
                LENGTH,
                "3",
                format!("found it, a text without a unit, {of_length}"),
            ),
            (SPEED, "1e400 m/s", of_speed.clone()),
            (SPEED, "-1e400", of_speed),
            (
                LENGTH,
                "3 kg",
                "found it with the unit kg, allowed units: m, cm, mm, um".to_owned(),
            ),
            (
                NONE,
                "3 m",
                format!("found it with the unit m, {allowed}, without a unit"),
            ),
        ] {
            assert_eq!(parse(unit, text), Err(message), "{text}");
        }
    }

    #[test]
    fn ends_are_in_or_out_as_the_text_says() {
        let range = above(0.0).at_most(1.5e-4);
        assert_eq!(range.to_string(), "above 0 and at most 1.5e-4");
        assert!(!range.contains(0.0) && range.contains(1e-300));
        assert!(range.contains(1.5e-4) && !range.contains(1.6e-4));
        let range = at_least(0.0).below(1.0);
        assert_eq!(range.to_string(), "of at least 0 and below 1");
        assert!(range.contains(0.0) && !range.contains(1.0));
        assert!(!range.contains(f64::INFINITY) && !range.contains(f64::NAN));
    }
}

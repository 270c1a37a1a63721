//! One axis of a study.

use crate::load::reference;
use crate::overrides::{Step, steps};
use crate::quantity::short;
use crate::source::{Node, Origin, Value};
use std::fmt;

/// An axis: keys of the scene that vary together.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Dotted keys, as `--set` takes them. More than one vary together.
    pub keys: Vec<String>,
    /// Their values.
    pub values: AxisValues,
    /// Where the values were written.
    pub(super) origin: Origin,
}

/// The values of an axis.
#[derive(Clone, Debug)]
pub enum AxisValues {
    /// One item a value; each with one value a key.
    List(Vec<AxisItem>),
    /// `count` whole numbers from `first` on.
    Whole {
        /// The first.
        first: i64,
        /// Their number, at least 1.
        count: u64,
    },
    /// Drawn: see [`super::Draws`].
    Drawn(Distribution),
}

/// The values of all keys of an axis at one place of its list.
#[derive(Clone, Debug)]
pub struct AxisItem {
    /// Its name in the dataset, in place of the value of the first key.
    pub name: Option<String>,
    /// One a key.
    pub values: Vec<AxisValue>,
    pub(super) origin: Origin,
}

/// The distribution of a drawn axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Uniform between two numbers.
    Uniform(f64, f64),
    /// The logarithm is uniform, between two positive numbers.
    LogUniform(f64, f64),
    /// Normal, with mean and standard deviation.
    Normal(f64, f64),
    /// Whole numbers from the first to the last, equally likely.
    Whole(i64, i64),
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisValue {
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// True or false.
    Boolean(bool),
    /// An array or a table, as TOML.
    Toml(String),
}

impl AxisValue {
    /// `None` for what no key takes.
    pub(super) fn of(node: &Node) -> Option<Self> {
        Some(match &node.value {
            Value::Integer(Some(whole), _) => Self::Whole(i64::try_from(*whole).ok()?),
            Value::Float(number) if number.is_finite() => Self::Number(*number),
            Value::Text(text) => Self::Text(text.clone()),
            Value::Boolean(value) => Self::Boolean(*value),
            Value::Array(_) | Value::Table(_) => Self::Toml(node.origin.text().to_owned()),
            Value::Integer(None, _) | Value::Float(_) | Value::Other(_) => return None,
        })
    }
}

/// As TOML, which reads back as the same value.
impl fmt::Display for AxisValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Number(number) => f.write_str(&short(*number)),
            Self::Text(text) => write!(f, "{}", toml::Value::String(text.clone())),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Toml(text) => f.write_str(text),
        }
    }
}

impl Axis {
    /// Number of values; `None` for a drawn axis.
    pub fn length(&self) -> Option<u64> {
        match &self.values {
            AxisValues::List(items) => Some(items.len() as u64),
            AxisValues::Whole { count, .. } => Some(*count),
            AxisValues::Drawn(_) => None,
        }
    }

    /// Whether its values are drawn.
    pub fn is_drawn(&self) -> bool {
        matches!(self.values, AxisValues::Drawn(_))
    }

    /// SI unit of a bare number of a key, empty where it has none or the key is unknown.
    pub fn unit(key: &str) -> &'static str {
        let step = |step: Step<'_>| match step {
            Step::Key(name) => format!(".{name}"),
            Step::Index(_) => "[]".to_owned(),
        };
        let steps = steps(key).unwrap_or_default().into_iter().map(step);
        // As in the reference: `estimator[].observer_pole`.
        let pattern = steps.collect::<String>();
        let pattern = pattern.trim_start_matches('.');
        let rows = reference();
        let row = rows.iter().find(|row| row.key == pattern);
        row.map_or("", |row| row.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_find_their_units() {
        assert_eq!(Axis::unit("drive.speed"), "m/s");
        assert_eq!(Axis::unit("estimator.0.observer_pole"), "rad/s");
        assert_eq!(Axis::unit("estimator[2].observer_pole"), "rad/s");
        assert_eq!(Axis::unit("no.such.key"), "");
    }

    /// Numbers keep their bits on the way through an override; texts are quoted.
    #[test]
    fn values_are_toml() {
        for number in [0.1 + 0.2, 1e-300, 12345.678, -0.0, 1e22] {
            let text = AxisValue::Number(number).to_string();
            let back: f64 = text.parse().expect("a number");
            assert_eq!(back.to_bits(), number.to_bits(), "{text}");
        }
        assert_eq!(AxisValue::Text("5 deg".into()).to_string(), "\"5 deg\"");
    }
}

//! Keys whose values do not go together.

use crate::quantity::short;
use std::borrow::Cow;

/// A key and its value as text, for messages.
pub type Value = (Cow<'static, str>, String);

/// Keys whose values do not go together, and what is allowed.
pub struct Conflict {
    /// The keys, the one to blame first.
    pub keys: Vec<Value>,
    /// What is allowed.
    pub rule: String,
}

impl Conflict {
    /// What was found and what is allowed.
    pub fn message(&self) -> String {
        let keys = self.keys.iter();
        let found: Vec<String> = keys
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        format!("found {}, allowed: {}", found.join(" and "), self.rule)
    }
}

/// Keys that do not go together, the one to blame first, and what is allowed.
pub fn conflict(keys: impl Into<Vec<Value>>, rule: impl Into<String>) -> Conflict {
    Conflict {
        keys: keys.into(),
        rule: rule.into(),
    }
}

/// A key and its number.
pub fn valued(key: &'static str, value: f64) -> Value {
    (key.into(), short(value))
}

/// A key and its word.
pub fn named(key: &'static str, value: &str) -> Value {
    (key.into(), format!("\"{value}\""))
}

/// A limit in a message, rounded down to three digits, so that what a message allows is allowed; 0
/// for a limit that is not positive.
pub fn floor(limit: f64) -> String {
    // This comparison is false for NaN, which becomes 0 too.
    match limit > 0.0 {
        true => short(rounded_down(limit)),
        false => "0".to_owned(),
    }
}

/// A positive number rounded down to three digits.
fn rounded_down(value: f64) -> f64 {
    let digits = 2 - value.log10().floor() as i32;
    // Dividing by a power of ten rounds once; multiplying by its inverse would round twice.
    let scale = 10.0_f64.powi(digits.abs());
    match digits >= 0 {
        true => (value * scale).floor() / scale,
        false => (value / scale).floor() * scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Never above the number, and never zero, whatever its size.
    #[test]
    fn limits_are_rounded_down() {
        for (value, expected) in [
            (1.5e-4, 1.5e-4),
            (1.239e-5, 1.23e-5),
            (3e-10, 3e-10),
            (2.9999e-13, 2.99e-13),
            (0.999_99, 0.999),
            (12_345.0, 12_300.0),
        ] {
            let found = rounded_down(value);
            assert!(
                found <= value && (found - expected).abs() < 1e-12 * expected,
                "{found}"
            );
        }
    }
}

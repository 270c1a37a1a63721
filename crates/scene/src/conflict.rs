//! Keys whose values do not go together.

use crate::quantity::short;

/// A key and its value as text, for messages.
pub(crate) type Value = (&'static str, String);

/// Keys whose values do not go together, and what is allowed.
pub(crate) struct Conflict {
    /// The keys, the one to blame first.
    pub keys: Vec<Value>,
    /// What is allowed.
    pub rule: String,
}

impl Conflict {
    /// What was found and what is allowed.
    pub fn message(&self) -> String {
        let found: Vec<String> = self
            .keys
            .iter()
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        format!("found {}, allowed: {}", found.join(" and "), self.rule)
    }
}

/// Keys that do not go together, the one to blame first, and what is allowed.
pub(crate) fn conflict(keys: impl Into<Vec<Value>>, rule: impl Into<String>) -> Conflict {
    Conflict {
        keys: keys.into(),
        rule: rule.into(),
    }
}

/// A key and its number.
pub(crate) fn valued(key: &'static str, value: f64) -> Value {
    (key, short(value))
}

/// A key and its word.
pub(crate) fn named(key: &'static str, value: &str) -> Value {
    (key, format!("\"{value}\""))
}

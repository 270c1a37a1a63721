//! Parts of JSON Schema.

use crate::quantity::{Dimension, Number};
use serde_json::{Map, Value as Json, json};

/// JSON Schema of a table with these properties and no others.
pub(crate) fn object(properties: Map<String, Json>, required: &[&str]) -> Json {
    let mut object = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    });
    if !required.is_empty() {
        object["required"] = json!(required);
    }
    object
}

/// JSON Schema of a list of at least `least` and at most `most` items.
pub(crate) fn items(item: Json, least: usize, most: usize) -> Json {
    json!({"type": "array", "items": item, "minItems": least, "maxItems": most})
}

/// A text of a number, as the reader takes it, and a unit.
pub(crate) fn with_unit(unit: &Dimension) -> Json {
    const NUMBER: &str = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?";
    let units: Vec<String> = unit.names.iter().map(|name| escaped(name)).collect();
    let pattern = format!(r"^\s*{NUMBER}\s*({})\s*$", units.join("|"));
    json!({"type": "string", "pattern": pattern})
}

/// The name of a unit as a regular expression; any blanks between its parts.
fn escaped(unit: &str) -> String {
    let mut out = String::new();
    for c in unit.chars() {
        match c {
            ' ' => out += r"\s+",
            c if c.is_ascii_alphanumeric() => out.push(c),
            c => out.extend(['\\', c]),
        }
    }
    out
}

/// A number in its range.
pub(crate) fn bounded(number: &Number) -> Json {
    let mut schema = json!({"type": "number"});
    let names = [
        ["exclusiveMinimum", "minimum"],
        ["exclusiveMaximum", "maximum"],
    ];
    for (end, names) in [number.range.low, number.range.high].into_iter().zip(names) {
        if let Some((at, included)) = end {
            schema[names[usize::from(included)]] = json!(at);
        }
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{INERTIA, RATE_WALK};

    #[test]
    fn units_are_taken_literally() {
        assert_eq!(escaped(RATE_WALK.si()), r"rad\/s\/sqrt\(s\)");
        assert_eq!(escaped(INERTIA.si()), r"kg\s+m\^2");
    }
}

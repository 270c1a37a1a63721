//! JSON Schema of tables and values, from the declarations of their keys.

use crate::key::{Field, Key, Number, SWITCH, Words};
use crate::range::Range;
use crate::units::Dimension;
use robhaz_estimator::statics::LOAD_PARAMETERS;
use serde_json::{Map, Value, json};

/// A number at the start of a text, as the reader takes it.
const NUMBER: &str = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?";

/// A table with these keys and no others; with the defaults that the keys have in `defaults`.
pub(crate) fn table<T>(keys: &[Key<T>], defaults: Option<&mut T>) -> Value {
    object(properties(keys, defaults), &required(keys))
}

/// A table with these properties and no others.
pub(crate) fn object(properties: Map<String, Value>, required: &[&str]) -> Value {
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

/// The names of the keys without a default.
pub(crate) fn required<T>(keys: &[Key<T>]) -> Vec<&'static str> {
    let required = keys.iter().filter(|k| k.required);
    required.map(|k| k.name).collect()
}

/// The schema of each key.
pub(crate) fn properties<T>(keys: &[Key<T>], mut defaults: Option<&mut T>) -> Map<String, Value> {
    let property = |key: &Key<T>| {
        let schema = property(key, defaults.as_deref_mut());
        (key.name.to_owned(), schema)
    };
    keys.iter().map(property).collect()
}

fn property<T>(key: &Key<T>, mut defaults: Option<&mut T>) -> Value {
    let mut schema = match &key.field {
        Field::Table(keys) => table(keys, defaults.as_deref_mut()),
        field => of_field(field),
    };
    let mut meaning = key.meaning.to_owned();
    if !key.field.unit().is_empty() {
        meaning += &format!(". Unit: {}", key.field.unit());
    }
    if let Field::Own { default, .. } | Field::OwnWord { default, .. } = &key.field
        && !default.is_empty()
    {
        meaning += &format!(". Default: {default}");
    }
    schema["description"] = json!(meaning);
    let default = defaults.filter(|_| !key.required);
    if let Some(default) = default.and_then(|d| default_of(&key.field, d)) {
        schema["default"] = default;
    }
    schema
}

/// The default of a number, switch or word. Others follow from other keys.
fn default_of<T>(field: &Field<T>, of: &mut T) -> Option<Value> {
    Some(match field {
        Field::Number(_, at) => json!(*at(of)),
        Field::Count(_, get, _) => json!(get(of)),
        Field::Switch(at) => json!(SWITCH[usize::from(*at(of))]),
        Field::Word(words, get, _) => json!(words[get(of)]),
        _ => return None,
    })
}

fn of_field<T>(field: &Field<T>) -> Value {
    match field {
        Field::Number(n, _) => number(n),
        Field::Count(n, ..) => {
            let mut count = bounded("integer", n.range);
            count["minimum"] = json!(1);
            count
        }
        Field::Three(n, _) => array(number(n), 3, 3),
        Field::Point(n, _) => array(number(n), 2, 2),
        Field::ThreePoints(n, _) => array(array(number(n), 2, 2), 3, 3),
        Field::Switch(_) => switch(),
        Field::Word(words, ..) | Field::OwnWord { words, .. } => word(words),
        Field::ThreeWords(words, ..) => array(word(words), 3, 3),
        Field::LoadCovariance(_) => {
            let row = array(json!({"type": "number"}), LOAD_PARAMETERS, LOAD_PARAMETERS);
            array(row, LOAD_PARAMETERS, LOAD_PARAMETERS)
        }
        Field::Text(_) => text(),
        Field::Table(keys) => table(keys, None),
        Field::Own { form, .. } => (form.schema)(),
    }
}

/// One of a few words.
pub(crate) fn word(words: Words) -> Value {
    json!({"enum": words})
}

/// `"off"` or `"on"`, or a boolean.
pub(crate) fn switch() -> Value {
    json!({"enum": ["off", "on", false, true]})
}

/// A text with at least one character that is no blank.
pub(crate) fn text() -> Value {
    json!({"type": "string", "pattern": r"\S"})
}

/// A list of at least `least` and at most `most` items.
pub(crate) fn array(item: Value, least: usize, most: usize) -> Value {
    json!({"type": "array", "items": item, "minItems": least, "maxItems": most})
}

/// A number in its range, or a text of a number and a unit. The range of such a text is not in the schema.
pub(crate) fn number(number: &Number) -> Value {
    let bare = bounded("number", number.range);
    match number.unit.units.is_empty() {
        true => bare,
        false => json!({"anyOf": [bare, with_unit(number.unit)]}),
    }
}

/// A text of a number and a unit.
pub(crate) fn with_unit(unit: &Dimension) -> Value {
    let units: Vec<String> = unit.units.iter().map(|u| escaped(u.name)).collect();
    json!({
        "type": "string",
        "pattern": format!(r"^\s*{NUMBER}\s*({})\s*$", units.join("|")),
    })
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

fn bounded(kind: &str, range: Range) -> Value {
    let mut schema = json!({"type": kind});
    let [low, high] = range.ends();
    if let Some((low, included)) = low {
        schema[if included {
            "minimum"
        } else {
            "exclusiveMinimum"
        }] = json!(low);
    }
    if let Some((high, included)) = high {
        schema[if included {
            "maximum"
        } else {
            "exclusiveMaximum"
        }] = json!(high);
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{INERTIA, RATE_WALK};

    #[test]
    fn units_are_taken_literally() {
        assert_eq!(escaped(RATE_WALK.si()), r"rad\/s\/sqrt\(s\)");
        assert_eq!(escaped(INERTIA.si()), r"kg\s+m\^2");
    }
}

//! Lists of wheels in scene files.

use crate::key::Form;
use crate::reader::{Reader, join};
use crate::source::{Node, Value};
use serde_json::json;

/// Name of the key.
pub(crate) const WHEELS: &str = "wheels";
/// What it may hold.
pub(crate) const WHEELS_ALLOWED: &str =
    "an array of 1 to 3 different wheels: 1 front, 2 middle, 3 rear";

/// A list of wheels as a value of a key.
pub(crate) const FORM: Form = Form {
    words: WHEELS_ALLOWED,
    schema: || json!({"type": "array", "items": {"enum": [1, 2, 3]}, "minItems": 1, "uniqueItems": true}),
};

/// Reads a list of different wheels, counted from 1 in the file and from 0 here.
pub(crate) fn read(reader: &mut Reader, node: &Node, path: &str) -> Vec<usize> {
    let mut wheels = Vec::new();
    let Some(node) = node.get(WHEELS) else {
        return wheels;
    };
    let path = join(path, WHEELS);
    let items = match &node.value {
        Value::Array(items) if !items.is_empty() => items.as_slice(),
        _ => {
            reader.refuse(node, &path, WHEELS_ALLOWED);
            &[]
        }
    };
    for (i, item) in items.iter().enumerate() {
        let path = format!("{path}[{i}]");
        let index = match item.value {
            Value::Integer(Some(1), _) => 0,
            Value::Integer(Some(2), _) => 1,
            Value::Integer(Some(3), _) => 2,
            _ => {
                reader.refuse(item, &path, "a wheel: 1 front, 2 middle, 3 rear");
                continue;
            }
        };
        if wheels.contains(&index) {
            reader.refuse(item, &path, "each wheel once");
        } else {
            wheels.push(index);
        }
    }
    wheels
}

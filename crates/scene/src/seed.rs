//! Seeds of random numbers.

use crate::key::Form;
use crate::reader::Reader;
use crate::source::{Node, Value};
use serde_json::json;

/// What a seed may be.
pub(crate) const ALLOWED: &str = "a whole number of at least 0 and below 2^64";

/// A seed as a value of a key. No TOML file has larger numbers than 2^63 - 1.
pub(crate) const FORM: Form = Form {
    words: ALLOWED,
    schema: || json!({"type": "integer", "minimum": 0}),
};

/// Reads a seed.
pub(crate) fn read(reader: &mut Reader, node: &Node, path: &str) -> Option<u64> {
    let seed = match node.value {
        Value::Integer(Some(seed), _) => u64::try_from(seed).ok(),
        _ => None,
    };
    if seed.is_none() {
        reader.refuse(node, path, ALLOWED);
    }
    seed
}

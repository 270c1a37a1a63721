//! Seeds of random numbers.

use crate::reader::Reader;
use crate::source::{Node, Value};

/// What a seed may be.
pub(crate) const ALLOWED: &str = "a whole number of at least 0 and below 2^64";

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

//! Faults of a robot, and how they are reported.

use robhaz_keys::prelude::*;

/// The key at fault, and why.
pub type Fault = (&'static str, String);

/// Reports a fault at its key of a table, or at the table that lacks it.
pub fn report(reader: &mut Reader, table: &Node, path: &str, (key, message): Fault) {
    let node = table.find(key).unwrap_or(table);
    let message = format!("found {}, but {message}", node.origin.found());
    reader.push(Problem::at(&node.origin, &join(path, key), message).whole());
}

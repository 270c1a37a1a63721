//! Names that become parts of file names.

use crate::key::Form;
use crate::reader::Reader;
use crate::source::{Node, Value};
use serde_json::json;

/// The rule in words.
pub(crate) const ALLOWED: &str =
    "a text of 1 to 64 lower-case letters a to z, digits, \"-\" and \"_\"";

/// The rule as a value of a key.
pub(crate) const FORM: Form = Form {
    words: ALLOWED,
    schema: || json!({"type": "string", "pattern": "^[a-z0-9_-]{1,64}$"}),
};

const LONGEST: usize = 64;

fn is_allowed(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_'
}

/// Reads a name.
pub(crate) fn read(reader: &mut Reader, node: &Node, path: &str) -> Option<String> {
    match &node.value {
        Value::Text(text)
            if (1..=LONGEST).contains(&text.len()) && text.chars().all(is_allowed) =>
        {
            Some(text.clone())
        }
        _ => {
            reader.refuse(node, path, ALLOWED);
            None
        }
    }
}

/// A name from a file's stem: in lower case, with `-` for characters that are not allowed.
pub fn from_stem(stem: &str) -> String {
    let allow = |c: char| if is_allowed(c) { c } else { '-' };
    let name: String = stem
        .to_lowercase()
        .chars()
        .take(LONGEST)
        .map(allow)
        .collect();
    if name.is_empty() {
        "scene".to_owned()
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stems_become_names() {
        assert_eq!(from_stem("smooth-soft_2"), "smooth-soft_2");
        assert_eq!(from_stem("My Scene"), "my-scene");
        assert_eq!(from_stem(""), "scene");
    }
}

//! Forms of single values: texts, names, seeds, counts, switches.

use crate::form::{Plain, Word, quote, word};
use crate::source::Value;
use serde_json::json;

/// A text of at least one character that is no blank; in words. None is written for an empty one.
pub const fn text(words: &'static str) -> Plain<String> {
    Plain {
        words,
        schema: || json!({"type": "string", "pattern": r"\S"}),
        read: |node| {
            let text = node.as_text().filter(|text| !text.trim().is_empty());
            text.map(str::to_owned)
        },
        text: |text| (!text.is_empty()).then(|| quote(text)),
    }
}

/// Any text.
pub const TEXT: Plain<String> = Plain {
    schema: || json!({"type": "string"}),
    read: |node| Some(node.as_text()?.to_owned()),
    ..text("a text")
};

/// A name that becomes a part of file names.
pub const NAME: Plain<String> = Plain {
    schema: || json!({"type": "string", "pattern": "^[a-z0-9_-]{1,64}$"}),
    read: |node| {
        let is_name =
            |text: &&str| (1..=LONGEST_NAME).contains(&text.len()) && text.chars().all(is_of_name);
        Some(node.as_text().filter(is_name)?.to_owned())
    },
    ..text("a text of 1 to 64 lower-case letters a to z, digits, \"-\" and \"_\"")
};
const LONGEST_NAME: usize = 64;

fn is_of_name(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_'
}

/// A name from a file's stem: in lower case, with `-` for characters that are not allowed.
pub fn from_stem(stem: &str) -> String {
    let allow = |c: char| if is_of_name(c) { c } else { '-' };
    let stem = stem.to_lowercase();
    let name: String = stem.chars().take(LONGEST_NAME).map(allow).collect();
    match name.is_empty() {
        true => "scene".to_owned(),
        false => name,
    }
}

/// The seed of random numbers. No TOML file has larger numbers than 2^63 - 1.
pub const SEED: Plain<u64> = Plain {
    words: "a whole number of at least 0 and below 2^64",
    schema: || json!({"type": "integer", "minimum": 0}),
    read: |node| u64::try_from(node.whole()?).ok(),
    text: |seed| Some(seed.to_string()),
};

/// A number of things.
pub const COUNT: Plain<u32> = Plain {
    words: "a whole number of at least 1 and at most 1000",
    schema: || json!({"type": "integer", "minimum": 1, "maximum": 1000}),
    read: |node| {
        let whole = match node.value {
            // A cast saturates: out of range at the ends.
            Value::Float(number) if number.fract() == 0.0 => number as i128,
            _ => node.whole()?,
        };
        u32::try_from(whole).ok().filter(|n| (1..=1000).contains(n))
    },
    text: |count| Some(count.to_string()),
};

/// `"off"` or `"on"`, or a boolean.
pub const SWITCH: Word<bool> = word(&[false, true], |on| match on {
    false => "off",
    true => "on",
});

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

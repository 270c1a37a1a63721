//! Forms: what the value of a key may be. Each reads, writes and describes values of one type.

use crate::error::Problem;
use crate::quantity::{Dimension, NONE, Number, at_least, number, short};
use crate::reader::{Reader, refusal};
use crate::source::{Node, Value};
use crate::suggest::nearest;
use crate::write::{Out, quote};
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_model::Vec2;
use serde_json::{Map, Value as Json, json};
use std::marker::PhantomData;

/// A key of scene files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyReference {
    /// Full dotted key; `[]` stands for an index.
    pub key: String,
    /// SI unit of a bare number; empty where there is none.
    pub unit: &'static str,
    /// Other units that a text may carry.
    pub other_units: String,
    /// Default in the SI unit, or in words; `required` if there is none.
    pub default: String,
    /// Allowed values.
    pub allowed: String,
    /// Meaning of the key.
    pub meaning: &'static str,
}

/// What a value may be.
pub(crate) trait Form: Sync {
    /// The type of the value, or of what holds it.
    type Value;

    /// Reads a value. What is not allowed becomes a problem, and leaves `into` as it was.
    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value);

    /// JSON Schema, with the defaults of keys below that `defaults` holds.
    fn schema(&self, defaults: Option<&mut Self::Value>) -> Json;

    /// Allowed values in messages.
    fn allowed(&self) -> String {
        "a table".to_owned()
    }

    /// Allowed values in tables of keys, which have a column for units.
    fn allowed_values(&self) -> String {
        self.allowed()
    }

    /// The units that the value may have, SI first.
    fn units(&self) -> &'static [&'static str] {
        &[]
    }

    /// The value in TOML; `None` where no line is written for it.
    fn text(&self, _value: &mut Self::Value) -> Option<String> {
        None
    }

    /// The value as a default in tables of keys.
    fn shown(&self, value: &mut Self::Value) -> String {
        let text = self.text(value).unwrap_or_default();
        text.trim_matches('"').to_owned()
    }

    /// Whether tables of keys list the keys below alone.
    fn is_section(&self) -> bool {
        false
    }

    /// Writes what has headings of its own.
    fn tables(&self, _out: &mut Out, _path: &str, _meaning: &str, _value: &mut Self::Value) {}

    /// Adds the rows of keys below.
    fn rows(&self, _rows: &mut Vec<KeyReference>, _path: &str, _value: &mut Self::Value) {}
}

/// A value that is read from its node alone.
pub(crate) struct Plain<V> {
    /// Allowed values in words.
    pub words: &'static str,
    /// Allowed values as JSON Schema.
    pub schema: fn() -> Json,
    /// The value; `None` for what is not allowed.
    pub read: fn(&Node) -> Option<V>,
    /// The value in TOML.
    pub text: fn(&V) -> Option<String>,
}

impl<V> Form for Plain<V> {
    type Value = V;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut V) {
        match (self.read)(node) {
            Some(value) => *into = value,
            None => reader.refuse(node, path, self.words),
        }
    }

    fn schema(&self, _defaults: Option<&mut V>) -> Json {
        (self.schema)()
    }

    fn allowed(&self) -> String {
        self.words.to_owned()
    }

    fn text(&self, value: &mut V) -> Option<String> {
        (self.text)(value)
    }
}

/// A value that is never written.
pub(crate) const fn read_only<V>(
    words: &'static str,
    schema: fn() -> Json,
    read: fn(&Node) -> Option<V>,
) -> Plain<V> {
    Plain {
        words,
        schema,
        read,
        text: |_| None,
    }
}

/// A value whose allowed values depend on other keys: what reads those reads it, too.
pub(crate) const fn dependent(words: &'static str, schema: fn() -> Json) -> Plain<()> {
    read_only(words, schema, |_| Some(()))
}

/// A text of at least one character that is no blank; in words. None is written for an empty one.
pub(crate) const fn text(words: &'static str) -> Plain<String> {
    Plain {
        words,
        schema: || json!({"type": "string", "pattern": r"\S"}),
        read: |node| {
            Some(
                node.as_text()
                    .filter(|text| !text.trim().is_empty())?
                    .to_owned(),
            )
        },
        text: |text| (!text.is_empty()).then(|| quote(text)),
    }
}

/// Any text.
pub(crate) const TEXT: Plain<String> = Plain {
    schema: || json!({"type": "string"}),
    read: |node| Some(node.as_text()?.to_owned()),
    ..text("a text")
};

/// A name that becomes a part of file names.
pub(crate) const NAME: Plain<String> = Plain {
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
pub(crate) const SEED: Plain<u64> = Plain {
    words: "a whole number of at least 0 and below 2^64",
    schema: || json!({"type": "integer", "minimum": 0}),
    read: |node| u64::try_from(node.whole()?).ok(),
    text: |seed| Some(seed.to_string()),
};

/// A number of things.
pub(crate) const COUNT: Plain<u32> = Plain {
    words: "a whole number of at least 1 and at most 1000",
    schema: || json!({"type": "integer", "minimum": 1, "maximum": 1000}),
    read: |node| {
        let whole = match node.value {
            #[expect(clippy::cast_possible_truncation, reason = "out of range at the ends")]
            Value::Float(number) if number.fract() == 0.0 => number as i128,
            _ => node.whole()?,
        };
        u32::try_from(whole).ok().filter(|n| (1..=1000).contains(n))
    },
    text: |count| Some(count.to_string()),
};

/// Different wheels in their order, counted from 1 in the file and from 0 here.
pub(crate) const WHEEL_LIST: Plain<[Option<usize>; 3]> = Plain {
    words: "an array of 1 to 3 different wheels: 1 front, 2 middle, 3 rear",
    schema: || json!({"type": "array", "items": {"enum": [1, 2, 3]}, "minItems": 1, "uniqueItems": true}),
    read: |node| {
        let Value::Array(items) = &node.value else {
            return None;
        };
        let mut wheels = [None; 3];
        for (i, item) in items.iter().enumerate() {
            let wheel = usize::try_from(item.whole()?).ok()?.checked_sub(1)?;
            let is_new = wheel < 3 && !wheels.contains(&Some(wheel));
            *wheels.get_mut(i)? = Some(is_new.then_some(wheel)?);
        }
        wheels[0].map(|_| wheels)
    },
    text: |wheels| {
        let wheels: Vec<_> = wheels
            .iter()
            .flatten()
            .map(|w| (w + 1).to_string())
            .collect();
        Some(format!("[{}]", wheels.join(", ")))
    },
};

/// Different wheels, whether each is among them.
pub(crate) const WHEEL_SET: Plain<[bool; 3]> = Plain {
    words: WHEEL_LIST.words,
    schema: WHEEL_LIST.schema,
    read: |node| {
        let wheels = (WHEEL_LIST.read)(node)?;
        Some([0, 1, 2].map(|w| wheels.contains(&Some(w))))
    },
    text: |set| (WHEEL_LIST.text)(&[0, 1, 2].map(|w| set[w].then_some(w))),
};

impl Form for Number {
    type Value = f64;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut f64) {
        if let Some(value) = reader.number(self, node, path) {
            *into = value;
        }
    }

    /// The shortest decimal that reads back as the same bits.
    fn text(&self, value: &mut f64) -> Option<String> {
        Some(format!("{value:?}"))
    }

    fn allowed(&self) -> String {
        self.allowed_in_full()
    }

    fn allowed_values(&self) -> String {
        let range = self.range.to_string();
        range.trim_start_matches("of ").to_owned()
    }

    /// A number in its range, or a text of a number and a unit. The range of such a text is not in the schema.
    fn schema(&self, _defaults: Option<&mut f64>) -> Json {
        let bare = bounded(self);
        match self.unit.units.is_empty() {
            true => bare,
            false => json!({"anyOf": [bare, with_unit(self.unit)]}),
        }
    }

    fn units(&self) -> &'static [&'static str] {
        self.unit.names
    }

    fn shown(&self, value: &mut f64) -> String {
        short(*value)
    }
}

/// `"off"` or `"on"`, or a boolean.
pub(crate) const SWITCH: Word<bool> = word(&[false, true], |on| match on {
    false => "off",
    true => "on",
});

/// One of a few values, by its word.
pub(crate) struct Word<E: 'static> {
    all: &'static [E],
    name: fn(E) -> &'static str,
}

/// One of `all`, by its `name`.
pub(crate) const fn word<E>(all: &'static [E], name: fn(E) -> &'static str) -> Word<E> {
    Word { all, name }
}

impl<E: Copy + Sync> Form for Word<E> {
    type Value = E;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut E) {
        if let Some(index) = reader.word(&self.words(), node, path) {
            *into = self.all[index];
        }
    }

    fn schema(&self, _defaults: Option<&mut E>) -> Json {
        match self.words().as_slice() {
            ["off", "on"] => json!({"enum": ["off", "on", false, true]}),
            words => json!({"enum": words}),
        }
    }

    fn allowed(&self) -> String {
        quoted(&self.words())
    }

    fn text(&self, value: &mut E) -> Option<String> {
        Some(quote((self.name)(*value)))
    }
}

impl<E: Copy> Word<E> {
    fn words(&self) -> Vec<&'static str> {
        self.all.iter().map(|e| (self.name)(*e)).collect()
    }
}

/// A value that may be missing.
pub(crate) struct Maybe<F>(pub F);

impl<F: Form<Value: Default>> Form for Maybe<F> {
    type Value = Option<F::Value>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        let (mark, mut value) = (reader.mark(), F::Value::default());
        self.0.read(reader, node, path, &mut value);
        if reader.mark() == mark {
            *into = Some(value);
        }
    }

    fn text(&self, value: &mut Self::Value) -> Option<String> {
        self.0.text(value.as_mut()?)
    }

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        self.0.schema(None)
    }
}

/// An array of a fixed number of values.
pub(crate) struct Array<F, V> {
    item: F,
    /// In words, with `{}` for an item.
    words: &'static str,
    values: PhantomData<V>,
}

/// `[x, y]`
pub(crate) type Point = Array<Number, Vec2>;

/// An array of a fixed number of values; `words` have `{}` for an item.
pub(crate) const fn array<F, V>(words: &'static str, item: F) -> Array<F, V> {
    Array {
        item,
        words,
        values: PhantomData,
    }
}

/// A point in a range, SI.
pub(crate) const fn point(number: Number) -> Point {
    array("[x, y], each {}", number)
}

/// Values in a row.
pub(crate) trait Items<T>: Sync {
    const COUNT: usize;

    fn items(&mut self) -> &mut [T];
}

impl<T: Sync, const N: usize> Items<T> for [T; N] {
    const COUNT: usize = N;

    fn items(&mut self) -> &mut [T] {
        self
    }
}

impl Items<f64> for Vec2 {
    const COUNT: usize = 2;

    fn items(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

impl<F: Form, V: Items<F::Value>> Form for Array<F, V> {
    type Value = V;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut V) {
        let items = reader.items(node, path, V::COUNT..=V::COUNT, || self.allowed());
        for ((item, path), into) in items.into_iter().zip(into.items()) {
            self.item.read(reader, item, &path, into);
        }
    }

    fn schema(&self, _defaults: Option<&mut V>) -> Json {
        items(self.item.schema(None), V::COUNT, V::COUNT)
    }

    fn allowed(&self) -> String {
        self.in_words(&self.item.allowed())
    }

    fn allowed_values(&self) -> String {
        self.in_words(&self.item.allowed_values())
    }

    fn units(&self) -> &'static [&'static str] {
        self.item.units()
    }

    fn text(&self, value: &mut V) -> Option<String> {
        let items = value.items().iter_mut().map(|v| self.item.text(v));
        Some(format!(
            "[{}]",
            items.collect::<Option<Vec<_>>>()?.join(", ")
        ))
    }
}

impl<F, V> Array<F, V> {
    /// Of a point, its coordinates are described.
    fn in_words(&self, item: &str) -> String {
        let number = item.strip_prefix("[x, y], each ").unwrap_or(item);
        self.words.replace("{}", number)
    }
}

type Row = Array<Number, [f64; LOAD_PARAMETERS]>;

/// Rows of a covariance of the load parameters, SI.
pub(crate) struct Covariance;

impl Covariance {
    const ROWS: Array<Row, [[f64; LOAD_PARAMETERS]; LOAD_PARAMETERS]> =
        array("", array("", number(NONE, at_least(-1e12).at_most(1e12))));
}

impl Form for Covariance {
    type Value = Option<LoadCovariance>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        let is_row =
            |n: &Node| matches!(&n.value, Value::Array(cells) if cells.len() == LOAD_PARAMETERS);
        match &node.value {
            Value::Array(rows) if rows.len() == LOAD_PARAMETERS && rows.iter().all(is_row) => {}
            _ => return reader.refuse(node, path, &self.allowed()),
        }
        let (mark, mut rows) = (reader.mark(), [[0.0; LOAD_PARAMETERS]; LOAD_PARAMETERS]);
        Self::ROWS.read(reader, node, path, &mut rows);
        if reader.mark() != mark {
            return;
        }
        match LoadCovariance::new(&rows) {
            Ok(covariance) => *into = Some(covariance),
            Err(error) => {
                let allowed = self.allowed();
                let message = format!("it is no covariance: {error}; allowed: {allowed}");
                reader.push(Problem::at(&node.origin, path, message).whole());
            }
        }
    }

    fn text(&self, value: &mut Self::Value) -> Option<String> {
        let text = Self::ROWS.text(&mut value.as_ref()?.rows())?;
        Some(
            text.replace("[[", "[\n[")
                .replace("], ", "],\n")
                .replace("]]", "]\n]"),
        )
    }

    fn allowed(&self) -> String {
        format!("{LOAD_PARAMETERS} rows of {LOAD_PARAMETERS} numbers, a covariance")
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        Self::ROWS.schema(None)
    }
}

impl Reader {
    /// The items of an array with so many, each with its path; none after a problem.
    pub fn items<'n>(
        &mut self,
        node: &'n Node,
        path: &str,
        count: std::ops::RangeInclusive<usize>,
        allowed: impl Fn() -> String,
    ) -> Vec<(&'n Node, String)> {
        match &node.value {
            Value::Array(items) if count.contains(&items.len()) => {
                let items = items.iter().enumerate();
                items
                    .map(|(i, item)| (item, format!("{path}[{i}]")))
                    .collect()
            }
            _ => {
                self.refuse(node, path, &allowed());
                Vec::new()
            }
        }
    }

    /// A number in SI, within its range.
    pub fn number(&mut self, number: &Number, node: &Node, path: &str) -> Option<f64> {
        let value = match &node.value {
            Value::Float(value) | Value::Integer(_, value) => *value,
            Value::Text(text) => match number.parse(text, &node.origin.found()) {
                Ok(value) => value,
                Err(message) => {
                    self.push(Problem::at(&node.origin, path, message));
                    return None;
                }
            },
            _ => {
                self.refuse(node, path, &number.allowed_in_full());
                return None;
            }
        };
        if number.range.contains(value) {
            return Some(value);
        }
        self.refuse(node, path, &number.allowed());
        None
    }

    /// The index of a word among those allowed.
    pub fn word(&mut self, words: &[&str], node: &Node, path: &str) -> Option<usize> {
        let text = match &node.value {
            Value::Text(text) => text.as_str(),
            // A switch also takes a boolean.
            Value::Boolean(on) if words == ["off", "on"] => words[usize::from(*on)],
            _ => "",
        };
        let found = words.iter().position(|w| *w == text);
        if found.is_none() {
            self.complain(&node.origin, path, || {
                refusal(node, &(quoted(words) + &did_you_mean(text, words)))
            });
        }
        found
    }
}

/// `; did you mean "word"?`, or nothing.
pub(crate) fn did_you_mean(found: &str, words: &[&str]) -> String {
    nearest(found, words).map_or(String::new(), |near| format!("; did you mean \"{near}\"?"))
}

/// `"one", "two"`
pub(crate) fn quoted(words: &[&str]) -> String {
    let words: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
    words.join(", ")
}

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

fn bounded(number: &Number) -> Json {
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

    #[test]
    fn stems_become_names() {
        assert_eq!(from_stem("smooth-soft_2"), "smooth-soft_2");
        assert_eq!(from_stem("My Scene"), "my-scene");
        assert_eq!(from_stem(""), "scene");
    }
}

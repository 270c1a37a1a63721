//! Forms: what the value of a key may be. Each reads, writes and describes values of one type.

use crate::reader::{Reader, nearest, refusal};
use crate::source::{Node, Value};
use serde_json::{Map, Value as Json, json};

/// A key of a file, in tables of keys.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
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

/// What a form allows.
pub struct About {
    /// Allowed values in messages.
    pub allowed: String,
    /// The same in tables of keys, which have a column for units; empty for a section, of which they
    /// list the keys alone.
    pub values: String,
    /// The units that the value may have, SI first.
    pub units: &'static [&'static str],
}

impl About {
    /// Values without a unit, in words.
    pub fn new(allowed: impl Into<String>) -> Self {
        let (allowed, units) = (allowed.into(), &[]);
        Self {
            values: allowed.clone(),
            allowed,
            units,
        }
    }

    /// A table of which tables of keys list the keys alone.
    pub fn section() -> Self {
        let values = String::new();
        Self {
            values,
            ..Self::new("a table")
        }
    }
}

/// What a value may be.
pub trait Form: Sync {
    /// The type of the value, or of what holds it.
    type Value;

    /// Reads a value. What is not allowed becomes a problem, and leaves `into` as it was.
    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value);

    /// JSON Schema, with the defaults of keys below that `defaults` holds.
    fn schema(&self, defaults: Option<&mut Self::Value>) -> Json;

    /// What is allowed.
    fn about(&self) -> About {
        About::section()
    }

    /// Allowed values in messages.
    fn allowed(&self) -> String {
        self.about().allowed
    }

    /// The value in TOML; `None` where no line is written for it.
    fn text(&self, _value: &mut Self::Value) -> Option<String> {
        None
    }

    /// Writes what has headings of its own.
    fn tables(&self, _: &mut Out, _head: &str, _path: &str, _meaning: &str, _: &mut Self::Value) {}

    /// Adds the rows of keys below.
    fn rows(&self, _rows: &mut Vec<KeyReference>, _path: &str, _value: &mut Self::Value) {}
}

/// A value that is read from its node alone.
pub struct Plain<V> {
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

    fn about(&self) -> About {
        About::new(self.words)
    }

    fn text(&self, value: &mut V) -> Option<String> {
        (self.text)(value)
    }
}

/// A value that is never written.
pub const fn read_only<V>(
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
pub const fn dependent(words: &'static str, schema: fn() -> Json) -> Plain<()> {
    read_only(words, schema, |_| Some(()))
}

/// One of a few values, by its word.
pub struct Word<E: 'static> {
    all: &'static [E],
    name: fn(E) -> &'static str,
}

/// One of `all`, by its `name`.
pub const fn word<E>(all: &'static [E], name: fn(E) -> &'static str) -> Word<E> {
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

    fn about(&self) -> About {
        About::new(quoted(&self.words()))
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
pub struct Maybe<F>(pub F);

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

    fn about(&self) -> About {
        self.0.about()
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        self.0.schema(None)
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, about: &str, of: &mut Self::Value) {
        if let Some(value) = of {
            self.0.tables(out, head, path, about, value);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Self::Value) {
        self.0.rows(rows, path, &mut F::Value::default());
    }
}

/// An array of values.
pub struct Array<F: Form, V> {
    /// The form of each item.
    pub item: F,
    /// In words, with `{}` for an item.
    pub words: &'static str,
    /// Least and largest number of items in a file.
    pub count: [usize; 2],
    /// The items in the value.
    pub items: fn(&mut V) -> &mut [F::Value],
    /// How many of the items are written.
    pub written: fn(&V) -> usize,
}

/// An array of a fixed number of values; `words` have `{}` for an item.
pub const fn array<F: Form, const N: usize>(
    words: &'static str,
    item: F,
) -> Array<F, [F::Value; N]> {
    Array {
        item,
        words,
        count: [N; 2],
        items: |values| values,
        written: |_| N,
    }
}

impl<F: Form, V> Form for Array<F, V> {
    type Value = V;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut V) {
        let [least, most] = self.count;
        let items = reader.items(node, path, least..=most, || self.allowed());
        for ((item, path), into) in items.into_iter().zip((self.items)(into)) {
            self.item.read(reader, item, &path, into);
        }
    }

    fn schema(&self, _defaults: Option<&mut V>) -> Json {
        items(self.item.schema(None), self.count)
    }

    fn about(&self) -> About {
        let item = self.item.about();
        let in_words = |item: &str| {
            // Of a point, its coordinates are described.
            let number = item.trim_start_matches("[x, y], each ");
            self.words.replace("{}", number)
        };
        About {
            allowed: in_words(&item.allowed),
            values: in_words(&item.values),
            ..item
        }
    }

    fn text(&self, value: &mut V) -> Option<String> {
        let count = (self.written)(value);
        let items = (self.items)(value).iter_mut().take(count);
        let texts: Vec<String> = items.filter_map(|v| self.item.text(v)).collect();
        (!texts.is_empty()).then(|| format!("[{}]", texts.join(", ")))
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
pub fn did_you_mean(found: &str, words: &[&str]) -> String {
    nearest(found, words).map_or(String::new(), |near| format!("; did you mean \"{near}\"?"))
}

/// `"one", "two"`
pub fn quoted(words: &[&str]) -> String {
    let words: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
    words.join(", ")
}

/// JSON Schema of a table with these properties and no others.
pub fn object(properties: Map<String, Json>, required: &[&str]) -> Json {
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
pub fn items(item: Json, [least, most]: [usize; 2]) -> Json {
    json!({"type": "array", "items": item, "minItems": least, "maxItems": most})
}

/// A TOML file being written: every choice with its unit, from the declarations of the keys.
#[derive(Default)]
pub struct Out(pub String);

impl Out {
    /// A line.
    pub fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    /// The heading of a table.
    pub fn head(&mut self, head: &str, comment: &str) {
        self.line("");
        self.line(&with_comment(head, comment));
    }

    /// A key with its value.
    pub fn key(&mut self, name: &str, value: &str, comment: &str) {
        self.line(&with_comment(&format!("{name} = {value}"), comment));
    }
}

fn with_comment(text: &str, comment: &str) -> String {
    match comment {
        "" => text.to_owned(),
        _ => format!("{text} # {comment}"),
    }
}

/// A text in quotes, as TOML writes it.
pub fn quote(value: &str) -> String {
    toml::Value::String(value.to_owned()).to_string()
}

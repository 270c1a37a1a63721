//! Forms: what the value of a key may be. Each reads, writes and describes values of one type.

use crate::error::Problem;
use crate::key::{self, Key};
use crate::quantity::{Dimension, NONE, Number, at_least, number, short};
use crate::reader::{Reader, refusal};
use crate::reference::KeyReference;
use crate::source::{Node, Value};
use crate::suggest::nearest;
use crate::write::{Out, quote};
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_model::Vec2;
use serde_json::{Map, Value as Json, json};
use std::marker::PhantomData;

/// What a value may be.
pub(crate) trait Form: Sync {
    /// The type of the value.
    type Value;

    /// Reads a value. What is not allowed becomes a problem, and leaves `into` as it was.
    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value);

    /// The value in TOML; `None` where no line is written for it.
    fn text(&self, value: &Self::Value) -> Option<String>;

    /// Allowed values in messages.
    fn allowed(&self) -> String;

    /// JSON Schema, with the defaults of keys below that `defaults` holds.
    fn schema(&self, defaults: Option<&mut Self::Value>) -> Json;

    /// Allowed values in tables of keys, which have a column for units.
    fn allowed_values(&self) -> String {
        self.allowed()
    }

    /// The units that the value may have, SI first.
    fn units(&self) -> &'static [&'static str] {
        &[]
    }

    /// The value as a default in tables of keys.
    fn shown(&self, value: &Self::Value) -> String {
        let text = self.text(value).unwrap_or_default();
        text.trim_matches('"').to_owned()
    }

    /// The value as a default in JSON Schema.
    fn json(&self, _value: &Self::Value) -> Option<Json> {
        None
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

impl Form for Number {
    type Value = f64;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut f64) {
        if let Some(value) = reader.number(self, node, path) {
            *into = value;
        }
    }

    /// The shortest decimal that reads back as the same bits.
    fn text(&self, value: &f64) -> Option<String> {
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

    fn shown(&self, value: &f64) -> String {
        short(*value)
    }

    fn json(&self, value: &f64) -> Option<Json> {
        Some(json!(value))
    }
}

/// A whole number from 1 to `most`.
pub(crate) struct Count {
    pub most: u32,
}

impl Count {
    fn number(&self) -> Number {
        number(NONE, at_least(1.0).at_most(f64::from(self.most)))
    }
}

impl Form for Count {
    type Value = u32;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut u32) {
        let number = self.number();
        match reader.number(&number, node, path) {
            Some(value) if value.fract() != 0.0 => {
                reader.refuse(node, path, &format!("a whole number {}", number.range));
            }
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number of at least 1 and below 2^32"
            )]
            Some(value) => *into = value as u32,
            None => {}
        }
    }

    fn text(&self, value: &u32) -> Option<String> {
        Some(value.to_string())
    }

    fn allowed(&self) -> String {
        self.number().allowed()
    }

    fn allowed_values(&self) -> String {
        self.number().allowed_values()
    }

    fn schema(&self, _defaults: Option<&mut u32>) -> Json {
        json!({"type": "integer", "minimum": 1, "maximum": self.most})
    }

    fn json(&self, value: &u32) -> Option<Json> {
        Some(json!(value))
    }
}

/// The seed of random numbers. No TOML file has larger numbers than 2^63 - 1.
pub(crate) struct Seed;

impl Form for Seed {
    type Value = u64;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut u64) {
        match node.whole().map(u64::try_from) {
            Some(Ok(seed)) => *into = seed,
            _ => reader.refuse(node, path, &self.allowed()),
        }
    }

    fn text(&self, value: &u64) -> Option<String> {
        Some(value.to_string())
    }

    fn allowed(&self) -> String {
        "a whole number of at least 0 and below 2^64".to_owned()
    }

    fn schema(&self, _defaults: Option<&mut u64>) -> Json {
        json!({"type": "integer", "minimum": 0})
    }
}

/// `"off"` or `"on"`, or a boolean.
pub(crate) struct Switch;

const SWITCH: &[&str] = &["off", "on"];

impl Form for Switch {
    type Value = bool;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut bool) {
        match node.value {
            Value::Boolean(on) => *into = on,
            _ => *into = reader.word(SWITCH, node, path).map_or(*into, |on| on == 1),
        }
    }

    fn text(&self, value: &bool) -> Option<String> {
        Some(quote(SWITCH[usize::from(*value)]))
    }

    fn allowed(&self) -> String {
        quoted(SWITCH)
    }

    fn schema(&self, _defaults: Option<&mut bool>) -> Json {
        json!({"enum": ["off", "on", false, true]})
    }

    fn json(&self, value: &bool) -> Option<Json> {
        Some(json!(SWITCH[usize::from(*value)]))
    }
}

/// One of a few values, by its word.
pub(crate) struct Word<E: 'static> {
    all: &'static [E],
    name: fn(E) -> &'static str,
}

/// One of `all`, by its `name`.
pub(crate) const fn word<E>(all: &'static [E], name: fn(E) -> &'static str) -> Word<E> {
    Word { all, name }
}

impl<E: Copy> Word<E> {
    fn words(&self) -> Vec<&'static str> {
        self.all.iter().map(|e| (self.name)(*e)).collect()
    }
}

impl<E: Copy + Sync> Form for Word<E> {
    type Value = E;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut E) {
        if let Some(index) = reader.word(&self.words(), node, path) {
            *into = self.all[index];
        }
    }

    fn text(&self, value: &E) -> Option<String> {
        Some(quote((self.name)(*value)))
    }

    fn allowed(&self) -> String {
        quoted(&self.words())
    }

    fn schema(&self, _defaults: Option<&mut E>) -> Json {
        json!({"enum": self.words()})
    }

    fn json(&self, value: &E) -> Option<Json> {
        Some(json!((self.name)(*value)))
    }
}

/// A text. None is written for an empty one.
pub(crate) struct Text {
    /// In words.
    pub words: &'static str,
    /// As a regular expression; empty for any text.
    pub pattern: &'static str,
}

/// A text of at least one character that is no blank; in words.
pub(crate) const fn text(words: &'static str) -> Text {
    Text {
        words,
        pattern: r"\S",
    }
}

/// A name that becomes a part of file names.
pub(crate) const NAME: Text = Text {
    words: "a text of 1 to 64 lower-case letters a to z, digits, \"-\" and \"_\"",
    pattern: "^[a-z0-9_-]{1,64}$",
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

impl Form for Text {
    type Value = String;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut String) {
        let is_allowed = |text: &str| match self.pattern {
            r"\S" => !text.trim().is_empty(),
            pattern if pattern == NAME.pattern => {
                (1..=LONGEST_NAME).contains(&text.len()) && text.chars().all(is_of_name)
            }
            _ => true,
        };
        match &node.value {
            Value::Text(text) if is_allowed(text) => into.clone_from(text),
            _ => reader.refuse(node, path, self.words),
        }
    }

    fn text(&self, value: &String) -> Option<String> {
        (!value.is_empty()).then(|| quote(value))
    }

    fn allowed(&self) -> String {
        self.words.to_owned()
    }

    fn schema(&self, _defaults: Option<&mut String>) -> Json {
        match self.pattern {
            "" => json!({"type": "string"}),
            pattern => json!({"type": "string", "pattern": pattern}),
        }
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

    fn text(&self, value: &Self::Value) -> Option<String> {
        self.0.text(value.as_ref()?)
    }

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        self.0.schema(None)
    }
}

/// A value whose allowed values depend on other keys: what reads those reads it, too.
pub(crate) struct Dependent<V> {
    /// Allowed values in words.
    pub words: &'static str,
    /// Allowed values as JSON Schema.
    pub schema: fn() -> Json,
    /// The value in TOML.
    pub text: fn(&V) -> Option<String>,
}

/// A value of which nothing is written.
pub(crate) const fn dependent(words: &'static str, schema: fn() -> Json) -> Dependent<()> {
    Dependent {
        words,
        schema,
        text: |()| None,
    }
}

impl<V> Form for Dependent<V> {
    type Value = V;

    fn read(&self, _reader: &mut Reader, _node: &Node, _path: &str, _into: &mut V) {}

    fn text(&self, value: &V) -> Option<String> {
        (self.text)(value)
    }

    fn allowed(&self) -> String {
        self.words.to_owned()
    }

    fn schema(&self, _defaults: Option<&mut V>) -> Json {
        (self.schema)()
    }
}

/// `[x, y]`
pub(crate) struct Point(pub Number);

impl Form for Point {
    type Value = Vec2;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec2) {
        let mut xy = [into.x, into.y];
        self.pair().read(reader, node, path, &mut xy);
        *into = xy.into();
    }

    fn text(&self, value: &Vec2) -> Option<String> {
        self.pair().text(&[value.x, value.y])
    }

    fn allowed(&self) -> String {
        self.pair().allowed()
    }

    fn allowed_values(&self) -> String {
        self.pair().allowed_values()
    }

    fn schema(&self, _defaults: Option<&mut Vec2>) -> Json {
        self.pair().schema(None)
    }

    fn units(&self) -> &'static [&'static str] {
        self.0.units()
    }
}

impl Point {
    fn pair(&self) -> Array<Number, 2> {
        array("[x, y], each {}", self.0)
    }
}

/// An array of `N` values.
pub(crate) struct Array<F, const N: usize> {
    /// In words, with `{}` for an item.
    words: &'static str,
    item: F,
}

/// An array of `N` values; `words` have `{}` for an item.
pub(crate) const fn array<F, const N: usize>(words: &'static str, item: F) -> Array<F, N> {
    Array { words, item }
}

impl<F, const N: usize> Array<F, N> {
    /// Of a point, its coordinates are described.
    fn in_words(&self, item: &str) -> String {
        let number = item.strip_prefix("[x, y], each ").unwrap_or(item);
        self.words.replace("{}", number)
    }
}

impl<F: Form<Value: Clone>, const N: usize> Form for Array<F, N> {
    type Value = [F::Value; N];

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        match &node.value {
            Value::Array(items) if items.len() == N => {
                for (i, (item, into)) in items.iter().zip(into).enumerate() {
                    self.item.read(reader, item, &format!("{path}[{i}]"), into);
                }
            }
            _ => reader.refuse(node, path, &self.allowed()),
        }
    }

    fn text(&self, value: &Self::Value) -> Option<String> {
        let items: Option<Vec<String>> = value.iter().map(|v| self.item.text(v)).collect();
        Some(format!("[{}]", items?.join(", ")))
    }

    fn allowed(&self) -> String {
        self.in_words(&self.item.allowed())
    }

    fn allowed_values(&self) -> String {
        self.in_words(&self.item.allowed_values())
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        items(self.item.schema(None), N, N)
    }

    fn units(&self) -> &'static [&'static str] {
        self.item.units()
    }
}

/// A list of different wheels, counted from 1 in the file and from 0 here.
pub(crate) struct Wheels<V>(PhantomData<V>);

/// A list of wheels, or a set of them.
pub(crate) const fn wheels<V: WheelSet>() -> Wheels<V> {
    Wheels(PhantomData)
}

/// How wheels are held.
pub(crate) trait WheelSet: Sync {
    fn of(wheels: &[usize]) -> Self;
    fn listed(&self) -> Vec<usize>;
}

/// In their order.
impl WheelSet for [Option<usize>; 3] {
    fn of(wheels: &[usize]) -> Self {
        std::array::from_fn(|k| wheels.get(k).copied())
    }

    fn listed(&self) -> Vec<usize> {
        self.iter().flatten().copied().collect()
    }
}

/// As a set.
impl WheelSet for [bool; 3] {
    fn of(wheels: &[usize]) -> Self {
        std::array::from_fn(|k| wheels.contains(&k))
    }

    fn listed(&self) -> Vec<usize> {
        (0..3).filter(|k| self[*k]).collect()
    }
}

impl<V: WheelSet> Form for Wheels<V> {
    type Value = V;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut V) {
        let mut wheels = Vec::new();
        for (item, path) in reader.items(node, path, 1..=usize::MAX, &self.allowed()) {
            match item.whole().and_then(|w| usize::try_from(w).ok()) {
                Some(wheel @ 1..=3) if wheels.contains(&(wheel - 1)) => {
                    reader.refuse(item, &path, "each wheel once");
                }
                Some(wheel @ 1..=3) => wheels.push(wheel - 1),
                _ => reader.refuse(item, &path, "a wheel: 1 front, 2 middle, 3 rear"),
            }
        }
        *into = V::of(&wheels);
    }

    fn text(&self, value: &V) -> Option<String> {
        let wheels = value.listed().into_iter().map(|i| (i + 1).to_string());
        Some(format!("[{}]", wheels.collect::<Vec<_>>().join(", ")))
    }

    fn allowed(&self) -> String {
        "an array of 1 to 3 different wheels: 1 front, 2 middle, 3 rear".to_owned()
    }

    fn schema(&self, _defaults: Option<&mut V>) -> Json {
        json!({"type": "array", "items": {"enum": [1, 2, 3]}, "minItems": 1, "uniqueItems": true})
    }
}

/// Rows of a covariance of the load parameters, SI.
pub(crate) struct Covariance;

impl Covariance {
    const ROWS: Array<Array<Number, LOAD_PARAMETERS>, LOAD_PARAMETERS> =
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

    fn text(&self, value: &Self::Value) -> Option<String> {
        let text = Self::ROWS.text(&value.as_ref()?.rows())?;
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

/// A table.
pub(crate) struct Table<T: 'static> {
    pub keys: &'static [Key<T>],
    /// In words; empty for a section, of which tables of keys list the keys alone.
    pub words: &'static str,
    /// Whether it is not written.
    pub is_hidden: fn(&T) -> bool,
}

/// A table of which tables of keys list the keys alone.
pub(crate) const fn section<T>(keys: &'static [Key<T>]) -> Table<T> {
    Table {
        keys,
        words: "",
        is_hidden: |_| false,
    }
}

impl<T> Form for Table<T> {
    type Value = T;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut T) {
        reader.table(self.keys, node, path, into);
    }

    fn text(&self, _value: &T) -> Option<String> {
        None
    }

    fn allowed(&self) -> String {
        match self.words {
            "" => "a table".to_owned(),
            words => words.to_owned(),
        }
    }

    fn schema(&self, defaults: Option<&mut T>) -> Json {
        key::schema(self.keys, defaults)
    }

    fn is_section(&self) -> bool {
        self.words.is_empty()
    }

    fn tables(&self, out: &mut Out, path: &str, meaning: &str, value: &mut T) {
        if !(self.is_hidden)(value) {
            out.head(&format!("[{path}]"), meaning);
            out.table(self.keys, value, path);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, value: &mut T) {
        key::rows(rows, self.keys, path, value);
    }
}

/// Tables, each headed `[[path]]`.
pub(crate) struct List<T: 'static> {
    pub keys: &'static [Key<T>],
    /// In words; empty for a list of which tables of keys list the keys alone.
    pub words: &'static str,
    pub least: usize,
    pub most: usize,
    /// An item before its keys are read.
    pub start: fn() -> T,
    /// Checks an item whose keys have no problem, with those before it.
    pub check: fn(&mut Reader, &Node, &str, &mut T, &[T]),
}

impl<T> Form for List<T> {
    type Value = Vec<T>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<T>) {
        into.clear();
        for (item, path) in reader.items(node, path, self.least..=self.most, &self.allowed()) {
            let (mark, mut value) = (reader.mark(), (self.start)());
            reader.table(self.keys, item, &path, &mut value);
            if reader.mark() == mark {
                (self.check)(reader, item, &path, &mut value, into);
                into.push(value);
            }
        }
    }

    fn text(&self, _value: &Vec<T>) -> Option<String> {
        None
    }

    fn allowed(&self) -> String {
        self.words.to_owned()
    }

    fn schema(&self, _defaults: Option<&mut Vec<T>>) -> Json {
        items(key::schema(self.keys, None), self.least, self.most)
    }

    fn tables(&self, out: &mut Out, path: &str, _meaning: &str, value: &mut Vec<T>) {
        for item in value {
            out.head(&format!("[[{path}]]"), "");
            out.table(self.keys, item, path);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Vec<T>) {
        key::rows(rows, self.keys, &format!("{path}[]"), &mut (self.start)());
    }
}

impl Reader {
    /// The items of an array with so many, each with its path; none after a problem.
    pub fn items<'n>(
        &mut self,
        node: &'n Node,
        path: &str,
        count: std::ops::RangeInclusive<usize>,
        allowed: &str,
    ) -> Vec<(&'n Node, String)> {
        match &node.value {
            Value::Array(items) if count.contains(&items.len()) => {
                let items = items.iter().enumerate();
                items
                    .map(|(i, item)| (item, format!("{path}[{i}]")))
                    .collect()
            }
            _ => {
                self.refuse(node, path, allowed);
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
    let [low, high] = number.range.ends();
    let names = [
        ["exclusiveMinimum", "minimum"],
        ["exclusiveMaximum", "maximum"],
    ];
    for (end, names) in [low, high].into_iter().zip(names) {
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

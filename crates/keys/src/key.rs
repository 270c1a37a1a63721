//! Keys and tables of keys. A key has a name, a meaning, the form of its value, and the field that
//! it sets. Each is declared once, by [`keys!`].
//!
//! Reading, writing, tables of keys and JSON Schema walk these declarations.
//! Defaults are not declared: they come from the `Default` or a named constructor of the type that
//! holds the field.

use crate::error::Problem;
use crate::form::{About, Form, KeyReference, Out, items, object, quote};
use crate::quantity::short;
use crate::reader::{Reader, join};
use crate::source::{Entry, Node};
use serde_json::{Map, Value as Json, json};

/// A key of a table that sets a field of `T`.
pub struct Key<T: 'static> {
    /// Its name in the file.
    pub name: &'static str,
    /// What it means; the comment beside it in a written file.
    pub meaning: &'static str,
    /// What holds where it is not given.
    pub absent: Absent,
    /// The form of its value, at its field.
    pub field: &'static dyn Form<Value = T>,
}

/// Keys in their order.
pub trait Keys<'k, T: 'static>: IntoIterator<Item = &'k Key<T>> + Clone {}

impl<'k, T: 'static, K: IntoIterator<Item = &'k Key<T>> + Clone> Keys<'k, T> for K {}

/// What holds where a key is not given.
#[derive(Clone, Copy, PartialEq)]
pub enum Absent {
    /// What the field holds before the file is read.
    Default,
    /// The default in words, where it follows from other keys.
    Words(&'static str),
    /// It must be given.
    Required,
}

/// Declares the keys of a table: the meaning as a doc comment, the name, `(required)` or the
/// default in words where the field does not hold it, the form of the value, and the field: its
/// path in the table's type, `self` for a section of it, or a closure in brackets. A key that is
/// not always written has its condition after `if`: a function of the table.
#[macro_export]
macro_rules! keys {
    (@absent) => {
        $crate::key::Absent::Default
    };
    (@absent required) => {
        $crate::key::Absent::Required
    };
    (@absent $words:literal) => {
        $crate::key::Absent::Words($words)
    };
    (@at self) => {
        |it| it
    };
    (@at ($at:expr)) => {
        $at
    };
    (@at $($field:tt).+) => {
        |it| &mut it.$($field).+
    };
    ($(#[doc = $about:literal])* $vis:vis $table:ident: $t:ty; $(
        $(#[doc = $meaning:literal])+
        $name:ident $(($($absent:tt)+))?: $form:expr => $($at:tt).+ $(if $is_written:expr)?;
    )+) => {
        $(#[doc = $about])*
        $vis const $table: &[$crate::key::Key<$t>] = &[$($crate::key::Key {
            name: stringify!($name),
            meaning: concat!($($meaning),+).trim_ascii(),
            absent: $crate::key::keys!(@absent $($($absent)+)?),
            field: &$crate::key::At::<$t, _> {
                at: $crate::key::keys!(@at $($at).+),
                form: $form,
                // The condition, if there is one, comes before that which always holds.
                is_written: [$($is_written as fn(&$t) -> bool,)? |_: &$t| true][0],
            },
        }),+];
    };
}
pub use crate::keys;

/// A form of values at a field of `T`.
pub struct At<T: 'static, F: Form> {
    /// The field.
    pub at: fn(&mut T) -> &mut F::Value,
    /// The form of its value.
    pub form: F,
    /// Whether it is written into a file.
    pub is_written: fn(&T) -> bool,
}

impl<T, F: Form> Form for At<T, F> {
    type Value = T;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut T) {
        self.form.read(reader, node, path, (self.at)(into));
    }

    fn schema(&self, of: Option<&mut T>) -> Json {
        self.form.schema(of.map(self.at))
    }

    fn about(&self) -> About {
        self.form.about()
    }

    fn text(&self, of: &mut T) -> Option<String> {
        (self.is_written)(of).then(|| self.form.text((self.at)(of)))?
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, meaning: &str, of: &mut T) {
        if (self.is_written)(of) {
            self.form.tables(out, head, path, meaning, (self.at)(of));
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, of: &mut T) {
        self.form.rows(rows, path, (self.at)(of));
    }
}

/// A table of any file that names the versions that wrote it. It is not read.
pub const IGNORED: &str = "resolved";

impl Reader {
    /// Reads a whole table.
    pub fn table<T>(&mut self, keys: &[Key<T>], node: &Node, path: &str, into: &mut T) {
        let Some(entries) = node.entries() else {
            return self.refuse(node, path, "a table");
        };
        for entry in entries {
            self.entry(keys, entry, path, into);
        }
        self.require(keys, node, path);
    }

    /// Adds a problem for each key without a default that a table lacks.
    pub fn require<'k, T: 'static>(&mut self, keys: impl Keys<'k, T>, node: &Node, path: &str) {
        for key in keys {
            if key.absent == Absent::Required && node.get(key.name).is_none() {
                self.missing(node, &join(path, key.name), &key.field.allowed());
            }
        }
    }

    /// Reads one entry of a table.
    pub fn entry<T>(&mut self, keys: &[Key<T>], entry: &Entry, path: &str, into: &mut T) {
        match keys.iter().find(|k| k.name == entry.key) {
            Some(key) => key
                .field
                .read(self, &entry.node, &join(path, key.name), into),
            None if path.is_empty() && entry.key == IGNORED => {}
            None => self.unknown(entry, path, &names(keys)),
        }
    }

    /// Adds a problem: a table lacks a key.
    pub fn missing(&mut self, node: &Node, path: &str, allowed: &str) {
        let message = format!("missing, and it has no default; allowed: {allowed}");
        self.push(Problem::at(&node.origin, path, message).whole());
    }
}

impl Out {
    /// A whole file: a line of comment, the keys, the `version` of the program that writes it, the
    /// tables.
    pub fn file<T: 'static>(comment: &str, version: &str, keys: &[Key<T>], of: &mut T) -> String {
        let mut out = Self::default();
        out.line(&format!("# {comment}"));
        out.fields(keys, of);
        out.head(&format!("[{IGNORED}]"), "what wrote this file; not read");
        out.key("version", &quote(version), "");
        out.tables(keys, of, "");
        out.0
    }

    /// The keys of a table whose heading is written, then the tables in it.
    pub fn table<'k, T: 'static>(&mut self, keys: impl Keys<'k, T>, of: &mut T, path: &str) {
        self.fields(keys.clone(), of);
        self.tables(keys, of, path);
    }

    /// Keys with their units and meanings.
    pub fn fields<'k, T: 'static>(&mut self, keys: impl Keys<'k, T>, of: &mut T) {
        for key in keys {
            let Some(value) = key.field.text(of) else {
                continue;
            };
            match key.field.about().units.first() {
                None => self.key(key.name, &value, key.meaning),
                Some(unit) => self.key(key.name, &value, &format!("{unit}; {}", key.meaning)),
            }
        }
    }

    /// The tables in a table.
    pub fn tables<'k, T: 'static>(&mut self, keys: impl Keys<'k, T>, of: &mut T, path: &str) {
        for key in keys {
            let path = join(path, key.name);
            key.field
                .tables(self, &format!("[{path}]"), &path, key.meaning, of);
        }
    }
}

/// The names of keys, in their order.
pub fn names<'k, T: 'static>(keys: impl Keys<'k, T>) -> Vec<&'static str> {
    keys.into_iter().map(|k| k.name).collect()
}

/// The rows of the reference: keys of a table, then those of the tables in it. `of` holds the
/// defaults.
pub fn rows<T>(rows: &mut Vec<KeyReference>, keys: &[Key<T>], path: &str, of: &mut T) {
    let own = keys.iter().map(|key| row(key, path, of));
    rows.extend(own.filter(|row| !row.allowed.is_empty()));
    for key in keys {
        key.field.rows(rows, &join(path, key.name), of);
    }
}

/// The row of one key.
pub fn row<T>(key: &Key<T>, path: &str, of: &mut T) -> KeyReference {
    let About { values, units, .. } = key.field.about();
    KeyReference {
        key: join(path, key.name),
        unit: units.first().copied().unwrap_or_default(),
        other_units: units.get(1..).unwrap_or_default().join(", "),
        default: match key.absent {
            Absent::Required => "required".to_owned(),
            Absent::Words(words) => words.to_owned(),
            Absent::Default => shown(&key.field.text(of).unwrap_or_default()),
        },
        allowed: values,
        meaning: key.meaning,
    }
}

/// A value in TOML as a default in tables of keys.
fn shown(text: &str) -> String {
    let number = text.parse().map(short);
    number.unwrap_or_else(|_| text.trim_matches('"').to_owned())
}

/// JSON Schema of a table with these keys and no others; with the defaults that the keys have in
/// `of`.
pub fn schema<T>(keys: &[Key<T>], of: Option<&mut T>) -> Json {
    object(properties(keys, of), &required(keys))
}

/// JSON Schema (draft 7) of a file with these keys; with the defaults that the keys have in `of`.
pub fn file_schema<T>(title: &str, keys: &[Key<T>], of: Option<&mut T>) -> Json {
    let mut file = schema(keys, of);
    file["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    file["title"] = json!(title);
    file["properties"][IGNORED] =
        json!({"type": "object", "description": "what wrote the file; not read"});
    file
}

/// The names of the keys without a default.
pub fn required<'k, T: 'static>(keys: impl Keys<'k, T>) -> Vec<&'static str> {
    let required = keys.into_iter().filter(|k| k.absent == Absent::Required);
    required.map(|k| k.name).collect()
}

/// JSON Schema of each key.
pub fn properties<'k, T: 'static>(
    keys: impl Keys<'k, T>,
    mut of: Option<&mut T>,
) -> Map<String, Json> {
    let property = |key: &Key<T>| {
        let mut schema = key.field.schema(of.as_deref_mut());
        let mut meaning = key.meaning.to_owned();
        if let Some(unit) = key.field.about().units.first() {
            meaning += &format!(". Unit: {unit}");
        }
        if let Absent::Words(default) = key.absent {
            meaning += &format!(". Default: {default}");
        }
        schema["description"] = json!(meaning);
        let default = of.as_deref_mut().and_then(|of| key.field.text(of));
        // Numbers and texts are written as in JSON.
        let default = default.and_then(|text| serde_json::from_str(&text).ok());
        if let (Some(default), Absent::Default) = (default, key.absent) {
            schema["default"] = default;
        }
        (key.name.to_owned(), schema)
    };
    keys.into_iter().map(property).collect()
}

/// A table.
pub struct Table<T: 'static> {
    /// The keys of the table.
    pub keys: &'static [Key<T>],
    /// In words; empty for a section, of which tables of keys list the keys alone.
    pub words: &'static str,
    /// Completes and checks a table whose keys have no problem.
    pub check: fn(&mut Reader, &Node, &mut T),
}

/// A table of which tables of keys list the keys alone.
pub const fn section<T>(keys: &'static [Key<T>]) -> Table<T> {
    Table {
        keys,
        words: "",
        check: |_, _, _| {},
    }
}

impl<T> Form for Table<T> {
    type Value = T;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut T) {
        let mark = reader.mark();
        reader.table(self.keys, node, path, into);
        if reader.mark() == mark {
            (self.check)(reader, node, into);
        }
    }

    fn about(&self) -> About {
        match self.words {
            "" => About::section(),
            words => About::new(words),
        }
    }

    fn schema(&self, defaults: Option<&mut T>) -> Json {
        schema(self.keys, defaults)
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, meaning: &str, value: &mut T) {
        out.head(head, meaning);
        out.table(self.keys, value, path);
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, value: &mut T) {
        self::rows(rows, self.keys, path, value);
    }
}

/// Checks an item at a path with those before it.
pub type Check<T> = fn(&mut Reader, &Node, &str, &T, &[T]);

/// Items of one form; tables are each headed `[[path]]`.
pub struct List<F: Form> {
    /// An item.
    pub item: F,
    /// In words.
    pub words: &'static str,
    /// Least and largest number of items.
    pub count: [usize; 2],
    /// An item before it is read.
    pub start: fn() -> F::Value,
    /// Checks an item without problems, with those before it.
    pub check: Check<F::Value>,
}

/// A list whose items have no rules beyond their own.
pub const fn list<F: Form>(
    item: F,
    words: &'static str,
    count: [usize; 2],
    start: fn() -> F::Value,
) -> List<F> {
    List {
        item,
        words,
        count,
        start,
        check: |_, _, _, _, _| {},
    }
}

impl<F: Form> Form for List<F> {
    type Value = Vec<F::Value>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        into.clear();
        let [least, most] = self.count;
        for (item, path) in reader.items(node, path, least..=most, || self.allowed()) {
            let (mark, mut value) = (reader.mark(), (self.start)());
            self.item.read(reader, item, &path, &mut value);
            if reader.mark() == mark {
                (self.check)(reader, item, &path, &value, into);
                into.push(value);
            }
        }
    }

    fn about(&self) -> About {
        About::new(self.words)
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        items(self.item.schema(None), self.count)
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, _: &str, value: &mut Self::Value) {
        for item in value {
            self.item.tables(out, &format!("[{head}]"), path, "", item);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Self::Value) {
        let path = format!("{path}[]");
        self.item.rows(rows, &path, &mut (self.start)());
    }
}

//! Files up to a size limit; a file or an override as a tree of nodes with their places in the
//! text.

use miette::NamedSource;
use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::iter::once;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::de::{DeInteger, DeTable, DeValue};
use tracing::debug;

/// Largest size of a TOML file, bytes: enough for 100 000 points of full precision.
const MOST_TOML: usize = 6_000_000;
/// Largest number of words and signs of such a file: each takes some hundred bytes of memory.
const MOST_TOKENS: usize = 1_000_000;

/// The content of a file of at most `most` bytes; the error completes the sentence "FILE ...".
pub fn read(path: &Path, most: usize) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    // Reading one byte more than allowed detects larger files, also pipes, which have no length.
    let mut file = file.take(most as u64 + 1);
    file.read_to_end(&mut bytes).map_err(cannot)?;
    match bytes.len() > most {
        true => Err(too_large(most)),
        false => {
            debug!(path = %path.display(), bytes = bytes.len(), "read");
            Ok(bytes)
        }
    }
}

/// The text of a TOML file.
pub fn read_toml(path: &Path) -> Result<String, String> {
    let text = String::from_utf8(read(path, MOST_TOML)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        format!("cannot be read: byte {at} is no UTF-8")
    })?;
    check_toml(&text).map(|()| text)
}

/// Checks the size of the text of a TOML file.
pub(crate) fn check_toml(text: &str) -> Result<(), String> {
    if text.len() > MOST_TOML {
        return Err(too_large(MOST_TOML));
    }
    let mut before = b' ';
    let tokens = text.bytes().filter(|b| {
        let is_space = |b: u8| b == b' ' || b == b'\t';
        let starts = b",=[]{}\"'.\n".contains(b) || is_space(*b) && !is_space(before);
        before = *b;
        starts
    });
    if tokens.count() > MOST_TOKENS {
        let most = grouped(MOST_TOKENS);
        return Err(format!(
            "is too large, allowed: at most {most} words and signs"
        ));
    }
    Ok(())
}

fn too_large(most: usize) -> String {
    format!("is too large, allowed: at most {} bytes", grouped(most))
}

/// A text with its name.
#[derive(Debug)]
pub struct Source {
    /// Whether it is an override of the command line: one line, named by itself.
    pub is_override: bool,
    /// The text, named by its file or `--set key=value`.
    pub text: NamedSource<String>,
    /// Byte at which each line starts.
    line_starts: Vec<usize>,
}

impl Source {
    fn new(is_override: bool, name: &str, text: &str) -> Arc<Self> {
        let breaks = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        let starts = once(0).chain(breaks.map(|(i, _)| i + 1));
        Arc::new(Self {
            is_override,
            line_starts: starts.collect(),
            text: NamedSource::new(name, text.to_owned()),
        })
    }

    /// The text of a file.
    pub fn file(name: &str, text: &str) -> Arc<Self> {
        Self::new(false, name, text)
    }

    /// An override `key=value` as given to `--set`.
    pub fn set(text: &str) -> Arc<Self> {
        Self::new(true, &format!("--set {text}"), text)
    }

    /// The bytes of a line (from 1) without its line break; `None` where there is no such line.
    pub fn line_span(&self, line: usize) -> Option<Range<usize>> {
        let (starts, text) = (&self.line_starts, self.text.inner());
        let start = *starts.get(line.checked_sub(1)?)?;
        let end = starts.get(line).map_or(text.len(), |next| next - 1);
        Some(start..start + text.get(start..end)?.trim_end_matches('\r').len())
    }
}

/// A place in a source.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The text that it is in.
    pub source: Arc<Source>,
    /// In bytes.
    pub span: Range<usize>,
}

impl Origin {
    /// A place of a text, in bytes.
    pub fn new(source: &Arc<Source>, span: Range<usize>) -> Self {
        Self {
            source: Arc::clone(source),
            span,
        }
    }

    /// The line, from 1.
    pub fn line(&self) -> usize {
        let starts = &self.source.line_starts;
        starts.partition_point(|start| *start <= self.span.start)
    }

    /// Whether it is in an override of the command line.
    pub fn is_override(&self) -> bool {
        self.source.is_override
    }

    /// Of a place over several lines, what is on the first.
    pub(crate) fn of_first_line(&self) -> Range<usize> {
        let line = self.source.line_span(self.line()).unwrap_or_default();
        self.span.start..self.span.end.min(line.end).max(self.span.start)
    }

    /// The text at the place.
    pub fn text(&self) -> &str {
        let text = self.source.text.inner().get(self.span.clone());
        text.unwrap_or_default()
    }

    /// The same on one line and cut.
    pub fn found(&self) -> String {
        match shortened(self.text()) {
            line if line.is_empty() => "nothing".to_owned(),
            line => line,
        }
    }

    /// The start of the line on which it is written.
    pub(crate) fn whole_line(&self) -> String {
        let span = self.source.line_span(self.line()).unwrap_or_default();
        shortened(self.source.text.inner().get(span).unwrap_or_default())
    }
}

/// A text on one line and cut after 60 characters. Reads no more of the text than it needs.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 60;
    let words = text.split_whitespace();
    let mut rest = words.flat_map(|word| once(' ').chain(word.chars())).skip(1);
    let line: String = rest.by_ref().take(LONGEST).collect();
    match rest.next() {
        Some(_) => line.trim_end().to_owned() + " ...",
        None => line,
    }
}

/// A value and where it was written.
#[derive(Clone, Debug)]
pub struct Node {
    /// Where it is written.
    pub origin: Origin,
    /// What it is.
    pub value: Value,
}

/// A value in the text.
#[derive(Clone, Debug)]
pub enum Value {
    /// A text in quotes.
    Text(String),
    /// A number with a decimal point or an exponent.
    Float(f64),
    /// A whole number, where it fits, and its value as a float.
    Integer(Option<i128>, f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A type that no key takes, in words.
    Other(&'static str),
    /// An array.
    Array(Vec<Node>),
    /// In the order of the file.
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Its name.
    pub key: String,
    /// Where its name is written.
    pub origin: Origin,
    /// Its value.
    pub node: Node,
}

impl Entry {
    /// A key at a place with its value.
    pub fn new(key: &str, origin: &Origin, node: Node) -> Self {
        let (key, origin) = (key.to_owned(), origin.clone());
        Self { key, origin, node }
    }
}

impl Node {
    /// A value at a place.
    pub fn new(origin: &Origin, value: Value) -> Self {
        let origin = origin.clone();
        Self { origin, value }
    }

    /// A text at a place.
    pub fn text(origin: &Origin, text: &str) -> Self {
        Self::new(origin, Value::Text(text.to_owned()))
    }

    /// The type of the value in words.
    pub(crate) fn type_name(&self) -> &'static str {
        match self.value {
            Value::Text(_) => "a text",
            Value::Float(_) => "a number",
            Value::Integer(..) => "a whole number",
            Value::Boolean(_) => "a boolean",
            Value::Other(name) => name,
            Value::Array(_) => "an array",
            Value::Table(_) => "a table",
        }
    }

    /// The entries of a table, `None` for anything else.
    pub fn entries(&self) -> Option<&[Entry]> {
        match &self.value {
            Value::Table(entries) => Some(entries),
            _ => None,
        }
    }

    /// A text, `None` for anything else.
    pub fn as_text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The items of an array, `None` for anything else.
    pub fn array(&self) -> Option<&[Self]> {
        match &self.value {
            Value::Array(items) => Some(items),
            _ => None,
        }
    }

    /// The number of items of an array, 0 of anything else.
    pub fn count(&self) -> usize {
        self.array().map_or(0, <[Self]>::len)
    }

    /// A whole number, `None` for anything else.
    pub fn whole(&self) -> Option<i128> {
        match self.value {
            Value::Integer(whole, _) => whole,
            _ => None,
        }
    }

    /// The value of a key of a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        let entry = self.entries()?.iter().find(|e| e.key == key)?;
        Some(&entry.node)
    }

    /// The value of a dotted path of tables.
    pub fn find(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(self, |node, key| node.get(key))
    }

    /// Where an override sets the key `by`, removes keys of a section that come from the file.
    pub fn drop_keys(&mut self, by: &str, section: &str, which: impl Fn(&str) -> bool) {
        let is_override = self.find(by).is_some_and(|n| n.origin.is_override());
        let (true, Value::Table(sections)) = (is_override, &mut self.value) else {
            return;
        };
        for entry in sections.iter_mut().filter(|e| e.key == section) {
            if let Value::Table(entries) = &mut entry.node.value {
                entries.retain(|e| e.origin.is_override() || !which(&e.key));
            }
        }
    }
}

/// Reads a TOML document; hands each error with its place to `refuse`.
pub fn document(source: &Arc<Source>, mut refuse: impl FnMut(&Origin, &str)) -> Option<Node> {
    let (table, errors) = DeTable::parse_recoverable(source.text.inner());
    let place = Place { source, offset: 0 };
    let mut lines = HashSet::new();
    for error in &errors {
        let origin = place.origin(error.span().unwrap_or(0..0));
        // One mistake can cause many errors; the first of a line is enough.
        if lines.insert(origin.line()) {
            refuse(&origin, error.message());
        }
    }
    let value = || Value::Table(place.entries(table.get_ref()));
    let node = || Node::new(&place.origin(table.span()), value());
    errors.is_empty().then(node)
}

/// The part of a source from `offset` on as a TOML value; as a text if it is none.
pub(crate) fn value_or_text(source: &Arc<Source>, offset: usize) -> Node {
    let text = source.text.inner().get(offset..).unwrap_or_default();
    let place = Place { source, offset };
    match DeValue::parse(text) {
        Ok(value) => place.node(value.get_ref(), value.span()),
        Err(_) => Node::text(&place.origin(0..text.len()), text.trim()),
    }
}

/// Turns the parser's spans into origins.
struct Place<'a> {
    source: &'a Arc<Source>,
    /// Where the parsed text starts in the source.
    offset: usize,
}

impl Place<'_> {
    fn origin(&self, span: Range<usize>) -> Origin {
        let span = self.offset + span.start..self.offset + span.end;
        Origin::new(self.source, span)
    }

    fn node(&self, value: &DeValue<'_>, span: Range<usize>) -> Node {
        let value = match value {
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Integer(integer) => whole(integer),
            // Too large a number becomes infinite, which no range contains.
            DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::NAN)),
            DeValue::Boolean(value) => Value::Boolean(*value),
            DeValue::Datetime(_) => Value::Other("a date or time"),
            DeValue::Array(items) => {
                let items = items.iter();
                Value::Array(items.map(|i| self.node(i.get_ref(), i.span())).collect())
            }
            DeValue::Table(table) => Value::Table(self.entries(table)),
        };
        Node::new(&self.origin(span), value)
    }

    fn entries(&self, table: &DeTable<'_>) -> Vec<Entry> {
        let mut entries: Vec<_> = table
            .iter()
            .map(|(key, value)| {
                let node = self.node(value.get_ref(), value.span());
                Entry::new(key.get_ref(), &self.origin(key.span()), node)
            })
            .collect();
        // The parser sorts by name.
        entries.sort_by_key(|e| e.origin.span.start);
        entries
    }
}

fn whole(integer: &DeInteger<'_>) -> Value {
    let value = i128::from_str_radix(integer.as_str(), integer.radix()).ok();
    let float = value.map_or(f64::INFINITY, |v| v as f64);
    Value::Integer(value, float)
}

/// A count with a space between groups of three digits.
pub fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    groups
        .map(String::from_utf8_lossy)
        .collect::<Vec<_>>()
        .join(" ")
}

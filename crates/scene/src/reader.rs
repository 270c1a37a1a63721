//! Reads tables by the declarations of their keys and collects every problem.

use crate::error::{Problem, SceneError};
use crate::key::{Field, Key, Number, SWITCH, Words, quoted};
use crate::source::{Entry, Node, Origin, Source, SourceKind, Value, document};
use crate::suggest::{home_of, nearest};
use crate::units::UnitError;
use robhaz_model::Vec2;
use std::path::PathBuf;
use std::sync::Arc;

/// Collects what is wrong while a scene is read.
pub(crate) struct Reader {
    problems: Vec<Problem>,
    /// Paths in the scene are relative to this folder.
    pub base_dir: PathBuf,
}

impl Reader {
    pub fn new(base_dir: PathBuf) -> Self {
        Self {
            problems: Vec::new(),
            base_dir,
        }
    }

    /// How many problems there are so far.
    pub fn mark(&self) -> usize {
        self.problems.len()
    }

    /// Whether no problem lies under one of these keys.
    pub fn is_clean(&self, keys: &[&str]) -> bool {
        let under = |key: &str| keys.iter().any(|k| key.starts_with(k));
        !self.problems.iter().any(|p| under(p.key()))
    }

    pub fn push(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// Something else was found than is allowed.
    pub fn refuse(&mut self, node: &Node, path: &str, allowed: &str) {
        let found = node.origin.found();
        let kind = match node.value {
            // Texts and numbers show what they are.
            Value::Text(_) | Value::Float(_) | Value::Integer(..) => String::new(),
            _ => format!(" ({})", node.type_name()),
        };
        let message = format!("found {found}{kind}, allowed: {allowed}");
        self.push(Problem::at(&node.origin, path, message));
    }

    /// Parses a text as TOML; syntax errors become problems.
    pub fn document(&mut self, source: &Arc<Source>) -> Node {
        let (node, errors) = document(source);
        let broken = errors
            .iter()
            .filter(|e| e.breaks_structure)
            .map(|e| e.origin.line())
            .min();
        for error in errors {
            let line = whole_line(&error.origin);
            let message = format!("TOML does not allow this: {}; found: {line}", error.message);
            let mut problem = Problem::at(&error.origin, "", message).syntax();
            // Marks the file as one of which the rest may be misread.
            problem.whole = Some(error.origin.line()) == broken;
            self.push(problem);
        }
        node
    }

    /// The scene, or all problems.
    pub fn finish<T>(self, value: T) -> Result<T, SceneError> {
        let mut problems = without_echoes(self.problems);
        let place = |p: &Problem| {
            let line = p.line();
            (line.is_none(), p.file().to_owned(), line)
        };
        problems.sort_by_cached_key(place);
        let mut problems = problems.into_iter();
        match problems.next() {
            None => Ok(value),
            Some(first) => Err(SceneError::new(first, problems.collect())),
        }
    }

    /// The entries of a table; anything else is a problem.
    pub fn entries<'n>(&mut self, node: &'n Node, path: &str) -> &'n [Entry] {
        node.entries().unwrap_or_else(|| {
            self.refuse(node, path, "a table");
            &[]
        })
    }

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

    /// Reads one entry of a table.
    pub fn entry<T>(&mut self, keys: &[Key<T>], entry: &Entry, path: &str, into: &mut T) {
        match keys.iter().find(|k| k.name == entry.key) {
            Some(key) => self.field(key, &entry.node, &join(path, key.name), into),
            None => {
                let names: Vec<_> = keys.iter().map(|k| k.name).collect();
                self.unknown(entry, path, &names);
            }
        }
    }

    /// Complains of every required key that a table lacks.
    pub fn require<T>(&mut self, keys: &[Key<T>], node: &Node, path: &str) {
        for key in keys.iter().filter(|k| k.required) {
            if node.get(key.name).is_none() {
                let message = format!(
                    "missing, and it has no default; allowed: {}",
                    key.field.allowed()
                );
                let path = join(path, key.name);
                self.push(Problem::at(&node.origin, &path, message).whole());
            }
        }
    }

    /// A key that its table does not have.
    pub fn unknown(&mut self, entry: &Entry, path: &str, allowed: &[&str]) {
        let mut message = format!("unknown key, allowed: {}", allowed.join(", "));
        if let Some(near) = nearest(&entry.key, allowed) {
            message += &format!("; did you mean {near}?");
        } else if let Some(home) = home_of(&entry.key) {
            message += &format!("; {} belongs to {home}", entry.key);
        }
        let path = join(path, &entry.key);
        self.push(Problem::at(&entry.origin, &path, message));
    }

    fn field<T>(&mut self, key: &Key<T>, node: &Node, path: &str, into: &mut T) {
        match &key.field {
            Field::Number(number, at) => {
                if let Some(value) = self.number(number, node, path) {
                    *at(into) = value;
                }
            }
            Field::Three(number, at) => {
                if let Some(items) = self.items(node, path, &key.field.allowed()) {
                    *at(into) = self.each(items, path, 0.0, |r, n, p| r.number(number, n, p));
                }
            }
            Field::Point(number, at) => {
                if let Some(value) = self.point(number, node, path) {
                    *at(into) = value;
                }
            }
            Field::ThreePoints(number, at) => {
                if let Some(items) = self.items(node, path, &key.field.allowed()) {
                    let none = Vec2::zeros();
                    *at(into) = self.each(items, path, none, |r, n, p| r.point(number, n, p));
                }
            }
            Field::Switch(at) => {
                if let Some(index) = self.word(SWITCH, node, path) {
                    *at(into) = index == 1;
                }
            }
            Field::Word(words, _, set) => {
                if let Some(index) = self.word(words, node, path) {
                    set(into, index);
                }
            }
            Field::ThreeWords(words, _, set) => {
                if let Some(items) = self.items(node, path, &key.field.allowed()) {
                    set(
                        into,
                        self.each(items, path, 0, |r, n, p| r.word(words, n, p)),
                    );
                }
            }
            Field::Table(keys) => self.table(keys, node, path, into),
            Field::Own { .. } | Field::OwnWord { .. } => {}
        }
    }

    /// A number in SI, within its range.
    pub fn number(&mut self, number: &Number, node: &Node, path: &str) -> Option<f64> {
        let value = match &node.value {
            Value::Float(value) | Value::Integer(_, value) => *value,
            Value::Text(text) => match number.unit.parse(text) {
                Ok(value) => value,
                Err(error) => {
                    self.bad_unit(number, node, path, &error);
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

    fn bad_unit(&mut self, number: &Number, node: &Node, path: &str, error: &UnitError) {
        let found = node.origin.found();
        let message = match error {
            UnitError::NotANumber => {
                return self.refuse(node, path, &number.allowed_in_full());
            }
            // As a bare number of that size.
            UnitError::TooLarge => return self.refuse(node, path, &number.allowed()),
            UnitError::NoUnit => format!(
                "found {found}, a text without a unit, allowed: {}",
                number.allowed_in_full()
            ),
            UnitError::Wrong(unit) if number.unit.units.is_empty() => format!(
                "found {found} with the unit {unit}, allowed: {}, without a unit",
                number.allowed()
            ),
            UnitError::Wrong(unit) => format!(
                "found {found} with the unit {unit}, allowed units: {}",
                number.unit.names()
            ),
        };
        self.push(Problem::at(&node.origin, path, message));
    }

    /// A point `[x, y]` in SI.
    pub fn point(&mut self, number: &Number, node: &Node, path: &str) -> Option<Vec2> {
        let allowed = format!("[x, y], each {}", number.allowed_in_full());
        let [x, y]: &[Node; 2] = self.items(node, path, &allowed)?;
        // Both, so that both can complain.
        let (x, y) = (
            self.number(number, x, &format!("{path}[0]")),
            self.number(number, y, &format!("{path}[1]")),
        );
        Some(Vec2::new(x?, y?))
    }

    /// The index of a word among those allowed.
    pub fn word(&mut self, words: Words, node: &Node, path: &str) -> Option<usize> {
        let text = match &node.value {
            Value::Text(text) => text.as_str(),
            _ => "",
        };
        if let Some(index) = words.iter().position(|w| *w == text) {
            return Some(index);
        }
        let mut allowed = quoted(words);
        if let Some(near) = nearest(text, words) {
            allowed += &format!("; did you mean \"{near}\"?");
        }
        self.refuse(node, path, &allowed);
        None
    }

    /// The items of an array of exactly `N`.
    fn items<'n, const N: usize>(
        &mut self,
        node: &'n Node,
        path: &str,
        allowed: &str,
    ) -> Option<&'n [Node; N]> {
        let items = match &node.value {
            Value::Array(items) => items.as_slice().try_into().ok(),
            _ => None,
        };
        if items.is_none() {
            self.refuse(node, path, allowed);
        }
        items
    }

    fn each<V: Copy>(
        &mut self,
        items: &[Node; 3],
        path: &str,
        bad: V,
        read: impl Fn(&mut Self, &Node, &str) -> Option<V>,
    ) -> [V; 3] {
        let mut values = [bad; 3];
        for (i, item) in items.iter().enumerate() {
            values[i] = read(self, item, &format!("{path}[{i}]")).unwrap_or(bad);
        }
        values
    }
}

/// `path.name`, or `name` alone at the top.
pub(crate) fn join(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

/// The text of the line on which something starts.
fn whole_line(origin: &Origin) -> String {
    let text = origin.source.named.inner();
    let line = text.lines().nth(origin.line() - 1).unwrap_or_default();
    line.trim().chars().take(60).collect()
}

/// Leaves out problems that only echo a syntax error: those on its line, those after a line from which on the file may
/// have been misread, and then also keys that seem to be missing.
fn without_echoes(problems: Vec<Problem>) -> Vec<Problem> {
    let syntax: Vec<(Origin, bool)> = problems
        .iter()
        .filter(|p| p.syntax)
        .filter_map(|p| Some((p.origin()?.clone(), p.whole)))
        .collect();
    let echoes = |p: &Problem| {
        let Some(origin) = p.origin() else {
            return false;
        };
        syntax.iter().any(|(error, breaks)| {
            Arc::ptr_eq(&error.source, &origin.source)
                && origin.source.kind == SourceKind::File
                && (error.line() == origin.line()
                    || *breaks && (p.whole || origin.line() > error.line()))
        })
    };
    let is_echo: Vec<bool> = problems.iter().map(|p| !p.syntax && echoes(p)).collect();
    let mut is_echo = is_echo.into_iter();
    let mut problems = problems;
    problems.retain(|_| !is_echo.next().unwrap_or(false));
    problems
}

//! Reads tables by the declarations of their keys and collects every problem.

use crate::error::{Problem, SceneError};
use crate::excerpt::harmless;
use crate::key::{Field, Key, Number, SWITCH, Words, quoted};
use crate::source::{Entry, Node, Origin, Source, SourceKind, Value, document};
use crate::suggest::nearest;
use crate::units::UnitError;
use robhaz_model::Vec2;
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// Most problems of a file that are shown.
const SHOWN: usize = 20;
/// Most problems of a file that are looked at in full. The sections of a file are not read in the order of its lines: the
/// first ones by line are among these unless there are many more.
const KEPT: usize = 1000;

/// Collects what is wrong while a scene is read.
pub(crate) struct Reader {
    problems: Vec<Problem>,
    /// How many of them each source has, by its name.
    kept: HashMap<String, usize>,
    /// How many more each source has, which were only counted.
    hidden: HashMap<String, usize>,
    /// The sections in which those are.
    hidden_sections: BTreeSet<String>,
    /// Paths in the scene are relative to this folder.
    pub base_dir: PathBuf,
    /// The table that has a key of a name, for messages on misplaced keys.
    home_of: fn(&str) -> Option<String>,
}

impl Reader {
    pub fn new(base_dir: PathBuf, home_of: fn(&str) -> Option<String>) -> Self {
        Self {
            problems: Vec::new(),
            kept: HashMap::new(),
            hidden: HashMap::new(),
            hidden_sections: BTreeSet::new(),
            base_dir,
            home_of,
        }
    }

    /// How many problems there are so far.
    pub fn mark(&self) -> usize {
        self.problems.len() + self.hidden.values().sum::<usize>()
    }

    /// How many problems a source has so far.
    pub fn problems_of(&self, source: &str) -> usize {
        let count = |of: &HashMap<String, usize>| of.get(source).copied().unwrap_or(0);
        count(&self.kept) + count(&self.hidden)
    }

    /// Whether no problem lies under one of these keys.
    pub fn is_clean(&self, keys: &[&str]) -> bool {
        let under = |key: &str| keys.iter().any(|k| key.starts_with(k));
        let hidden = self.hidden_sections.iter().any(|s| under(s));
        !hidden && !self.problems.iter().any(|p| under(p.key()))
    }

    /// Adds a problem of a place. Its message is made only where it can be shown: a file with a million mistakes is read
    /// as fast as one without.
    pub fn complain(&mut self, origin: &Origin, key: &str, message: impl FnOnce() -> String) {
        let name = &origin.source.name;
        if self.kept.get(name).is_none_or(|count| *count < KEPT) {
            return self.push(Problem::at(origin, key, message()));
        }
        self.hide(name, 1);
        if let Some((section, _)) = key.split_once(['.', '[']) {
            self.hidden_sections.insert(format!("{section}."));
        }
    }

    pub fn push(&mut self, problem: Problem) {
        let name = match problem.origin() {
            Some(origin) => origin.source.name.clone(),
            None => problem.file().to_owned(),
        };
        *self.kept.entry(name).or_default() += 1;
        self.problems.push(problem);
    }

    /// Counts problems of a source that are not shown.
    pub fn hide(&mut self, source: &str, count: usize) {
        if count > 0 {
            *self.hidden.entry(source.to_owned()).or_default() += count;
        }
    }

    /// Something else was found than is allowed.
    pub fn refuse(&mut self, node: &Node, path: &str, allowed: &str) {
        self.complain(&node.origin, path, || refusal(node, allowed));
    }

    /// Parses a text as TOML; syntax errors become problems.
    pub fn document(&mut self, source: &Arc<Source>) -> Node {
        let (node, errors) = document(source);
        let broken = errors
            .iter()
            .filter(|e| e.breaks_structure)
            .map(|e| e.origin.line())
            .min();
        for error in errors.iter().take(KEPT) {
            let line = error.origin.whole_line();
            let message = format!("TOML does not allow this: {}; found: {line}", error.message);
            let mut problem = Problem::at(&error.origin, "", message).syntax();
            // Marks the file as one of which the rest may be misread.
            problem.whole = Some(error.origin.line()) == broken;
            self.push(problem);
        }
        self.hide(&source.name, errors.len().saturating_sub(KEPT));
        node
    }

    /// The scene, or its problems.
    pub fn finish<T>(self, value: T) -> Result<T, SceneError> {
        let mut problems = without_echoes(self.problems);
        let mut hidden: HashMap<String, usize> = HashMap::new();
        for (source, count) in self.hidden {
            *hidden.entry(harmless(&source)).or_default() += count;
        }
        let count = problems.len() + hidden.values().sum::<usize>();
        let place = |p: &Problem| {
            let line = p.line();
            (line.is_none(), p.file().to_owned(), line)
        };
        problems.sort_by_cached_key(place);
        let mut shown = Vec::new();
        for of_file in problems.chunk_by(|a, b| a.file() == b.file()) {
            let file = of_file[0].file();
            shown.extend(of_file.iter().take(SHOWN).cloned());
            let more = of_file.len().saturating_sub(SHOWN) + hidden.remove(file).unwrap_or(0);
            if more > 0 {
                let message = format!("and {} more problems", grouped(more));
                shown.push(Problem::unread(file, message));
            }
        }
        let mut shown = shown.into_iter();
        match shown.next() {
            None => Ok(value),
            Some(first) => Err(SceneError::new(first, shown.collect(), count)),
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
        let home_of = self.home_of;
        self.complain(&entry.origin, &join(path, &short_key(&entry.key)), || {
            let mut message = format!("unknown key, allowed: {}", allowed.join(", "));
            if let Some(near) = nearest(&entry.key, allowed) {
                message += &format!("; did you mean {near}?");
            } else if let Some(home) = home_of(&entry.key) {
                message += &format!("; {} belongs to {home}", entry.key);
            }
            message
        });
    }

    fn field<T>(&mut self, key: &Key<T>, node: &Node, path: &str, into: &mut T) {
        match &key.field {
            Field::Number(number, at) => {
                if let Some(value) = self.number(number, node, path) {
                    *at(into) = value;
                }
            }
            Field::Count(number, _, set) => {
                if let Some(count) = self.count(number, node, path) {
                    set(into, count);
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

    /// A whole number from 1 on, within its range.
    fn count(&mut self, number: &Number, node: &Node, path: &str) -> Option<u32> {
        let value = self.number(number, node, path)?;
        if value.fract() != 0.0 {
            self.refuse(node, path, &format!("a whole number {}", number.range));
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number of at least 1 and below 2^32"
        )]
        Some(value as u32)
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
            // A switch can be written as TOML does.
            Value::Boolean(on) if words == SWITCH => SWITCH[usize::from(*on)],
            _ => "",
        };
        if let Some(index) = words.iter().position(|w| *w == text) {
            return Some(index);
        }
        self.complain(&node.origin, path, || {
            let mut allowed = quoted(words);
            if let Some(near) = nearest(text, words) {
                allowed += &format!("; did you mean \"{near}\"?");
            }
            refusal(node, &allowed)
        });
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

/// What was found and what is allowed.
fn refusal(node: &Node, allowed: &str) -> String {
    let found = node.origin.found();
    let kind = match node.value {
        // Texts and numbers show what they are.
        Value::Text(_) | Value::Float(_) | Value::Integer(..) => String::new(),
        _ => format!(" ({})", node.type_name()),
    };
    format!("found {found}{kind}, allowed: {allowed}")
}

/// A key as messages name it: 60 characters of it at most.
fn short_key(key: &str) -> String {
    const LONGEST: usize = 60;
    match key.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &key[..end]),
        None => key.to_owned(),
    }
}

/// A count with a space between groups of three digits.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
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

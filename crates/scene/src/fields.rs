//! Reads tables by the declarations of their keys.

use crate::error::Problem;
use crate::key::{Field, Key, Number, SWITCH, quoted};
use crate::range::at_least;
use crate::reader::{Reader, join, refusal};
use crate::source::{Entry, Node, Value};
use crate::suggest::nearest;
use crate::units::{NONE, UnitError};
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_model::Vec2;

impl Reader {
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

    /// Adds a problem for every required key that a table lacks.
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
            Field::LoadCovariance(at) => {
                if let Some(covariance) = self.load_covariance(node, path, &key.field.allowed()) {
                    *at(into) = Some(covariance);
                }
            }
            Field::Text(at) => {
                if let Some(text) = self.text(node, path) {
                    *at(into) = text;
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
            // The same message as for a bare number.
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
        // Both are read, so that both can have a problem.
        let (x, y) = (
            self.number(number, x, &format!("{path}[0]")),
            self.number(number, y, &format!("{path}[1]")),
        );
        Some(Vec2::new(x?, y?))
    }

    /// Rows of a covariance of the load parameters, SI.
    fn load_covariance(
        &mut self,
        node: &Node,
        path: &str,
        allowed: &str,
    ) -> Option<LoadCovariance> {
        let number = Number {
            unit: NONE,
            range: at_least(-1e12).at_most(1e12),
        };
        let items: &[Node; LOAD_PARAMETERS] = self.items(node, path, allowed)?;
        let mark = self.mark();
        let mut rows = [[0.0; LOAD_PARAMETERS]; LOAD_PARAMETERS];
        for (i, (row, item)) in rows.iter_mut().zip(items).enumerate() {
            let path = format!("{path}[{i}]");
            let cells: &[Node; LOAD_PARAMETERS] = self.items(item, &path, allowed)?;
            for (j, (entry, cell)) in row.iter_mut().zip(cells).enumerate() {
                *entry = self
                    .number(&number, cell, &format!("{path}[{j}]"))
                    .unwrap_or_default();
            }
        }
        if self.mark() != mark {
            return None;
        }
        match LoadCovariance::new(&rows) {
            Ok(covariance) => Some(covariance),
            Err(error) => {
                let message = format!("it is no covariance: {error}; allowed: {allowed}");
                self.push(Problem::at(&node.origin, path, message).whole());
                None
            }
        }
    }

    /// A text of at least one character.
    pub fn text(&mut self, node: &Node, path: &str) -> Option<String> {
        match &node.value {
            Value::Text(text) if !text.trim().is_empty() => Some(text.clone()),
            _ => {
                self.refuse(node, path, "a text");
                None
            }
        }
    }

    /// The index of a word among those allowed.
    pub fn word(&mut self, words: &[&'static str], node: &Node, path: &str) -> Option<usize> {
        let text = match &node.value {
            Value::Text(text) => text.as_str(),
            // A switch also takes a boolean.
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

/// A key in messages: at most its first 60 characters.
fn short_key(key: &str) -> String {
    const LONGEST: usize = 60;
    match key.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &key[..end]),
        None => key.to_owned(),
    }
}

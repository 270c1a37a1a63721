//! A half of `[robot]`: by the name of a built-in, from a file, or a table.

use crate::robot::choice::RobotChoice;
use crate::robot::fault::{Fault, report};
use robhaz_keys::prelude::*;
use serde_json::{Value as Json, json};
use std::path::Path;

/// A robot file that is compiled into the program: its name, path and text.
pub type BuiltIn = (&'static str, &'static str, &'static str);

/// One of the two halves of `[robot]`.
pub(crate) struct Part {
    /// Full key.
    pub path: &'static str,
    /// The first is the default.
    pub(super) builtins: &'static [BuiltIn],
    pub(super) what: &'static str,
    pub(super) keys: &'static [Key<RobotChoice>],
    pub(super) name: fn(&mut RobotChoice) -> &mut String,
    /// Completes and checks a table whose keys have no problem.
    pub(super) check: fn(&mut RobotChoice, &Node) -> Result<(), Fault>,
}

impl Form for Part {
    type Value = RobotChoice;

    fn read(&self, reader: &mut Reader, node: &Node, _path: &str, into: &mut RobotChoice) {
        let mark = reader.mark();
        let Some((name, node, path)) = self.content(reader, Some(node)) else {
            return;
        };
        *(self.name)(into) = name;
        reader.table(self.keys, &node, path, into);
        if reader.mark() > mark {
            return;
        }
        if let Err(fault) = (self.check)(into, &node) {
            report(reader, &node, path, fault);
        }
    }

    fn about(&self) -> About {
        let (names, what) = (quoted(&self.names()), self.what);
        let values = format!("{names}, the path of a .toml file, or a table");
        About {
            values,
            ..About::new(format!(
                "{names}, the path of a {what} file ending in .toml, or a table with the keys of such a file"
            ))
        }
    }

    fn schema(&self, _defaults: Option<&mut RobotChoice>) -> Json {
        let table = key::schema(self.keys, None);
        json!({"anyOf": [{"enum": self.names()}, {"type": "string", "pattern": r"\.toml$"}, table]})
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, about: &str, of: &mut RobotChoice) {
        out.head(head, about);
        out.table(self.keys, of, path);
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, value: &mut RobotChoice) {
        key::rows(rows, self.keys, path, value);
    }
}

impl Part {
    fn names(&self) -> Vec<&'static str> {
        self.builtins.iter().map(|b| b.0).collect()
    }

    /// The content of a built-in or a file.
    fn by_name(&self, reader: &mut Reader, node: &Node, name: &str) -> Option<Node> {
        if let Some((_, file, text)) = self.builtins.iter().find(|b| b.0 == name) {
            return reader.document(&Source::file(file, text));
        }
        if Path::new(name).extension().is_none_or(|e| e != "toml") {
            let allowed = self.allowed() + &did_you_mean(name, &self.names());
            reader.refuse(node, self.path, &allowed);
            return None;
        }
        let path = reader.base_dir.join(name);
        let shown = path.display().to_string();
        let text = source::read_toml(&path).map_err(|error| {
            let (found, allowed) = (node.origin.found(), self.allowed());
            let message = format!("found {found}, but {shown} {error}; allowed: {allowed}");
            Problem::at(&node.origin, self.path, message)
        });
        let text = reader.keep(text)?;
        reader.document(&Source::file(&shown, &text))
    }

    /// The name and the table that `chosen`, or the default, stands for, and the table's key; an
    /// empty one for a file.
    pub(super) fn content(
        &self,
        reader: &mut Reader,
        chosen: Option<&Node>,
    ) -> Option<(String, Node, &'static str)> {
        let (name, node, path) = match chosen.map(|node| (node, &node.value)) {
            None => {
                let (name, file, text) = self.builtins[0];
                (name, reader.document(&Source::file(file, text))?, "")
            }
            Some((node, Value::Text(name))) => {
                (name.as_str(), self.by_name(reader, node, name)?, "")
            }
            Some((node, Value::Table(_))) => ("inline", node.clone(), self.path),
            Some((node, _)) => {
                reader.refuse(node, self.path, &self.allowed());
                return None;
            }
        };
        Some((name.to_owned(), node, path))
    }

    /// The table that `chosen` (or the default) names, so that an override can change a part of it.
    /// Its name gets the ending [`CHANGED`].
    pub(crate) fn written_out(
        &self,
        reader: &mut Reader,
        chosen: Option<&Node>,
        origin: &Origin,
    ) -> Option<Node> {
        let own_name = chosen.map(|c| c.get("name").and_then(Node::as_text));
        let (name, node) = match (chosen, own_name.flatten()) {
            (Some(table), Some(name)) => (name.to_owned(), table.clone()),
            (Some(other), None) if other.as_text().is_none() => return Some(other.clone()),
            _ => self
                .content(reader, chosen)
                .map(|(name, node, _)| (name, node))?,
        };
        let name = name.strip_suffix(CHANGED).unwrap_or(&name);
        let mut entries: Vec<Entry> = node.entries().unwrap_or_default().to_vec();
        entries.retain(|e| e.key != "name");
        let name = Node::text(origin, &format!("{name}{CHANGED}"));
        entries.push(Entry::new("name", origin, name));
        Some(Node::new(&node.origin, Value::Table(entries)))
    }
}

/// Ends the name of a part that an override has changed.
const CHANGED: &str = ", changed";

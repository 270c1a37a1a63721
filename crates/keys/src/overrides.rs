//! Overrides `key=value` from the command line, put into the tree of the file before it is read.

use crate::error::Problem;
use crate::reader::{Reader, join};
use crate::source::{Entry, Node, Origin, Source, Value, value_or_text};
use std::sync::Arc;

/// Largest number of parts of a dotted key, far above that of any key: each is a call.
const MOST_PARTS: usize = 32;

/// One step of a dotted key.
pub enum Step<'a> {
    /// A key of a table.
    Key(&'a str),
    /// An index of an array, from 0.
    Index(usize),
}

/// How overrides are put into the tree of a kind of file.
pub struct Overrides {
    /// Examples in the message on a text that is no override.
    pub example: &'static str,
    /// The value of a key before an override changes a part of it: what the key has, if anything,
    /// with what a name or a default stands for written out; `None` after a problem. The text is
    /// the full dotted key, the place that of the override.
    pub expand: fn(&mut Reader, &str, Option<Node>, &Origin) -> Option<Node>,
}

impl Overrides {
    /// Puts one override into the tree.
    pub fn apply(&self, reader: &mut Reader, root: &mut Node, text: &str) {
        let source = Source::set(text);
        let Some((key, _)) = text.split_once('=') else {
            return self.malformed(reader, &source, text.len());
        };
        let Some(steps) = steps(key.trim()) else {
            return self.malformed(reader, &source, key.len());
        };
        let origin = Origin::new(&source, 0..key.len());
        if steps.len() > MOST_PARTS {
            let found = steps.len();
            let message = format!("found a key of {found} parts, allowed: at most {MOST_PARTS}");
            return reader.push(Problem::at(&origin, "", message));
        }
        let rest = &text[key.len() + 1..];
        let blank = rest.len() - rest.trim_start().len();
        let value = value_or_text(&source, key.len() + 1 + blank);
        self.put(reader, root, "", &steps, &origin, value);
    }

    fn malformed(&self, reader: &mut Reader, source: &Arc<Source>, length: usize) {
        let origin = Origin::new(source, 0..length);
        let message = format!(
            "not an override, allowed: key=value with a dotted key, such as {}",
            self.example
        );
        reader.push(Problem::at(&origin, "", message));
    }

    fn put(
        &self,
        reader: &mut Reader,
        node: &mut Node,
        path: &str,
        steps: &[Step<'_>],
        origin: &Origin,
        value: Node,
    ) {
        let Some((step, rest)) = steps.split_first() else {
            *node = value;
            return;
        };
        let message = match (step, &mut node.value) {
            (Step::Key(key), Value::Table(entries)) => {
                let path = join(path, key);
                let at = entries.iter().position(|e| e.key == *key);
                let present = at.map(|i| entries.remove(i).node);
                let child = match rest.is_empty() {
                    true => value,
                    false => {
                        let Some(mut child) = (self.expand)(reader, &path, present, origin) else {
                            return;
                        };
                        self.put(reader, &mut child, &path, rest, origin, value);
                        child
                    }
                };
                let entry = Entry::new(key, origin, child);
                return entries.insert(at.unwrap_or(entries.len()), entry);
            }
            (Step::Index(index), Value::Array(items)) => {
                let (count, inner) = (items.len(), format!("{path}[{index}]"));
                match items.get_mut(*index) {
                    Some(item) => return self.put(reader, item, &inner, rest, origin, value),
                    None if count == 0 => format!("found index {index}, but {path} is empty"),
                    None => {
                        let last = count - 1;
                        format!("found index {index}, allowed: 0 to {last} ({path} has {count})")
                    }
                }
            }
            (step, _) => {
                let wanted = match step {
                    Step::Key(key) => format!("the key {key}"),
                    Step::Index(index) => format!("the index {index}"),
                };
                format!(
                    "found {wanted} under what is {}, allowed: keys of tables and indices of arrays",
                    node.type_name()
                )
            }
        };
        reader.push(Problem::at(origin, path, message));
    }
}

/// `a.b.0.c` or `a.b[0].c`, taken apart.
pub fn steps(key: &str) -> Option<Vec<Step<'_>>> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let mut steps = Vec::new();
    for part in key.split('.') {
        let (name, indices) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() || !name.chars().all(plain) {
            return None;
        }
        steps.push(match name.parse() {
            Ok(index) => Step::Index(index),
            Err(_) => Step::Key(name),
        });
        for index in indices.split_inclusive(']') {
            let index = index.strip_prefix('[')?.strip_suffix(']')?;
            steps.push(Step::Index(index.parse().ok()?));
        }
    }
    Some(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dotted_keys_are_taken_apart() {
        let show = |key| {
            let steps = steps(key)?;
            let steps = steps.iter().map(|s| match s {
                Step::Key(key) => (*key).to_owned(),
                Step::Index(index) => format!("#{index}"),
            });
            Some(steps.collect::<Vec<_>>().join(" "))
        };
        assert_eq!(show("a.b-c.d_1").as_deref(), Some("a b-c d_1"));
        assert_eq!(show("a.0.b").as_deref(), Some("a #0 b"));
        assert_eq!(show("a[0][12].b").as_deref(), Some("a #0 #12 b"));
        for bad in [
            "", ".", "a.", ".a", "a..b", "a b", "a[", "a[x]", "a[0", "a[0]b", "[0]",
        ] {
            assert_eq!(show(bad), None, "{bad}");
        }
    }
}

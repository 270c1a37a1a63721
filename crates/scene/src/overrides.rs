//! Overrides `key=value` from the command line, put into the tree of the file before it is read.

use crate::error::Problem;
use crate::estimators;
use crate::reader::Reader;
use crate::robot::{GEOMETRY_PART, MASS_PART};
use crate::source::{Entry, Node, Origin, Source, Value, value_or_text};
use std::sync::Arc;

/// One step of a dotted key.
pub(crate) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// Puts one override into the tree.
pub(crate) fn apply(reader: &mut Reader, root: &mut Node, text: &str) {
    let source = Source::set(text);
    let Some((key, _)) = text.split_once('=') else {
        return malformed(reader, &source, text.len());
    };
    let Some(steps) = steps(key.trim()) else {
        return malformed(reader, &source, key.len());
    };
    let origin = Origin::new(&source, 0..key.len());
    let rest = &text[key.len() + 1..];
    let blank = rest.len() - rest.trim_start().len();
    let value = value_or_text(&source, key.len() + 1 + blank);
    put(reader, root, "", &steps, &origin, value);
}

fn malformed(reader: &mut Reader, source: &Arc<Source>, length: usize) {
    let origin = Origin::new(source, 0..length);
    let message = "not an override, allowed: key=value with a dotted key, such as drive.kp=2 or estimator.0.observer_pole=30";
    reader.push(Problem::at(&origin, "", message.to_owned()));
}

/// `a.b.0.c` or `a.b[0].c`, taken apart.
pub(crate) fn steps(key: &str) -> Option<Vec<Step<'_>>> {
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

fn put(
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
    match (step, &mut node.value) {
        (Step::Key(key), Value::Table(entries)) => {
            let path = crate::reader::join(path, key);
            let at = entries.iter().position(|e| e.key == *key);
            let present = at.map(|i| entries.remove(i).node);
            let Some(mut child) = before(reader, &path, present, rest, origin) else {
                return;
            };
            put(reader, &mut child, &path, rest, origin, value);
            let entry = Entry::new(key, origin, child);
            entries.insert(at.unwrap_or(entries.len()), entry);
        }
        (Step::Index(index), Value::Array(items)) => {
            let count = items.len();
            match items.get_mut(*index) {
                Some(item) => {
                    let path = format!("{path}[{index}]");
                    put(reader, item, &path, rest, origin, value);
                }
                None => {
                    let message = match count {
                        0 => format!("found index {index}, but {path} is empty"),
                        _ => format!(
                            "found index {index}, allowed: 0 to {} ({path} has {count})",
                            count - 1
                        ),
                    };
                    reader.push(Problem::at(origin, path, message));
                }
            }
        }
        (step, _) => {
            let wanted = match step {
                Step::Key(key) => format!("the key {key}"),
                Step::Index(index) => format!("the index {index}"),
            };
            let message = format!(
                "found {wanted} under what is {}, allowed: keys of tables and indices of arrays",
                node.type_name()
            );
            reader.push(Problem::at(origin, path, message));
        }
    }
}

/// The value under `path` before `rest` of an override goes into it; `None` after a problem.
///
/// Where only a part of a robot or of the estimators is changed, the default or named one is
/// expanded first.
fn before(
    reader: &mut Reader,
    path: &str,
    present: Option<Node>,
    rest: &[Step<'_>],
    origin: &Origin,
) -> Option<Node> {
    let mut parts = [&GEOMETRY_PART, &MASS_PART].into_iter();
    let part = parts.find(|p| p.path == path);
    match (present, part) {
        (present, Some(part)) if !rest.is_empty() => {
            part.written_out(reader, present.as_ref(), origin)
        }
        (Some(present), _) => Some(present),
        (None, _) if path == estimators::PATH => Some(estimators::default_node(origin)),
        (None, _) => Some(Node::new(origin, Value::Table(Vec::new()))),
    }
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

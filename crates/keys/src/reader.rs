//! Collects the problems of a file while it is read.

use crate::error::{FileError, Problem};
use crate::source::{self, Entry, Node, Origin, Source, Value, document, grouped};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest number of problems that are shown.
const SHOWN: usize = 20;
/// Largest number of problems that are kept; further ones are only counted. Sections are not read
/// in the order of lines: the first problems by line are among these unless there are many more.
const KEPT: usize = 1000;

/// Collects problems while a file is read.
pub struct Reader {
    problems: Vec<Problem>,
    /// Number of further problems, which were only counted.
    hidden: usize,
    /// Paths in the file are relative to this folder.
    pub base_dir: PathBuf,
    /// The seed of the file, for what is drawn while it is read.
    pub seed: u64,
    /// The table that has a key of a name, for messages on misplaced keys.
    pub home_of: fn(&str) -> Option<String>,
}

impl Reader {
    /// A reader of files in a folder. `home_of` names the table that has a key of a name.
    pub fn new(base_dir: PathBuf, home_of: fn(&str) -> Option<String>) -> Self {
        Self {
            problems: Vec::new(),
            hidden: 0,
            base_dir,
            seed: 0,
            home_of,
        }
    }

    /// Text, name and folder of a file; `allowed` says what it must be.
    pub fn load<'p>(
        path: &'p Path,
        allowed: &str,
    ) -> Result<(String, String, &'p Path), FileError> {
        let shown = path.display().to_string();
        let text = source::read_toml(path)
            .map_err(|error| FileError::unread(&shown, format!("{error}; allowed: {allowed}")))?;
        Ok((text, shown, path.parent().unwrap_or(Path::new(""))))
    }

    /// Parses a text as TOML and reads it with `read`; the error has all problems.
    pub fn read<T>(
        mut self,
        name: &str,
        text: &str,
        read: impl FnOnce(&mut Self, Node) -> T,
    ) -> Result<T, FileError> {
        source::check_toml(text).map_err(|error| FileError::unread(name, error))?;
        let root = self.document(&Source::file(name, text));
        let value = root.map(|root| read(&mut self, root));
        let count = self.mark();
        // Nothing was read only after a problem.
        if let (Some(value), 0) = (value, count) {
            return Ok(value);
        }
        let mut problems = self.problems;
        problems.sort_by_cached_key(|p| (p.line.is_none(), p.file.clone(), p.line));
        problems.truncate(SHOWN);
        if count > SHOWN {
            let message = format!("and {} more problems", grouped(count - SHOWN));
            problems.push(Problem::unread(&problems[0].file, message));
        }
        Err(FileError { problems, count })
    }

    /// The entries of a table; anything else is a problem.
    pub fn entries<'n>(&mut self, node: &'n Node, path: &str) -> &'n [Entry] {
        node.entries().unwrap_or_else(|| {
            self.refuse(node, path, "a table");
            &[]
        })
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

    /// Number of problems so far.
    pub fn mark(&self) -> usize {
        self.problems.len() + self.hidden
    }

    /// Whether no problem lies under one of these keys.
    pub fn is_clean(&self, keys: &[&str]) -> bool {
        let under = |problem: &Problem| keys.iter().any(|k| problem.key.starts_with(k));
        self.hidden == 0 && !self.problems.iter().any(under)
    }

    /// Adds a problem at a place. The message is made only if the problem is kept, so that a file
    /// with a million mistakes is read as fast as a correct one.
    pub fn complain(&mut self, origin: &Origin, key: &str, message: impl FnOnce() -> String) {
        match self.problems.len() < KEPT {
            true => self.push(Problem::at(origin, key, message())),
            false => self.hidden += 1,
        }
    }

    /// Adds a problem.
    pub fn push(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// A value, or none after a problem, which is added.
    pub fn keep<T>(&mut self, found: Result<T, Problem>) -> Option<T> {
        found.map_err(|problem| self.push(problem)).ok()
    }

    /// Adds a problem: the value at a node is not allowed.
    pub fn refuse(&mut self, node: &Node, path: &str, allowed: &str) {
        self.complain(&node.origin, path, || refusal(node, allowed));
    }

    /// Adds a problem: the value of a key of a table is not allowed. It is at the key, or at the
    /// table that lacks it.
    pub fn refuse_key(&mut self, table: &Node, path: &str, key: &str, allowed: &str) {
        self.refuse(table.get(key).unwrap_or(table), &join(path, key), allowed);
    }

    /// Adds a problem if a table has a key: beside others it is not allowed.
    pub fn refuse_given(&mut self, table: &Node, path: &str, key: &str, allowed: &str) {
        if let Some(given) = table.get(key) {
            self.refuse(given, &join(path, key), allowed);
        }
    }

    /// Parses a text as TOML; `None` after syntax errors, which become problems.
    pub fn document(&mut self, source: &Arc<Source>) -> Option<Node> {
        document(source, |origin, message| {
            self.complain(origin, "", || {
                let line = origin.whole_line();
                format!("TOML does not allow this: {message}; found: {line}")
            });
        })
    }
}

/// `path.name`, or `name` alone at the top.
pub fn join(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

/// What was found and what is allowed.
pub(crate) fn refusal(node: &Node, allowed: &str) -> String {
    let found = node.origin.found();
    let kind = match node.value {
        // Texts and numbers show what they are.
        Value::Text(_) | Value::Float(_) | Value::Integer(..) => String::new(),
        _ => format!(" ({})", node.type_name()),
    };
    format!("found {found}{kind}, allowed: {allowed}")
}

/// A key in messages: at most its first 60 characters.
fn short_key(key: &str) -> String {
    const LONGEST: usize = 60;
    match key.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &key[..end]),
        None => key.to_owned(),
    }
}

/// Longest name that is compared, characters: the time of a comparison grows with the length.
const LONGEST: usize = 64;

/// The allowed name that a misspelt one most likely means: few letters differ, or the start is the
/// same.
pub fn nearest<'a>(found: &str, allowed: &[&'a str]) -> Option<&'a str> {
    /// Least Jaro-Winkler similarity, 0 to 1; it gives the start more weight.
    const ALIKE: f64 = 0.85;
    if found.len() > LONGEST {
        return None;
    }
    let found = found.to_lowercase();
    // Three letters in ten may be wrong, but never all of them.
    let tolerance = (found.chars().count() * 3 / 10).max(1);
    let typing_error = allowed
        .iter()
        .map(|name| {
            let lower = name.to_lowercase();
            (strsim::damerau_levenshtein(&found, &lower), *name)
        })
        .filter(|(distance, name)| *distance <= tolerance && *distance < name.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name);
    let alike = || {
        let likeness = |name: &&str| strsim::jaro_winkler(&found, &name.to_lowercase());
        let best = allowed
            .iter()
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
        (likeness(best) > ALIKE).then_some(*best)
    };
    typing_error.or_else(alike)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_find_their_word() {
        let words = ["speed", "torque_limit", "kp", "ki"];
        assert_eq!(nearest("torqe_limit", &words), Some("torque_limit"));
        assert_eq!(nearest("Speed", &words), Some("speed"));
        assert_eq!(nearest("kx", &words), Some("kp"));
        assert_eq!(nearest("torqe", &words), Some("torque_limit"));
        assert_eq!(nearest("gravity", &words), None);
        assert_eq!(nearest("", &words), None);
        assert_eq!(nearest("b", &["A", "B"]), Some("B"));
        assert_eq!(nearest("C", &["A", "B"]), None);
    }
}

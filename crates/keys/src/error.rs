//! Problems of a file. Each names its file, line and key, what was found and what is allowed.

use crate::source::Origin;
use miette::{Diagnostic, LabeledSpan, SourceCode};
use std::fmt;

/// One problem. Its `Display` is one complete line, with control characters escaped.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The file as the user named it, or `--set key=value` for an override.
    pub file: String,
    /// The line in the file, from 1; `None` for an override and for a file that cannot be read.
    pub line: Option<usize>,
    /// The full dotted key; empty where there is none.
    pub key: String,
    /// What was found and what is allowed.
    pub message: String,
    /// Where it was written; `None` for a file that cannot be read.
    pub origin: Option<Origin>,
    /// Whether it is about several keys or a missing key.
    pub whole: bool,
}

impl Problem {
    /// A problem of a key at a place.
    pub fn at(origin: &Origin, key: &str, message: String) -> Self {
        let source = &origin.source;
        Self {
            line: (!source.is_override).then(|| origin.line()),
            key: harmless(key),
            origin: Some(origin.clone()),
            ..Self::unread(source.text.name(), message)
        }
    }

    /// A problem of a file without a known line.
    pub fn unread(file: &str, message: String) -> Self {
        Self {
            file: harmless(file),
            line: None,
            key: String::new(),
            message: harmless(&message),
            origin: None,
            whole: false,
        }
    }

    /// The same problem at another place.
    pub fn move_to(&mut self, origin: &Origin) {
        let whole = self.whole;
        *self = Self::at(origin, &self.key, std::mem::take(&mut self.message));
        self.whole = whole;
    }

    /// The same problem, about several keys or a missing key.
    pub fn whole(mut self) -> Self {
        self.whole = true;
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        f.write_str(": ")?;
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

impl Diagnostic for Problem {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.origin.as_ref()?.source.text)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.origin.as_ref()?.of_first_line();
        let label = LabeledSpan::new_with_span(None, (place.start, place.len()));
        Some(Box::new(std::iter::once(label)))
    }
}

/// The problems of a file: at least one, at most 20.
///
/// `Display` gives the first problem and the number of others; [`FileError::problems`] are those
/// that are shown. As a [`Diagnostic`] it shows the place of the first problem, and the others as
/// related diagnostics.
///
/// `Debug`, which a `main` that returns it prints, has all of them as text.
pub struct FileError {
    /// The problems that are shown: file by file in the order of their lines, those of overrides
    /// last. Of more than 20, the first 20 and a last one with the number of the others.
    pub problems: Vec<Problem>,
    /// Number of all problems.
    pub count: usize,
}

impl FileError {
    /// The problem of a file that cannot be read.
    pub fn unread(file: &str, message: String) -> Self {
        Problem::unread(file, message).into()
    }

    /// Whether every problem is about several keys, each of which is allowed alone.
    pub fn is_conflict(&self) -> bool {
        self.problems.iter().all(|problem| problem.whole)
    }
}

impl From<Problem> for FileError {
    fn from(problem: Problem) -> Self {
        Self {
            problems: vec![problem],
            count: 1,
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problems.first().map_or(Ok(()), |first| first.fmt(f))?;
        match self.count {
            0 | 1 => Ok(()),
            2 => f.write_str(" (and 1 more problem)"),
            n => write!(f, " (and {} more problems)", n - 1),
        }
    }
}

impl fmt::Debug for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problems: Vec<String> = self.problems.iter().map(Problem::to_string).collect();
        f.write_str(&problems.join("\n"))
    }
}

impl std::error::Error for FileError {}

impl Diagnostic for FileError {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.problems.first()?.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.problems.first()?.labels()
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let rest = self.problems.get(1..).filter(|rest| !rest.is_empty())?;
        Some(Box::new(rest.iter().map(|p| p as &dyn Diagnostic)))
    }
}

/// Escapes a text for terminals: control characters and marks of the writing direction become
/// escapes such as `\u{1b}`, a tab becomes a space.
pub fn harmless(text: &str) -> String {
    let is_mark = |c: char| matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    let shown = |c: char| match c {
        '\t' => " ".to_owned(),
        c if c.is_control() || is_mark(c) => c.escape_unicode().to_string(),
        c => c.to_string(),
    };
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_is_printed_commands_a_terminal() {
        let shown = harmless("a\u{1b}[31mb\u{9b}\r\n\tc\u{202e}é");
        assert_eq!(shown, r"a\u{1b}[31mb\u{9b}\u{d}\u{a} c\u{202e}é");
    }
}

//! What is wrong with a scene: every problem names its file, line and key, what was found and what is allowed.

use crate::source::{Origin, SourceKind};
use miette::{Diagnostic, LabeledSpan, SourceCode};
use std::fmt;

/// One thing that is wrong. Its `Display` is one line that says everything.
#[derive(Clone, Debug)]
pub struct Problem {
    file: String,
    key: String,
    message: String,
    origin: Option<Origin>,
    /// A rule over several keys or a missing key: means nothing in a file that could be read in part only.
    pub(crate) whole: bool,
    pub(crate) syntax: bool,
}

impl Problem {
    pub(crate) fn at(origin: &Origin, key: &str, message: String) -> Self {
        Self {
            file: origin.source.named.name().to_owned(),
            key: key.to_owned(),
            message,
            origin: Some(origin.clone()),
            whole: false,
            syntax: false,
        }
    }

    /// A file of which not even the text is known.
    pub(crate) fn unread(file: &str, message: String) -> Self {
        Self {
            file: file.to_owned(),
            key: String::new(),
            message,
            origin: None,
            whole: false,
            syntax: false,
        }
    }

    pub(crate) fn whole(self) -> Self {
        Self {
            whole: true,
            ..self
        }
    }

    pub(crate) fn syntax(self) -> Self {
        Self {
            syntax: true,
            ..self
        }
    }

    pub(crate) fn origin(&self) -> Option<&Origin> {
        self.origin.as_ref()
    }

    /// The file as the user named it, or `--set key=value` for an override.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The line in the file, from 1; `None` for an override and for a file that cannot be read.
    pub fn line(&self) -> Option<usize> {
        let origin = self.origin.as_ref()?;
        (origin.source.kind == SourceKind::File).then(|| origin.line())
    }

    /// The full dotted key; empty where there is none.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// What was found and what is allowed.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line() {
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
        let origin = self.origin.as_ref()?;
        Some(&origin.source.named)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let origin = self.origin.as_ref()?;
        let label = LabeledSpan::new_with_span(None, origin.span.clone());
        Some(Box::new(std::iter::once(label)))
    }
}

/// Everything that is wrong with a scene, at least one problem.
///
/// `Display` gives the first problem and how many more there are; [`SceneError::problems`] gives all. As a
/// [`Diagnostic`] it shows the first problem's place, and the others as related ones.
#[derive(Debug)]
pub struct SceneError {
    /// On the heap, so that a result that holds an error stays small.
    first: Box<Problem>,
    rest: Vec<Problem>,
}

impl SceneError {
    pub(crate) fn new(first: Problem, rest: Vec<Problem>) -> Self {
        Self {
            first: Box::new(first),
            rest,
        }
    }

    /// All problems: file by file in the order of their lines, those of overrides last.
    pub fn problems(&self) -> impl Iterator<Item = &Problem> {
        std::iter::once(&*self.first).chain(&self.rest)
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.first.fmt(f)?;
        match self.rest.len() {
            0 => Ok(()),
            1 => f.write_str(" (and 1 more problem)"),
            n => write!(f, " (and {n} more problems)"),
        }
    }
}

impl std::error::Error for SceneError {}

impl Diagnostic for SceneError {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.first.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.first.labels()
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        if self.rest.is_empty() {
            return None;
        }
        Some(Box::new(self.rest.iter().map(|p| p as &dyn Diagnostic)))
    }
}

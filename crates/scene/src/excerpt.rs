//! The lines around a problem, cut and escaped for any terminal.

use crate::source::Origin;
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::fmt::Write;

/// Largest number of columns of a line: with the gutter and a line number of six digits, 120.
const WIDTH: usize = 108;
/// Columns shown before the place where the line is cut.
const BEFORE: usize = 40;

/// The line of a problem and its neighbours: each cut to [`WIDTH`] columns, control characters escaped.
#[derive(Clone, Debug)]
pub(crate) struct Excerpt {
    name: String,
    text: String,
    /// The place in `text`, in bytes.
    pub span: (usize, usize),
    /// Number of the first line, from 0.
    first_line: usize,
}

impl Excerpt {
    pub fn of(origin: &Origin) -> Self {
        let source = &origin.source;
        let line = origin.line();
        let mut excerpt = Self {
            name: harmless(&source.name),
            text: String::new(),
            span: (0, 0),
            first_line: line.saturating_sub(2),
        };
        for number in line.saturating_sub(1).max(1)..=line + 1 {
            let Some(of_line) = source.line_span(number) else {
                continue;
            };
            let text = source.text.get(of_line.clone()).unwrap_or_default();
            if number == line {
                // Of a place over several lines, the first is shown.
                let place = |byte: usize| byte.clamp(of_line.start, of_line.end) - of_line.start;
                excerpt.place(text, place(origin.span.start), place(origin.span.end));
            } else {
                excerpt.text += &cut(text, WIDTH);
            }
            excerpt.text.push('\n');
        }
        excerpt
    }

    /// Adds the line of the place, cut so that the place is visible.
    fn place(&mut self, line: &str, start: usize, end: usize) {
        let parts = (line.get(..start), line.get(start..end), line.get(end..));
        let (Some(before), Some(place), Some(after)) = parts else {
            self.text += &cut(line, WIDTH);
            return;
        };
        // Only the end of the text before the place can fit.
        let tail = before.char_indices().rev().nth(WIDTH).map_or(0, |(i, _)| i);
        let before = harmless(&before[tail..]);
        if tail > 0 || columns(&before) + columns(&cut(place, WIDTH)) > WIDTH {
            let mut kept = 0;
            let from = before.char_indices().rev().find(|(_, c)| {
                kept += column(*c);
                kept > BEFORE
            });
            let from = from.map_or(0, |(i, c)| i + c.len_utf8());
            if from > 0 || tail > 0 {
                self.text += "... ";
            }
            self.text += &before[from..];
        } else {
            self.text += &before;
        }
        let line_start = self.text.rfind('\n').map_or(0, |i| i + 1);
        let left = |text: &str| WIDTH.saturating_sub(columns(&text[line_start..]));
        let place = cut(place, left(&self.text));
        self.span = (self.text.len(), place.len());
        self.text += &place;
        let after = cut(after, left(&self.text));
        self.text += &after;
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let found = self.text.read_span(span, lines_before, lines_after)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            found.data(),
            *found.span(),
            self.first_line + found.line(),
            found.column(),
            found.line_count(),
        )))
    }
}

/// The start of a text, at most `width` columns, escaped.
fn cut(text: &str, width: usize) -> String {
    const DOTS: &str = " ...";
    // A character takes at least one column.
    let end = text
        .char_indices()
        .nth(width)
        .map_or(text.len(), |(i, _)| i);
    let shown = harmless(&text[..end]);
    if end == text.len() && columns(&shown) <= width {
        return shown;
    }
    if width < DOTS.len() {
        return String::new();
    }
    let mut used = DOTS.len();
    let fits = shown.chars().take_while(|c| {
        used += column(*c);
        used <= width
    });
    fits.collect::<String>() + DOTS
}

/// Largest number of columns that a character takes.
fn column(c: char) -> usize {
    if c.is_ascii() { 1 } else { 2 }
}

fn columns(text: &str) -> usize {
    text.chars().map(column).sum()
}

/// Escapes a text for terminals: control characters and marks of the writing direction become escapes such as `\u{1b}`,
/// a tab becomes a space.
pub(crate) fn harmless(text: &str) -> String {
    let is_mark = |c: char| matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\t' => out.push(' '),
            c if c.is_control() || is_mark(c) => {
                // Writing to a text cannot fail.
                let _ = write!(out, "{}", c.escape_unicode());
            }
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Source;
    use proptest::prelude::*;

    #[test]
    fn nothing_that_is_printed_commands_a_terminal() {
        let shown = harmless("a\u{1b}[31mb\u{9b}\r\n\tc\u{202e}é");
        assert_eq!(shown, r"a\u{1b}[31mb\u{9b}\u{d}\u{a} c\u{202e}é");
    }

    proptest! {
        /// Property: for any text and place, lines are short and the place is in the text.
        #[test]
        fn excerpts_are_short(text in "[ -~\u{1b}é\t\n漢]{0,400}", at in 0..400_usize, length in 0..300_usize) {
            let start = (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
            let end = (0..=(at + length).min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
            let source = Source::file("x", &text);
            let excerpt = Excerpt::of(&Origin { source, span: start..end.max(start) });
            for line in excerpt.text.lines() {
                prop_assert!(columns(line) <= WIDTH, "{} columns: {line}", columns(line));
                prop_assert!(!line.chars().any(char::is_control));
            }
            let (from, length) = excerpt.span;
            prop_assert!(excerpt.text.get(from..from + length).is_some());
        }
    }
}

//! Tables as text, in the dialects of CSV that instruments and spreadsheets write.
//!
//! Separator comma, semicolon or tab; decimal point or comma; quotes; any line end; with or without
//! a byte order mark. Comments with `#`, rows without content and the line `sep=;` are left out.

use csv::{ByteRecord, Reader, ReaderBuilder};
use std::borrow::Cow;
use std::io::{self, Read};

/// Rows from which the separator is found.
const SAMPLE: usize = 20;
/// The start of a file in which these rows are sought, bytes. Without a line end in it, it is no
/// table.
const HEAD: usize = 1 << 20;
/// Separators in the order in which they are tried: a comma may be the decimal mark of the others.
const SEPARATORS: [(u8, &str); 3] = [(b'\t', "tab"), (b';', "semicolon"), (b',', "comma")];

/// A table as text, read row by row.
pub struct TextTable<'a> {
    reader: Reader<Box<dyn Read + Send + 'a>>,
    /// The separator, and its name.
    pub(crate) separator: (u8, &'static str),
    /// Line feeds that the reader has passed at the end of a row: none of `\r\n`, which it ends at
    /// `\r`.
    passed: u64,
}

impl<'a> TextTable<'a> {
    /// Opens a table at its start.
    ///
    /// # Errors
    /// Those of the source; `InvalidData` for UTF-16 and for what has no lines.
    pub fn open(mut source: impl Read + Send + 'a) -> io::Result<Self> {
        let mut head = Vec::new();
        source.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
        if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
            let message = "found text in UTF-16, allowed: UTF-8 or plain ASCII";
            return Err(invalid(message));
        }
        let line_end: &[u8] = match head.iter().position(|b| b"\r\n".contains(b)) {
            None if head.len() == HEAD => {
                return Err(invalid("found no line end in its first MB, allowed: lines"));
            }
            Some(i) if head[i..].starts_with(b"\r\n") => b"\r\n",
            Some(i) if head[i] == b'\r' => b"\r",
            _ => b"\n",
        };
        let separator = separator(&head);
        // The last row ends as the others do, so that its line is counted alike.
        let bytes = io::Cursor::new(head).chain(source).chain(line_end);
        Ok(Self {
            reader: rows(separator.0, Box::new(bytes)),
            separator,
            passed: u64::from(line_end == b"\n"),
        })
    }

    /// Reads the next row; false at the end.
    ///
    /// # Errors
    /// Those of the source.
    pub fn read(&mut self, row: &mut TextRow) -> io::Result<bool> {
        while self.reader.read_byte_record(&mut row.cells)? {
            if !is_blank(&row.cells) {
                let cells = row.cells.as_slice();
                let inside = match cells.contains(&b'\n') {
                    true => cells.iter().filter(|b| **b == b'\n').count() as u64,
                    false => 0,
                };
                let passed = inside + self.passed;
                row.line = self.reader.position().line().saturating_sub(passed);
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn invalid(message: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}

fn rows<R: Read>(separator: u8, source: R) -> Reader<R> {
    ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .buffer_capacity(1 << 16)
        .from_reader(source)
}

/// The separator by which every one of the first rows has two columns, else the one by which the
/// first row has.
fn separator(head: &[u8]) -> (u8, &'static str) {
    let counts = |separator: u8| -> Vec<usize> {
        let rows = rows(separator, head).into_byte_records();
        let filled = rows.map_while(Result::ok).filter(|row| !is_blank(row));
        filled.take(SAMPLE).map(|row| row.len()).collect()
    };
    let tried = SEPARATORS.map(|(byte, _)| counts(byte));
    let is_table = |c: &Vec<usize>| !c.is_empty() && c.iter().all(|n| *n > 1);
    let all = tried.iter().position(is_table);
    let first = || tried.iter().position(|c| c.first().is_some_and(|n| *n > 1));
    SEPARATORS[all.or_else(first).unwrap_or(2)]
}

/// Whether a row has no data: only separators, an indented comment, or the line `sep=;` that
/// spreadsheets write.
fn is_blank(row: &ByteRecord) -> bool {
    let first = row.get(0).unwrap_or_default().trim_ascii_start();
    first.starts_with(b"#")
        || first.starts_with(b"sep=")
        || row.iter().all(|cell| cell.trim_ascii().is_empty())
}

/// A row of a table.
#[derive(Default)]
pub struct TextRow {
    cells: ByteRecord,
    /// The line on which it starts, from 1.
    pub line: u64,
}

impl TextRow {
    /// Number of its cells.
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// Number of its cells up to the last that is not empty.
    pub fn filled(&self) -> usize {
        let filled = self.cells.iter().rposition(|c| !c.trim_ascii().is_empty());
        filled.map_or(0, |last| last + 1)
    }

    /// The text of a cell without spaces around it; empty where there is no such cell.
    pub fn text(&self, index: usize) -> Cow<'_, str> {
        match String::from_utf8_lossy(self.cells.get(index).unwrap_or_default()) {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_owned()),
        }
    }

    /// The texts of all cells.
    pub fn texts(&self) -> Vec<String> {
        let texts = (0..self.count()).map(|i| self.text(i).into_owned());
        texts.collect()
    }
}

/// A number with a decimal point or comma, not both; also `nan` and `inf`.
pub fn decimal(text: &str) -> Option<f64> {
    let plain = text.parse().ok();
    plain.or_else(|| {
        let text = text.replace('\u{2212}', "-").replacen(',', ".", 1);
        text.parse().ok()
    })
}

/// Name and unit of a column `name [unit]` or `name (unit)`.
pub fn name_and_unit(column: &str) -> Option<(&str, &str)> {
    let (name, unit) = [('[', ']'), ('(', ')')]
        .iter()
        .find_map(|(open, close)| column.strip_suffix(*close)?.rsplit_once(*open))?;
    Some((name.trim(), unit.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: each row has the line on which it starts, whatever stands above it and however
    /// lines end.
    #[test]
    fn rows_have_their_lines() -> io::Result<()> {
        let text = "# a\nx;y\n\n1,5;2\n # b\n;\n3;\"4\n\"\n5;6";
        for end in ["\n", "\r\n"] {
            let text = text.replace('\n', end);
            for mark in ["", "\u{feff}"] {
                let text = format!("{mark}{text}");
                let mut table = TextTable::open(text.as_bytes())?;
                let (mut row, mut found) = (TextRow::default(), Vec::new());
                while table.read(&mut row)? {
                    found.push((row.line, row.texts().join("|")));
                }
                let expected = [(2, "x|y"), (4, "1,5|2"), (7, "3|4"), (9, "5|6")];
                assert_eq!(found, expected.map(|(line, row)| (line, row.to_owned())));
            }
        }
        Ok(())
    }

    #[test]
    fn decimals_have_a_point_or_a_comma() {
        assert_eq!(decimal("1,5"), Some(1.5));
        assert_eq!(decimal("-1.5e-3"), Some(-1.5e-3));
        assert_eq!(decimal("\u{2212}2"), Some(-2.0));
        for bad in ["1.234,5", "1,234.5", "1,234,5", "", "0x10", "1 5"] {
            assert_eq!(decimal(bad), None, "{bad}");
        }
    }
}

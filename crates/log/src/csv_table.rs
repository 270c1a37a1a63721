//! Logs as text: tables with the names of the columns in the first row.

use crate::error::{LogError, open_file};
use crate::rows::{ColumnInfo, Place, Row, Rows, TimeColumn, repeated};
use crate::stamp::{Stamp, TimeUnit};
use robhaz_terrain::text_table::{TextRow, TextTable, decimal, name_and_unit};
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// The columns of a CSV file, from its first row.
pub fn columns(path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
    let (_, names) = open(path)?;
    let column = |name: String| ColumnInfo {
        unit: name_and_unit(&name).map(|(_, unit)| unit.to_owned()),
        name,
    };
    Ok(names.into_iter().map(column).collect())
}

fn not_a_table(path: &Path, reason: &str) -> LogError {
    LogError::Format {
        path: path.to_path_buf(),
        what: "CSV",
        reason: format!(
            "{reason}; allowed: the names of the columns in the first line, after comments with #, UTF-8"
        ),
    }
}

/// A file after its first row, and the names in it.
fn open(path: &Path) -> Result<(TextTable<'static>, Vec<String>), LogError> {
    let not_a_table = |reason: &str| not_a_table(path, reason);
    let unread = |error: io::Error| not_a_table(&error.to_string());
    let mut table = TextTable::open(open_file(path)?).map_err(unread)?;
    let mut first = TextRow::default();
    if !table.read(&mut first).map_err(unread)? {
        return Err(not_a_table("it is empty"));
    }
    let (names, line) = (first.texts(), first.line());
    if names.iter().any(|name| name.contains('\u{fffd}')) {
        return Err(not_a_table("its first line is no UTF-8"));
    }
    if names.iter().all(|name| decimal(name).is_some()) {
        let reason = format!("line {line} has numbers, not names");
        return Err(not_a_table(&reason));
    }
    if let Some((first, again)) = repeated(&names) {
        let place = format!("line {line}, column {}", again + 1);
        let message = format!(
            "found the name {} again, allowed: each name once; column {} has it, too: rename or remove one",
            names[again],
            first + 1
        );
        return Err(LogError::place(path, place, message));
    }
    Ok((table, names))
}

/// The rows of a CSV file.
pub struct CsvRows {
    path: PathBuf,
    table: TextTable<'static>,
    names: Vec<String>,
    /// Index and unit of the time.
    time: (usize, TimeUnit),
    /// Indices of the chosen columns.
    chosen: Vec<usize>,
    /// Whether the file ends with a line end.
    ends_with_line: bool,
    /// The next row, read ahead so that the last one is known.
    ahead: TextRow,
    has_ahead: bool,
    current: TextRow,
    cut_off: Option<String>,
}

impl CsvRows {
    /// Opens a file. Every name is the name of a column.
    pub fn open(path: &Path, time: &TimeColumn, chosen: &[String]) -> Result<Self, LogError> {
        let (table, names) = open(path)?;
        let index = |name: &String| {
            let found = names.iter().position(|n| n == name);
            found.ok_or_else(|| LogError::whole(path, format!("has no column {name}")))
        };
        let mut rows = Self {
            path: path.to_path_buf(),
            table,
            time: (index(&time.name)?, time.unit),
            chosen: chosen.iter().map(index).collect::<Result<_, _>>()?,
            names,
            ends_with_line: ends_with_line(open_file(path)?).map_err(LogError::io(path))?,
            ahead: TextRow::default(),
            has_ahead: false,
            current: TextRow::default(),
            cut_off: None,
        };
        rows.advance()?;
        Ok(rows)
    }

    fn advance(&mut self) -> Result<(), LogError> {
        std::mem::swap(&mut self.current, &mut self.ahead);
        let read = self.table.read(&mut self.ahead);
        self.has_ahead = read.map_err(LogError::io(&self.path))?;
        Ok(())
    }

    /// A cell of the current row that is not what is allowed.
    fn refused(&self, column: usize, allowed: &str) -> LogError {
        let place = format!(
            "line {}, column {}",
            self.current.line(),
            self.names[column]
        );
        let found = shortened(&self.current.text(column));
        LogError::place(
            &self.path,
            place,
            format!("found {found:?}, allowed: {allowed}"),
        )
    }

    fn cell(&self, column: usize) -> Result<Option<f64>, LogError> {
        let text = self.current.text(column);
        match decimal(&text) {
            Some(value) => Ok(Some(value).filter(|v| v.is_finite())),
            None if text.is_empty() => Ok(None),
            None => Err(self.refused(column, "a number; nothing or nan for a lost reading")),
        }
    }

    fn stamp(&self) -> Result<Stamp, LogError> {
        let (column, unit) = self.time;
        let text = self.current.text(column);
        let stamp = match text.parse::<i64>() {
            Ok(whole) if unit != TimeUnit::SECOND => unit.of_whole(whole),
            _ => decimal(&text).and_then(|number| unit.of_float(number)),
        };
        stamp.ok_or_else(|| self.refused(column, "a finite number: every row has a time"))
    }
}

impl Rows for CsvRows {
    fn next_row(&mut self) -> Result<Option<Row>, LogError> {
        if !self.has_ahead {
            return Ok(None);
        }
        self.advance()?;
        let (found, expected) = (self.current.count(), self.names.len());
        let line = self.current.line();
        let is_last = !self.has_ahead;
        if is_last && (found < expected || !self.ends_with_line) {
            let why = match found < expected {
                true => format!("it has {found} of {expected} cells"),
                false => "it has no line end, so its last number may be cut".to_owned(),
            };
            self.cut_off = Some(format!("line {line}: {why}"));
            return Ok(None);
        }
        if found != expected {
            let message = format!(
                "found {found} cells, allowed: {expected}, as many as names in the first line; correct or remove this line"
            );
            return Err(LogError::place(&self.path, format!("line {line}"), message));
        }
        let cells = self.chosen.iter().map(|c| self.cell(*c));
        Ok(Some(Row {
            place: Place::Line(line),
            stamp: self.stamp()?,
            cells: cells.collect::<Result<_, _>>()?,
        }))
    }

    fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }
}

/// Whether the last byte is a line end.
fn ends_with_line(mut file: File) -> io::Result<bool> {
    let mut last = [0];
    if file.seek(SeekFrom::End(0))? > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    Ok(matches!(last, [b'\n' | b'\r']))
}

/// The start of a text.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

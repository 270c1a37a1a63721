//! Logs as text: tables with the names of the columns in the first row.

use crate::error::open_file;
use crate::rows::{finite, repeated};
use crate::{AddRow, ColumnInfo, LogError, Place, Row, Stamp, TimeColumn, TimeUnit, iso8601};
use robhaz_terrain::decimals::{Decimals, Grouping, NO_THOUSANDS};
use robhaz_terrain::text_table::{TextRow, TextTable, decimal, name_and_unit};
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// The columns of a CSV file, from its first row.
pub fn columns(path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
    let (_, names) = open(path)?;
    let column = |name: String| ColumnInfo {
        unit: name_and_unit(&name).map(|(_, unit)| unit.to_owned()),
        name,
        is_time_stamp: false,
    };
    Ok(names.into_iter().map(column).collect())
}

/// A file after its first row, and the names in it.
fn open(path: &Path) -> Result<(TextTable<'static>, Vec<String>), LogError> {
    let not_a_table = |reason: &str| {
        let allowed = "the names of the columns in the first line, after comments with #, UTF-8";
        LogError::format(path, "CSV", format!("{reason}; allowed: {allowed}"))
    };
    let unread = |error: io::Error| not_a_table(&error.to_string());
    let mut table = TextTable::open(open_file(path)?).map_err(unread)?;
    let mut first = TextRow::default();
    if !table.read(&mut first).map_err(unread)? {
        return Err(not_a_table("it is empty"));
    }
    let (names, line) = (first.texts(), first.line);
    if names.iter().any(|name| name.contains('\u{fffd}')) {
        return Err(not_a_table("its first line is no UTF-8"));
    }
    if names.iter().all(|name| decimal(name).is_some()) {
        let reason = format!("line {line} has numbers, not names");
        return Err(not_a_table(&reason));
    }
    if let [name] = &names[..] {
        let reason = format!(
            "line {line} has one name, {:?}, and the times need a column of their own; allowed between columns: comma, semicolon or tab",
            shortened(name)
        );
        return Err(LogError::format(path, "CSV", reason));
    }
    if let Some((again, message)) = repeated(names.iter()) {
        let place = format!("line {line}, column {again}");
        let message = message + ": rename or remove one";
        return Err(LogError::place(path, place, message));
    }
    Ok((table, names))
}

/// What a time may be.
const EVERY_ROW: &str =
    "a finite number or a date and time such as 2024-05-01T12:00:00.010Z: every row has a time";
/// What a number of a time may be that is beyond a stamp.
pub const BEYOND: &str = "at most 292 years in the stated time_unit: state the unit that the column has as time_unit of its [[channel]], s, ms, us or ns";
const WHOLE_STAMP: &str =
    "whole seconds, and whole nanoseconds from 0 to 999999999 in a column of their own";

/// Hands the rows of a CSV file to `add`, with the cells of chosen columns. Every name is the name
/// of a column. Returns why the file ends before its end: it was cut off.
pub fn read(
    path: &Path,
    time: &TimeColumn,
    chosen: &[String],
    add: &mut AddRow<'_>,
) -> Result<Option<String>, LogError> {
    let (mut table, names) = open(path)?;
    let index = |name: &String| {
        let found = names.iter().position(|n| n == name);
        found.ok_or_else(|| LogError::whole(path, format!("has no column {name}")))
    };
    let seconds = index(&time.name)?;
    let nanoseconds = time.nanoseconds.as_ref().map(index).transpose()?;
    let chosen: Vec<usize> = chosen.iter().map(index).collect::<Result<_, _>>()?;
    let mut numbers = Numbers {
        path,
        names: &names,
        decimals: Decimals::default(),
        groupings: vec![Grouping::default(); names.len()],
    };
    let ends_with_line = ends_with_line(open_file(path)?).map_err(LogError::io(path))?;
    let mut read = |row: &mut TextRow| table.read(row).map_err(LogError::io(path));
    // One row is read ahead, so that the last one is known.
    let (mut row, mut ahead) = (TextRow::default(), TextRow::default());
    let mut has_row = read(&mut row)?;
    while has_row {
        has_row = read(&mut ahead)?;
        if !has_row && let Some(why) = cut_off(&row, names.len()) {
            return Ok(Some(why));
        }
        numbers.check_count(&row)?;
        let stamp = numbers.stamp(&row, seconds, nanoseconds, time.unit);
        let cells = chosen.iter().map(|column| numbers.cell(&row, *column));
        let cells: Result<_, _> = cells.collect();
        // Without a line end the last number may be cut, where it is one and where it is none any more. Scripts leave the
        // line end out, too: a number that is cut is one wrong reading of the last frame.
        if !has_row && !ends_with_line && (stamp.is_err() || cells.is_err()) {
            let line = row.line;
            return Ok(Some(format!(
                "line {line}: it has no line end, and a cell that is no number"
            )));
        }
        add(Row {
            place: Place("line", row.line),
            stamp: stamp?,
            cells: cells?,
        })?;
        std::mem::swap(&mut row, &mut ahead);
    }
    numbers.check_thousands(&chosen)?;
    Ok(None)
}

/// Why the last row of a file is cut off; `None` of a whole one.
fn cut_off(row: &TextRow, expected: usize) -> Option<String> {
    let (found, line) = (row.count(), row.line);
    (found < expected).then(|| format!("line {line}: it has {found} of {expected} cells"))
}

/// The numbers of a file, which have one decimal mark.
struct Numbers<'a> {
    path: &'a Path,
    names: &'a [String],
    decimals: Decimals,
    /// Of each column, whether its cells have thousands separators.
    groupings: Vec<Grouping>,
}

impl Numbers<'_> {
    /// Refuses a row with more or fewer cells than names.
    fn check_count(&self, row: &TextRow) -> Result<(), LogError> {
        let (found, expected) = (row.count(), self.names.len());
        if found == expected {
            return Ok(());
        }
        let message = format!(
            "found {found} cells, allowed: {expected}, as many as names in the first line; correct or remove this line"
        );
        Err(LogError::place(self.path, Place("line", row.line), message))
    }

    /// The number of a cell, not a number of an empty one: a lost reading.
    fn cell(&mut self, row: &TextRow, column: usize) -> Result<f64, LogError> {
        let text = row.text(column);
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        let number = self.read(row, column, "; nothing or nan for a lost reading")?;
        self.groupings[column].take(&text, number, row.line);
        Ok(finite(number))
    }

    /// Refuses columns whose cells have thousands separators.
    fn check_thousands(&self, columns: &[usize]) -> Result<(), LogError> {
        for column in columns {
            if let Some((line, cell)) = self.groupings[*column].thousands(false) {
                return Err(self.refused(line, *column, cell, NO_THOUSANDS));
            }
        }
        Ok(())
    }

    fn refused(&self, line: u64, column: usize, cell: &str, allowed: &str) -> LogError {
        let place = format!("line {line}, column {}", self.names[column]);
        let message = format!("found {:?}, allowed: {allowed}", shortened(cell));
        LogError::place(self.path, place, message)
    }

    /// The number of a cell; `also` says what else is allowed.
    fn read(&mut self, row: &TextRow, column: usize, also: &str) -> Result<f64, LogError> {
        let text = row.text(column);
        let read = self.decimals.read(&text, row.line);
        read.map_err(|allowed| self.refused(row.line, column, &text, &format!("{allowed}{also}")))
    }

    /// The stamp of a row: of a column in a unit, or of whole seconds and a column of nanoseconds.
    fn stamp(
        &mut self,
        row: &TextRow,
        column: usize,
        nanoseconds: Option<usize>,
        unit: TimeUnit,
    ) -> Result<Stamp, LogError> {
        let text = row.text(column);
        let stamp = if let Some(rest) = nanoseconds {
            let [seconds, nanoseconds] = [column, rest].map(|c| self.read(row, c, ""));
            let stamp = Stamp::of_parts(seconds?, nanoseconds?);
            return stamp.ok_or_else(|| self.refused(row.line, rest, &row.text(rest), WHOLE_STAMP));
        } else if let (true, Ok(whole)) = (unit != TimeUnit::SECOND, text.parse::<i64>()) {
            let stamp = unit.of_whole(whole);
            return stamp.ok_or_else(|| self.refused(row.line, column, &text, BEYOND));
        } else if decimal(&text).is_some() {
            unit.of_float(self.read(row, column, "")?)
        } else {
            iso8601::parse(&text)
        };
        stamp.ok_or_else(|| self.refused(row.line, column, &text, EVERY_ROW))
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

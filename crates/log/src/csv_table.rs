//! Logs as text: tables with the names of the columns in the first row.

use crate::error::{LogError, open_file};
use crate::rows::{AddRow, ColumnInfo, Place, Row, TimeColumn, finite, repeated};
use crate::stamp::{Stamp, TimeUnit};
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
    if let Some((again, message)) = repeated(names.iter()) {
        let place = format!("line {line}, column {again}");
        return Err(LogError::place(
            path,
            place,
            message + ": rename or remove one",
        ));
    }
    Ok((table, names))
}

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
    let time = (index(&time.name)?, time.unit);
    let chosen: Vec<usize> = chosen.iter().map(index).collect::<Result<_, _>>()?;
    let ends_with_line = ends_with_line(open_file(path)?).map_err(LogError::io(path))?;
    let mut read = |row: &mut TextRow| table.read(row).map_err(LogError::io(path));
    // One row is read ahead, so that the last one is known.
    let (mut row, mut ahead) = (TextRow::default(), TextRow::default());
    let mut has_row = read(&mut row)?;
    while has_row {
        has_row = read(&mut ahead)?;
        let (found, expected, line) = (row.count(), names.len(), row.line);
        if !has_row && (found < expected || !ends_with_line) {
            let why = match found < expected {
                true => format!("it has {found} of {expected} cells"),
                false => "it has no line end, so its last number may be cut".to_owned(),
            };
            return Ok(Some(format!("line {line}: {why}")));
        }
        if found != expected {
            let message = format!(
                "found {found} cells, allowed: {expected}, as many as names in the first line; correct or remove this line"
            );
            return Err(LogError::place(path, format!("line {line}"), message));
        }
        let refused = |column: usize, allowed: &str| {
            let place = format!("line {line}, column {}", names[column]);
            let found = shortened(&row.text(column));
            LogError::place(path, place, format!("found {found:?}, allowed: {allowed}"))
        };
        let stamp = stamp(&row.text(time.0), time.1)
            .ok_or_else(|| refused(time.0, "a finite number: every row has a time"))?;
        let cells = chosen.iter().map(|column| match &*row.text(*column) {
            // A lost reading.
            "" => Ok(f64::NAN),
            text => decimal(text)
                .map(finite)
                .ok_or_else(|| refused(*column, "a number; nothing or nan for a lost reading")),
        });
        add(Row {
            place: Place("line", line),
            stamp,
            cells: cells.collect::<Result<_, _>>()?,
        })?;
        std::mem::swap(&mut row, &mut ahead);
    }
    Ok(None)
}

fn stamp(text: &str, unit: TimeUnit) -> Option<Stamp> {
    match text.parse::<i64>() {
        Ok(whole) if unit != TimeUnit::SECOND => unit.of_whole(whole),
        _ => unit.of_float(decimal(text)?),
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

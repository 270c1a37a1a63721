//! Comma-separated text; separators comma, semicolon and tab; with the last two also a decimal comma.

use crate::error::{LogError, open_file};
use crate::rows::{ColumnInfo, Place, Row, Rows, TimeColumn, repeated};
use crate::stamp::{Stamp, TimeUnit};
use csv::{ByteRecord, Reader, ReaderBuilder};
use std::fs::File;
use std::io::{BufRead, BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// Longest start of a file up to the end of the names, bytes: more is no table.
const LONGEST_HEADER: u64 = 1 << 20;
/// First byte of a comment. Comments and empty lines are left out.
const COMMENT: u8 = b'#';

/// The columns of a CSV file, from its first line that is no comment.
pub fn columns(path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
    let (_, names) = header(path)?;
    Ok(names.iter().map(|name| column(name)).collect())
}

/// Name and unit of a column `angle [deg]`.
fn column(text: &str) -> ColumnInfo {
    let unit = [('[', ']'), ('(', ')')].iter().find_map(|(open, close)| {
        let (_, unit) = text.strip_suffix(*close)?.rsplit_once(*open)?;
        Some(unit.trim().to_owned())
    });
    ColumnInfo {
        name: text.to_owned(),
        unit,
    }
}

/// The separator, and the names in the first line that is neither empty nor a comment.
fn header(path: &Path) -> Result<(u8, Vec<String>), LogError> {
    let mut reader = BufReader::new(open_file(path)?).take(LONGEST_HEADER);
    let (line, number) = first_line(&mut reader).map_err(LogError::io(path))?;
    let not_a_table = |reason: &str| LogError::Format {
        path: path.to_path_buf(),
        what: "CSV",
        reason: format!(
            "{reason}; allowed: the names of the columns in the first line, after comments with #, UTF-8"
        ),
    };
    let text = std::str::from_utf8(&line);
    let text = text
        .map_err(|_| not_a_table("its first line is no UTF-8"))?
        .trim_end();
    if text.is_empty() {
        return Err(not_a_table("it is empty"));
    }
    let count = |separator: u8| text.bytes().filter(|b| *b == separator).count();
    // The first of those that occur most.
    let separator =
        [b',', b';', b'\t'].into_iter().fold(
            b',',
            |most, s| if count(s) > count(most) { s } else { most },
        );
    let mut reader = builder(separator).from_reader(text.as_bytes());
    let mut record = ByteRecord::new();
    reader
        .read_byte_record(&mut record)
        .map_err(|error| not_a_table(&error.to_string()))?;
    let name = |cell: &[u8]| String::from_utf8_lossy(cell).trim().to_owned();
    let names: Vec<String> = record.iter().map(name).collect();
    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
        return Err(not_a_table(&format!(
            "line {number} has numbers, not names"
        )));
    }
    if let Some((first, again)) = repeated(&names) {
        let place = format!("line {number}, column {}", again + 1);
        let message = format!(
            "found the name {} again, allowed: each name once; column {} has it, too: rename or remove one",
            names[again],
            first + 1
        );
        return Err(LogError::place(path, place, message));
    }
    Ok((separator, names))
}

/// The first line that is neither empty nor a comment, without a byte order mark, and its number;
/// empty if there is none.
fn first_line(reader: &mut impl BufRead) -> std::io::Result<(Vec<u8>, u64)> {
    let mut number = 0;
    loop {
        let mut line = Vec::new();
        number += 1;
        if reader.read_until(b'\n', &mut line)? == 0 {
            return Ok((line, number));
        }
        if number == 1 && line.starts_with("\u{feff}".as_bytes()) {
            line.drain(..3);
        }
        let is_empty = line.iter().all(|byte| matches!(byte, b'\r' | b'\n'));
        if !is_empty && line[0] != COMMENT {
            return Ok((line, number));
        }
    }
}

fn builder(separator: u8) -> ReaderBuilder {
    let mut builder = ReaderBuilder::new();
    builder
        .delimiter(separator)
        .comment(Some(COMMENT))
        .has_headers(false)
        .flexible(true);
    builder
}

/// The rows of a CSV file.
pub struct CsvRows {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    names: Vec<String>,
    /// Index and unit of the time.
    time: (usize, TimeUnit),
    /// Indices of the chosen columns.
    chosen: Vec<usize>,
    decimal_comma: bool,
    /// Whether the file ends with a line end.
    ends_with_line: bool,
    /// The next row, read ahead so that the last one is known.
    ahead: ByteRecord,
    has_ahead: bool,
    current: ByteRecord,
    cut_off: Option<String>,
}

impl CsvRows {
    /// Opens a file. Every name is the name of a column.
    pub fn open(path: &Path, time: &TimeColumn, chosen: &[String]) -> Result<Self, LogError> {
        let (separator, names) = header(path)?;
        let index = |name: &String| {
            let found = names.iter().position(|n| n == name);
            found.ok_or_else(|| LogError::whole(path, format!("has no column {name}")))
        };
        let (time, chosen) = (
            (index(&time.name)?, time.unit),
            chosen.iter().map(index).collect::<Result<_, _>>()?,
        );
        let mut file = open_file(path)?;
        let ends_with_line = ends_with_line(&mut file).map_err(LogError::io(path))?;
        let reader = builder(separator).from_reader(BufReader::with_capacity(1 << 18, file));
        let mut rows = Self {
            path: path.to_path_buf(),
            reader,
            names,
            time,
            chosen,
            decimal_comma: separator != b',',
            ends_with_line,
            ahead: ByteRecord::new(),
            has_ahead: false,
            current: ByteRecord::new(),
            cut_off: None,
        };
        // The line of the names, then the first row.
        rows.advance()?;
        rows.advance()?;
        Ok(rows)
    }

    fn advance(&mut self) -> Result<(), LogError> {
        std::mem::swap(&mut self.current, &mut self.ahead);
        let read = self.reader.read_byte_record(&mut self.ahead);
        self.has_ahead = read.map_err(|error| LogError::Format {
            path: self.path.clone(),
            what: "CSV",
            reason: error.to_string(),
        })?;
        Ok(())
    }

    fn line(&self) -> u64 {
        self.current.position().map_or(0, csv::Position::line)
    }

    fn problem(&self, column: usize, message: String) -> LogError {
        let name = self.names.get(column).map_or("", String::as_str);
        let place = format!("line {}, column {name}", self.line());
        LogError::place(&self.path, place, message)
    }

    /// The text of a cell; empty where the row is too short.
    fn text(&self, column: usize) -> Result<&str, LogError> {
        let cell = self.current.get(column).unwrap_or_default();
        let text = std::str::from_utf8(cell)
            .map_err(|_| self.problem(column, "found bytes that are no UTF-8".to_owned()))?;
        Ok(text.trim())
    }

    fn number(&self, text: &str) -> Option<f64> {
        let plain = text.parse().ok();
        match plain {
            None if self.decimal_comma && text.contains(',') => {
                text.replacen(',', ".", 1).parse().ok()
            }
            plain => plain,
        }
    }

    fn cell(&self, column: usize) -> Result<Option<f64>, LogError> {
        let text = self.text(column)?;
        if text.is_empty() {
            return Ok(None);
        }
        match self.number(text) {
            Some(value) => Ok(Some(value).filter(|v| v.is_finite())),
            None => {
                let found = shortened(text);
                let allowed = "a number; nothing or nan for a lost reading";
                Err(self.problem(column, format!("found {found:?}, allowed: {allowed}")))
            }
        }
    }

    fn stamp(&self) -> Result<Stamp, LogError> {
        let (column, unit) = self.time;
        let text = self.text(column)?;
        let stamp = match text.parse::<i64>() {
            Ok(whole) if unit != TimeUnit::SECOND => unit.of_whole(whole),
            _ => self.number(text).and_then(|number| unit.of_float(number)),
        };
        stamp.ok_or_else(|| {
            let found = shortened(text);
            let allowed = "a finite number: every row has a time";
            self.problem(column, format!("found {found:?}, allowed: {allowed}"))
        })
    }
}

impl Rows for CsvRows {
    fn next_row(&mut self) -> Result<Option<Row>, LogError> {
        if !self.has_ahead {
            return Ok(None);
        }
        self.advance()?;
        let (found, expected) = (self.current.len(), self.names.len());
        let is_last = !self.has_ahead;
        if is_last && (found < expected || !self.ends_with_line) {
            let why = match found < expected {
                true => format!("it has {found} of {expected} cells"),
                false => "it has no line end, so its last number may be cut".to_owned(),
            };
            self.cut_off = Some(format!("line {}: {why}", self.line()));
            return Ok(None);
        }
        if found != expected {
            let message = format!(
                "found {found} cells, allowed: {expected}, as many as names in the first line; correct or remove this line"
            );
            let place = format!("line {}", self.line());
            return Err(LogError::place(&self.path, place, message));
        }
        let cells = self.chosen.iter().map(|c| self.cell(*c));
        Ok(Some(Row {
            place: Place::Line(self.line()),
            stamp: self.stamp()?,
            cells: cells.collect::<Result<_, _>>()?,
        }))
    }

    fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }
}

/// Whether the last byte is a line end. Leaves the file at its start.
fn ends_with_line(file: &mut File) -> std::io::Result<bool> {
    let mut last = [0];
    let length = file.seek(SeekFrom::End(0))?;
    if length > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
    }
    file.seek(SeekFrom::Start(0))?;
    Ok(last == *b"\n" || last == *b"\r")
}

/// The start of a text.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

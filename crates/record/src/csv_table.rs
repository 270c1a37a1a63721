//! A table as comma-separated text: names in the first line, floats as the shortest text that reads back as the same number.

use crate::append::{Appender, FlushClock};
use crate::columns::{Table, Value};
use crate::error::{RecordError, io_error};
use robhaz_run::Frame;
use std::io::Write as _;
use std::path::Path;

/// Largest text that waits for the file, bytes.
const MOST_WAITING: usize = 1 << 20;

/// A table being written. Whole rows go to the file, at least every simulated second.
pub struct CsvTable {
    table: Table,
    out: Appender,
    waiting: Vec<u8>,
    clock: FlushClock,
}

impl CsvTable {
    /// Creates the file and writes the names.
    pub fn create(folder: &Path, table: Table) -> Result<Self, RecordError> {
        let mut out = Appender::create(&folder.join(format!("{}.csv", table.name)))?;
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        out.append((names.join(",") + "\n").as_bytes())?;
        Ok(Self {
            table,
            out,
            waiting: Vec::new(),
            clock: FlushClock::default(),
        })
    }

    /// Adds the row of a record, if it has one.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        if !self.table.has_row(frame) {
            return Ok(());
        }
        for (i, column) in self.table.columns.iter().enumerate() {
            if i > 0 {
                self.waiting.push(b',');
            }
            let written = match column.value(frame) {
                // `{:?}` is the shortest text that reads back as the same number, with an exponent where that is shorter.
                Value::Float(value) | Value::Optional(Some(value)) => {
                    write!(self.waiting, "{value:?}")
                }
                Value::Optional(None) => Ok(()),
                Value::Count(count) => write!(self.waiting, "{count}"),
            };
            written.map_err(io_error("write", self.out.path()))?;
        }
        self.waiting.push(b'\n');
        if self.clock.is_due(frame.time) || self.waiting.len() >= MOST_WAITING {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the last rows to the file.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.flush()
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        // Rows that cannot be written are dropped: written later they would follow a gap.
        let rows = std::mem::take(&mut self.waiting);
        self.out.append(&rows)
    }
}

/// Writes `columns.csv`: table, column, unit and description, for which CSV has no place.
pub fn write_columns(folder: &Path, tables: &[Table]) -> Result<(), RecordError> {
    let mut text = String::from("table,column,unit,description\n");
    for table in tables {
        for column in &table.columns {
            let description = column.description.replace('"', "\"\"");
            text.push_str(&format!(
                "{},{},{},\"{description}\"\n",
                table.name, column.name, column.unit
            ));
        }
    }
    let path = folder.join("columns.csv");
    std::fs::write(&path, text).map_err(io_error("write", &path))
}

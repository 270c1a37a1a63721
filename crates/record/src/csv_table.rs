//! A table as comma-separated text: names in the first line, floats as the shortest text that reads back as the same number.

use crate::columns::{Table, Value};
use crate::error::{RecordError, io_error};
use robhaz_run::Frame;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A table being written.
pub struct CsvTable {
    table: Table,
    path: PathBuf,
    out: BufWriter<File>,
}

impl CsvTable {
    /// Creates the file and writes the names.
    pub fn create(folder: &Path, table: Table) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.csv", table.name));
        let mut out = BufWriter::new(File::create(&path).map_err(io_error("create", &path))?);
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        writeln!(out, "{}", names.join(",")).map_err(io_error("write", &path))?;
        Ok(Self { table, path, out })
    }

    /// Adds the row of a record, if it has one.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        if !self.table.has_row(frame) {
            return Ok(());
        }
        for (i, column) in self.table.columns.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let written = match column.value(frame) {
                // `{:?}` is the shortest text that reads back as the same number, with an exponent
                // where that is shorter.
                Value::Float(value) | Value::Optional(Some(value)) => {
                    write!(self.out, "{comma}{value:?}")
                }
                Value::Optional(None) => write!(self.out, "{comma}"),
                Value::Count(count) => write!(self.out, "{comma}{count}"),
            };
            written.map_err(io_error("write", &self.path))?;
        }
        writeln!(self.out).map_err(io_error("write", &self.path))
    }

    /// Writes the last rows to the file.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.out.flush().map_err(io_error("write", &self.path))
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

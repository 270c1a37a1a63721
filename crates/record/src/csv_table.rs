//! A table as comma-separated text: names in the first line, floats as short as they read back the same.

use crate::columns::{Table, Value};
use crate::error::{RecordError, io_error};
use robhaz_run::Frame;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Rows after which what is buffered goes to the file, so that a killed run loses little.
const FLUSH_ROWS: u64 = 1000;

/// A table being written.
pub struct CsvTable {
    table: Table,
    path: PathBuf,
    out: BufWriter<File>,
    rows: u64,
}

impl CsvTable {
    /// Creates the file and writes the names.
    pub fn create(folder: &Path, table: Table) -> Result<Self, RecordError> {
        let path = folder.join(format!("{}.csv", table.name));
        let file = File::create(&path).map_err(io_error("create", &path))?;
        let mut out = BufWriter::new(file);
        let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
        writeln!(out, "{}", names.join(",")).map_err(io_error("write", &path))?;
        Ok(Self {
            table,
            path,
            out,
            rows: 0,
        })
    }

    /// Writes one row.
    pub fn push(&mut self, frame: &Frame<'_>) -> Result<(), RecordError> {
        self.row(frame).map_err(io_error("write", &self.path))
    }

    /// Brings everything to the file.
    pub fn close(&mut self) -> Result<(), RecordError> {
        self.out.flush().map_err(io_error("write", &self.path))
    }

    fn row(&mut self, frame: &Frame<'_>) -> io::Result<()> {
        for (i, column) in self.table.columns.iter().enumerate() {
            if i > 0 {
                self.out.write_all(b",")?;
            }
            match column.value(frame) {
                // `{:?}` is the shortest text that reads back as the same number, with an exponent where that is shorter.
                Value::Float(value) | Value::Optional(Some(value)) => {
                    write!(self.out, "{value:?}")?;
                }
                Value::Optional(None) => {}
                Value::Count(count) => write!(self.out, "{count}")?,
            }
        }
        self.out.write_all(b"\n")?;
        self.rows += 1;
        if self.rows.is_multiple_of(FLUSH_ROWS) {
            self.out.flush()?;
        }
        Ok(())
    }
}

/// Writes `columns.csv`: table, column, unit and description, which CSV has no place for.
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

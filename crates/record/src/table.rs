//! The sink that writes the tables.

use crate::columns::Table;
use crate::csv_table::{CsvTable, write_columns};
use crate::error::{RecordError, check_name, io_error};
use crate::felt_ground::FeltGrounds;
use crate::format::TableFormat;
use crate::ground_table::write_grounds;
use crate::parquet_table::ParquetTables;
use crate::terrain_table::write_terrain;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::path::{Path, PathBuf};
use std::slice;

/// Writes the tables `truth`, `sensors`, `commands`, `estimate-NAME`, `ground-NAME` and `terrain` of
/// a run into a folder. Recorded readings have neither `truth` nor `terrain`; only a control that
/// takes readings has `commands`. An estimator that finds no ground has no table `ground-NAME`; it is
/// written at the end of the run, because points change until the robot has left them.
///
/// A Parquet table that is not complete has another name; a run that breaks off closes its tables.
pub struct TableSink {
    folder: PathBuf,
    format: TableFormat,
    /// The tables that are written as CSV.
    csv: Vec<CsvTable>,
    /// The tables that are written as Parquet.
    parquet: ParquetTables,
    /// The ground that the estimators find: its tables are written at the end.
    grounds: Option<(RunDescription, FeltGrounds)>,
    /// A row could not be written.
    failed: bool,
}

impl TableSink {
    /// A sink for a folder, which is made if need be.
    pub fn new(folder: &Path, format: TableFormat) -> Self {
        Self {
            folder: folder.to_path_buf(),
            format,
            csv: Vec::new(),
            parquet: ParquetTables::default(),
            grounds: None,
            failed: false,
        }
    }

    fn open(&mut self, run: &RunDescription) -> Result<(), RecordError> {
        let folder = &self.folder;
        for estimator in &run.estimators {
            check_name(&estimator.label, folder)?;
        }
        std::fs::create_dir_all(folder).map_err(io_error("create", folder))?;
        let tables = Table::all(run);
        if self.format == TableFormat::Csv {
            write_columns(folder, &tables)?;
        }
        self.grounds = Some((run.clone(), FeltGrounds::new(run)));
        let metadata = metadata(run);
        write_terrain(folder, self.format, run, &metadata)?;
        for table in tables {
            match self.format {
                TableFormat::Csv => self.csv.push(CsvTable::create(folder, table)?),
                TableFormat::Parquet => self.parquet.add(folder, table, &metadata)?,
            }
        }
        Ok(())
    }

    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        if let Some((_, grounds)) = &mut self.grounds {
            frames.iter().for_each(|frame| grounds.add(frame));
        }
        for table in &mut self.csv {
            frames.iter().try_for_each(|frame| table.push(frame))?;
        }
        self.parquet.push_all(frames)
    }

    fn write_grounds(&mut self, end: Option<&RunEnd>) -> Result<(), RecordError> {
        let Some((run, mut grounds)) = self.grounds.take() else {
            return Ok(());
        };
        grounds.finish(end);
        write_grounds(&self.folder, self.format, &run, &grounds, &metadata(&run))
    }
}

/// What a file says of its run.
pub fn metadata(run: &RunDescription) -> [(&'static str, String); 2] {
    [
        ("scene", run.name.clone()),
        ("robhaz_version", env!("CARGO_PKG_VERSION").to_owned()),
    ]
}

impl Sink for TableSink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        Ok(self.open(run)?)
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.frames(slice::from_ref(frame))
    }

    fn frames(&mut self, frames: &[Frame<'_>]) -> Result<(), SinkError> {
        let pushed = self.push_all(frames);
        self.failed |= pushed.is_err();
        Ok(pushed?)
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // One table that cannot be closed must not keep the others open.
        let parquet = self.parquet.close();
        let csv: Vec<_> = self.csv.drain(..).map(|mut table| table.close()).collect();
        csv.into_iter()
            .chain([parquet])
            .collect::<Result<(), _>>()?;
        if !self.failed {
            self.write_grounds(end)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::{Kind, Value};
    use crate::testing::{Record, described, log, records, scene};
    use arrow_array::{Array, Float64Array, RecordBatch, UInt32Array};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use std::fs::{self, File};

    fn write(folder: &Path, format: TableFormat, records: &[Record]) {
        let mut sink = TableSink::new(folder, format);
        sink.begin(&described(&scene())).expect("begins");
        for record in records {
            sink.frame(&record.frame()).expect("a row");
        }
        sink.end(None).expect("ends");
    }

    fn read(path: &Path) -> (Vec<RecordBatch>, ParquetRecordBatchReaderBuilder<File>) {
        let open = || {
            let file = File::open(path).expect("the table is there");
            ParquetRecordBatchReaderBuilder::try_new(file).expect("it has a footer")
        };
        let batches = open()
            .build()
            .expect("a reader")
            .collect::<Result<Vec<_>, _>>()
            .expect("all rows can be read");
        (batches, open())
    }

    /// Every value of every table comes back as it was, gaps as gaps.
    #[test]
    fn parquet_gives_back_what_was_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let records = records();
        write(folder.path(), TableFormat::Parquet, &records);
        for table in Table::all(&described(&scene())) {
            let path = folder.path().join(format!("{}.parquet", table.name));
            let (batches, _) = read(&path);
            assert_eq!(
                batches.iter().map(RecordBatch::num_rows).sum::<usize>(),
                records.len()
            );
            let mut row = 0;
            for batch in &batches {
                for i in 0..batch.num_rows() {
                    for (column, array) in table.columns.iter().zip(batch.columns()) {
                        let expected = column.value(&records[row].frame());
                        let found = cell(column.kind(), array.as_ref(), i);
                        assert_eq!(found, expected, "{}", column.name);
                    }
                    row += 1;
                }
            }
        }
    }

    fn cell(kind: Kind, array: &dyn Array, row: usize) -> Value {
        let array = array.as_any();
        if kind == Kind::Count {
            let counts: &UInt32Array = array.downcast_ref().expect("counts");
            return Value::Count(counts.value(row));
        }
        let floats: &Float64Array = array.downcast_ref().expect("floats");
        if kind == Kind::Optional {
            return Value::Optional(floats.is_valid(row).then(|| floats.value(row)));
        }
        Value::Float(floats.value(row))
    }

    /// Whoever opens the file sees units, meanings, scene and version.
    #[test]
    fn parquet_says_what_its_columns_are() {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), TableFormat::Parquet, &records());
        let (_, file) = read(&folder.path().join("truth.parquet"));
        let schema = file.schema();
        for column in &Table::truth().columns {
            let field = schema.field_with_name(&column.name).expect("a field");
            assert_eq!(
                field.metadata().get("unit").map(String::as_str),
                Some(column.unit)
            );
            assert_eq!(
                field.metadata().get("description"),
                Some(&column.description)
            );
        }
        let metadata = file
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .expect("metadata");
        let value = |key: &str| {
            metadata
                .iter()
                .find(|entry| entry.key == key)
                .and_then(|entry| entry.value.clone())
        };
        assert_eq!(value("scene").as_deref(), Some("trial"));
        assert_eq!(
            value("robhaz_version").as_deref(),
            Some(env!("CARGO_PKG_VERSION"))
        );
    }

    /// Text, but no digit lost; gaps are empty.
    #[test]
    fn csv_gives_back_what_was_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let records = records();
        write(folder.path(), TableFormat::Csv, &records);
        for table in Table::all(&described(&scene())) {
            let path = folder.path().join(format!("{}.csv", table.name));
            let mut reader = csv::Reader::from_path(path).expect("the table is there");
            let names: Vec<_> = table.columns.iter().map(|c| c.name.clone()).collect();
            assert_eq!(reader.headers().expect("names"), names);
            let rows = reader
                .records()
                .collect::<Result<Vec<_>, _>>()
                .expect("rows of one length");
            assert_eq!(rows.len(), records.len());
            for (row, record) in rows.iter().zip(&records) {
                for (text, column) in row.iter().zip(&table.columns) {
                    let value = match column.kind() {
                        Kind::Count => Value::Count(text.parse().expect("a count")),
                        Kind::Float => Value::Float(text.parse().expect("a number")),
                        Kind::Optional if text.is_empty() => Value::Optional(None),
                        Kind::Optional => Value::Optional(Some(text.parse().expect("a number"))),
                    };
                    assert_eq!(value, column.value(&record.frame()), "{}", column.name);
                }
            }
        }
    }

    /// CSV has no place for units: they stand beside it, for every column.
    #[test]
    fn csv_has_its_units_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), TableFormat::Csv, &records());
        let mut reader =
            csv::Reader::from_path(folder.path().join("columns.csv")).expect("it is there");
        let rows: Vec<Vec<String>> = reader
            .records()
            .map(|row| row.expect("a row").iter().map(String::from).collect())
            .collect();
        let expected: Vec<Vec<String>> = Table::all(&described(&scene()))
            .iter()
            .flat_map(|table| {
                table.columns.iter().map(|c| {
                    vec![
                        table.name.clone(),
                        c.name.clone(),
                        c.unit.to_owned(),
                        c.description.clone(),
                    ]
                })
            })
            .chain(crate::terrain_table::rows_of_columns())
            .collect();
        assert_eq!(rows, expected);
    }

    /// The same run leaves the same bytes: results can be compared by checksum.
    #[test]
    fn the_same_records_leave_the_same_bytes() {
        for format in [TableFormat::Parquet, TableFormat::Csv] {
            let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
            for folder in &folders {
                write(folder.path(), format, &records());
            }
            let mut files = 0;
            for entry in fs::read_dir(folders[0].path()).expect("files") {
                let name = entry.expect("a file").file_name();
                let [a, b] = [0, 1].map(|i| fs::read(folders[i].path().join(&name)));
                assert_eq!(a.expect("first"), b.expect("second"), "{name:?}");
                files += 1;
            }
            assert!(files >= 5);
        }
    }

    /// Recorded readings: no table of the truth or of the ground, all else as in a simulation.
    #[test]
    fn without_truth_there_is_no_table_of_it() {
        for format in [TableFormat::Parquet, TableFormat::Csv] {
            let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
            write(folders[0].path(), format, &records());
            let mut sink = TableSink::new(folders[1].path(), format);
            sink.begin(&log()).expect("begins");
            for record in &records() {
                sink.frame(&record.without_truth()).expect("a row");
            }
            sink.end(None).expect("ends");
            let names = |folder: &Path| -> std::collections::BTreeSet<String> {
                let files = fs::read_dir(folder).expect("files");
                let name = |f: std::io::Result<fs::DirEntry>| f.expect("a file").file_name();
                files
                    .map(|f| name(f).to_string_lossy().into_owned())
                    .collect()
            };
            let [all, found] = [0, 1].map(|i| names(folders[i].path()));
            let extension = if format == TableFormat::Csv {
                "csv"
            } else {
                "parquet"
            };
            let missing: Vec<&String> = all.difference(&found).collect();
            assert_eq!(
                missing,
                [
                    &format!("terrain.{extension}"),
                    &format!("truth.{extension}")
                ]
            );
            for name in found.iter().filter(|n| *n != "columns.csv") {
                let [a, b] = [0, 1].map(|i| fs::read(folders[i].path().join(name)).expect("bytes"));
                assert!(a == b, "{name}");
            }
        }
    }

    /// A scene cannot write outside the run's folder.
    #[test]
    fn names_that_leave_the_folder_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = scene();
        scene.estimators[0].name = "../x".to_owned();
        let error = TableSink::new(folder.path(), TableFormat::Csv)
            .begin(&described(&scene))
            .expect_err("refused");
        assert!(error.to_string().contains("\"../x\""), "{error}");
    }
}

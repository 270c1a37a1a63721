//! The sink that writes the tables.

use crate::columns::Table;
use crate::csv_table::{CsvTable, write_columns};
use crate::direct_tables::DirectTables;
use crate::error::{RecordError, check_name, io_error};
use crate::felt_ground::FeltGrounds;
use crate::format::TableFormat;
use crate::ground_table::write_grounds;
use crate::parquet_table::{TornEnd, write_parquet};
use crate::stream_table::StreamTable;
use crate::terrain_table::write_terrain;
use rayon::prelude::*;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use std::path::{Path, PathBuf};
use std::slice;

/// Most rows of tables of which several are made into Parquet at once. The writer keeps a row group and what the footer says of
/// all row groups: some 40 MB for the truth of an hour at 1 kHz.
const SHORT: u64 = 1_000_000;

enum Writer {
    /// Becomes Parquet at the end.
    Stream(Box<StreamTable>),
    Csv(CsvTable),
}

impl Writer {
    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        match self {
            Self::Stream(table) => table.push_all(frames),
            Self::Csv(table) => frames.iter().try_for_each(|frame| table.push(frame)),
        }
    }
}

/// Writes the tables `truth`, `sensors`, `commands`, `estimate-NAME`, `ground-NAME` and `terrain` of a run into a folder. Recorded
/// readings have neither `truth` nor `terrain`; only a control that takes readings has `commands`. An estimator that finds no ground has no table `ground-NAME`; it is written at the end of the
/// run, because points change until the robot has left them.
///
/// While a simulation goes on, a Parquet table is a stream of Arrow batches (`.arrows`), to which rows go at least every
/// simulated second; the end of the run makes Parquet of it and removes the stream. CSV tables grow in the same steps. So a
/// run that breaks off keeps every row, and one that is killed all but its last second: [`crate::recover`] makes tables of its
/// streams. Parquet tables of recorded readings are written at once: killed, they are computed again from the readings.
pub struct TableSink {
    folder: PathBuf,
    format: TableFormat,
    writers: Vec<Writer>,
    /// Parquet tables of recorded readings.
    direct: DirectTables,
    /// The ground that the estimators find: its tables are written at the end.
    grounds: Option<(RunDescription, FeltGrounds)>,
    /// Whether the Parquet tables can be made at once: see [`SHORT`].
    is_short: bool,
    /// A row could not be written. The streams stay as they are.
    failed: bool,
}

impl TableSink {
    /// A sink for a folder, which is made if need be.
    pub fn new(folder: &Path, format: TableFormat) -> Self {
        Self {
            folder: folder.to_path_buf(),
            format,
            writers: Vec::new(),
            direct: DirectTables::default(),
            grounds: None,
            is_short: true,
            failed: false,
        }
    }

    fn open(&mut self, run: &RunDescription) -> Result<(), RecordError> {
        let folder = &self.folder;
        for estimator in &run.estimators {
            check_name(&estimator.label, folder)?;
        }
        std::fs::create_dir_all(folder).map_err(io_error("create", folder))?;
        self.is_short = run.record.count() <= SHORT;
        let tables = Table::all(run);
        if self.format == TableFormat::Csv {
            write_columns(folder, &tables)?;
        }
        self.grounds = Some((run.clone(), FeltGrounds::new(run)));
        write_terrain(folder, self.format, run, &metadata(run))?;
        let metadata = metadata(run);
        for table in tables {
            let writer = match (self.format, &run.world) {
                (TableFormat::Csv, _) => Writer::Csv(CsvTable::create(folder, table)?),
                (TableFormat::Parquet, Some(_)) => {
                    Writer::Stream(Box::new(StreamTable::create(folder, table, &metadata)?))
                }
                (TableFormat::Parquet, None) => {
                    self.direct.add(folder, table, &metadata)?;
                    continue;
                }
            };
            self.writers.push(writer);
        }
        Ok(())
    }

    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        if let Some((_, grounds)) = &mut self.grounds {
            frames.iter().for_each(|frame| grounds.add(frame));
        }
        for writer in &mut self.writers {
            writer.push_all(frames)?;
        }
        self.direct.push_all(frames)
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
        let mut first_failure = self.direct.close().err();
        let mut streams = Vec::new();
        for writer in self.writers.drain(..) {
            let closed = match writer {
                Writer::Stream(mut table) => {
                    let closed = table.close();
                    streams.push(table.path().to_path_buf());
                    closed
                }
                Writer::Csv(mut table) => table.close(),
            };
            if let Err(error) = closed {
                first_failure.get_or_insert(error);
            }
        }
        // Where rows did not fit, their Parquet file would not either.
        if first_failure.is_none() && !self.failed {
            first_failure = convert(&streams, &self.folder, self.is_short).err();
        }
        if first_failure.is_none() && !self.failed {
            first_failure = self.write_grounds(end).err();
        }
        match first_failure {
            Some(error) => Err(error.into()),
            None => Ok(()),
        }
    }
}

/// Makes a Parquet file of each stream and removes the streams that are no longer needed: on all cores, or one after the other.
fn convert(streams: &[PathBuf], folder: &Path, at_once: bool) -> Result<(), RecordError> {
    let convert = |stream: &PathBuf| {
        write_parquet(stream, folder, TornEnd::Refuse)?;
        std::fs::remove_file(stream).map_err(io_error("remove", stream))
    };
    if at_once {
        streams.par_iter().map(convert).collect()
    } else {
        streams.iter().try_for_each(convert)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::{Kind, Value};
    use crate::parquet_table::{RecoveredTable, recover};
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

    /// Rows of `table` that can be read in a folder as a killed run leaves it.
    fn recovered(folder: &Path, table: &str) -> RecoveredTable {
        let copy = tempfile::tempdir().expect("a folder");
        let name = format!("{table}.arrows");
        fs::copy(folder.join(&name), copy.path().join(&name)).expect("a stream");
        let mut tables = recover(copy.path(), copy.path(), false).expect("it can be read");
        tables.remove(0)
    }

    /// A run that is killed has not closed its tables: all can be read but the last second, at any moment and wherever the
    /// last batch is torn.
    #[test]
    fn a_killed_run_loses_a_second_at_most() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut sink = TableSink::new(folder.path(), TableFormat::Parquet);
        sink.begin(&described(&scene())).expect("begins");
        assert_eq!(recovered(folder.path(), "truth").rows, 0);
        for record in &records() {
            sink.frame(&record.frame()).expect("a row");
            let end = recovered(folder.path(), "truth").end.unwrap_or(0.0);
            assert!(record.truth.time - end < 1.0, "{end}");
        }
        assert_eq!(recovered(folder.path(), "truth").rows, 201);
        // Killed in the middle of a write.
        let stream = folder.path().join("truth.arrows");
        let whole = fs::read(&stream).expect("a stream");
        for cut in [1, 100, 10_000] {
            fs::write(&stream, &whole[..whole.len() - cut]).expect("written");
            assert_eq!(recovered(folder.path(), "truth").rows, 101, "{cut}");
        }
    }

    /// A recovered table equals that of the finished run; it replaces another one only on request.
    #[test]
    fn a_recovered_table_is_that_of_the_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut sink = TableSink::new(folder.path(), TableFormat::Parquet);
        sink.begin(&described(&scene())).expect("begins");
        for record in &records() {
            sink.frame(&record.frame()).expect("a row");
        }
        let out = tempfile::tempdir().expect("a folder");
        let out = out.path().join("new");
        let recover = |replace| recover(folder.path(), &out, replace);
        let tables = recover(false).expect("tables");
        assert_eq!(tables.len(), 5);
        let error = recover(false).expect_err("it is there");
        assert!(error.to_string().ends_with(".parquet exists"), "{error}");
        assert_eq!(recover(true).expect("replaced"), tables);
        sink.end(None).expect("ends");
        for table in tables {
            let name = table.path.file_name().expect("a name");
            let of_the_run = fs::read(folder.path().join(name)).expect("a table");
            assert!(
                of_the_run == fs::read(&table.path).expect("a table"),
                "{name:?}"
            );
        }
        let error = recover(true).expect_err("the streams have gone");
        assert!(matches!(error, RecordError::NoStreams { .. }), "{error}");
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

//! The sink that makes the tables.

use crate::batch::BatchBuilder;
use crate::columns::Table;
use crate::error::{RecordError, check_name, create_folder};
use crate::estimated_terrain::EstimatedTerrains;
use crate::format::TableFormat;
use crate::ground_table::ground_batches;
use crate::table_file::{GROUP_ROWS, TableFile, start_columns, write_table};
use crate::terrain_table::terrain_batch;
use arrow_array::RecordBatch;
use rayon::prelude::*;
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use std::path::{Path, PathBuf};
use std::slice;

/// Makes the tables `truth`, `sensors`, `commands`, `estimate-NAME`, `ground-NAME` and `terrain` of
/// a run, in a folder or in memory. Recorded readings have neither `truth` nor `terrain`; only a control that
/// takes readings has `commands`. An estimator that finds no ground has no table `ground-NAME`; it is
/// made at the end of the run, because points change until the robot has left them.
///
/// A file that is not complete has another name; a run that breaks off closes its tables.
#[derive(Default)]
pub struct TableSink {
    /// Where the files are; `None` in memory.
    folder: Option<(PathBuf, TableFormat)>,
    tables: Vec<RowTable>,
    /// The ground that the estimators find.
    grounds: Option<(RunDescription, EstimatedTerrains)>,
    /// A row could not be written.
    failed: bool,
    in_memory: Vec<(String, RecordBatch)>,
}

/// A table whose rows come record by record.
struct RowTable {
    rows: BatchBuilder,
    /// `None` in memory.
    file: Option<TableFile>,
}

impl RowTable {
    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        self.rows.push_all(frames);
        match &mut self.file {
            Some(file) if self.rows.rows() >= GROUP_ROWS => file.write(&self.rows.take()?),
            _ => Ok(()),
        }
    }

    /// Completes its file, or returns what is in memory.
    fn finish(mut self) -> Result<Option<(String, RecordBatch)>, RecordError> {
        let Some(mut file) = self.file else {
            let batch = self.rows.take()?;
            return Ok(Some((self.rows.name().to_owned(), batch)));
        };
        file.write(&self.rows.take()?)?;
        file.finish(false).map(|()| None)
    }
}

impl TableSink {
    /// A sink for a folder, which is made if need be.
    pub fn new(folder: &Path, format: TableFormat) -> Self {
        Self {
            folder: Some((folder.to_path_buf(), format)),
            ..Self::default()
        }
    }

    /// A sink that keeps the tables as Arrow batches, with the same names, columns and metadata.
    pub fn in_memory() -> Self {
        Self::default()
    }

    /// Name and content of each table in memory: `truth`, `sensors`, `estimate-NAME`, then `terrain` and `ground-NAME`. Empty
    /// before the end of the run.
    pub fn into_tables(self) -> Vec<(String, RecordBatch)> {
        self.in_memory
    }

    fn open(&mut self, run: &RunDescription) -> Result<(), RecordError> {
        if let Some((folder, format)) = &self.folder {
            for estimator in &run.estimators {
                check_name(&estimator.label, folder)?;
            }
            create_folder(folder)?;
            start_columns(folder, *format)?;
        }
        self.grounds = Some((run.clone(), EstimatedTerrains::new(run)));
        let metadata = metadata(run);
        for table in Table::all(run) {
            let rows = BatchBuilder::new(table, &metadata);
            let create = |(folder, format): &(PathBuf, TableFormat)| {
                TableFile::create(folder, *format, rows.name(), rows.schema(), false)
            };
            let file = self.folder.as_ref().map(create).transpose()?;
            self.tables.push(RowTable { rows, file });
        }
        Ok(())
    }

    /// Adds the rows of records to all tables, on all cores. A table that cannot be written is left out from then on.
    fn push_all(&mut self, frames: &[Frame<'_>]) -> Result<(), RecordError> {
        if let Some((_, grounds)) = &mut self.grounds {
            frames.iter().for_each(|frame| grounds.add(frame));
        }
        let written = self.tables.par_iter_mut().map(|t| t.push_all(frames));
        let written: Vec<_> = written.collect();
        let mut is_whole = written.iter().map(Result::is_ok);
        self.tables.retain(|_| is_whole.next().unwrap_or(true));
        written.into_iter().collect()
    }

    /// Closes all tables even if one fails.
    fn close(&mut self) -> Result<(), RecordError> {
        let tables = std::mem::take(&mut self.tables);
        let closed: Vec<_> = tables.into_par_iter().map(RowTable::finish).collect();
        for table in closed {
            self.in_memory.extend(table?);
        }
        Ok(())
    }

    /// The tables of the ground, true and found.
    fn make_grounds(&mut self, end: Option<&RunEnd>) -> Result<(), RecordError> {
        let Some((run, mut grounds)) = self.grounds.take() else {
            return Ok(());
        };
        grounds.finish(end);
        let metadata = metadata(&run);
        let terrain = terrain_batch(&run, &metadata)?;
        let found = ground_batches(&run, &grounds, &metadata)?;
        for (name, batch) in terrain.into_iter().chain(found) {
            match &self.folder {
                Some((folder, format)) => write_table(folder, *format, &name, &batch)?,
                None => self.in_memory.push((name, batch)),
            }
        }
        Ok(())
    }
}

/// What a file says of its run.
fn metadata(run: &RunDescription) -> [(&'static str, String); 2] {
    [
        ("scene", run.name.clone()),
        ("robhaz_version", env!("CARGO_PKG_VERSION").to_owned()),
    ]
}

impl Sink for TableSink {
    fn clearance_need(&self) -> ClearanceNeed {
        ClearanceNeed::Always
    }

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
        self.close()?;
        if !self.failed {
            self.make_grounds(end)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::Kind;
    use crate::testing::{Record, described, log, records, scene};
    use arrow_array::{Array, Float64Array, RecordBatch, UInt32Array};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_run::RunError;
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

    fn cell(kind: Kind, array: &dyn Array, row: usize) -> Option<f64> {
        let array = array.as_any();
        if kind == Kind::Count {
            let counts: &UInt32Array = array.downcast_ref().expect("counts");
            return Some(f64::from(counts.value(row)));
        }
        let floats: &Float64Array = array.downcast_ref().expect("floats");
        floats.is_valid(row).then(|| floats.value(row))
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
                    let is_missing = column.kind() == Kind::Optional && text.is_empty();
                    let value = (!is_missing).then(|| text.parse().expect("a number"));
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
            let extension = format.extension();
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

    /// Equivalence: the tables in memory are those of the folder, to the bit, with the same columns, units and descriptions.
    #[test]
    fn memory_holds_what_a_folder_holds() -> Result<(), RunError> {
        let mut scene = scene();
        scene.record.duration = 3.0;
        let folder = tempfile::tempdir().expect("a folder");
        let mut files = TableSink::new(folder.path(), TableFormat::Parquet);
        let mut memory = TableSink::in_memory();
        robhaz_run::run(&scene, &mut [&mut files, &mut memory])?;
        let tables = memory.into_tables();
        let count = std::fs::read_dir(folder.path()).expect("files").count();
        assert_eq!(tables.len(), count);
        for (name, batch) in tables {
            let file = File::open(folder.path().join(format!("{name}.parquet"))).expect("a table");
            let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("a footer");
            assert_eq!(reader.schema().fields(), batch.schema().fields(), "{name}");
            let reader = reader.with_batch_size(batch.num_rows().max(1));
            let rows = reader.build().expect("a reader");
            let mut rows = rows.map(|batch| batch.expect("rows"));
            let read = rows.next().expect("a batch");
            assert_eq!(read.columns(), batch.columns(), "{name}");
            assert!(rows.next().is_none());
        }
        Ok(())
    }

    /// The bytes of a table do not depend on how its rows come, one by one or many at once, over
    /// several batches and row groups.
    #[test]
    fn a_table_does_not_depend_on_how_its_rows_come() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let records = records();
        let rows = records.iter().cycle().take(40_001);
        let rows: Vec<_> = rows.map(|record| record.without_truth()).collect();
        // A row group is a multiple of 1 and of 256: groups end at the same rows.
        for (folder, at_once) in folders.iter().zip([1, 256]) {
            let mut sink = TableSink::new(folder.path(), TableFormat::Parquet);
            sink.begin(&log()).expect("begins");
            for some in rows.chunks(at_once) {
                sink.frames(some).expect("rows");
            }
            sink.end(None).expect("closed");
        }
        let names = fs::read_dir(folders[0].path()).expect("files");
        let names: Vec<_> = names
            .map(|file| file.expect("a file").file_name())
            .collect();
        assert_eq!(names.len(), 4, "{names:?}");
        for name in names {
            let [a, b] = [0, 1].map(|i| fs::read(folders[i].path().join(&name)).expect("a table"));
            assert!(a == b, "{name:?}");
        }
    }

    /// A sink that goes without an end leaves no table that looks complete; a folder that has gone is an error.
    #[test]
    fn an_incomplete_table_has_no_name() {
        for format in [TableFormat::Parquet, TableFormat::Csv] {
            let folder = tempfile::tempdir().expect("a folder");
            let begin = || {
                let mut sink = TableSink::new(folder.path(), format);
                sink.begin(&log()).expect("begins");
                sink.frame(&records()[0].without_truth()).expect("a row");
                sink
            };
            drop(begin());
            let name = format!("estimate-mine.{}", format.extension());
            let file = |name: &str| folder.path().join(name).is_file();
            assert!(file(&format!("{name}.partial")) && !file(&name));
            let mut sink = begin();
            fs::remove_dir_all(folder.path()).expect("removed");
            let error = sink.end(None).expect_err("nowhere to put it").to_string();
            assert!(
                error.contains(&format!(".{}", format.extension())),
                "{error}"
            );
        }
    }
}

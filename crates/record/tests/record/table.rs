//! The tables of a run, as files and in memory.

use crate::testing::{Record, described, log, records, scene, value_of};
use arrow_array::{Array, Float64Array, RecordBatch, UInt32Array};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use robhaz_record::{Kind, Table, TableFormat, TableSink};
use robhaz_run::{RunError, Sink};
use std::fs::{self, File};
use std::path::Path;

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
                    let expected = value_of(column, &records[row].frame());
                    let found = cell(column.kind, array.as_ref(), i);
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
                let is_missing = column.kind == Kind::Optional && text.is_empty();
                let value = (!is_missing).then(|| text.parse().expect("a number"));
                assert_eq!(value, value_of(column, &record.frame()), "{}", column.name);
            }
        }
    }
}

/// The lines of the terrain's columns, from the table with metadata.
fn of_the_terrain() -> Vec<Vec<String>> {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), TableFormat::Parquet, &records());
    let (_, file) = read(&folder.path().join("terrain.parquet"));
    let line = |field: &std::sync::Arc<arrow_schema::Field>| {
        let note = |key: &str| field.metadata()[key].clone();
        let name = field.name().clone();
        vec![
            "terrain".to_owned(),
            name,
            note("unit"),
            note("description"),
        ]
    };
    file.schema().fields().iter().map(line).collect()
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
        .chain(of_the_terrain())
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

/// Equivalence: the tables in memory are those of the folder, to the bit, with the same columns,
/// units and descriptions.
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

/// A sink that goes without an end leaves no table that looks complete; a folder that has gone is
/// an error.
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

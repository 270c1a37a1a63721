//! The table of the ground.

use arrow_array::Array;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use robhaz_record::{TableFormat, TableSink};
use robhaz_run::Sink;
use robhaz_terrain::{Profile, Surveyed, Terrain};
use std::fs::File;

/// Both formats hold the same ground, a riser without slope, and reach as far as the run.
#[test]
fn the_ground_is_in_the_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut scene = crate::testing::scene();
    scene.terrain.profile = Profile::Stairs(robhaz_terrain::Stairs::step());
    scene.record.duration = 20.0;
    let run = crate::testing::described(&scene);
    for format in [TableFormat::Csv, TableFormat::Parquet] {
        let mut sink = TableSink::new(folder.path(), format);
        sink.begin(&run).expect("begins");
        sink.end(None).expect("ends");
    }
    let csv = csv::Reader::from_path(folder.path().join("terrain.csv"));
    let rows: Vec<Vec<Option<f64>>> = csv
        .expect("the table")
        .records()
        .map(|r| r.expect("a row").iter().map(|c| c.parse().ok()).collect())
        .collect();
    // Every 5 mm, and 1 m on beyond the front wheels.
    let far = scene.robot.robot.geometry.axles[0].x + 20.0 * scene.drive.speed + 1.0;
    let terrain = Terrain::new(Profile::Stairs(robhaz_terrain::Stairs::step()));
    let expected = terrain.survey(rows[0][0].expect("a place"), far, 0.005);
    let row = |p: &Surveyed| vec![Some(p.x), Some(p.height), p.slope, p.curvature];
    let expected_rows: Vec<Vec<_>> = expected.iter().map(row).collect();
    assert_eq!(rows, expected_rows);

    let file = File::open(folder.path().join("terrain.parquet")).expect("the table");
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).expect("a footer");
    for (name, unit) in [
        ("x", "m"),
        ("height", "m"),
        ("slope", "1"),
        ("curvature", "1/m"),
    ] {
        let field = builder.schema().field_with_name(name).expect("a field");
        let found = field.metadata().get("unit").map(String::as_str);
        assert_eq!(found, Some(unit));
    }
    let batches: Vec<_> = builder.build().expect("a reader").collect();
    let batch = batches[0].as_ref().expect("rows");
    assert_eq!(batch.num_rows(), expected.len());
    assert_eq!(batch.column(2).null_count(), 2);
}

//! The table `terrain`: the ground of a run.

use crate::error::{RecordError, io_error};
use crate::format::TableFormat;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use robhaz_run::{RunDescription, World};
use robhaz_terrain::{Profile, Surveyed};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

const NAME: &str = "terrain";
/// Largest distance of rows on a curve, m: a twentieth of a wheel's radius.
const SPACING: f64 = 0.005;
/// Largest number of rows on curves: on a longer ground they are farther apart.
const MOST: f64 = 1e6;
/// Ground before and behind the reach of the run and the profile, m.
const MARGIN: f64 = 1.0;

/// A column: name, unit, description, and its value.
type Column = (
    &'static str,
    &'static str,
    &'static str,
    fn(&Surveyed) -> Option<f64>,
);

const COLUMNS: [Column; 4] = [
    ("x", "m", "position along the ground", |p| Some(p.x)),
    ("height", "m", "height of the ground", |p| Some(p.height)),
    (
        "slope",
        "1",
        "dy/dx; two rows at one x where it jumps, empty on a riser",
        |p| p.slope,
    ),
    (
        "curvature",
        "1/m",
        "y''/(1 + y'^2)^(3/2), positive in hollows; empty on a riser",
        |p| p.curvature,
    ),
];

/// Writes the table, and with CSV its lines of `columns.csv`, which is there already. Recorded readings have no ground.
pub fn write_terrain(
    folder: &Path,
    format: TableFormat,
    run: &RunDescription,
    metadata: &[(&str, String)],
) -> Result<(), RecordError> {
    let Some(world) = &run.world else {
        return Ok(());
    };
    let points = survey(run, world);
    match format {
        TableFormat::Parquet => {
            let path = folder.join(format!("{NAME}.parquet"));
            let file = File::create(&path).map_err(io_error("create", &path))?;
            write_parquet(file, &points, metadata).map_err(|source| RecordError::Parquet {
                path: path.clone(),
                source,
            })
        }
        TableFormat::Csv => {
            let path = folder.join(format!("{NAME}.csv"));
            write_csv(&path, &points).map_err(io_error("write", &path))?;
            let path = folder.join("columns.csv");
            add_columns(&path).map_err(io_error("write", &path))
        }
    }
}

/// The ground of the profile and as far as the wheels can come at the set speed.
fn survey(run: &RunDescription, world: &World) -> Vec<Surveyed> {
    let profile = &world.terrain.profile;
    let terrain = world.terrain.build(&run.robot.robot);
    let geometry = &run.robot.robot.geometry;
    let travel = world.drive.speed * run.record.duration;
    let [back, ahead] = world
        .drive
        .planned_travel(run.record.duration, geometry.wheel_radius);
    let axles = geometry.axles.iter();
    let reached = axles.flat_map(|a| [0.0, travel, back, ahead].map(|x| a.x + x));
    let ends = match profile {
        Profile::Flat => None,
        _ => Some(terrain.extent()),
    };
    let all = reached.chain(ends.into_iter().flat_map(|(from, to)| [from, to]));
    let (from, to) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    let (from, to) = (from - MARGIN, to + MARGIN);
    terrain.survey(from, to, SPACING.max((to - from) / MOST))
}

fn write_parquet(
    file: File,
    points: &[Surveyed],
    metadata: &[(&str, String)],
) -> ParquetResult<()> {
    let field = |(name, unit, description, _): &Column| {
        let nullable = ["slope", "curvature"].contains(name);
        Field::new(*name, DataType::Float64, nullable).with_metadata(HashMap::from([
            ("unit".to_owned(), (*unit).to_owned()),
            ("description".to_owned(), (*description).to_owned()),
        ]))
    };
    let schema = Arc::new(Schema::new(COLUMNS.iter().map(field).collect::<Vec<_>>()));
    let array = |(_, _, _, value): &Column| -> ArrayRef {
        Arc::new(points.iter().map(value).collect::<Float64Array>())
    };
    let batch = RecordBatch::try_new(Arc::clone(&schema), COLUMNS.iter().map(array).collect())?;
    let metadata = metadata
        .iter()
        .map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata.collect()))
        .build();
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties))?;
    writer.write(&batch)?;
    writer.close()?;
    Ok(())
}

fn write_csv(path: &Path, points: &[Surveyed]) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    writeln!(out, "{}", COLUMNS.map(|c| c.0).join(","))?;
    for point in points {
        let cell = |c: Column| c.3(point).map_or(String::new(), |value| format!("{value:?}"));
        writeln!(out, "{}", COLUMNS.map(cell).join(","))?;
    }
    out.flush()
}

fn add_columns(path: &Path) -> io::Result<()> {
    let mut out = OpenOptions::new().append(true).open(path)?;
    for (name, unit, description, _) in COLUMNS {
        writeln!(out, "{NAME},{name},{unit},\"{description}\"")?;
    }
    Ok(())
}

/// The lines of `columns.csv` on this table.
#[cfg(test)]
pub fn rows_of_columns() -> impl Iterator<Item = Vec<String>> {
    COLUMNS.into_iter().map(|(name, unit, description, _)| {
        [NAME, name, unit, description].map(str::to_owned).to_vec()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_terrain::Terrain;

    /// Both formats hold the same ground, a riser without slope, and reach as far as the run.
    #[test]
    fn the_ground_is_in_the_table() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = crate::testing::scene();
        scene.terrain.profile = Profile::step();
        scene.record.duration = 20.0;
        let run = crate::testing::described(&scene);
        let metadata = [("scene", "trial".to_owned())];
        std::fs::write(folder.path().join("columns.csv"), "").expect("written");
        for format in [TableFormat::Csv, TableFormat::Parquet] {
            write_terrain(folder.path(), format, &run, &metadata).expect("written");
        }
        let expected = survey(&run, run.world.as_ref().expect("a simulation"));
        let far = scene.robot.robot.geometry.axles[0].x + 20.0 * scene.drive.speed + MARGIN;
        assert!(expected.last().is_some_and(|p| (p.x - far).abs() < 1e-12));
        let terrain = Terrain::new(Profile::step());
        assert_eq!(expected, terrain.survey(expected[0].x, far, SPACING));

        let csv = csv::Reader::from_path(folder.path().join("terrain.csv"));
        let rows: Vec<Vec<Option<f64>>> = csv
            .expect("the table")
            .records()
            .map(|r| r.expect("a row").iter().map(|c| c.parse().ok()).collect())
            .collect();
        let row = |p: &Surveyed| COLUMNS.map(|c| c.3(p)).to_vec();
        assert_eq!(rows, expected.iter().map(row).collect::<Vec<_>>());

        let file = File::open(folder.path().join("terrain.parquet")).expect("the table");
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).expect("a footer");
        for (name, unit, _, _) in COLUMNS {
            let field = builder.schema().field_with_name(name).expect("a field");
            assert_eq!(field.metadata().get("unit").map(String::as_str), Some(unit));
        }
        let batches: Vec<_> = builder.build().expect("a reader").collect();
        let batch = batches[0].as_ref().expect("rows");
        assert_eq!(batch.num_rows(), expected.len());
        assert_eq!(batch.column(2).null_count(), 2);
    }
}

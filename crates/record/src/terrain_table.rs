//! The table `terrain`: the ground of a run.

use crate::error::RecordError;
use crate::point_table::{PointColumn, batch_of_points};
use crate::quantile::extremes;
use arrow_array::RecordBatch;
use robhaz_run::RunDescription;
use robhaz_scene::Scene;
use robhaz_terrain::{Profile, Surveyed};

const NAME: &str = "terrain";
/// Largest distance of rows on a curve, m: a twentieth of a wheel's radius.
const SPACING: f64 = 0.005;
/// Largest number of rows on curves: on a longer ground they are farther apart.
const MOST: f64 = 1e6;
/// Ground before and behind the reach of the run and the profile, m.
const MARGIN: f64 = 1.0;

const COLUMNS: &[PointColumn<Surveyed>] = crate::point_columns! {
    Float "x", "m", "position along the ground" => |p| Some(p.x);
    Float "height", "m", "height of the ground" => |p| Some(p.height);
    Optional "slope", "1", "dy/dx; two rows at one x where it jumps, empty on a riser" => |p| p.slope;
    Optional "curvature", "1/m", "y''/(1 + y'^2)^(3/2), positive in hollows; empty on a riser" => |p| p.curvature;
};

/// Name and content of the table, as an Arrow batch. Recorded readings have no ground.
pub fn terrain_batch(
    run: &RunDescription,
    metadata: &[(&str, String)],
) -> Result<Option<(String, RecordBatch)>, RecordError> {
    let Some(world) = &run.world else {
        return Ok(None);
    };
    let batch = batch_of_points(COLUMNS, &survey(run, world), metadata)?;
    Ok(Some((NAME.to_owned(), batch)))
}

/// The ground of the profile and as far as the wheels can come at the set speed.
fn survey(run: &RunDescription, world: &Scene) -> Vec<Surveyed> {
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
    let (from, to) = extremes(all);
    let (from, to) = (from - MARGIN, to + MARGIN);
    terrain.survey(from, to, SPACING.max((to - from) / MOST))
}

/// The lines of `columns.csv` on this table.
#[cfg(test)]
pub fn rows_of_columns() -> impl Iterator<Item = Vec<String>> {
    COLUMNS.iter().map(|c| {
        [NAME, c.name, c.unit, c.description]
            .map(str::to_owned)
            .to_vec()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::TableFormat;
    use crate::table_file::{start_columns, write_table};
    use arrow_array::Array;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use robhaz_terrain::Terrain;
    use std::fs::File;

    /// Both formats hold the same ground, a riser without slope, and reach as far as the run.
    #[test]
    fn the_ground_is_in_the_table() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = crate::testing::scene();
        scene.terrain.profile = Profile::step();
        scene.record.duration = 20.0;
        let run = crate::testing::described(&scene);
        for format in [TableFormat::Csv, TableFormat::Parquet] {
            start_columns(folder.path(), format).expect("begun");
            let (name, batch) = terrain_batch(&run, &[])
                .expect("a batch")
                .expect("a ground");
            write_table(folder.path(), format, &name, &batch).expect("written");
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
        let row = |p: &Surveyed| COLUMNS.iter().map(|c| (c.get)(p)).collect();
        let expected_rows: Vec<Vec<_>> = expected.iter().map(row).collect();
        assert_eq!(rows, expected_rows);

        let file = File::open(folder.path().join("terrain.parquet")).expect("the table");
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).expect("a footer");
        for column in COLUMNS {
            let field = builder
                .schema()
                .field_with_name(column.name)
                .expect("a field");
            let unit = field.metadata().get("unit").map(String::as_str);
            assert_eq!(unit, Some(column.unit));
        }
        let batches: Vec<_> = builder.build().expect("a reader").collect();
        let batch = batches[0].as_ref().expect("rows");
        assert_eq!(batch.num_rows(), expected.len());
        assert_eq!(batch.column(2).null_count(), 2);
    }
}

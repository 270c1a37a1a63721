//! Tables of points, which are made at once: `terrain`, the ground of a run; `ground-NAME`, the
//! ground as an estimator has found it; a judged path.

use crate::batch::{array, field, schema};
use crate::columns::Kind;
use crate::error::Result;
use crate::estimated_terrain::{ComparedPoint, compared};
use crate::table_file::{TableFormat, start_columns, write_table};
use arrow_array::RecordBatch;
use robhaz_run::{RunDescription, RunEnd};
use robhaz_scene::Scene;
use robhaz_score::extremes;
use robhaz_terrain::{Profile, Surveyed, Terrain};
use std::path::Path;

/// Largest distance of rows on a curve, m: a twentieth of a wheel's radius.
const SPACING: f64 = 0.005;
/// Largest number of rows on curves: on a longer ground they are farther apart.
const MOST: f64 = 1e6;
/// Ground before and behind the reach of the run and the profile, m.
const MARGIN: f64 = 1.0;

/// A column of a table of points.
pub struct PointColumn<T> {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` where it has none.
    pub unit: &'static str,
    /// Its content.
    pub description: &'static str,
    /// The kind of its values.
    pub kind: Kind,
    /// Its value at a point.
    pub get: fn(&T) -> Option<f64>,
}

/// Columns of points, a line each: kind, name, unit, meaning, value.
#[macro_export]
macro_rules! point_columns {
    ($($kind:ident $name:literal, $unit:literal, $description:literal => $get:expr;)*) => {
        &[$($crate::PointColumn {
            name: $name,
            unit: $unit,
            description: $description,
            kind: $crate::Kind::$kind,
            get: $get,
        }),*]
    };
}

/// The table as an Arrow batch. `metadata` are keys and values of the table as a whole.
///
/// # Errors
/// [`RecordError::Batch`] where columns have different lengths.
fn batch_of_points<T>(
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result<RecordBatch> {
    let fields = columns.iter();
    let fields = fields.map(|c| field(c.name, c.unit, c.description, c.kind.values()));
    let values = |column: &PointColumn<T>| {
        let values = points.iter().map(column.get);
        values.map(|v| v.unwrap_or(f64::NAN)).collect()
    };
    let arrays = columns.iter().map(|c| array(values(c), c.kind));
    let batch = RecordBatch::try_new(schema(fields.collect(), metadata), arrays.collect());
    Ok(batch?)
}

/// Writes the table `name` into a folder that has no other; with CSV also `columns.csv`. `metadata`
/// are keys and values of the table as a whole.
///
/// # Errors
/// [`RecordError`](crate::RecordError) of the file system.
pub fn write_points<T>(
    folder: &Path,
    format: TableFormat,
    name: &str,
    columns: &[PointColumn<T>],
    points: &[T],
    metadata: &[(&str, String)],
) -> Result {
    start_columns(folder, format)?;
    let batch = batch_of_points(columns, points, metadata)?;
    write_table(folder, format, name, &batch)
}

const TERRAIN: &[PointColumn<Surveyed>] = point_columns! {
    Float "x", "m", "position along the ground" => |p| Some(p.x);
    Float "height", "m", "height of the ground" => |p| Some(p.height);
    Optional "slope", "1", "dy/dx; two rows at one x where it jumps, empty on a riser" => |p| p.slope;
    Optional "curvature", "1/m", "y''/(1 + y'^2)^(3/2), positive in hollows; empty on a riser" => |p| p.curvature;
};

const GROUND: &[PointColumn<ComparedPoint>] = point_columns! {
    Float "section", "1", "number of the section: places of different sections have different origins" =>
        |(p, _)| Some(f64::from(p.section));
    Float "x", "m", "place along the path, from the middle axle's place at the start" => |(p, _)| Some(p.x);
    Float "y", "m", "height over the middle wheel's contact at the start" => |(p, _)| Some(p.height);
    Float "slope", "rad", "angle of the tangent" => |(p, _)| Some(p.slope);
    Float "sigma_x", "m", "standard deviation of x" => |(p, _)| Some(p.sigma_x);
    Float "sigma_y", "m", "standard deviation of y at x, with that of x times the slope" => |(p, _)| Some(p.sigma_height);
    Float "sigma_slope", "rad", "standard deviation of the slope at x" => |(p, _)| Some(p.sigma_slope);
    Float "friction_at_least", "1",
        "lower bound of mu_max: the largest |T/N| that a wheel bore there, less two deviations; 0 without any" =>
        |(p, _)| Some(p.friction.at_least);
    Optional "friction_at_most", "1",
        "upper bound of mu_max: |T/N| at which a wheel began to slip there, plus two deviations; empty where none did" =>
        |(p, _)| p.friction.at_most;
    Optional "true_y", "m", "true height at x, from the same origin; empty in later sections" => |(_, t)| t.map(|t| t.height);
    Optional "true_slope", "rad", "true angle at x; empty on a riser and in later sections" => |(_, t)| (*t)?.slope;
};

/// Name and content of the table of the ground, which recorded readings do not have, and of each
/// estimator that has found ground.
pub fn ground_tables(
    run: &RunDescription,
    end: Option<&RunEnd>,
    metadata: &[(&str, String)],
) -> Result<Vec<(String, RecordBatch)>> {
    let world = run.world.as_ref();
    let terrain = world.map(|w| w.terrain.build(&run.robot.robot));
    let mut tables = Vec::new();
    if let Some((world, terrain)) = world.zip(terrain.as_ref()) {
        let points = survey(run, world, terrain);
        let batch = batch_of_points(TERRAIN, &points, metadata)?;
        tables.push(("terrain".to_owned(), batch));
    }
    for (k, estimator) in run.estimators.iter().enumerate() {
        let points = end.map(|end| compared(run, end, k, terrain.as_ref()));
        let points = points.unwrap_or_default();
        if !points.is_empty() {
            let batch = batch_of_points(GROUND, &points, metadata)?;
            tables.push((format!("ground-{}", estimator.label), batch));
        }
    }
    Ok(tables)
}

/// The ground of the profile and as far as the wheels can come at the set speed.
fn survey(run: &RunDescription, world: &Scene, terrain: &Terrain) -> Vec<Surveyed> {
    let geometry = &run.robot.robot.geometry;
    let travel = world.drive.speed * run.record.duration;
    let planned = (world.drive).planned_travel(run.record.duration, geometry.wheel_radius);
    let [back, ahead] = planned;
    let axles = geometry.axles.iter();
    let reached = axles.flat_map(|a| [0.0, travel, back, ahead].map(|x| a.x + x));
    let has_ends = world.terrain.profile != Profile::Flat;
    let ends = has_ends.then(|| terrain.extent()).into_iter();
    let all = reached.chain(ends.flat_map(|(from, to)| [from, to]));
    let (from, to) = extremes(all);
    let (from, to) = (from - MARGIN, to + MARGIN);
    terrain.survey(from, to, SPACING.max((to - from) / MOST))
}

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

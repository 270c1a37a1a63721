//! The table `ground-NAME`: the ground as an estimator has found it.

use crate::error::RecordError;
use crate::estimated_terrain::{ComparedPoint, EstimatedTerrains};
use crate::point_table::{PointColumn, batch_of_points};
use arrow_array::RecordBatch;
use robhaz_run::RunDescription;

const COLUMNS: &[PointColumn<ComparedPoint>] = crate::point_columns! {
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

/// Name and content of the table of each estimator that has found ground, as Arrow batches.
pub fn ground_batches(
    run: &RunDescription,
    grounds: &EstimatedTerrains,
    metadata: &[(&str, String)],
) -> Result<Vec<(String, RecordBatch)>, RecordError> {
    let robot = &run.robot.robot;
    let terrain = run.world.as_ref().map(|w| w.terrain.build(robot));
    let mut batches = Vec::new();
    for (k, estimator) in run.estimators.iter().enumerate() {
        let points = grounds.compared(k, terrain.as_ref());
        if !points.is_empty() {
            let batch = batch_of_points(COLUMNS, &points, metadata)?;
            batches.push((format!("ground-{}", estimator.label), batch));
        }
    }
    Ok(batches)
}

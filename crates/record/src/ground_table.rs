//! The table `ground-NAME`: the ground as an estimator has found it.

use crate::error::RecordError;
use crate::felt_ground::{ComparedPoint, FeltGrounds};
use crate::format::TableFormat;
use crate::point_table::{PointColumn, batch_of_points, write_points};
use arrow_array::RecordBatch;
use arrow_schema::ArrowError;
use robhaz_run::RunDescription;
use std::path::Path;

const COLUMNS: [PointColumn<ComparedPoint>; 11] = [
    PointColumn::always(
        "section",
        "1",
        "number of the section: places of different sections have different origins",
        |(p, _)| Some(f64::from(p.section)),
    ),
    PointColumn::always(
        "x",
        "m",
        "place along the path, from the middle axle's place at the start",
        |(p, _)| Some(p.x),
    ),
    PointColumn::always(
        "y",
        "m",
        "height over the middle wheel's contact at the start",
        |(p, _)| Some(p.height),
    ),
    PointColumn::always("slope", "rad", "angle of the tangent", |(p, _)| {
        Some(p.slope)
    }),
    PointColumn::always("sigma_x", "m", "standard deviation of x", |(p, _)| {
        Some(p.sigma_x)
    }),
    PointColumn::always(
        "sigma_y",
        "m",
        "standard deviation of y at x, with that of x times the slope",
        |(p, _)| Some(p.sigma_height),
    ),
    PointColumn::always(
        "sigma_slope",
        "rad",
        "standard deviation of the slope at x",
        |(p, _)| Some(p.sigma_slope),
    ),
    PointColumn::always(
        "friction_at_least",
        "1",
        "lower bound of mu_max: the largest |T/N| that a wheel bore there, less two deviations; 0 without any",
        |(p, _)| Some(p.friction.at_least),
    ),
    PointColumn {
        nullable: true,
        ..PointColumn::always(
            "friction_at_most",
            "1",
            "upper bound of mu_max: |T/N| at which a wheel began to slip there, plus two deviations; empty where none did",
            |(p, _)| p.friction.at_most,
        )
    },
    PointColumn {
        nullable: true,
        ..PointColumn::always(
            "true_y",
            "m",
            "true height at x, from the same origin; empty in later sections",
            |(_, t)| t.map(|t| t.height),
        )
    },
    PointColumn {
        nullable: true,
        ..PointColumn::always(
            "true_slope",
            "rad",
            "true angle at x; empty on a riser and in later sections",
            |(_, t)| (*t)?.slope,
        )
    },
];

/// Writes the table of each estimator that has found ground.
pub fn write_grounds(
    folder: &Path,
    format: TableFormat,
    run: &RunDescription,
    grounds: &FeltGrounds,
    metadata: &[(&str, String)],
) -> Result<(), RecordError> {
    for (name, points) in found(run, grounds) {
        write_points(folder, format, &name, &COLUMNS, &points, metadata)?;
    }
    Ok(())
}

/// Name and content of the table of each estimator that has found ground, as Arrow batches.
pub fn ground_batches(
    run: &RunDescription,
    grounds: &FeltGrounds,
    metadata: &[(&str, String)],
) -> Result<Vec<(String, RecordBatch)>, ArrowError> {
    let batch = |(name, points): (String, Vec<_>)| {
        Ok((name, batch_of_points(&COLUMNS, &points, metadata)?))
    };
    found(run, grounds).into_iter().map(batch).collect()
}

/// Name and points of each table.
fn found(run: &RunDescription, grounds: &FeltGrounds) -> Vec<(String, Vec<ComparedPoint>)> {
    let robot = &run.robot.robot;
    let terrain = run.world.as_ref().map(|w| w.terrain.build(robot));
    let estimators = run.estimators.iter().enumerate();
    let tables = estimators.map(|(k, estimator)| {
        let points = grounds.compared(k, terrain.as_ref());
        (format!("ground-{}", estimator.label), points)
    });
    tables.filter(|(_, points)| !points.is_empty()).collect()
}

//! What scales and inclinometers would show of a given robot.

use crate::blocks::{Blocks, posture_on};
use crate::error::WeighError;
use crate::measurements::{Accuracy, Measurements, Reading};
use crate::statics::plate_forces;
use robhaz_model::Robot;

/// Readings of a robot on blocks, with errors of the stated accuracy. `normal` draws from N(0, 1).
///
/// # Errors
/// [`WeighError`] with the index of the posture that the robot cannot take.
pub fn simulate(
    robot: &Robot,
    postures: &[Blocks],
    accuracy: &Accuracy,
    mut normal: impl FnMut() -> f64,
) -> Result<Measurements, (usize, WeighError)> {
    let offsets = [0, 1].map(|_| accuracy.inclination_offset * normal());
    let mut measurements = Measurements::default();
    for (k, blocks) in postures.iter().enumerate() {
        let angles = posture_on(robot, blocks).map_err(|error| (k, error))?;
        let drawn = [0, 1, 2].map(|_| accuracy.horizontal_force * normal());
        let mean = drawn.iter().sum::<f64>() / 3.0;
        let horizontal = drawn.map(|t| t - mean);
        let forces = plate_forces(robot, angles, horizontal);
        let forces = forces.map_err(|error| (k, error))?;
        measurements.readings.push(Reading {
            // As in the table of these readings: names in the first line, then a posture a line.
            line: k as u64 + 2,
            inclinations: [0, 1].map(|i| angles[i] + offsets[i] + accuracy.inclination * normal()),
            forces: forces.map(|n| Some(n + accuracy.scale * normal())),
        });
    }
    Ok(measurements)
}

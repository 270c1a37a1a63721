//! The posture of a robot with its wheels on blocks, and what scales would show of it there.

use crate::error::{Result, WeighError};
use crate::measurements::{Accuracy, Measurements, Reading};
use crate::statics::plate_forces;
use robhaz_model::{GRAVITY, Posture, PostureError, Robot, Vec2, cross};

/// Heights of the horizontal plates under the front, middle and rear wheel, m.
pub type Blocks = [f64; 3];

/// Distance that a posture keeps from the stops, rad: 2 deg.
const STOP_MARGIN: f64 = 0.035;
/// Share of the mean wheel load that each wheel bears at least, so that the robot stands firmly.
const LEAST_LOAD: f64 = 0.1;
/// Most steps of Newton's method.
const MOST_STEPS: usize = 50;

/// Angles of links 1 and 2 with the wheels on blocks, rad: Newton's method from the nominal pose.
///
/// # Errors
/// [`WeighError`]: heights that the linkage does not reach, a wheel that bears too little.
pub fn posture_on(robot: &Robot, blocks: &Blocks) -> Result<[f64; 2]> {
    let geometry = &robot.geometry;
    let error = |[theta1, theta2]: [f64; 2]| -> Result<Vec2, PostureError> {
        let posture = Posture::close(geometry, theta1, theta2)?;
        let height = |i: usize| posture.axle_from_q(geometry, i).y - blocks[i];
        Ok(Vec2::new(height(0) - height(1), height(1) - height(2)))
    };
    let unreachable = || WeighError::new("the linkage cannot reach these heights");
    let mut angles = [0.0; 2];
    for _ in 0..MOST_STEPS {
        let now = error(angles)?;
        if now.norm() < 1e-12 {
            return check(robot, angles);
        }
        let step = 1e-6;
        let by1 = (error([angles[0] + step, angles[1]])? - now) / step;
        let by2 = (error([angles[0], angles[1] + step])? - now) / step;
        let determinant = cross(by1, by2);
        if determinant.abs() < 1e-9 {
            return Err(unreachable());
        }
        let change = [cross(now, by2), cross(by1, now)].map(|c| c / determinant);
        for i in 0..2 {
            // Half a radian is more than the way between the stops.
            angles[i] -= change[i].clamp(-0.3, 0.3);
        }
    }
    Err(unreachable())
}

fn check(robot: &Robot, angles: [f64; 2]) -> Result<[f64; 2]> {
    let (stop, opening) = (&robot.geometry.stop, angles[0] - angles[1]);
    if !(opening > stop.lower + STOP_MARGIN && opening < stop.upper - STOP_MARGIN) {
        let message = "theta_1 - theta_2 would be beyond or close to an end stop of pin Q";
        return Err(WeighError::new(message));
    }
    let forces = plate_forces(robot, angles, [0.0; 3])?;
    let least = LEAST_LOAD * robot.mass.total() * GRAVITY / 3.0;
    match (1..).zip(forces).find(|(_, n)| *n < least) {
        Some((wheel, force)) => Err(WeighError::new(format!(
            "wheel{wheel} would bear {force:.1} N only"
        ))),
        None => Ok(angles),
    }
}

/// Readings of a robot on blocks, with errors of the stated accuracy. `normal` draws from N(0, 1).
///
/// # Errors
/// [`WeighError`] with the blocks of the posture that the robot cannot take.
pub fn simulate(
    robot: &Robot,
    postures: &[Blocks],
    accuracy: &Accuracy,
    mut normal: impl FnMut() -> f64,
) -> Result<Measurements> {
    let offsets = [0, 1].map(|_| accuracy.inclination_offset * normal());
    let scales = [0, 1, 2].map(|_| accuracy.draw_scale(&mut normal));
    let mut measurements = Measurements::default();
    for (k, blocks) in postures.iter().enumerate() {
        let refused = |reason: WeighError| {
            let blocks = blocks.map(|h| format!("{:.0}", 1e3 * h)).join(", ");
            WeighError::new(format!(
                "the simulated robot cannot be weighed on blocks of {blocks} mm: {reason}"
            ))
        };
        let angles = posture_on(robot, blocks).map_err(refused)?;
        let drawn = [0, 1, 2].map(|_| accuracy.horizontal_force * normal());
        let mean = drawn.iter().sum::<f64>() / 3.0;
        let horizontal = drawn.map(|t| t - mean);
        let forces = plate_forces(robot, angles, horizontal).map_err(refused)?;
        measurements.readings.push(Reading {
            // As in the table of these readings: names in the first line, then a posture a line.
            line: k as u64 + 2,
            inclinations: [0, 1].map(|i| angles[i] + offsets[i] + accuracy.inclination * normal()),
            forces: [0, 1, 2]
                .map(|i| Some(accuracy.shown(forces[i], scales[i]) + accuracy.scale * normal())),
        });
    }
    Ok(measurements)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the wheels' lowest points are at the blocks' heights, relative to each other;
    /// level ground is the nominal pose; all blocks of one height as well.
    #[test]
    fn wheels_stand_on_their_blocks() {
        let robot = Robot::default_a();
        for blocks in [[0.1, 0.0, 0.05], [0.0, 0.1, 0.0], [0.05; 3]] {
            let angles = posture_on(&robot, &blocks).expect("reachable");
            let posture = Posture::close(&robot.geometry, angles[0], angles[1]).expect("closes");
            let y = |i| posture.axle_from_q(&robot.geometry, i).y;
            for i in 0..2 {
                let expected = blocks[i] - blocks[i + 1];
                assert!((y(i) - y(i + 1) - expected).abs() < 1e-11, "{blocks:?}");
            }
        }
        assert_eq!(posture_on(&robot, &[0.05; 3]), Ok([0.0; 2]));
    }

    #[test]
    fn blocks_that_are_too_high_are_refused() {
        let robot = Robot::default_a();
        assert!(posture_on(&robot, &[0.0, 2.0, 0.0]).is_err());
        let found = posture_on(&robot, &[0.28, 0.0, 0.0]);
        assert!(found.is_err_and(|e| e.to_string().contains("an end stop of pin Q")));
    }
}

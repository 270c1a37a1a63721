//! How a reading follows from the cells of a row.

use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// How a reading follows from the cells of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Formula {
    /// What the cells give.
    pub source: Source,
    /// Factor from it to the reading. 1 keeps the bits.
    pub factor: f64,
    /// Subtracted after the factor, in the reading's SI unit. 0 keeps the bits.
    pub offset: f64,
    /// Whether the result is a direction, taken within half a turn of 0: 180 deg are -180 deg.
    pub is_direction: bool,
}

/// What the cells of a row give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A cell, by its index in the row.
    Cell(usize),
    /// The inclination, rad: angle of the direction up, seen from the sensor's axes that point
    /// forward and up in the nominal pose; of a body that rolls (true) with respect to the level across, so that a roll
    /// does not change it.
    Inclination(Upward, [[f64; 3]; 2], bool),
    /// The rate about an axis, such as that across the robot, nose up positive: cells x y z of the angular
    /// velocity, and that axis.
    Rate([usize; 3], [f64; 3]),
}

/// Where the direction up comes from, in the sensor's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Upward {
    /// The specific force: cells x y z. At rest it points up.
    SpecificForce([usize; 3]),
    /// The orientation: cells x y z w of the rotation from the sensor to the world, and the
    /// direction up along the world's z axis, 1 or -1.
    Orientation([usize; 4], f64),
}

impl Formula {
    /// What the cells give, as it is.
    pub fn of(source: Source) -> Self {
        Self {
            source,
            factor: 1.0,
            offset: 0.0,
            is_direction: false,
        }
    }

    /// A cell as it is.
    pub fn of_cell(cell: usize) -> Self {
        Self::of(Source::Cell(cell))
    }

    /// The reading of a row's cells; `None` where a cell is missing or the direction has no length.
    pub fn value(&self, cells: &[f64]) -> Option<f64> {
        let found = match self.source {
            Source::Cell(cell) => all(cells, [cell])?[0],
            Source::Inclination(up, axes, rolls) => {
                let direction = up.direction(cells)?;
                let [forward, upward] = axes.map(|axis| dot(direction, axis));
                let left = || dot(direction, across(axes[1], axes[0]));
                let level = if rolls { left().hypot(upward) } else { upward };
                let has_length = forward != 0.0 || level != 0.0;
                has_length.then(|| forward.atan2(level))?
            }
            Source::Rate(of, axis) => dot(all(cells, of)?, axis),
        };
        let (value, offset) = (found * self.factor, self.offset);
        // Subtracting zero would change the sign of a zero.
        let value = if offset == 0.0 { value } else { value - offset };
        Some(match self.is_direction {
            true => within_half_turn(value),
            false => value,
        })
    }
}

impl Upward {
    fn direction(&self, cells: &[f64]) -> Option<[f64; 3]> {
        match *self {
            Self::SpecificForce(of) => all(cells, of),
            // The third row of the rotation matrix.
            Self::Orientation(of, up) => {
                let [x, y, z, w] = all(cells, of)?;
                let axis = [
                    2.0 * (x * z - w * y),
                    2.0 * (y * z + w * x),
                    w * w - x * x - y * y + z * z,
                ];
                Some(axis.map(|part| up * part))
            }
        }
    }
}

/// An angle within half a turn of 0, rad: a sensor that hangs upside down shows 180 deg from both
/// sides.
fn within_half_turn(angle: f64) -> f64 {
    // Others keep their bits.
    if angle.abs() <= PI {
        return angle;
    }
    angle - TAU * (angle / TAU).round()
}

/// The axis across the robot about which nose up is positive: from forward to up.
pub fn across(forward: [f64; 3], up: [f64; 3]) -> [f64; 3] {
    Vector3::from(forward).cross(&Vector3::from(up)).into()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    Vector3::from(a).dot(&Vector3::from(b))
}

/// The values of cells; `None` where one is missing.
fn all<const N: usize>(cells: &[f64], of: [usize; N]) -> Option<[f64; N]> {
    let values = of.map(|index| *cells.get(index).unwrap_or(&f64::NAN));
    values.iter().all(|v| v.is_finite()).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    /// Closed form: an IMU with x forward and z up, nose up by 0.3 rad, that is -0.3 rad about its
    /// y axis, turning nose up at 0.2 rad/s.
    #[test]
    fn an_imu_gives_inclination_and_rate() {
        let inclination = |up| Formula {
            source: Source::Inclination(up, [X, Z], false),
            ..Formula::of_cell(0)
        };
        let (sin, cos) = 0.3_f64.sin_cos();
        let force = [9.81 * sin, 0.5, 9.81 * cos];
        let found = inclination(Upward::SpecificForce([0, 1, 2])).value(&force);
        assert!((found.unwrap() - 0.3).abs() < 1e-15);
        let (sin, cos) = (-0.15_f64).sin_cos();
        let turned = [0.0, sin, 0.0, cos];
        let found = inclination(Upward::Orientation([0, 1, 2, 3], 1.0)).value(&turned);
        assert!((found.unwrap() - 0.3).abs() < 1e-15);
        // The same attitude of a body with z down in a world with z down: nose up is +0.3 rad about
        // y, and so is its rate.
        let down = [0.0, 0.0, -1.0];
        let aviation = Formula {
            source: Source::Inclination(Upward::Orientation([0, 1, 2, 3], -1.0), [X, down], false),
            ..Formula::of_cell(0)
        };
        let found = aviation.value(&[0.0, -sin, 0.0, cos]);
        assert!((found.unwrap() - 0.3).abs() < 1e-15);
        let rate = Formula {
            source: Source::Rate([0, 1, 2], across(X, down)),
            ..Formula::of_cell(0)
        };
        let found = rate.value(&[0.7, 0.2, 0.9]);
        assert!((found.unwrap() - 0.2).abs() < 1e-15);
        let rate = Formula {
            source: Source::Rate([0, 1, 2], across(X, Z)),
            offset: 0.05,
            ..Formula::of_cell(0)
        };
        let found = rate.value(&[0.7, -0.2, 0.9]);
        assert!((found.unwrap() - 0.15).abs() < 1e-15);
    }

    /// Closed form: a specific force of 20 deg roll and 10 deg pitch gives both, whatever the other;
    /// pitch and roll by the axes of a sensor that is turned by a quarter about its z axis, too.
    #[test]
    fn pitch_and_roll_of_both_sides() {
        let [pitch, roll] = [10.0_f64, 20.0].map(f64::to_radians);
        let force = [
            pitch.sin(),
            pitch.cos() * roll.sin(),
            pitch.cos() * roll.cos(),
        ];
        let turned = [-force[1], force[0], force[2]];
        let of = |source, cells: &[f64]| {
            let formula = Formula {
                source,
                ..Formula::of_cell(0)
            };
            formula.value(cells).expect("a direction")
        };
        let up = Upward::SpecificForce([0, 1, 2]);
        for (cells, forward) in [(force, X), (turned, [0.0, 1.0, 0.0])] {
            let found = of(Source::Inclination(up, [forward, Z], true), &cells);
            assert!((found - pitch).abs() < 1e-15, "{found}");
            let left = across(Z, forward);
            let found = of(Source::Inclination(up, [left, Z], false), &cells);
            assert!((found - roll).abs() < 1e-15, "{found}");
        }
    }

    /// Without a direction, or with a missing cell, there is no reading.
    #[test]
    fn a_missing_cell_is_a_missing_reading() {
        let inclination = Formula {
            source: Source::Inclination(Upward::SpecificForce([0, 1, 2]), [X, Z], false),
            ..Formula::of_cell(0)
        };
        assert_eq!(inclination.value(&[0.0; 3]), None);
        assert_eq!(inclination.value(&[1.0, f64::NAN, 2.0]), None);
        assert_eq!(Formula::of_cell(1).value(&[1.0]), None);
    }

    #[test]
    fn angles_are_taken_within_half_a_turn() {
        for (angle, expected) in [(3.1 + TAU, 3.1), (-0.2 - TAU, -0.2), (PI - 0.01, PI - 0.01)] {
            assert!((within_half_turn(angle) - expected).abs() < 1e-14);
        }
    }

    /// The bits of a cell stay, those of a negative zero too.
    #[test]
    fn a_cell_in_si_keeps_its_bits() {
        for value in [-0.0, 0.1 + 0.2, 5e-324, -1e300] {
            let found = Formula::of_cell(0).value(&[value]);
            assert_eq!(found.map(f64::to_bits), Some(value.to_bits()));
        }
    }
}

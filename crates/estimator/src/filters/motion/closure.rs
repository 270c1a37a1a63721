//! Measurements: loop closure. Wheels that pass one place of the ground find the same height and slope
//! there ([`crate::ground`]).
//!
//! | | direction | slope |
//! |---|---|---|
//! | innovation | less the error of the velocity's direction that the heights show, rad | given angle less its estimated error and the mapped slope, rad |
//! | states | velocity of Q | contact angle (or its error) |
//! | noise | white: variance of the heights, once in a stretch of way | white: variance of the mapped slope |
//! | gate | [`GATE`] | [`GATE`] |
//! | channels | none of its own | none of its own |

use super::filter::MotionFilter;
use crate::common::ROLLING_SPEED;
use crate::deviation::GATE;
use crate::filters::Measurement;
use crate::state::{CONTACT_ANGLE, VELOCITY};

impl MotionFilter {
    /// Corrects the states by an error of the direction of the velocity of Q, as dy/dx, with its
    /// variance: see [`crate::ground::GroundMemory::take_direction_error`]. Returns the change of
    /// that direction, as dy/dx; zero while the robot hardly rolls.
    ///
    /// A constant error of the direction and the sum of the torque offsets are one: the parity
    /// residual ties them. So this is what separates a slope from torque offsets on even ground.
    pub fn correct_direction(&mut self, error: f64, variance: f64) -> f64 {
        let velocity = self.velocity();
        let speed = robhaz_model::sqrt(velocity.norm_squared());
        let (cos, sin) = (velocity.x / speed, velocity.y / speed);
        // Written so that a NaN leaves, too.
        if !(speed > ROLLING_SPEED) {
            return 0.0;
        }
        // The angle changes with dy/dx by cos^2.
        let level = cos * cos;
        let row = [
            (VELOCITY.of(0), -sin / speed),
            (VELOCITY.of(1), cos / speed),
        ];
        self.close(row, -level * error, level * level * variance);
        let after = self.velocity();
        after.y / after.x - velocity.y / velocity.x
    }

    /// Corrects the states by what the ground shows of the contact angle of wheel `i`: it is
    /// `slope`, rad, with this variance; `given` is the given one. See
    /// [`crate::ground::GroundMemory::mapped_slope`]. Nothing while the robot hardly rolls, and
    /// after an impact.
    ///
    /// The direction of a wheel's velocity depends on the robot's speed, which nothing shows while
    /// two wheels slide. The ground that the wheels ahead have passed does not.
    pub fn correct_contact_angle(&mut self, i: usize, given: f64, slope: f64, variance: f64) {
        let slow = ROLLING_SPEED * ROLLING_SPEED;
        if !(self.velocity().norm_squared() > slow) || self.is_after_impact() {
            return;
        }
        let state = CONTACT_ANGLE.of(i);
        let error = given - slope - self.filter.x[state];
        self.close([(state, 1.0)], error, variance);
    }
    /// Corrects the states by a measurement of the ground with the noise of this variance.
    fn close<const K: usize>(&mut self, row: [(usize, f64); K], innovation: f64, variance: f64) {
        let measurement = Measurement {
            row,
            innovation,
            white: variance,
            correlated: [],
            inflation: 0.0,
            gate: GATE,
        };
        let expected = self.filter.expect(&measurement);
        self.correct(&measurement, &expected, 1.0);
    }
}

//! A robot whose wheels spin in place: its velocity is zero, and rolling tells nothing of slopes
//! and torques.

use super::filter::{
    ACCELERATION, CONTACT_ANGLE, GEAR_FRICTION, MotionFilter, TORQUE_OFFSET, VELOCITY, angle_sigma,
};
use super::rolling::RollingWheel;
use super::tuning::TUNING;
use crate::contact::{RollingResiduals, SlipResidual};
use crate::deviation::root_sum_square;
use crate::settings::{ContactAngles, NoiseBudget};

impl MotionFilter {
    /// The robot has been found to stand: unknown contact angles are discarded. What holds the
    /// robot is ahead of some of its wheels, in the direction `spin` of their rims (its sign
    /// counts): a contact angle lies between that of level ground and that of a wall.
    pub fn discard_motion(&mut self, spin: f64) {
        if self.angles == ContactAngles::Unknown {
            let angle = libm::copysign(TUNING.held_angle, spin);
            self.filter.x[CONTACT_ANGLE..CONTACT_ANGLE + 3].fill(-angle);
        }
    }

    /// Discards the estimated errors of torques and contact angles: they were found with other
    /// loads.
    pub fn discard_errors(&mut self, budget: &NoiseBudget) {
        for i in 0..3 {
            self.filter
                .set(TORQUE_OFFSET + i, 0.0, budget.torque_offset);
            let angle = self.filter.x[CONTACT_ANGLE + i];
            let sigma = angle_sigma(budget, self.angles);
            self.filter.set(CONTACT_ANGLE + i, angle, sigma);
        }
        self.filter.set(GEAR_FRICTION, 0.0, budget.gear_friction);
    }

    /// The robot stands at this sample: velocity and acceleration are zero, and torque errors are
    /// only considered.
    ///
    /// Unknown contact angles are as uncertain as at first, however long it stands: one parity
    /// residual a sample, always the same, cannot tell three of them, and each linearisation of it
    /// about other angles would seem to tell more.
    ///
    /// A force F that errs in direction by an angle a errs by F a^2/2 along itself, which the
    /// linear covariance does not contain. For a Gaussian angle of deviation s its mean square is
    /// F^2 (3 s^4)/4, and three times that for three wheels of the load `mean_load` (N): the
    /// unmodelled load is at least that.
    pub fn stand(&mut self, mean_load: f64) {
        for i in 0..2 {
            self.filter.set(VELOCITY + i, 0.0, TUNING.velocity_at_rest);
            self.filter
                .set(ACCELERATION + i, 0.0, TUNING.acceleration.sigma);
        }
        if self.angles == ContactAngles::Unknown {
            for state in CONTACT_ANGLE..CONTACT_ANGLE + 3 {
                let angle = self.filter.x[state];
                self.filter.set(state, angle, TUNING.held_angle);
            }
            // The root of three times 3/4.
            let second_order = 1.5 * mean_load * TUNING.held_angle * TUNING.held_angle;
            self.unmodelled_load = self.unmodelled_load.max(second_order * second_order);
        }
        self.impact = TUNING.impact_time;
    }

    /// Residuals of the rolling constraints of wheel `i` of a standing robot, which correct
    /// nothing: all of the rim's speed is slip.
    pub fn spin_in_place(&self, i: usize, wheel: &RollingWheel) -> RollingResiduals {
        let creep = self.creep(i, wheel);
        let noise = root_sum_square(wheel.bias_sigma, wheel.noise_sigma);
        RollingResiduals {
            away: 0.0,
            away_sigma: noise,
            slip: wheel.rim_speed.map(|rim_speed| SlipResidual {
                beyond_creep: rim_speed - creep.slip(),
                creep: creep.slip(),
                variance: noise * noise,
                noise,
            }),
        }
    }
}

//! Measurement: the speed of a wheel along the ground is that of its rim less the slip, which is
//! proportional to T/N while the wheel grips.
//!
//! | | |
//! |---|---|
//! | innovation | `r (omega_i - omega_k) - t(gamma_i) . v_i - c_i T_i/N_i`, m/s |
//! | states | velocity of Q, creep, rolling radius, torque offset, resistance |
//! | noise | white: gyroscope; correlated: slip beyond linear creep, errors of creep times T/N, of N, and the product of the errors of creep and T/N, what the torque's observer leaves, gyroscope's bias |
//! | gate | [`GATE`]; beyond it a wheel that pulls slides, and the velocity is wrong at one that does not |
//! | channels | encoder, motor torque, gyroscope |

use super::filter::MotionFilter;
use super::rolling::{RollingWheel, Sample};
use super::tuning;
use crate::common::FILTER_TIME;
use crate::contact::{SLIPPING_RATIO, SlipResidual};
use crate::deviation::{GATE, root_sum_square};
use crate::filters::GaussMarkov;
use crate::filters::Measurement;
use crate::settings::ContactAngles;
use crate::state::{CREEP, RADIUS, RESISTANCE, TORQUE_GAIN, TORQUE_OFFSET, VELOCITY};

/// Factor on the variance of the slip speed for what the linear law of creep leaves out: it grows
/// with the fourth power of T/N.
fn variance_factor(ratio: f64) -> f64 {
    let square = ratio * ratio / (SLIPPING_RATIO * SLIPPING_RATIO);
    1.0 + square * square
}

impl MotionFilter {
    /// The measurement of one wheel, whose rim has the speed `rim`, m/s.
    fn slip(&self, sample: &Sample<'_>, rim: f64) -> Measurement<6, 6> {
        let (i, wheel, velocity) = (sample.i, sample.wheel, sample.velocity);
        let (creep, slip) = (self.creep(i), self.creep(i) * wheel.ratio);
        // Derivative of the slip with respect to a torque error, which changes T/N.
        let by_offset = -creep / wheel.moment_of_load;
        // The derivatives by the torque errors are those at the estimated N. Where N is not beyond
        // its own deviation, T/N has no slope that the torques could be found from.
        let load_known = wheel.load_sigma < 1.0;
        let free = sample.correct && wheel.settled;
        let on = if free && self.rolls(&velocity) && load_known {
            1.0
        } else {
            0.0
        };
        let ratio_sigma = self.ratio_sigma(i, wheel);
        let pulls = wheel.ratio.abs() > tuning::PULLING * ratio_sigma;
        let shows_creep = pulls && wheel.ratio.abs() < tuning::LINEAR_RATIO;
        let creep_sigma = creep * robhaz_model::sqrt(self.filter.p[CREEP.of(i)][CREEP.of(i)]);
        // Shorter than the error of the creep: slip measurements reduce that of T/N.
        let of_product = GaussMarkov::new(creep_sigma * ratio_sigma, wheel.product_time);
        let mut of_creep = slip * wheel.load_sigma;
        if !shows_creep {
            of_creep = root_sum_square(of_creep, creep_sigma * wheel.ratio);
        }
        let nonlinear = robhaz_model::sqrt(variance_factor(wheel.ratio));
        let of_observer = root_sum_square(by_offset * wheel.torque_sigma, wheel.rim_sigma);
        Measurement {
            row: [
                (VELOCITY.of(0), velocity.direction.x),
                (VELOCITY.of(1), velocity.direction.y),
                (RADIUS.of(i), -rim),
                (CREEP.of(i), if shows_creep { on * slip } else { 0.0 }),
                (TORQUE_OFFSET.of(i), on * by_offset),
                (RESISTANCE.of(0), on * by_offset * wheel.resisted),
            ],
            innovation: rim * (1.0 + self.filter.x[RADIUS.of(i)]) - velocity.speed - slip,
            white: wheel.white(),
            correlated: [
                GaussMarkov::new(tuning::SLIP.sigma * nonlinear, tuning::SLIP.time),
                GaussMarkov::new(of_creep, tuning::SLIP.time),
                of_product,
                GaussMarkov::new(of_observer, FILTER_TIME),
                GaussMarkov::new(wheel.bias_sigma, tuning::SLIP.time),
                GaussMarkov::new(wheel.across_sigma, tuning::TURN_TIME),
            ],
            inflation: self.inflation_of_rolling(sample.dt),
            gate: GATE,
        }
    }

    /// Corrects the states by the slip of one wheel. Returns what the rim shows of it.
    pub(super) fn correct_slip(&mut self, sample: &Sample<'_>, rim: f64) -> SlipResidual {
        let (i, wheel) = (sample.i, sample.wheel);
        let measurement = self.slip(sample, rim);
        let expected = self.filter.expect(&measurement);
        let found = expected.innovation;
        let residual = SlipResidual {
            beyond_creep: found.value,
            creep: self.creep(i) * wheel.ratio,
            variance: found.variance,
            noise: wheel.turning_sigma(),
            density: wheel.slip_density(sample.dt),
        };
        if found.nis() > GATE * GATE {
            if wheel.ratio.abs() > tuning::STICKING_RATIO {
                self.modes.set_sliding(i);
            } else if self.rolls(&sample.velocity) && self.angles == ContactAngles::Unknown {
                // A wheel that hardly pulls does not slide: the velocity is wrong.
                self.inflate_velocity(sample.velocity.direction * found.value);
                return residual;
            }
        }
        if !self.modes.is_sliding(i) {
            self.correct(&measurement, &expected, sample.dt);
            for creep in &mut self.filter.x[CREEP.all()] {
                *creep = creep.clamp(tuning::LEAST_CREEP, tuning::GREATEST_CREEP);
            }
        }
        residual
    }

    /// Standard deviation of T/N of wheel `i` from the errors of its torque and of N, -.
    fn ratio_sigma(&self, i: usize, wheel: &RollingWheel) -> f64 {
        let p = &self.filter.p;
        let (offset, gain) = (TORQUE_OFFSET.of(i), TORQUE_GAIN.of(i));
        let torque_variance = p[offset][offset]
            + p[RESISTANCE.of(0)][RESISTANCE.of(0)]
            + p[gain][gain] * wheel.torque * wheel.torque;
        let of_torque = robhaz_model::sqrt(torque_variance) / wheel.moment_of_load;
        root_sum_square(of_torque, wheel.ratio * wheel.load_sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: twice at the limit, 16 times more at twice the ratio.
    #[test]
    fn the_variance_grows_beyond_the_linear_range() {
        for (ratio, expected) in [(0.0, 1.0), (-0.15, 2.0), (0.3, 17.0)] {
            // Rounding of a dozen operations.
            assert!((variance_factor(ratio) - expected).abs() < 1e-12 * expected);
        }
    }
}

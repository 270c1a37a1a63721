//! Acceleration of the robot that its inclinometers feel.

use super::filter::MotionFilter;
use super::noise::LastingError;
use super::states::{ACCELERATION, CONSIDERED, COUNT};
use super::tuning::TUNING;
use super::turns::Turns;
use crate::filters::Kalman;
use crate::visit::visit_fields;

/// What one inclinometer shows of the horizontal acceleration of Q at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FeltAcceleration {
    /// Acceleration of Q that it shows, less the estimated one after the same low pass, m/s^2, forward positive.
    pub difference: f64,
    /// Variance of its white noise, m^2/s^4.
    pub white: f64,
    /// Standard deviation of the error of the link's angle, as acceleration, m/s^2.
    pub of_angle: f64,
    /// Standard deviation of what its place and the error of its lag add while the link turns, m/s^2.
    pub of_turning: f64,
    /// Time constant of its low pass, s.
    pub lag: f64,
}

/// Mean of the differences since they last corrected the states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FeltMean {
    /// Integral of the difference, m/s.
    sum: f64,
    /// Time, s.
    time: f64,
}

visit_fields!(FeltMean: sum, time);

impl MotionFilter {
    /// Corrects the states by what the inclinometers of links 1 and 2 feel of the acceleration of Q, `dt` seconds after the last sample:
    /// `None` without a reading. As the other constraints at 1 kHz, every third sample: see [`Turns`]. Nothing while a wheel is suspect:
    /// what an impact does to the filtered rates of the links would pass for an acceleration.
    ///
    /// An inclinometer measures the direction of the specific force, and the gyroscope the angle of the link: what is left is the
    /// acceleration along the link, within seconds. It is the only measurement of the robot's motion that does not need a wheel that grips.
    pub fn feel(&mut self, readings: &[Option<FeltAcceleration>; 2], dt: f64) {
        let count = readings.iter().flatten().count();
        if count == 0 || self.is_any_suspect() {
            self.felt = FeltMean::default();
            return;
        }
        let share = 1.0 / count as f64;
        let (mut white, mut of_angle, mut of_turning, mut lag) = (0.0, 0.0, 0.0, 0.0_f64);
        for felt in readings.iter().flatten() {
            self.felt.sum += share * felt.difference * dt;
            white += share * share * felt.white;
            // Both links' errors of these kinds may have the same sign.
            of_angle += share * felt.of_angle;
            of_turning += share * felt.of_turning;
            lag = lag.max(felt.lag);
        }
        self.felt.time += dt;
        if !(self.felt.time > Turns::LONGEST_WAIT - Turns::ROUNDING) {
            return;
        }
        let FeltMean { sum, time } = core::mem::take(&mut self.felt);
        let change = robhaz_model::sqrt(self.acceleration_change * lag);
        let r = white * dt / time
            + LastingError::new(of_angle, TUNING.angle_time).white(time)
            + LastingError::new(of_turning, TUNING.turning_time).white(time)
            + LastingError::new(change, lag).white(time);
        let h = [(ACCELERATION, 1.0)];
        let ph = self.filter.covariance_times(&h);
        let of_states = Kalman::<COUNT, CONSIDERED>::along(&ph, &h);
        let estimated = self.estimated_states();
        // No gate: an impact is an acceleration, too.
        self.filter
            .apply_within(estimated, &ph, sum / time, of_states + r, f64::INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::super::prediction::MeasuredAccelerations;
    use super::*;
    use crate::settings::{ContactAngles, NoiseBudget};

    const DT: f64 = 1e-3;

    /// A robot that accelerates by `acceleration` (m/s^2) while all its wheels slide: nothing but the inclinometers of the links `read` shows it.
    fn accelerated(acceleration: f64, read: [bool; 2], lag: f64) -> MotionFilter {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
        let measured = MeasuredAccelerations {
            rims: acceleration,
            links: 0.0,
        };
        let mut expected = 0.0;
        for _ in 0..1000 {
            motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
            // What the sensor and the expected reading pass through.
            let weight = if lag > 0.0 {
                -libm::expm1(-DT / lag)
            } else {
                1.0
            };
            expected += weight * (motion.acceleration().x - acceleration - expected);
            let felt = FeltAcceleration {
                difference: -expected,
                white: 0.017 * 0.017,
                of_angle: 0.005,
                of_turning: 0.0,
                lag,
            };
            motion.feel(&read.map(|read| read.then_some(felt)), DT);
        }
        motion
    }

    /// Closed form: with any of the inclinometers and any lag the speed after a second is the acceleration times the second, less what the
    /// filter takes to follow: 30 ms without a lag, at most 100 ms with one of 20 ms.
    #[test]
    fn the_speed_of_a_robot_that_slides_is_felt() {
        for read in [[true, false], [false, true], [true, true]] {
            for (lag, late) in [(0.0, 0.05), (0.02, 0.1)] {
                for acceleration in [0.3, -0.3] {
                    let motion = accelerated(acceleration, read, lag);
                    let missing = 1.0 - motion.velocity().x / acceleration;
                    assert!(missing > 0.0 && missing < late, "{read:?} {lag}: {missing}");
                    let found = motion.acceleration().x;
                    // The process decays towards zero in the meantime.
                    assert!((found / acceleration - 1.0).abs() < 0.06, "{found}");
                }
            }
        }
        assert!(accelerated(0.3, [false; 2], 0.0).velocity().x.abs() < 1e-12);
    }

    /// Property: a second link narrows the acceleration, by less than the root of two, because the angles' errors count as common.
    #[test]
    fn two_links_tell_more_than_one() {
        let sigma = |read| accelerated(0.3, read, 0.0).estimated(ACCELERATION).1;
        let (one, two) = (sigma([true, false]), sigma([true, true]));
        assert!(
            two < one && two > one * core::f64::consts::FRAC_1_SQRT_2,
            "{one} {two}"
        );
    }

    /// Property: while a wheel is suspect what the inclinometers feel changes nothing.
    #[test]
    fn an_impact_is_not_felt() {
        let mut motion = accelerated(0.3, [true; 2], 0.0);
        motion.suspect[1] = 0.2;
        let before = motion;
        let felt = FeltAcceleration {
            difference: 5.0,
            white: 1e-4,
            of_angle: 0.0,
            of_turning: 0.0,
            lag: 0.0,
        };
        for _ in 0..10 {
            motion.feel(&[Some(felt); 2], DT);
        }
        assert_eq!(motion.filter, before.filter);
    }
}

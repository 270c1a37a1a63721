//! Measurement: the inclinometers of links 1 and 2 show the horizontal acceleration of Q.
//!
//! An inclinometer measures the direction of the specific force, and the gyroscope the angle of the
//! link: what is left is the acceleration along the link, within seconds. It is the only measurement
//! of the robot's motion that does not need a wheel that grips.
//!
//! | | |
//! |---|---|
//! | innovation | acceleration that both show in the mean, less the estimated one after the same low pass, m/s^2 |
//! | states | acceleration of Q |
//! | noise | white: inclinometers; correlated: the links' angles, what both differ beyond [`WITHIN`], place and lag while the link turns |
//! | gate | none: an impact is an acceleration, too |
//! | channels | inclinometers, gyroscopes |

use super::filter::MotionFilter;
use super::tuning;
use crate::common::FILTER_TIME;
use crate::deviation::WITHIN;
use crate::filters::GaussMarkov;
use crate::filters::Measurement;
use crate::state::ACCELERATION;

/// What one inclinometer shows of the horizontal acceleration of Q at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensedAcceleration {
    /// Acceleration of Q that it shows, less the estimated one after the same low pass, m/s^2,
    /// forward positive.
    pub innovation: f64,
    /// Variance of its white noise, m^2/s^4.
    pub white: f64,
    /// Standard deviation of the error of the link's angle, as acceleration, m/s^2.
    pub of_angle: f64,
    /// Standard deviation of what its place and the error of its lag add while the link turns,
    /// m/s^2.
    pub of_turning: f64,
}

impl MotionFilter {
    /// Corrects the states by the acceleration of Q that the inclinometers of links 1 and 2 show,
    /// `dt` seconds after the last sample: `None` without a reading. Skipped after an impact: what
    /// it does to the filtered rates of the links would pass for an acceleration.
    ///
    /// Both links measure the same acceleration of Q. Half of the excess of their difference over
    /// [`WITHIN`] deviations is added to the correlated noise: otherwise a gyroscope with a wrong sign
    /// would pass for an acceleration, and no inclination would contradict it.
    pub fn correct_acceleration(&mut self, readings: &[Option<SensedAcceleration>; 2], dt: f64) {
        self.since_acceleration += dt;
        let share = match readings {
            [None, None] => return,
            [Some(_), Some(_)] => 0.5,
            _ => 1.0,
        };
        let time = core::mem::take(&mut self.since_acceleration);
        if self.is_after_impact() {
            return;
        }
        let (mut innovation, mut white) = (0.0, 0.0);
        let (mut of_angle, mut of_turning) = (0.0, 0.0);
        for sensed in readings.iter().flatten() {
            innovation += share * sensed.innovation;
            white += share * share * sensed.white;
            // Both links' errors of these kinds may have the same sign.
            of_angle += share * sensed.of_angle;
            of_turning += share * sensed.of_turning;
        }
        let apart = match readings {
            [Some(first), Some(second)] => (first.innovation - second.innovation).abs(),
            _ => 0.0,
        };
        // Of the difference of two independent links; `white` is that of their mean.
        let agreeing = 4.0 * white + 2.0 * (of_angle * of_angle + of_turning * of_turning);
        let excess = 0.5 * (apart - WITHIN * robhaz_model::sqrt(agreeing)).max(0.0);
        let measurement = Measurement {
            row: [(ACCELERATION.of(0), 1.0)],
            innovation,
            white,
            correlated: [
                GaussMarkov::new(of_angle, tuning::ANGLE_TIME),
                GaussMarkov::new(excess, tuning::ANGLE_TIME),
                GaussMarkov::new(of_turning, FILTER_TIME),
            ],
            inflation: 0.0,
            gate: f64::INFINITY,
        };
        let expected = self.filter.expect(&measurement);
        self.correct(&measurement, &expected, time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{ContactAngles, NoiseBudget};

    const DT: f64 = 1e-3;

    /// A robot that accelerates by `acceleration` (m/s^2) while all its wheels slide: nothing but
    /// the inclinometers of the links `read` shows it.
    fn accelerated(acceleration: f64, read: [bool; 2], lag: f64) -> MotionFilter {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
        let measured = [acceleration, 0.0];
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
            let sensed = SensedAcceleration {
                innovation: -expected,
                white: 0.017 * 0.017,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            motion.correct_acceleration(&read.map(|read| read.then_some(sensed)), DT);
        }
        motion
    }

    /// Closed form: with any of the inclinometers and any lag the speed after a second is the
    /// acceleration times the second, less what the filter takes to follow: 30 ms without a lag, at
    /// most 100 ms with one of 20 ms.
    #[test]
    fn the_speed_of_a_robot_that_slides_is_found() {
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

    /// Property: inclinometers that are read at every tenth sample only show the acceleration, too:
    /// the process of 0.6 m/s^2 is the larger part of its deviation.
    #[test]
    fn rare_readings_show_the_acceleration() {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
        let measured = [0.3, 0.0];
        for k in 0..1000 {
            motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
            let sensed = SensedAcceleration {
                innovation: 0.3 - motion.acceleration().x,
                white: 0.017 * 0.017,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            motion.correct_acceleration(&[(k % 10 == 0).then_some(sensed); 2], DT);
        }
        let (found, sigma) = motion.filter.estimated(ACCELERATION.of(0));
        assert!((found - 0.3).abs() < 0.02 && sigma < 0.3, "{found} {sigma}");
    }

    /// Property: a second link narrows the acceleration, by less than the root of two, because the
    /// angles' errors count as common.
    #[test]
    fn two_links_tell_more_than_one() {
        let sigma = |read| {
            accelerated(0.3, read, 0.0)
                .filter
                .estimated(ACCELERATION.of(0))
                .1
        };
        let (one, two) = (sigma([true, false]), sigma([true, true]));
        assert!(
            two < one && two > one * core::f64::consts::FRAC_1_SQRT_2,
            "{one} {two}"
        );
    }

    /// Property: what only one of two links shows counts by less, the more it is.
    #[test]
    fn links_that_differ_count_by_less() {
        let budget = NoiseBudget::typical();
        let found = |difference: f64| {
            let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
            let sensed = |innovation| SensedAcceleration {
                innovation,
                white: 1e-4,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            let measured = [0.0; 2];
            for _ in 0..3 {
                motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
                motion.correct_acceleration(&[Some(sensed(difference)), Some(sensed(0.0))], DT);
            }
            motion.acceleration().x / difference
        };
        assert!(found(1.0) < 0.1 * found(0.01) && found(0.01) > 0.0);
    }

    /// Property: after an impact what the inclinometers measure changes nothing.
    #[test]
    fn an_impact_is_no_acceleration() {
        let mut motion = accelerated(0.3, [true; 2], 0.0);
        motion.modes.set_impact();
        let before = motion;
        let sensed = SensedAcceleration {
            innovation: 5.0,
            white: 1e-4,
            of_angle: 0.0,
            of_turning: 0.0,
        };
        for _ in 0..10 {
            motion.correct_acceleration(&[Some(sensed); 2], DT);
        }
        assert_eq!(motion.filter, before.filter);
    }
}

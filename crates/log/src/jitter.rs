//! Errors of time stamps, measured by the wheels: at a steady speed a wheel is a clock.
//!
//! A stamp that is late by e makes the step before it longer and the one behind it shorter than the wheel
//! has turned: what two steps in a row err by has the covariance `-sigma^2`, and steps further apart
//! have none. True motion is smooth, so that it has a positive one; at a low rate, where wheels pass a
//! slope within a step or two, it has one of steps further apart, too. Counts of encoders of their own
//! are independent. So the covariance is taken between one wheel and the next step of another, and
//! counts if it is much greater than those of the steps behind that.
//!
//! Errors that follow a pattern, such as those of stamps in whole milliseconds at 60 Hz, have covariances
//! of all steps. But where stamps are uneven and the wheels' turns are not, the stamps err: a step that is
//! longer by d than its neighbours, while the wheel turns on by none of it, errs by -d, which no motion
//! does. What a step errs by has the covariance `-2 sigma^2` with what the stamps say of it.

use robhaz_estimator::SensorFrame;
use robhaz_score::signals::{fit, mean, median, rms};

/// Steps before and behind a step over which its speed is taken.
const STEPS: usize = 8;
/// Spin speed of a wheel that can serve as a clock, rad/s: a Sojourner drives with 0.15 rad/s.
const LEAST_SPIN: f64 = 0.05;
/// Turn of a wheel within a step up to which its speed hardly changes from step to step, rad: a fifth
/// of its radius along the ground. On rough ground a step of half the radius looks like an error of the
/// stamps by 1.6 % of the step.
const LARGEST_TURN: f64 = 0.2;
/// Relative difference of the speeds before and behind a step of a steady wheel.
const STEADY: f64 = 0.25;
/// Largest error of a step that is one of stamps, in periods: more is a gap or a jump.
const LARGEST: f64 = 3.0;
/// Least number of pairs of steps.
const LEAST_PAIRS: usize = 50;
/// Standard errors beyond which the covariance is no chance: 3e-5.
const SIGNIFICANT: f64 = 4.0;
/// Covariance of two steps in a row over those of steps further apart from which on it is one of
/// stamps.
const DISTINCT: f64 = 4.0;
/// Share of the variance of the stamped steps that no wheel turns from which on they are even but for
/// their unit.
const UNTURNED: f64 = 0.5;
/// Largest deviation of a step from a whole number of units of the stamps, as a share of the unit.
const WHOLE: f64 = 0.01;
/// Least unit of stamps that matters, s.
const LEAST_UNIT: f64 = 1e-5;
/// Standard deviation of a uniform error over its width.
const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// Errors of time stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jitter {
    /// Standard deviation of a stamp, s; 0 where the log shows none.
    pub sigma: f64,
    /// Whether the wheels turn steadily for long enough to show it.
    pub is_shown: bool,
    /// Unit of the stamps, s, if their steps are different whole numbers of one.
    pub unit: Option<f64>,
}

impl Jitter {
    /// Of frames with encoders of this many counts a turn (0: exact).
    pub fn of(frames: &[SensorFrame], counts: f64) -> Self {
        let errors = [0, 1, 2].map(|i| errors(frames, i));
        let typical = |of: fn(&Step) -> f64| {
            let steps = errors.iter().flatten().flatten();
            median(steps.map(of).collect())
        };
        let speed = typical(|step| step.speed.abs());
        let turn = typical(|step| step.turn.abs());
        let unit = unit(frames);
        let Some(speed) = speed.filter(|_| turn.is_some_and(|turn| turn < LARGEST_TURN)) else {
            return Self {
                unit,
                ..Self::default()
            };
        };
        let of_count = UNIFORM * count_angle(counts) / speed;
        let at = |lag: usize| -> Vec<(f64, f64)> {
            let pairs = [(0, 1), (0, 2), (1, 2)];
            let of = |(i, j): (usize, usize)| covariance(&errors[i], &errors[j], lag);
            pairs.into_iter().filter_map(of).collect()
        };
        let mut found = at(1);
        let mut of_counts = 0.0;
        // Wheels that are never read together have clocks of their own.
        if found.is_empty() {
            found.extend(errors.iter().filter_map(|own| covariance(own, own, 1)));
            of_counts = of_count * of_count;
        }
        let is_shown = !found.is_empty();
        let certain = |(mean, error): &(f64, f64)| {
            let by_chance = *mean <= SIGNIFICANT * error;
            if by_chance { 0.0 } else { mean - of_counts }
        };
        let variance = median(found.iter().map(certain).collect()).unwrap_or(0.0);
        let further = [2, 3].into_iter().flat_map(at);
        let of_motion = median(further.map(|(mean, _)| mean.abs()).collect());
        let is_distinct = variance > DISTINCT * of_motion.unwrap_or(0.0);
        let variance = if is_distinct { variance } else { 0.0 };
        let uneven = errors.iter().filter_map(|steps| uneven(steps, unit));
        let variance = variance.max(median(uneven.collect()).unwrap_or(0.0));
        let sigma = variance.max(0.0).sqrt();
        Self {
            // Below half a count's error it counts for nothing.
            sigma: if sigma < 0.5 * of_count { 0.0 } else { sigma },
            is_shown,
            unit,
        }
    }

    /// Whether it is clearly more than the one that is stated, s.
    pub fn exceeds(&self, stated: f64) -> bool {
        self.sigma > 1.25 * stated
    }

    /// The one that counts, s: the stated one unless this is clearly more.
    pub fn counted(&self, stated: f64) -> f64 {
        let exceeds = self.exceeds(stated);
        if exceeds { self.sigma } else { stated }
    }
}

/// Angle of a count of an encoder with this many a turn, rad; 0 of an exact one (0).
pub fn count_angle(counts: f64) -> f64 {
    let angle = std::f64::consts::TAU / counts;
    if counts > 0.0 { angle } else { 0.0 }
}

/// A step that ends at a frame.
#[derive(Clone, Copy)]
struct Step {
    /// By how much the wheel has turned longer than the stamps say, s.
    error: f64,
    /// What the stamps say, s.
    stamped: f64,
    /// Spin speed, rad/s.
    speed: f64,
    /// rad
    turn: f64,
}

/// Number and time (s) of the frames with an angle of a wheel, and that, rad.
pub fn angles(frames: &[SensorFrame], wheel: usize) -> Vec<(usize, f64, f64)> {
    let read = |(k, frame): (usize, &SensorFrame)| {
        let angle = frame.wheel_angle[wheel].filter(|angle| angle.is_finite())?;
        Some((k, frame.time, angle))
    };
    frames.iter().enumerate().filter_map(read).collect()
}

/// The steps of a wheel, by the frame at which each ends; `None` where it does not turn steadily.
fn errors(frames: &[SensorFrame], wheel: usize) -> Vec<Option<Step>> {
    let read = angles(frames, wheel);
    let mut found = vec![None; frames.len()];
    let steps = read.windows(2).map(|w| w[1].1 - w[0].1);
    let Some(period) = median(steps.collect()) else {
        return found;
    };
    for k in (STEPS + 1)..read.len().saturating_sub(STEPS) {
        let ((_, t0, a0), (_, t1, a1)) = (read[k - 1 - STEPS], read[k - 1]);
        let ((frame, t2, a2), (_, t3, a3)) = (read[k], read[k + STEPS]);
        let (before, behind) = ((a1 - a0) / (t1 - t0), (a3 - a2) / (t3 - t2));
        let speed = (a3 - a0) / (t3 - t0);
        // Written so that a NaN fails, too.
        if !(speed.abs() > LEAST_SPIN && (before - behind).abs() < STEADY * speed.abs()) {
            continue;
        }
        let turn = a2 - a1;
        let stamped = t2 - t1;
        let error = turn / speed - stamped;
        if error.abs() < LARGEST * period && stamped - period < LARGEST * period {
            found[frame] = Some(Step {
                error,
                stamped,
                speed,
                turn,
            });
        }
    }
    found
}

/// Less the covariance of the errors of a step of one wheel and of the step of the other that is the
/// `lag`th one behind it, s^2, and its standard error; `None` of too few.
fn covariance(a: &[Option<Step>], b: &[Option<Step>], lag: usize) -> Option<(f64, f64)> {
    let mut products = Vec::new();
    for (one, other) in [(a, b), (b, a)] {
        let (mut errors, mut used) = (Vec::<f64>::new(), 0);
        for (one, other) in one.iter().zip(other) {
            // Each step of the one wheel has one of the other behind it.
            if let Some(other) = other.filter(|_| errors.len() > used) {
                let before = errors.len().checked_sub(lag);
                products.extend(before.map(|k| -errors[k] * other.error));
                used = errors.len();
            }
            errors.extend(one.map(|step| step.error));
        }
    }
    if products.len() < 2 * LEAST_PAIRS {
        return None;
    }
    let count = products.len() as f64;
    let mean = products.iter().sum::<f64>() / count;
    let squares = products.iter().map(|p| (p - mean) * (p - mean));
    let square = squares.sum::<f64>() / count;
    // Each pair of steps counts twice.
    Some((mean, (2.0 * square / count).sqrt()))
}

/// Variance of a stamp, s^2, by how much of the differences between the stamped steps a wheel does not turn: all of it
/// with errors of the stamps, none of it at uneven times. By the regression of the steps' errors on what the stamps say;
/// `None` of too few, or of even stamps.
fn uneven(steps: &[Option<Step>], unit: Option<f64>) -> Option<f64> {
    let steps: Vec<&Step> = steps.iter().flatten().collect();
    if steps.len() < 2 * LEAST_PAIRS {
        return None;
    }
    let beside_mean = |of: fn(&Step) -> f64| -> Vec<f64> {
        let all: Vec<f64> = steps.iter().map(|step| of(step)).collect();
        let mean = mean(&all).unwrap_or(0.0);
        all.iter().map(|x| x - mean).collect()
    };
    let stamped = beside_mean(|step| step.stamped);
    let found = fit(&beside_mean(|step| step.error), &[&stamped])?;
    let variance = rms(&stamped).powi(2);
    let slope = found.coefficients[0];
    let by_chance = -slope <= SIGNIFICANT * found.deviations[0];
    let unturned = if by_chance { 0.0 } else { -slope };
    // A step has the errors of two stamps. An even clock in whole units errs by all of a unit, which few steps show where
    // the period is nearly a whole number of them.
    let of_steps = 0.5 * unturned * variance;
    let unit = unit.filter(|_| unturned > UNTURNED);
    Some(unit.map_or(of_steps, |unit| of_steps.max((UNIFORM * unit).powi(2))))
}

/// The unit of the stamps, s, if all steps are whole numbers of it and differ: the least step or the
/// least difference of two.
fn unit(frames: &[SensorFrame]) -> Option<f64> {
    let mut steps: Vec<f64> = frames.windows(2).map(|w| w[1].time - w[0].time).collect();
    steps.sort_by(f64::total_cmp);
    let least = *steps.first()?;
    let differences = steps.windows(2).map(|w| w[1] - w[0]);
    let differences = differences.filter(|by| *by > LEAST_UNIT);
    let unit = differences.fold(least, f64::min);
    let whole = |step: &f64| (step / unit - (step / unit).round()).abs() < WHOLE;
    let differ = steps.last().is_some_and(|last| last - least > 0.5 * unit);
    (unit > LEAST_UNIT && differ && steps.iter().all(whole)).then_some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_sim::random::Stream;

    /// Wheels at 2 rad/s and 100 Hz, with encoders of 20 000 counts, whose stamps err by `sigma`, s.
    fn turns(sigma: f64) -> Vec<SensorFrame> {
        let mut random = Stream::new(1, "stamps");
        let count = std::f64::consts::TAU / 20_000.0;
        let of = |k: u32| {
            let time = 0.01 * f64::from(k);
            let angle = |start: f64| Some(((start + 2.0 * time) / count).floor() * count);
            SensorFrame {
                time: time + sigma * random.normal(),
                wheel_angle: [0.0, 0.31, -0.47].map(angle),
                ..SensorFrame::default()
            }
        };
        (0..1000).map(of).collect()
    }

    /// Closed form: the stamps' own deviation is found to 10 %, four standard errors of a thousand
    /// stamps; exact stamps have none, though they are counted.
    #[test]
    fn the_jitter_of_stamps_is_measured() {
        for sigma in [3e-4, 1e-3] {
            let found = Jitter::of(&turns(sigma), 20_000.0);
            assert!(
                found.is_shown && (found.sigma / sigma - 1.0).abs() < 0.1,
                "{found:?}"
            );
        }
        assert_eq!(
            Jitter::of(&turns(0.0), 20_000.0),
            Jitter {
                sigma: 0.0,
                is_shown: true,
                unit: None
            }
        );
        assert!(!Jitter::of(&turns(1e-3)[..40], 20_000.0).is_shown);
    }

    /// Closed form: stamps in whole milliseconds at 75 Hz, 13, 13 and 14 ms apart, where two stamps have
    /// the variance 2/9 ms^2; at 333 Hz, where one step in 333 shows it, the unit's own.
    #[test]
    fn the_resolution_of_stamps_is_measured() {
        for (rate, sigma) in [(75.0, 1.0 / 3.0), (333.0, UNIFORM)] {
            let mut turns = turns(0.0);
            for (k, frame) in turns.iter_mut().enumerate() {
                let time = k as f64 / rate;
                let by = 2.0 * (time - 0.01 * k as f64);
                frame.time = 1e-3 * (1e3 * time + 1e-6).floor();
                frame.wheel_angle = frame.wheel_angle.map(|angle| Some(angle? + by));
            }
            let found = Jitter::of(&turns, 20_000.0);
            assert!(
                (found.sigma / (1e-3 * sigma) - 1.0).abs() < 0.05,
                "{found:?}"
            );
            assert!(found.unit.is_some_and(|unit| (unit - 1e-3).abs() < 1e-6));
        }
    }

    /// Stamps at uneven times that are true are no jitter.
    #[test]
    fn uneven_steps_are_no_jitter() {
        let mut turns = turns(0.0);
        for (k, frame) in turns.iter_mut().enumerate() {
            let by = 2e-3 * (k as f64).sin();
            frame.time += by;
            frame.wheel_angle = frame.wheel_angle.map(|angle| Some(angle? + 2.0 * by));
        }
        assert!(Jitter::of(&turns, 20_000.0).sigma < 1e-5);
    }
}

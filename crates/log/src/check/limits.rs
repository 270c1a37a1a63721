//! Torques that stay at a limit, also with noise or behind a filter: is it the drive's, or that of what
//! reads them?
//!
//! A torque that is limited spends much time within its noise of its extreme, and passes quickly through what is
//! below; at the top of a wave it spends twice as much time in the first band as in the next one
//! (1 to sqrt(2) - 1). What a drive limits acts on the robot as it is read; what a sensor cuts off does not, and
//! the equations of the robot miss it. At rest a torque is held, and its extreme is no limit: only while wheels turn it
//! counts. A torque that comes to its extreme once may err there for as long: that is no fault.

use crate::check::Finding;
use robhaz_score::signals::{median, smooth, white_noise};

/// Half of the number of readings less one over which a torque is averaged.
const HALF: usize = 2;
/// Width of a band, in standard deviations of the noise of these means: from three below a limit to three
/// above.
const BAND: f64 = 6.0;
/// Bands that the range of a torque has at least.
const LEAST_RANGE: f64 = 4.0;
/// Readings at a limit over those in the next band.
const PILED_UP: usize = 3;
/// Least number of readings at a limit, and their least share.
const LEAST: usize = 100;
const LEAST_SHARE: f64 = 0.03;
/// Least number of visits to one limit that show a fault: an error can last throughout a single one.
const VISITS: usize = 2;
/// Residual of the equations over its deviation, the middle one, up to which they fit: of right torques it is half as
/// large as stated, also at a drive's own limit.
const FITS: f64 = 0.75;
/// That at a limit over that away from it which is a fault, and by itself: ten independent samples have nine times the
/// variance of others once in 10 000 logs.
const MORE: f64 = 1.5;
const MUCH_MORE: f64 = 3.0;

pub const TEST: &str = "limit";
const UNKNOWN: &str = "fine if that is the drive's own limit or a steady slope; if it is that of the current's sensor, the forces there are wrong: look up both";

/// The limit of a torque.
struct Limit {
    /// Whether each reading is at it.
    readings: Vec<bool>,
    /// N m.
    value: f64,
    /// Most times that the torque came to one of its ends from beyond the next band.
    visits: usize,
}

/// The limit of these readings of a torque, a NaN where there is none; `None` without one.
fn at_limit(values: &[f64]) -> Option<Limit> {
    let noise = white_noise(values)? / ((2 * HALF + 1) as f64).sqrt();
    let means = smooth(values, HALF);
    let band = BAND * noise;
    // A count of readings.
    let count = means.iter().filter(|x| x.is_finite()).count() as f64;
    let (mut readings, mut value, mut most, mut visits) = (vec![false; values.len()], 0.0, 0, 0);
    for sign in [1.0, -1.0] {
        let signed = means.iter().map(|x| sign * x);
        let top = signed.fold(f64::NEG_INFINITY, f64::max);
        if top < LEAST_RANGE * band || band <= 0.0 {
            continue;
        }
        let is_in = |x: f64, k: f64| {
            let below = (top - sign * x) / band;
            below >= k && below < k + 1.0
        };
        let [first, next] = [0.0, 1.0].map(|k| means.iter().filter(|x| is_in(**x, k)).count());
        let share = first as f64 / count;
        if first < PILED_UP * next.max(1) || first < LEAST || share < LEAST_SHARE {
            continue;
        }
        let (mut is_there, mut of_end) = (false, 0);
        for (reading, x) in readings.iter_mut().zip(&means) {
            let is_at = is_in(*x, 0.0);
            *reading |= is_at;
            of_end += usize::from(is_at && !is_there);
            // Missing readings end no visit.
            let has_left = top - sign * x >= 2.0 * band;
            is_there = is_at || is_there && !has_left;
        }
        visits = visits.max(of_end);
        if first > most {
            (most, value) = (first, sign * (top - 0.5 * band));
        }
    }
    (most > 0).then_some(Limit {
        readings,
        value,
        visits,
    })
}

/// Torques that stay at a limit, by their names, a NaN where a frame has none. `turning`: whether a wheel turns in each
/// frame; `squares`: the normalised square of the equations' residual, a NaN where it does not count, and `expected`,
/// their median if all that is stated holds; `correlated`: what is left over its deviation that time-correlated errors
/// make at most. `None` of torques without a limit.
pub fn finding(
    torques: impl Iterator<Item = (String, Vec<f64>)>,
    turning: &[bool],
    squares: &[f64],
    [expected, correlated]: [f64; 2],
) -> Option<Finding> {
    let (mut names, mut limits, mut visits) = (Vec::new(), Vec::new(), 0);
    let mut is_at_any = vec![false; squares.len()];
    for (name, values) in torques {
        let while_turning = values.iter().zip(turning);
        let values = while_turning.map(|(value, turns)| if *turns { *value } else { f64::NAN });
        let values: Vec<f64> = values.collect();
        if let Some(limit) = at_limit(&values) {
            names.push(name);
            limits.push(limit.value);
            visits = visits.max(limit.visits);
            let frames = is_at_any.iter_mut().zip(limit.readings);
            frames.for_each(|(at, found)| *at |= found);
        }
    }
    let limit = limits.first()?;
    let known = |is_at: bool| -> Vec<f64> {
        let frames = (0..squares.len()).filter(|k| turning[*k] && is_at_any[*k] == is_at);
        let squares = frames.map(|k| squares[k]);
        squares.filter(|square| square.is_finite()).collect()
    };
    let (at, away) = (known(true), known(false));
    let [count, others] = [at.len(), away.len()];
    let finding = |figure: String| Finding::ok(TEST, names.join(", "), figure);
    if count == 0 || others == 0 {
        let figure = format!("within its noise of an extreme again and again, {limit:.2} N m");
        return Some(finding(figure).cannot_tell(UNKNOWN));
    }
    let left = |squares| median(squares).map_or(f64::NAN, |middle| (middle / expected).sqrt());
    let [at, away] = [at, away].map(left);
    let share = 100.0 * count as f64 / (count + others) as f64;
    let finding = finding(format!(
        "within its noise of an extreme, {limit:.2} N m, for {share:.0} % of the time; there the equations leave {at:.2} of their deviation, elsewhere {away:.2}"
    ));
    let finding = finding
        .with("at a limit", at, "-")
        .with("elsewhere", away, "-");
    let is_more = at > FITS && at > MORE * away || at > MUCH_MORE * away;
    Some(if is_more && at > correlated && visits >= VISITS {
        finding.fault("what is read is cut off there, not what acts: choose a greater range of the current's sensor or of its number")
    } else if at < FITS && away < FITS {
        finding
    } else {
        finding.cannot_tell(UNKNOWN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::report::Verdict;
    use robhaz_sim::random::Stream;

    /// A torque that is held at rest at its extreme, as on a slope, has no limit; one that is held there while wheels
    /// turn has.
    #[test]
    fn a_torque_that_is_held_at_rest_has_no_limit() {
        let mut random = Stream::new(1, "noise");
        let held = |k: usize| {
            if k < 400 {
                4.0
            } else {
                3.0 * (0.02 * k as f64).sin()
            }
        };
        let values: Vec<f64> = (0..2000)
            .map(|k| held(k) + 0.1 * (random.uniform() - 0.5))
            .collect();
        let found = |at_rest: bool| {
            let turning: Vec<bool> = (0..2000).map(|k| !at_rest || k >= 400).collect();
            let torque = [("torque".to_owned(), values.clone())];
            finding(torque.into_iter(), &turning, &[1.0; 2000], [1.0, 0.0])
        };
        assert!(found(true).is_none() && found(false).is_some());
    }

    /// Where errors last, those of the stated size at a limit are no fault, though elsewhere there are less; larger ones are.
    #[test]
    fn errors_that_last_are_no_cut_off() {
        let mut random = Stream::new(1, "noise");
        let wave = |k: usize| (3.0 * (0.02 * k as f64).sin()).clamp(-1.5, 1.5);
        let torque: Vec<f64> = (0..2000)
            .map(|k| wave(k) + 0.1 * (random.uniform() - 0.5))
            .collect();
        let verdict = |at: f64, correlated: f64| {
            let left = |k: usize| if wave(k).abs() < 1.5 { 0.4 } else { at };
            let squares: Vec<f64> = (0..2000).map(|k| left(k) * left(k)).collect();
            let torque = [("torque".to_owned(), torque.clone())];
            let found = finding(
                torque.into_iter(),
                &[true; 2000],
                &squares,
                [1.0, correlated],
            );
            found.map(|found| found.verdict)
        };
        assert_eq!(verdict(1.3, 0.0), Some(Verdict::Fault));
        assert_eq!(verdict(1.3, 1.5), Some(Verdict::CannotTell));
        assert_eq!(verdict(1.8, 1.5), Some(Verdict::Fault));
    }

    /// A wave that is cut off in one of its periods alone is no fault, not even with readings that are missing there; in
    /// two of them it is.
    #[test]
    fn a_single_visit_is_no_cut_off() {
        let mut random = Stream::new(1, "noise");
        let noise: Vec<f64> = (0..2000).map(|_| 0.1 * (random.uniform() - 0.5)).collect();
        let verdict = |periods: usize, missing: bool| {
            // Of a period of 400 readings; low waves but for the first ones.
            let height = |k: usize| if k / 400 < periods { 3.0 } else { 1.0 };
            let wave = |k: usize| height(k) * (std::f64::consts::TAU * k as f64 / 400.0).sin();
            let torque = |k: usize| {
                let is_missing = missing && (95..105).contains(&(k % 400));
                if is_missing {
                    f64::NAN
                } else {
                    wave(k).clamp(-1.2, 1.5) + noise[k]
                }
            };
            let squares: Vec<f64> = (0..2000)
                .map(|k| {
                    if !(-1.2..=1.5).contains(&wave(k)) {
                        4.0
                    } else {
                        0.2
                    }
                })
                .collect();
            let torque = [("torque".to_owned(), (0..2000).map(torque).collect())];
            let found = finding(torque.into_iter(), &[true; 2000], &squares, [1.0, 0.0]);
            found.map(|found| found.verdict)
        };
        for missing in [false, true] {
            assert_eq!(verdict(1, missing), Some(Verdict::CannotTell), "{missing}");
            assert_eq!(verdict(2, missing), Some(Verdict::Fault), "{missing}");
        }
    }

    /// Closed form: a wave that is cut off at half of its height stays there for a third of its time at each
    /// end, and one that is not has no limit, nor has a torque without change.
    #[test]
    fn a_wave_that_is_cut_off_has_a_limit() {
        let mut random = Stream::new(1, "noise");
        let noise: Vec<f64> = (0..2000).map(|_| 0.1 * (random.uniform() - 0.5)).collect();
        let wave = |k: usize| 3.0 * (0.02 * k as f64).sin();
        let cut: Vec<f64> = (0..2000)
            .map(|k| wave(k).clamp(-1.5, 1.5) + noise[k])
            .collect();
        let found = at_limit(&cut).map(|limit| {
            let count = limit.readings.iter().filter(|at| **at).count();
            (count as f64 / 2000.0, limit.value.abs())
        });
        assert!(
            found.is_some_and(
                |(share, limit)| (share - 2.0 / 3.0).abs() < 0.03 && (limit - 1.5).abs() < 0.05
            ),
            "{found:?}"
        );
        let whole: Vec<f64> = (0..2000).map(|k| wave(k) + noise[k]).collect();
        assert!(at_limit(&whole).is_none() && at_limit(&noise).is_none());
    }
}

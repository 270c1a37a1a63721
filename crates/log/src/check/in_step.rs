//! Delays of encoders behind each other: wheels that roll start and stop together, whatever drives
//! them.

use crate::check::recording::{SMOOTHING, starts, steps};
use crate::check::{Channel, Finding, Recording, delay};
use robhaz_score::signals::{Allowed, Delay, median};

/// Longest delay that is looked for, s.
const LONGEST: f64 = 0.3;
/// Delay that is none, s: wheels that slip start one after the other.
const NONE: f64 = 0.025;
/// Share of a speed that the other ones explain where all roll.
const ROLLING: f64 = 0.99;
/// Time over which errors of the speeds are correlated, s: that over which they are averaged.
const MEMORY: f64 = SMOOTHING;

/// What shows it.
const START: &str = "drive straight on, from a rest to a rest, without slip";
/// What the channel of the wheels of a side ends with.
pub const OF_WHEELS: &str = "after the others";

/// Delay of the spin speed of the wheels `one` behind that of `other`, where these start and stop.
fn between(one: &[f64], other: &[f64], dt: f64, allowed: &Allowed) -> Option<Delay> {
    let [longest, memory] = [LONGEST, MEMORY].map(|time| steps(time, dt));
    let largest = other.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    let turning = other.iter().map(|x| x.abs()).filter(|x| *x > 0.1 * largest);
    let usual = median(turning.collect()).unwrap_or(0.0);
    // What the ground does to a drive comes to one wheel after the other.
    let starts = starts(other, usual, longest);
    let one = one.iter().zip(starts);
    let one: Vec<f64> = one.map(|(x, is)| if is { *x } else { f64::NAN }).collect();
    let delay = robhaz_score::signals::delay(&one, &[other], longest, memory, dt, *allowed);
    delay.filter(|delay| delay.seconds.abs() <= LONGEST)
}

/// `period`: of the slowest channel, s.
fn allowed(period: f64) -> Allowed {
    Allowed {
        early: NONE + 0.5 * period,
        late: NONE + 0.5 * period,
        explained: ROLLING,
        errors: 0.0,
    }
}

/// The wheel of a side that is latest or earliest, against the one between.
pub fn of_wheels(recording: &Recording) -> Finding {
    let allowed = allowed(recording.slowest);
    let behind = |[one, other]: [usize; 2]| {
        let [one, other] = [one, other].map(|i| recording.spin[i].as_slice());
        between(one, other, recording.dt, &allowed)
    };
    let lag = |i: usize| behind([i, 0]).map_or(0.0, |delay| delay.seconds);
    let lags = [0.0, lag(1), lag(2)];
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| lags[*i].total_cmp(&lags[*j]));
    let [early, middle, late] = order;
    let apart = match lags[late] - lags[middle] >= lags[middle] - lags[early] {
        true => late,
        false => early,
    };
    let [whose, other] = [apart, middle].map(|i| Channel::Encoder(i).to_string());
    let channel = format!("{whose} {OF_WHEELS}");
    finding(
        &channel,
        behind([apart, middle]),
        &allowed,
        [&whose, &other],
    )
}

/// The right side against the left one, by the mean spin speed (rad/s) of the wheels of each at steps of `dt` (s).
pub fn of_sides([left, right]: [&[f64]; 2], dt: f64) -> Finding {
    let allowed = allowed(dt);
    finding(
        "wheels of right after those of left",
        between(right, left, dt, &allowed),
        &allowed,
        ["encoders of right", "encoders of left"],
    )
}

fn finding(channel: &str, delay: Option<Delay>, allowed: &Allowed, whose: [&str; 2]) -> Finding {
    let unknown = ["the wheels do not start and stop together", START];
    delay::finding(channel, delay, allowed, unknown, whose, |late, offset| {
        format!(
            "{late} arrive late, by another clock or a slower bus, and so do torques of the same drive: state offset = {offset:.4} of a channel of theirs, [[channel]]"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel whose readings are late by 0.1 s shows that at the start, and one that comes to the waves of the ground
    /// 0.2 s after the other one shows nothing. Between samples of 10 ms.
    #[test]
    fn waves_of_the_ground_are_no_delay() {
        let dt = 0.01;
        let spin = |late: f64, behind: f64| -> Vec<f64> {
            let at = |k: u32| {
                let time = dt * f64::from(k) - late;
                let start = ((time - 1.0) / 0.6).clamp(0.0, 1.0);
                let on_waves = (time - 2.5).clamp(0.0, 1.0);
                start * (2.0 + on_waves * (3.0 * (time - behind)).sin())
            };
            (0..3000).map(at).collect()
        };
        let allowed = allowed(dt);
        let first = spin(0.0, 0.0);
        for (late, behind) in [(0.0, 0.2), (0.1, 0.0), (0.1, 0.2), (-0.1, 0.2)] {
            let found = between(&spin(late, behind), &first, dt, &allowed).map(|d| d.seconds);
            assert!(
                found.is_some_and(|found| (found - late).abs() < 0.5 * dt),
                "{late} {behind}: {found:?}"
            );
        }
    }
}

//! Delays of encoders behind each other: wheels that roll start and stop together, whatever drives
//! them.

use crate::check::delay;
use crate::check::recording::{Recording, steps};
use crate::check::report::Finding;
use crate::check::rewire::Channel;
use robhaz_score::signals::{Allowed, Delay, median};

/// Longest delay that is looked for, s.
const LONGEST: f64 = 0.3;
/// Delay that is none, s: wheels that slip start one after the other.
const NONE: f64 = 0.025;
/// Share of a speed that the other ones explain where all roll.
const ROLLING: f64 = 0.99;
/// Time over which what a wheel slips is correlated, s.
const MEMORY: f64 = 0.25;

/// What the channel of the wheels of a side ends with.
pub const OF_WHEELS: &str = "after the others";

/// Delay of the spin speed of the wheels `one` behind that of `other`.
fn between(one: &[f64], other: &[f64], dt: f64, allowed: &Allowed) -> Option<Delay> {
    let [longest, memory] = [LONGEST, MEMORY].map(|time| steps(time, dt));
    robhaz_score::signals::delay(one, &[other], longest, memory, dt, *allowed)
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

/// The wheel of a side that is latest or earliest against the two others.
pub fn of_wheels(recording: &Recording) -> Finding {
    let allowed = allowed(recording.slowest);
    let spin = &recording.spin;
    let behind = |one: &[f64], other: &[f64]| between(one, other, recording.dt, &allowed);
    let lag = |i: usize| behind(&spin[i], &spin[0]).map_or(0.0, |delay| delay.seconds);
    let lags = [0.0, lag(1), lag(2)];
    let middle = median(lags.to_vec()).unwrap_or(0.0);
    let off = |i: &usize| (lags[*i] - middle).abs();
    let apart = (0..3).max_by(|i, j| off(i).total_cmp(&off(j))).unwrap_or(0);
    let others = [1, 2].map(|k| &spin[(apart + k) % 3]);
    let mean: Vec<f64> = (0..others[0].len())
        .map(|k| 0.5 * (others[0][k] + others[1][k]))
        .collect();
    let whose = Channel::Encoder(apart).to_string();
    finding(
        &format!("{whose} {OF_WHEELS}"),
        behind(&spin[apart], &mean),
        &allowed,
        [&whose, "the two others"],
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
    let unknown = [
        "the wheels do not start and stop together",
        "drive straight on, from a rest to a rest, without slip",
    ];
    delay::finding(channel, delay, allowed, unknown, whose, |late, offset| {
        format!(
            "{late} arrive late, by another clock or a slower bus, and so do torques of the same drive: state offset = {offset:.4} of a channel of theirs, [[channel]]"
        )
    })
}

//! What drivers do to the sign of a torque or current: magnitudes, magnitudes with the sign of the
//! speed, values cut off at zero, negative ones read as unsigned, dead bands, whole numbers.
//!
//! Noise carries a signed reading through zero: of the readings near zero, about half have either sign.
//! A magnitude touches zero and never passes it.

use crate::check::readings::Stated;
use crate::check::report::Finding;
use crate::check::rewire::Channel;
use robhaz_estimator::SensorFrame;
use robhaz_model::Units;
use robhaz_score::signals::median;

/// Number of visits of a reading near zero that shows a lost sign, if no reading of the log is on the
/// other side. A signed one with as many of 1500 has all on one side once in 10 000 logs, with a mean
/// of 2.5 times its noise, and hardly ever with another.
const NEAR: usize = 25;
/// The same of readings in the direction of the wheel, none of which is near zero on the other side: a
/// signed one whose mean is twice its noise has a quarter of them there, 0.75^60 = 3e-8.
const NEAR_BY_SPEED: usize = 60;
/// What is near zero, in standard deviations of the noise.
const WINDOW: f64 = 0.5;
/// Spin speed whose sign is certain, rad/s for robot A.
const TURNS: f64 = 0.2;
/// Share of a drive's readings that are exactly zero from which on they are cut off or in a dead band.
const OFTEN_ZERO: f64 = 0.02;
/// Number of jumps over the range of the values, to and fro, that shows unsigned numbers.
const WRAPS: usize = 4;
/// Share of the range between the values of both signs that is empty if they are read as unsigned.
const EMPTY: f64 = 0.5;
/// A unit of the readings over their stated noise beyond which the unit is the error: its own is
/// `1/sqrt(12)` of it.
const COARSE: f64 = 4.0;

const TEST: &str = "signed";

/// A finding for each torque.
pub fn findings(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Finding> {
    let turns = TURNS / Units::of(stated.robot).time;
    let speeds = [0, 1, 2].map(|i| speeds(frames, i));
    let of = |i: usize| finding(frames, i, &speeds[i], turns, stated.budget.torque_noise);
    (0..3).map(of).collect()
}

/// Spin speed at each frame, rad/s, over a quarter of a second around it; a NaN where it is not known.
fn speeds(frames: &[SensorFrame], wheel: usize) -> Vec<f64> {
    const HALF: f64 = 0.125;
    let angle = |k: usize| frames[k].wheel_angle[wheel];
    let (mut from, mut to) = (0, 0);
    let speed = |k: usize| {
        let time = frames[k].time;
        while frames[from].time < time - HALF {
            from += 1;
        }
        while to + 1 < frames.len() && frames[to].time < time + HALF {
            to += 1;
        }
        let dt = frames[to].time - frames[from].time;
        let by = angle(to).zip(angle(from)).map(|(b, a)| b - a);
        by.filter(|_| dt > 0.0).map_or(f64::NAN, |by| by / dt)
    };
    (0..frames.len()).map(speed).collect()
}

fn finding(
    frames: &[SensorFrame],
    wheel: usize,
    speeds: &[f64],
    turns: f64,
    stated: f64,
) -> Finding {
    let channel = Channel::Torque(wheel);
    let read: Vec<(f64, f64)> = frames
        .iter()
        .zip(speeds)
        .filter_map(|(f, speed)| Some((channel.value(f).filter(|v| v.is_finite())?, *speed)))
        .collect();
    let values: Vec<f64> = read.iter().map(|(value, _)| *value).collect();
    if let Some(range) = unsigned(&values) {
        let figure =
            format!("jumps to and fro over an empty range; {range:.3} N m between both ends");
        let finding = Finding::ok(TEST, channel, figure).fault(format!(
            "negative numbers are read as unsigned: read the field as signed, or take {range:.3} N m off values above half of that"
        ));
        return finding.with("range", range, "N m");
    }
    let driven: Vec<f64> = read
        .iter()
        .filter(|(_, s)| s.abs() > turns)
        .map(|(v, _)| *v)
        .collect();
    let zeros = driven.iter().filter(|value| **value == 0.0).count();
    let often_zero = zeros > NEAR.max((OFTEN_ZERO * driven.len() as f64) as usize);
    let noise = noise(&values);
    let near = |of: &dyn Fn(f64, f64) -> f64| {
        let signed: Vec<f64> = read
            .iter()
            .map(|(value, speed)| of(*value, *speed))
            .collect();
        let is_near = |x: f64| x.abs() <= WINDOW * noise && x.abs() > 0.0;
        // Each visit counts once: readings that stay there are not independent.
        let visits = signed
            .windows(2)
            .filter(|w| is_near(w[1]) && !is_near(w[0]));
        let (above, below): (Vec<_>, Vec<_>) = visits.partition(|w| w[1] > 0.0);
        [above.len(), below.len()]
    };
    let one_side =
        |[above, below]: [usize; 2], least| above.min(below) == 0 && above.max(below) >= least;
    let plain = near(&|value, _| value);
    // While a wheel turns; its sign is certain there.
    let by_speed = near(&|value, speed| {
        if speed.abs() > turns {
            value * speed.signum()
        } else {
            0.0
        }
    });
    let of =
        |[above, below]: [usize; 2]| format!("{above} visits just above zero, {below} just below");
    let remedy_of_sign = "log the signed current or torque, or the driver's direction bit with it; the estimators need the sign";
    let all = [f64::INFINITY, f64::NEG_INFINITY];
    let [least, most] = values.iter().fold(all, |[a, b], v| [a.min(*v), b.max(*v)]);
    if (least >= 0.0 || most <= 0.0) && often_zero {
        let share = 100.0 * zeros as f64 / driven.len() as f64;
        let figure = format!(
            "never on the other side of zero, and exactly zero in {share:.1} % of the drive"
        );
        return Finding::ok(TEST, channel, figure)
            .fault(format!("torques of one sign are cut off: {remedy_of_sign}"));
    }
    if (least >= 0.0 || most <= 0.0) && one_side(plain, NEAR) {
        let figure = format!("{}: it touches zero and never passes it", of(plain));
        return Finding::ok(TEST, channel, figure)
            .fault(format!("the sign is lost: {remedy_of_sign}"));
    }
    if one_side(by_speed, NEAR_BY_SPEED) && plain.iter().all(|count| *count > 0) {
        let figure = format!(
            "{} in the direction of the wheel: it never brakes",
            of(by_speed)
        );
        return Finding::ok(TEST, channel, figure)
            .fault(format!("the sign is that of the speed: {remedy_of_sign}"));
    }
    let smallest = values
        .iter()
        .map(|v| v.abs())
        .filter(|v| *v > 0.0)
        .fold(f64::INFINITY, f64::min);
    let unit = unit(&values);
    let is_band = often_zero && smallest > 3.0 * unit.unwrap_or(0.0).max(WINDOW * noise);
    if is_band {
        let figure =
            format!("a dead band: nothing between -{smallest:.3} and {smallest:.3} N m but zero");
        return Finding::ok(TEST, channel, figure)
            .fault("switch the driver's dead band off, or add it to budget.torque_offset");
    }
    if let Some(unit) = unit.filter(|unit| *unit > COARSE * stated) {
        let error = unit / 12.0_f64.sqrt();
        let figure =
            format!("whole numbers of {unit:.3} N m; budget.torque_noise is {stated:.3} N m");
        return Finding::ok(TEST, channel, figure).fault(format!(
            "log more digits, or state budget.torque_noise = {error:.3}"
        ));
    }
    Finding::ok(TEST, channel, of(plain))
}

/// Standard deviation of the noise by the differences of readings in a row, N m. The median is blind to
/// true changes; of a magnitude it is at most that of the signed reading.
fn noise(values: &[f64]) -> f64 {
    /// Median of the size of a difference of two readings of white noise, in its standard deviations.
    const MEDIAN: f64 = 0.953_873;
    let steps = values.windows(2).map(|w| (w[1] - w[0]).abs());
    median(steps.collect()).unwrap_or(0.0) / MEDIAN
}

/// The unit of which all values are whole numbers: the least difference of two of them, if they are few
/// and repeat themselves. N m.
fn unit(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let different = sorted.len();
    let steps = sorted.windows(2).map(|w| w[1] - w[0]);
    let unit = steps.fold(f64::INFINITY, f64::min);
    let whole = |value: &f64| (value / unit - (value / unit).round()).abs() < 0.05;
    (different > 2 && 4 * different < values.len() && sorted.iter().all(whole)).then_some(unit)
}

/// The distance of the ends over which readings jump to and fro, N m, if between them lies nothing.
fn unsigned(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let [least, .., most] = sorted[..] else {
        return None;
    };
    let gap = sorted
        .windows(2)
        .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    let [below, above] = [gap[0], gap[1]];
    if !(above - below > EMPTY * (most - least) && most > least) {
        return None;
    }
    let jumps: Vec<f64> = values
        .windows(2)
        .filter(|w| (w[0] <= below) != (w[1] <= below))
        .map(|w| (w[1] - w[0]).abs())
        .collect();
    // Wild values jump as well, but not to the end of a range at which small ones begin.
    let at_ends = jumps
        .iter()
        .filter(|jump| **jump > 0.8 * (most - least))
        .count();
    let alike = 10 * at_ends > 9 * jumps.len();
    (jumps.len() >= WRAPS && alike).then(|| median(jumps).unwrap_or(most - least))
}

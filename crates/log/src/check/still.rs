//! Channels that do not change, and channels at the end of their range.

use crate::check::recorded::{ROUNDING, Recorded};
use crate::check::report::Finding;
use crate::check::rewire::Channel;
use crate::check::stated::Stated;
use robhaz_estimator::SensorFrame;
use robhaz_model::Units;
use std::f64::consts::TAU;

/// Longest time without any change of a working sensor while the robot drives, s.
const LONGEST_CONSTANT: f64 = 1.0;
/// Number of equal readings in a row, at the greatest or least value of the log, that shows the end
/// of a range.
const AT_LIMIT: usize = 20;
/// Speed of the slower one of two wheels that shows that robot A drives, rad/s.
const TURNS: f64 = 0.2;

/// Turn of a wheel that shows no drive, rad: the wheels of a parked robot may tick together as it
/// settles.
const PARKED: f64 = 0.1;

/// Longest time between two frames in which a jump of an angle is looked for, s.
const LONGEST_STEP: f64 = 0.05;

/// Step of a sensor over its noise from which on equal readings show nothing: of three readings two
/// are equal by chance.
const COARSE: f64 = 2.0;

const STUCK: &str = "stuck";
const RANGE: &str = "range";
const COLUMNS: &str = "columns";

/// All findings.
pub fn findings(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for channel in Recorded::of_frames(frames, stated) {
        findings.push(stuck(frames, driving, &channel));
        findings.extend(match channel.channel {
            encoder @ Channel::Encoder(_) => wrapped(frames, encoder),
            _ => at_limit(&channel),
        });
    }
    findings.extend(repeated(frames, stated.body.is_some()));
    findings
}

/// Channels of one kind whose readings are the same in each frame, though they change; without the
/// readings of links that are made of those of the body.
fn repeated(frames: &[SensorFrame], of_body: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (k, a) in Channel::ALL.into_iter().enumerate() {
        let is_made =
            |b: Channel| of_body && matches!(b, Channel::Gyro(_) | Channel::Inclinometer(_));
        let is_other = |b: &Channel| a.is_like(*b) && !is_made(*b);
        for b in Channel::ALL.into_iter().skip(k + 1).filter(is_other) {
            let pair = |f: &SensorFrame| Some((a.value(f)?, b.value(f)?));
            let pairs = || frames.iter().filter_map(pair);
            let first = pairs().next().map_or(0.0, |(x, _)| x);
            let equal = |(x, y): (f64, f64)| x.to_bits() == y.to_bits();
            if pairs().any(|(x, _)| x.to_bits() != first.to_bits()) && pairs().all(equal) {
                let channels = format!("{a}, {b}");
                let finding = Finding::ok(COLUMNS, channels, "the same value in each frame");
                let parked = || pairs().all(|(x, _)| (x - first).abs() < PARKED);
                if matches!(a, Channel::Encoder(_)) && parked() {
                    findings.push(finding.cannot_tell("the wheels do not turn: record a drive"));
                    continue;
                }
                findings.push(finding.fault(format!(
                    "the same column twice: map {a} and {b} to columns of their own"
                )));
            }
        }
    }
    findings
}

/// An angle that jumps back by a turn, or again and again by the same amount: it is not continued
/// over a turn.
fn wrapped(frames: &[SensorFrame], channel: Channel) -> Option<Finding> {
    // Within a gap a wheel may turn by as much.
    let step = |w: &[SensorFrame]| {
        let step = channel.value(&w[1])? - channel.value(&w[0])?;
        (w[1].time - w[0].time < LONGEST_STEP).then_some(step.abs())
    };
    let mut steps: Vec<f64> = frames.windows(2).filter_map(step).collect();
    steps.sort_by(f64::total_cmp);
    let [.., last, largest] = steps[..] else {
        return None;
    };
    // Above nine of ten: a speed that a hundred times as much is no acceleration of.
    let usual = steps[(steps.len() - 1) * 9 / 10];
    let is_equal = |other: f64| (largest - other).abs() < 2.0 * usual;
    if largest < 100.0 * usual || !(is_equal(last) || is_equal(TAU)) {
        return None;
    }
    let figure = format!("jumps by {largest:.4} rad in a frame, else by {usual:.4} at most");
    let remedy = "the angle starts anew after a turn or an overflow: state `wrap` of its reading in a description";
    let finding = Finding::ok(COLUMNS, channel, figure).fault(remedy);
    Some(finding.with("jump", largest, "rad"))
}

/// At each frame, which wheels turn: speeds over a quarter of a second before.
pub fn driving(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<[bool; 3]> {
    let turns = TURNS / Units::of(stated.robot).time;
    let mut from = 0;
    let turning = |(i, frame): (usize, &SensorFrame)| {
        while frame.time - frames[from].time > 0.25 && from < i {
            from += 1;
        }
        let before = &frames[from];
        let elapsed = frame.time - before.time;
        [0, 1, 2].map(|w| match (frame.wheel_angle[w], before.wheel_angle[w]) {
            (Some(a), Some(b)) if elapsed > 0.1 => (a - b).abs() > turns * elapsed,
            _ => false,
        })
    };
    frames.iter().enumerate().map(turning).collect()
}

/// Least change of a channel that is more than rounding.
fn resolution(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|w| (w[1] - w[0]).abs());
    changes
        .filter(|c| *c > ROUNDING)
        .fold(f64::INFINITY, f64::min)
}

/// The longest time for which a channel repeats its value while the other wheels turn (two of them
/// for an encoder).
fn stuck(frames: &[SensorFrame], driving: &[[bool; 3]], recorded: &Recorded) -> Finding {
    let (channel, values, noise) = (recorded.channel, &recorded.values, recorded.noise);
    let is_encoder = matches!(channel, Channel::Encoder(_));
    let (mut last, mut since) = (f64::NAN, 0.0);
    let (mut longest, mut at) = (0.0, 0.0);
    let mut any = false;
    for ((frame, driving), value) in frames.iter().zip(driving).zip(values) {
        let others = (0..3).filter(|w| channel != Channel::Encoder(*w));
        let turning = others.filter(|w| driving[*w]);
        let drives = turning.count() >= 2;
        any |= drives;
        if value.is_nan() {
            continue;
        }
        let repeats = (value - last).abs() <= ROUNDING;
        if !drives || !repeats {
            since = frame.time;
        }
        last = *value;
        if frame.time - since > longest {
            (longest, at) = (frame.time - since, since);
        }
    }
    if !any {
        let finding = Finding::ok(STUCK, channel, "two wheels never turn together");
        return finding.cannot_tell("record a drive");
    }
    let figure = format!("longest without a change {longest:.3} s while other wheels turn");
    let finding = Finding::ok(STUCK, channel, figure);
    if longest < LONGEST_CONSTANT {
        finding.with("longest", longest, "s")
    } else if !is_encoder && noise <= 0.0 {
        let remedy = "the budget states no noise, so the reading may be constant: state its noise";
        finding.cannot_tell(remedy)
    } else if !is_encoder
        && let step @ 0.0..f64::INFINITY = resolution(values)
        && step > COARSE * noise
    {
        finding.cannot_tell(format!(
            "it changes in steps of {step:.4}, more than its noise, so it may rest: record a drive that moves it"
        ))
    } else {
        let remedy = format!("dead from {at:.2} s on: check cable and driver");
        finding.fault(remedy).with("longest", longest, "s")
    }
}

/// Readings that stay at the greatest or least value of the log. Noise keeps a sensor in its range
/// from repeating a value.
fn at_limit(channel: &Recorded) -> Option<Finding> {
    let mut values = channel.values.clone();
    values.retain(|x| !x.is_nan());
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if channel.noise <= 0.0 || values.is_empty() || most - least <= ROUNDING {
        return None;
    }
    let (mut elsewhere, mut at_end, mut share) = (0, 0, 0);
    let mut limit = most;
    let is_same = |a: f64, b: f64| (a - b).abs() <= ROUNDING;
    for run in values.chunk_by(|a, b| is_same(*a, *b)) {
        let (value, count) = (run[0], run.len());
        if is_same(value, least) || is_same(value, most) {
            if count > at_end {
                (at_end, limit) = (count, value);
            }
            share += count;
        } else {
            elsewhere = elsewhere.max(count);
        }
    }
    let share = 100.0 * share as f64 / values.len() as f64;
    let figure = format!(
        "{least:.4} to {most:.4}; longest at an end {at_end} readings ({share:.1} % of all), elsewhere {elsewhere}"
    );
    let finding = Finding::ok(RANGE, channel.channel, figure);
    if at_end < AT_LIMIT || at_end < 5 * elsewhere {
        return Some(finding.with("at an end", share, "%"));
    }
    if matches!(channel.channel, Channel::Torque(_)) {
        let remedy = format!(
            "at its limit of {limit:.3}: fine if it is the drive's, else raise the sensor's range"
        );
        return Some(finding.cannot_tell(remedy));
    }
    let remedy = format!("saturated at {limit:.4}: choose a greater range of the sensor");
    Some(finding.fault(remedy).with("at an end", share, "%"))
}

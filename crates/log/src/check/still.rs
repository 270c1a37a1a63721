//! Channels that do not change, and channels at the end of their range.

use crate::check::recorded::ROUNDING;
use crate::check::recording::driving_spin;
use crate::check::{Channel, Finding, Recorded, Stated};
use robhaz_estimator::SensorFrame;
use robhaz_model::{Robot, Units};
use robhaz_score::extremes;
use robhaz_score::signals::{median, white_noise};
use std::f64::consts::TAU;
use std::fmt::Display;
use std::mem::discriminant;

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

/// Equal readings in a row that are looked for again and again.
const IN_A_ROW: u8 = 10;
/// White noise over that of the budget from which on a torque is measured: no drive's limit has any.
const MEASURED: f64 = 0.1;

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
    let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    for recorded in Recorded::of_frames(frames, stated) {
        let channel = recorded.channel;
        let is_encoder = channel.is_encoder();
        let range = match is_encoder {
            true => wrapped(frames, channel),
            false => at_limit(&recorded),
        };
        // At the end of its range a channel is not dead.
        if is_encoder || !range.as_ref().is_some_and(Finding::is_fault) {
            let drives = drives(driving, channel);
            let noise = (!is_encoder).then_some(recorded.noise);
            findings.push(stuck(channel, (&times, &recorded.values), &drives, noise));
        }
        findings.extend(range);
    }
    findings.extend(repeated(frames, stated.body.is_some()));
    findings
}

/// Channels of one kind whose readings are the same in each frame, though they change; without the
/// readings of links that are made of those of the body.
fn repeated(frames: &[SensorFrame], of_body: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    let all = Channel::all();
    for (k, a) in all.iter().copied().enumerate() {
        let is_made =
            |b: Channel| of_body && matches!(b, Channel::Gyro(_) | Channel::Inclinometer(_));
        let is_other = |b: &Channel| discriminant(&a) == discriminant(b) && !is_made(*b);
        for b in all.iter().copied().skip(k + 1).filter(is_other) {
            let pair = |f: &SensorFrame| Some((a.value(f)?, b.value(f)?));
            let pairs = || frames.iter().filter_map(pair);
            let first = pairs().next().map_or(0.0, |(x, _)| x);
            let equal = |(x, y): (f64, f64)| x.to_bits() == y.to_bits();
            if pairs().any(|(x, _)| x.to_bits() != first.to_bits()) && pairs().all(equal) {
                let channels = format!("{a}, {b}");
                let finding = Finding::ok(COLUMNS, channels, "the same value in each frame");
                let parked = || pairs().all(|(x, _)| (x - first).abs() < PARKED);
                if a.is_encoder() && parked() {
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

/// An angle that jumps back by a turn, or again and again by its range: it is not continued over a turn.
pub fn wrapped(frames: &[SensorFrame], channel: Channel) -> Option<Finding> {
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
    // One that starts anew stays within its range, but for single wrong readings.
    let known = frames.iter().filter_map(|frame| channel.value(frame));
    let mut known: Vec<f64> = known.filter(|angle| angle.is_finite()).collect();
    known.sort_by(f64::total_cmp);
    let few = known.len() / 100;
    let range = known.get(known.len().checked_sub(1 + few)?)? - known.get(few)?;
    let starts_anew = is_equal(last) && range < largest + 2.0 * usual;
    if largest < 100.0 * usual || !(starts_anew || is_equal(TAU)) {
        return None;
    }
    let figure = format!("jumps by {largest:.4} rad in a frame, else by {usual:.4} at most");
    let remedy = "the angle starts anew after a turn or an overflow: state `wrap` of its reading in a description";
    let finding = Finding::ok(COLUMNS, channel, figure).fault(remedy);
    Some(finding.with("jump", largest, "rad"))
}

/// At each frame, which wheels turn: speeds over a quarter of a second before.
pub fn driving(frames: &[SensorFrame], robot: &Robot) -> Vec<[bool; 3]> {
    let wheels: Vec<_> = frames.iter().map(|f| (f.time, f.wheel_angle)).collect();
    faster(&wheels, TURNS / Units::of(robot).time)
}

/// At each frame, whether a wheel turns; one without an angle has the last one. `wheels`: times (s) and angles (rad).
pub fn turning<const N: usize>(
    wheels: impl Iterator<Item = (f64, [Option<f64>; N])>,
    robot: &Robot,
) -> Vec<bool> {
    let mut held = [None; N];
    let hold = |(time, angles): (f64, [Option<f64>; N])| {
        held = std::array::from_fn(|i| angles[i].or(held[i]));
        (time, held)
    };
    let wheels: Vec<_> = wheels.map(hold).collect();
    let least = driving_spin(robot);
    let turn = faster(&wheels, least);
    turn.iter().map(|wheels| wheels.contains(&true)).collect()
}

/// At each frame, whether each wheel turns faster than that, rad/s.
fn faster<const N: usize>(wheels: &[(f64, [Option<f64>; N])], least: f64) -> Vec<[bool; N]> {
    let mut from = 0;
    let turning = |(i, (time, angles)): (usize, &(f64, [Option<f64>; N]))| {
        while time - wheels[from].0 > 0.25 && from < i {
            from += 1;
        }
        let (start, before) = wheels[from];
        let elapsed = time - start;
        std::array::from_fn(|w| match (angles[w], before[w]) {
            (Some(a), Some(b)) if elapsed > 0.1 => (a - b).abs() > least * elapsed,
            _ => false,
        })
    };
    wheels.iter().enumerate().map(turning).collect()
}

/// At each frame, whether two wheels turn, without that of the channel.
pub fn drives(driving: &[[bool; 3]], channel: Channel) -> Vec<bool> {
    let turn = |turns: &[bool; 3]| {
        let others = (0..3).filter(|i| channel != Channel::Encoder(*i));
        others.filter(|i| turns[*i]).count() >= 2
    };
    driving.iter().map(turn).collect()
}

/// Least change of a channel that is more than rounding.
fn resolution(values: &[f64]) -> f64 {
    let changes = values.windows(2).map(|w| (w[1] - w[0]).abs());
    let changes = changes.filter(|c| *c > ROUNDING);
    changes.fold(f64::INFINITY, f64::min)
}

/// The longest time for which a channel repeats its value while other wheels turn, `drives`, and the whole time at a
/// value to which it comes back; `noise` of a sample by the budget, `None` of an encoder.
pub fn stuck(
    name: impl Display,
    (times, values): (&[f64], &[f64]),
    drives: &[bool],
    noise: Option<f64>,
) -> Finding {
    if !drives.contains(&true) {
        let finding = Finding::ok(STUCK, name, "two wheels never turn together");
        return finding.cannot_tell("record a drive");
    }
    let runs = runs(times, values, drives);
    let longest = runs.iter().max_by(|a, b| a.length.total_cmp(&b.length));
    let (longest, at) = longest.map_or((0.0, 0.0), |run| (run.length, run.since));
    let figure = format!("longest without a change {longest:.3} s while other wheels turn");
    let finding = Finding::ok(STUCK, name, figure);
    let Some(noise) = noise else {
        return match longest < LONGEST_CONSTANT {
            true => finding.with("longest", longest, "s"),
            false => dead(finding, at).with("longest", longest, "s"),
        };
    };
    let step = resolution(values);
    // At an end of the range is the test of ranges, but for 0.
    let known = || values.iter().copied().filter(|value| !value.is_nan());
    let is_inside =
        |x: f64| x.abs() <= ROUNDING || known().any(|v| v < x) && known().any(|v| v > x);
    let again = again(&runs)
        .filter(|(value, ..)| noise > 0.0 && step <= COARSE * noise && is_inside(*value));
    if longest < LONGEST_CONSTANT
        && let Some((value, count, time)) = again
    {
        finding.with("in all", time, "s").fault(format!(
            "it reads {value:.4} again and again, {count} times for {time:.1} s in all, and by its noise never so: not measured there: check cable and driver, and whether it has a dead band"
        ))
    } else if longest < LONGEST_CONSTANT {
        finding.with("longest", longest, "s")
    } else if noise <= 0.0 {
        let remedy = "the budget states no noise, so the reading may be constant: state its noise";
        finding.cannot_tell(remedy)
    } else if step < f64::INFINITY && step > COARSE * noise {
        finding.cannot_tell(format!(
            "it changes in steps of {step:.4}, more than its noise, so it may rest: record a drive that moves it"
        ))
    } else {
        dead(finding, at).with("longest", longest, "s")
    }
}

fn dead(finding: Finding, at: f64) -> Finding {
    finding.fault(format!("dead from {at:.2} s on: check cable and driver"))
}

/// Equal readings in a row while other wheels turn; one by itself is a run, too.
struct Run {
    value: f64,
    count: usize,
    /// s
    since: f64,
    /// s
    length: f64,
}

fn runs(times: &[f64], values: &[f64], drives: &[bool]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let read = times.iter().zip(values).zip(drives);
    for ((&time, &value), drives) in read.filter(|((_, value), _)| !value.is_nan()) {
        match runs.last_mut() {
            Some(run) if *drives && (value - run.value).abs() <= ROUNDING => {
                run.count += 1;
                run.length = time - run.since;
            }
            _ => runs.push(Run {
                value,
                count: 1,
                since: time,
                length: 0.0,
            }),
        }
    }
    runs
}

/// The one value that a channel repeats [`IN_A_ROW`] times and more, again and again, how often and for how long, s, if
/// by the share of all its other readings that equal those before it would not have done so once in a hundred logs.
fn again(runs: &[Run]) -> Option<(f64, usize, f64)> {
    let is_long = |run: &&Run| run.count >= usize::from(IN_A_ROW);
    let mut long = runs.iter().filter(is_long);
    let value = long.next()?.value;
    if long.any(|run| (run.value - value).abs() > ROUNDING) {
        return None;
    }
    let long = || runs.iter().filter(is_long);
    // A dead band is entered from its edge, and not from anywhere.
    let away = |run: &Run| (run.value - value).abs();
    let is_beside = |i: usize| {
        let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
        beside.filter_map(|k| runs.get(k)).any(|run| is_long(&run))
    };
    let of_others = (0..runs.len()).filter(|i| !is_long(&&runs[*i]));
    let beside = of_others.clone().filter(|i| is_beside(*i));
    let at_edge = median(beside.map(|i| away(&runs[i])).collect())?;
    if at_edge < 0.5 * median(of_others.map(|i| away(&runs[i])).collect())? {
        return None;
    }
    let time = long().map(|run| run.length).sum();
    let others = || runs.iter().filter(|run| !is_long(run)).map(|run| run.count);
    // Counts of readings.
    let equal = others().map(|n| n - 1).sum::<usize>() as f64;
    let all = others().sum::<usize>() as f64;
    let by_chance = all * (equal / all).powi(i32::from(IN_A_ROW) - 1);
    (long().count() > 1 && time >= LONGEST_CONSTANT && by_chance < 0.01)
        .then(|| (value, long().count(), time))
}

/// Readings that stay at the greatest or least value of the log. Noise keeps a sensor in its range
/// from repeating a value.
fn at_limit(channel: &Recorded) -> Option<Finding> {
    let mut values = channel.values.clone();
    values.retain(|x| !x.is_nan());
    let (least, most) = extremes(values.iter().copied());
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
    // What is 0 there was not measured.
    if at_end < AT_LIMIT || at_end < 5 * elsewhere || limit.abs() <= ROUNDING {
        return Some(finding.with("at an end", share, "%"));
    }
    let inside = |x: &f64| !(is_same(*x, least) || is_same(*x, most));
    let inside = |x: &f64| if inside(x) { *x } else { f64::NAN };
    let noise = white_noise(&channel.values.iter().map(inside).collect::<Vec<f64>>());
    let is_measured = noise.is_some_and(|noise| noise > MEASURED * channel.noise);
    if channel.channel.is_torque() && !is_measured {
        let remedy = format!(
            "at its limit of {limit:.3}: fine if it is the drive's, else raise the sensor's range"
        );
        return Some(finding.cannot_tell(remedy));
    }
    let remedy = format!("saturated at {limit:.4}: choose a greater range of the sensor");
    Some(finding.fault(remedy).with("at an end", share, "%"))
}

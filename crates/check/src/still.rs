//! Channels that do not change, and channels at the end of their range.

use crate::report::Finding;
use robhaz_estimator::{NoiseBudget, SensorFrame};

/// Longest time without any change of a working sensor while the robot drives, s.
const LONGEST_CONSTANT: f64 = 1.0;
/// Number of equal readings in a row, at the greatest or least value of the log, that shows the end of a range.
const AT_LIMIT: usize = 20;
/// Speed of the slower one of two wheels that shows that the robot drives, rad/s.
const TURNS: f64 = 0.2;

const STUCK: &str = "stuck";
const RANGE: &str = "range";

/// Takes a reading out of a frame.
type Reading = Box<dyn Fn(&SensorFrame) -> Option<f64>>;

/// A channel of the frames.
struct Channel {
    name: String,
    value: Reading,
    /// White noise of a sample by the budget, in the reading's unit; 0 for a channel that may be constant.
    noise: f64,
    /// Index of the wheel of an encoder.
    encoder: Option<usize>,
}

fn channels(budget: &NoiseBudget) -> Vec<Channel> {
    let mut channels = Vec::new();
    for i in 0..3 {
        channels.push(Channel {
            name: format!("encoder {}", i + 1),
            value: Box::new(move |f| f.wheel_angle[i]),
            noise: 0.0,
            encoder: Some(i),
        });
    }
    for i in 0..3 {
        channels.push(Channel {
            name: format!("torque {}", i + 1),
            value: Box::new(move |f| f.motor_torque[i]),
            noise: budget.torque_noise,
            encoder: None,
        });
    }
    for k in 0..2 {
        let link = move |f: &SensorFrame| if k == 0 { f.link1 } else { f.link2 };
        channels.push(Channel {
            name: format!("gyro {}", k + 1),
            value: Box::new(move |f| link(f).rate),
            noise: budget.rate_noise,
            encoder: None,
        });
        channels.push(Channel {
            name: format!("inclinometer {}", k + 1),
            value: Box::new(move |f| link(f).inclination),
            noise: budget.inclination_noise,
            encoder: None,
        });
    }
    channels
}

/// All findings.
pub fn findings(frames: &[SensorFrame], budget: &NoiseBudget) -> Vec<Finding> {
    let driving = driving(frames);
    let mut findings = Vec::new();
    for channel in channels(budget) {
        findings.push(stuck(frames, &driving, &channel));
        if channel.encoder.is_none() {
            findings.extend(at_limit(frames, &channel));
        }
    }
    findings
}

/// At each frame, how many wheels turn: speeds over a quarter of a second before.
fn driving(frames: &[SensorFrame]) -> Vec<[bool; 3]> {
    let mut from = 0;
    frames
        .iter()
        .enumerate()
        .map(|(i, frame)| {
            while frame.time - frames[from].time > 0.25 && from < i {
                from += 1;
            }
            let before = &frames[from];
            let elapsed = frame.time - before.time;
            [0, 1, 2].map(|w| match (frame.wheel_angle[w], before.wheel_angle[w]) {
                (Some(a), Some(b)) if elapsed > 0.1 => (a - b).abs() > TURNS * elapsed,
                _ => false,
            })
        })
        .collect()
}

/// The longest time for which a channel repeats its value while the other wheels turn (two of them for an encoder).
fn stuck(frames: &[SensorFrame], driving: &[[bool; 3]], channel: &Channel) -> Finding {
    let (mut last, mut since) = (None, 0.0);
    let (mut longest, mut at) = (0.0, 0.0);
    let mut any = false;
    for (frame, driving) in frames.iter().zip(driving) {
        let turning = (0..3).filter(|w| Some(*w) != channel.encoder && driving[*w]);
        let drives = turning.count() >= 2;
        any |= drives;
        let Some(value) = (channel.value)(frame) else {
            continue;
        };
        if !drives || last != Some(value.to_bits()) {
            since = frame.time;
        }
        last = Some(value.to_bits());
        if frame.time - since > longest {
            (longest, at) = (frame.time - since, since);
        }
    }
    let name = channel.name.clone();
    if !any {
        let remedy = "record a drive";
        return Finding::cannot_tell(STUCK, name, "two wheels never turn together", remedy);
    }
    let figure = format!("longest without a change {longest:.3} s while other wheels turn");
    if longest < LONGEST_CONSTANT {
        Finding::ok(STUCK, name, figure)
    } else if channel.noise > 0.0 || channel.encoder.is_some() {
        let remedy = format!("dead from {at:.2} s on: check cable and driver");
        Finding::fault(STUCK, name, figure, remedy)
    } else {
        let remedy = "the budget states no noise, so the reading may be constant: state its noise";
        Finding::cannot_tell(STUCK, name, figure, remedy)
    }
}

/// Readings that stay at the greatest or least value of the log. Noise keeps a sensor in its range from repeating a value.
fn at_limit(frames: &[SensorFrame], channel: &Channel) -> Option<Finding> {
    let values: Vec<f64> = frames.iter().filter_map(|f| (channel.value)(f)).collect();
    let (least, most) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(*v), b.max(*v))
        });
    if channel.noise <= 0.0 || values.is_empty() || least >= most {
        return None;
    }
    let (mut elsewhere, mut at_end) = (0, 0);
    let mut limit = most;
    let mut share = 0;
    let mut start = 0;
    for i in 1..=values.len() {
        if i < values.len() && values[i].to_bits() == values[start].to_bits() {
            continue;
        }
        let run = i - start;
        let is = |end: f64| values[start].to_bits() == end.to_bits();
        if is(least) || is(most) {
            if run > at_end {
                (at_end, limit) = (run, values[start]);
            }
            share += run;
        } else {
            elsewhere = elsewhere.max(run);
        }
        start = i;
    }
    let (name, test) = (channel.name.clone(), RANGE);
    #[expect(clippy::cast_precision_loss, reason = "numbers of samples")]
    let share = 100.0 * share as f64 / values.len() as f64;
    let figure = format!(
        "{least:.4} to {most:.4}; longest at an end {at_end} readings ({share:.1} % of all), elsewhere {elsewhere}"
    );
    if at_end < AT_LIMIT || at_end < 5 * elsewhere {
        return Some(Finding::ok(test, name, figure));
    }
    if channel.name.starts_with("torque") {
        let remedy = format!(
            "at its limit of {limit:.3}: fine if it is the drive's, else raise the sensor's range"
        );
        return Some(Finding::cannot_tell(test, name, figure, remedy));
    }
    let remedy = format!("saturated at {limit:.4}: choose a greater range of the sensor");
    Some(Finding::fault(test, name, figure, remedy))
}

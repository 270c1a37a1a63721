//! Channels that tell nothing: without a value in the whole log, or with the same one throughout a drive. Each has one
//! finding. No other test uses it, so that no remedy follows from what was not measured.

use crate::check::recorded::ROUNDING;
use crate::check::recording::range;
use crate::check::still::drives;
use crate::check::{Change, Channel, Finding, Recorded, Stated};
use robhaz_estimator::SensorFrame;

const TEST: &str = "values";
const EMPTY: &str =
    "not measured, or not recorded: no estimator works without it, and no other test uses it";
/// A cause of turns that are none.
pub const OTHER_AXIS: &str = "\nor the IMU sees them on another axis, as one whose y axis points forward: state `forward` and `up` of its [imu]";

/// The findings, each with the channel that it takes out of the log: of a reading of the body or of
/// pin Q one that is made of it. And those of the others that are silent for a while.
pub fn findings(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> (Vec<(Channel, Finding)>, Vec<Finding>) {
    let all = Recorded::of_frames(frames, stated);
    let drives = drives_unseen(&all);
    let mut found: Vec<(Channel, Finding)> = Vec::new();
    for recorded in &all {
        // Without the inclination of the body neither link has one, whatever pin Q reads.
        let own = recorded.channel.in_frames();
        let is_made = |(channel, _): &(Channel, Finding)| *channel == own;
        if !found.iter().any(is_made)
            && let Some(finding) = finding(recorded, driving, drives)
        {
            found.push((own, finding.change([Change::Remove(own)])));
        }
    }
    let is_dead = |own: &&Recorded| found.iter().any(|(of, _)| *of == own.channel.in_frames());
    let silent_ones = all.iter().filter(|own| !is_dead(own)).filter_map(|own| {
        let read = own.values.iter().map(|value| !value.is_nan());
        let times = frames.iter().map(|frame| frame.time);
        silent(&own.channel.to_string(), times.zip(read))
    });
    let silences = silent_ones.collect();
    (found, silences)
}

/// Whether the robot drives though no encoder changes: two torques and a rate move far beyond their noise, which no
/// robot that stands shows.
fn drives_unseen(all: &[Recorded]) -> bool {
    /// Range over the white noise: that of a million readings of noise alone is 10.
    const FAR: f64 = 20.0;
    let moves = |own: &&Recorded| own.noise > 0.0 && range(&own.values) > FAR * own.noise;
    let of = |is: fn(Channel) -> bool| all.iter().filter(move |own| is(own.channel));
    of(Channel::is_encoder).all(|own| range(&own.values) <= ROUNDING)
        && of(Channel::is_torque).filter(moves).count() >= 2
        && of(Channel::is_rate).any(|own| moves(&own))
}

fn finding(recorded: &Recorded, driving: &[[bool; 3]], unseen: bool) -> Option<Finding> {
    let (channel, values) = (recorded.channel, &recorded.values);
    // The name in the log.
    let name = channel.reading();
    if values.iter().all(|value| value.is_nan()) {
        return Some(empty(channel, &name, values.len()));
    }
    let is_encoder = channel.is_encoder();
    // An exact sensor may be constant.
    let may_rest = !is_encoder && recorded.noise <= 0.0;
    let drives = unseen && is_encoder || drives(driving, channel).contains(&true);
    if may_rest || !drives {
        return None;
    }
    let what = match channel {
        Channel::Encoder(_) => "what turns with the wheel",
        Channel::Torque(_) => "what the drive states as effort or current",
        _ => "what this sensor writes",
    };
    let while_moves = match unseen {
        true => "torques and gyroscopes change",
        false => "wheels turn",
    };
    same(channel, &name, values, [what, while_moves])
}

fn empty(channel: impl ToString, name: &str, frames: usize) -> Finding {
    let figure = format!("{name} has no value in {frames} frames");
    Finding::ok(TEST, channel, figure).fault(EMPTY)
}

/// A reading with the same value in all frames, of a robot that drives.
pub fn same(
    channel: impl ToString,
    name: &str,
    values: &[f64],
    [what, while_moves]: [&str; 2],
) -> Option<Finding> {
    let mut known = values.iter().filter(|value| !value.is_nan());
    let value = *known.next()?;
    // Readings of the body follow from those of the links, with rounding.
    if known.any(|other| (other - value).abs() > ROUNDING) {
        return None;
    }
    let count = values.len();
    let figure = format!("{name} is {value} in all of {count} frames while {while_moves}");
    let mut remedy = format!(
        "not measured: check cable and driver, and whether {what} is its column; no other test uses it"
    );
    if value.abs() <= ROUNDING && (name.contains("inclination") || name.contains("roll")) {
        remedy += "\nor the orientation of an IMU without one is the identity throughout: state inclination = \"acceleration\" of its [imu]";
    }
    if value.abs() <= ROUNDING && name.contains("rate") {
        remedy += OTHER_AXIS;
    }
    Some(Finding::ok(TEST, channel, figure).fault(remedy))
}

/// A reading that is not there, in the whole log or for longer than the estimators bridge, by the times of
/// the frames, s, and whether they have it.
pub fn silent(name: &str, frames: impl Iterator<Item = (f64, bool)>) -> Option<Finding> {
    /// The estimators hold the last value for this time, s.
    const BRIDGED: f64 = 0.5;
    let (mut count, mut known, mut from, mut longest) = (0, 0, None, (0.0, 0.0));
    for (time, is_read) in frames {
        count += 1;
        known += usize::from(is_read);
        let start = *from.get_or_insert(time);
        if is_read {
            from = None;
        } else if time - start > longest.0 {
            longest = (time - start, start);
        }
    }
    if known == 0 {
        return Some(empty(name, name, count));
    }
    let (length, start) = longest;
    (length > BRIDGED).then(|| {
        let figure = format!("{name} has no value for {length:.1} s from {start:.1} s on");
        let remedy = "find out why it was not read: the last value is held there";
        let finding = Finding::ok(TEST, name, figure).fault(remedy);
        finding.with("without", length, "s")
    })
}

/// Leaves out findings of dead channels, alone or with others.
pub fn without(mut findings: Vec<Finding>, dead: &[(Channel, Finding)]) -> Vec<Finding> {
    let is_dead = |name: &str| dead.iter().any(|(_, finding)| finding.channel == name);
    findings.retain(|finding| !finding.channel.split(", ").any(is_dead));
    findings
}

/// The tests that were left out.
pub fn left_out() -> Finding {
    let figure = "they need the channels without values";
    let finding = Finding::ok("all other tests", "all", figure);
    finding.cannot_tell("record these channels, and check again")
}

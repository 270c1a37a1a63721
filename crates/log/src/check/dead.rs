//! Channels that tell nothing: without a value in the whole log, or with the same one throughout a drive. Each has one
//! finding. No other test uses it, so that no remedy follows from what was not measured.

use crate::check::readings::Stated;
use crate::check::report::Finding;
use crate::check::rewire::{Change, Channel};
use robhaz_estimator::SensorFrame;

const TEST: &str = "values";

/// The findings, each with the change that takes its channel out of the log.
pub fn findings(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> Vec<(Channel, Finding)> {
    let found = Channel::ALL.into_iter().filter_map(|channel| {
        let finding = of_channel(frames, stated, driving, channel)?;
        Some((channel, finding.change([Change::Remove(channel)])))
    });
    found.collect()
}

fn of_channel(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
    channel: Channel,
) -> Option<Finding> {
    let (count, reading) = (frames.len(), channel.reading());
    let mut values = frames.iter().filter_map(|f| channel.value(f));
    let Some(first) = values.next() else {
        let figure = format!("{reading} has no value in {count} frames");
        let remedy = "not measured, or not recorded: no estimator works without it, and no other test uses it";
        return Some(Finding::ok(TEST, channel, figure).fault(remedy));
    };
    let is_constant = values.all(|value| value.to_bits() == first.to_bits());
    // An exact sensor, and the gyroscopes that pin Q gives, may be constant.
    let may_be = channel.noise(&stated.budget) <= 0.0 && !matches!(channel, Channel::Encoder(_));
    let is_made = stated.of_body && matches!(channel, Channel::Gyro(_) | Channel::Inclinometer(_));
    if !is_constant || may_be || is_made {
        return None;
    }
    let own = match channel {
        Channel::Encoder(i) => Some(i),
        _ => None,
    };
    let drives = driving
        .iter()
        .any(|turns| (0..3).filter(|i| Some(*i) != own && turns[*i]).count() >= 2);
    let figure = format!("{reading} is {first} in all of {count} frames while wheels turn");
    let remedy = format!(
        "not measured: check cable and driver, and whether {} is its column; no other test uses it",
        match channel {
            Channel::Torque(_) => "what the drive states as effort or current",
            Channel::Encoder(_) => "what turns with the wheel",
            _ => "what the sensor of this link writes",
        }
    );
    drives.then(|| Finding::ok(TEST, channel, figure).fault(remedy))
}

/// The kinds of channels that are dead.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kinds {
    pub encoders: bool,
    pub torques: bool,
    pub links: bool,
}

impl Kinds {
    pub fn of(dead: &[(Channel, Finding)]) -> Self {
        let has = |is: fn(&Channel) -> bool| dead.iter().any(|(channel, _)| is(channel));
        Self {
            encoders: has(|c| matches!(c, Channel::Encoder(_))),
            torques: has(|c| matches!(c, Channel::Torque(_))),
            links: has(|c| matches!(c, Channel::Gyro(_) | Channel::Inclinometer(_))),
        }
    }

    pub fn any(self) -> bool {
        self.encoders || self.torques || self.links
    }
}

/// Leaves out findings of dead channels, alone or with others.
pub fn without(findings: Vec<Finding>, dead: &[(Channel, Finding)]) -> Vec<Finding> {
    let names: Vec<String> = dead
        .iter()
        .map(|(channel, _)| channel.to_string())
        .collect();
    let pin = dead
        .iter()
        .any(|(c, _)| matches!(c, Channel::Inclinometer(_)));
    let is_dead = |name: &str| names.iter().any(|dead| dead == name) || pin && name == "pin Q";
    findings
        .into_iter()
        .filter(|finding| !finding.channel.split(", ").any(is_dead))
        .collect()
}

/// The tests that were left out.
pub fn left_out() -> Finding {
    let finding = Finding::ok(
        "all other tests",
        "all",
        "they need the channels without values",
    );
    finding.cannot_tell("record these channels, and check again")
}

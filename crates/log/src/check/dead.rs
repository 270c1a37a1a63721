//! Channels that tell nothing: without a value in the whole log, or with the same one throughout a drive. Each has one
//! finding. No other test uses it, so that no remedy follows from what was not measured.

use crate::check::recorded::{Kind, ROUNDING, Recorded};
use crate::check::report::Finding;
use crate::check::rewire::{Change, Channel};
use crate::check::stated::Stated;
use robhaz_estimator::SensorFrame;

const TEST: &str = "values";
const EMPTY: &str =
    "not measured, or not recorded: no estimator works without it, and no other test uses it";
const CABLE: &str = "check cable and driver, and whether";
const UNUSED: &str = " is its column; no other test uses it";

/// The findings, each with the change that takes its channel out of the log.
pub fn findings(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> Vec<(Channel, Finding)> {
    let is_made = |channel: &Channel| {
        stated.body.is_some() && matches!(channel, Channel::Gyro(_) | Channel::Inclinometer(_))
    };
    let channels = Channel::ALL.into_iter().filter(|c| !is_made(c));
    let found = channels.filter_map(|channel| {
        let finding = of_channel(frames, stated, driving, channel)?;
        Some((channel, finding.change([Change::Remove(channel)])))
    });
    found.chain(of_body(frames, stated, driving)).collect()
}

/// Those of the body and of pin Q, with a channel that is made of them.
fn of_body(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> Vec<(Channel, Finding)> {
    if stated.body.is_none() {
        return Vec::new();
    }
    let mut found: Vec<(Channel, Finding)> = Vec::new();
    for channel in Recorded::of_frames(frames, stated) {
        let made = match channel.kind {
            Kind::Torque => continue,
            Kind::Rate => Channel::Gyro(0),
            Kind::Inclination | Kind::Pin => Channel::Inclinometer(0),
        };
        // Without the inclination of the body neither link has one, whatever pin Q reads.
        if channel.kind == Kind::Pin && found.iter().any(|(c, _)| *c == made) {
            continue;
        }
        let (name, count) = (&channel.name, frames.len());
        let mut values = channel.values.iter().filter(|v| !v.is_nan());
        let finding = match values.next() {
            None => Finding::ok(TEST, name, format!("{name} has no value in {count} frames"))
                .fault(EMPTY),
            Some(first)
                if channel.noise > 0.0
                    && values.all(|v| (v - first).abs() <= ROUNDING)
                    && driving.iter().any(|turns| turning(turns, None) >= 2) =>
            {
                let figure =
                    format!("{name} is {first} in all of {count} frames while wheels turn");
                let remedy = format!("not measured: {CABLE} what this sensor writes{UNUSED}");
                Finding::ok(TEST, name, figure).fault(remedy)
            }
            Some(_) => continue,
        };
        found.push((made, finding));
    }
    found
}

/// Number of wheels that turn, beside the own one of an encoder.
fn turning(turns: &[bool; 3], own: Option<usize>) -> usize {
    (0..3).filter(|i| Some(*i) != own && turns[*i]).count()
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
        return Some(Finding::ok(TEST, channel, figure).fault(EMPTY));
    };
    let is_constant = values.all(|value| value.to_bits() == first.to_bits());
    // An exact sensor may be constant.
    let may_be = channel.noise(&stated.budget) <= 0.0 && !matches!(channel, Channel::Encoder(_));
    if !is_constant || may_be {
        return None;
    }
    let own = match channel {
        Channel::Encoder(i) => Some(i),
        _ => None,
    };
    let drives = driving.iter().any(|turns| turning(turns, own) >= 2);
    let figure = format!("{reading} is {first} in all of {count} frames while wheels turn");
    let remedy = format!(
        "not measured: {CABLE} {}{UNUSED}",
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
        .map(|(_, finding)| finding.channel.clone())
        .collect();
    let is_dead = |name: &str| names.iter().any(|dead| dead == name);
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

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
/// The findings, each with the channel that it takes out of the log: of a reading of the body or of
/// pin Q one that is made of it.
pub fn findings(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    driving: &[[bool; 3]],
) -> Vec<(Channel, Finding)> {
    let mut found: Vec<(Channel, Finding)> = Vec::new();
    for reading in readings(frames, stated) {
        // Without the inclination of the body neither link has one, whatever pin Q reads.
        let is_made = |(channel, _): &(Channel, Finding)| *channel == reading.channel;
        if !found.iter().any(is_made)
            && let Some(finding) = reading.finding(driving)
        {
            let removed = Change::Remove(reading.channel);
            found.push((reading.channel, finding.change([removed])));
        }
    }
    found
}

/// A reading as it was recorded.
struct Reading {
    channel: Channel,
    /// Its channel in a finding, and its name in the log.
    shown: String,
    name: String,
    values: Vec<f64>,
    /// Whether it is of an exact sensor, which may be constant.
    may_rest: bool,
    /// What may have been recorded in its place.
    what: &'static str,
}

/// The readings of a log: of encoders, and those of [`Recorded::of_frames`].
fn readings(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Reading> {
    let encoder = |i: usize| {
        let channel = Channel::Encoder(i);
        let value = |f: &SensorFrame| channel.value(f).unwrap_or(f64::NAN);
        Reading {
            channel,
            shown: channel.to_string(),
            name: channel.reading(),
            values: frames.iter().map(value).collect(),
            may_rest: false,
            what: "what turns with the wheel",
        }
    };
    let other = |recorded: Recorded| {
        let own = Channel::ALL
            .into_iter()
            .find(|c| c.to_string() == recorded.name);
        let channel = own.unwrap_or(match recorded.kind {
            Kind::Rate => Channel::Gyro(0),
            _ => Channel::Inclinometer(0),
        });
        Reading {
            channel,
            name: own.map_or_else(|| recorded.name.clone(), Channel::reading),
            shown: recorded.name,
            values: recorded.values,
            may_rest: recorded.noise <= 0.0,
            what: match recorded.kind {
                Kind::Torque => "what the drive states as effort or current",
                _ => "what this sensor writes",
            },
        }
    };
    let others = Recorded::of_frames(frames, stated).into_iter().map(other);
    (0..3).map(encoder).chain(others).collect()
}

impl Reading {
    fn finding(&self, driving: &[[bool; 3]]) -> Option<Finding> {
        let (name, count) = (&self.name, self.values.len());
        let mut values = self.values.iter().filter(|v| !v.is_nan());
        let Some(first) = values.next() else {
            let figure = format!("{name} has no value in {count} frames");
            return Some(Finding::ok(TEST, &self.shown, figure).fault(EMPTY));
        };
        let own = |i: usize| self.channel == Channel::Encoder(i);
        let turns = |turns: &[bool; 3]| (0..3).filter(|i| !own(*i) && turns[*i]).count() >= 2;
        // Readings of the body follow from those of the links, with rounding.
        let is_constant = values.all(|v| (v - first).abs() <= ROUNDING);
        (is_constant && !self.may_rest && driving.iter().any(turns)).then(|| {
            let figure = format!("{name} is {first} in all of {count} frames while wheels turn");
            Finding::ok(TEST, &self.shown, figure).fault(format!(
                "not measured: check cable and driver, and whether {} is its column; no other test uses it",
                self.what
            ))
        })
    }
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

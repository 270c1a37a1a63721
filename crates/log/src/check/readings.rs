//! The readings of a log, and what was found so far.

use crate::check::clock::Clock;
use crate::check::{Finding, Recording, Stated};
use robhaz_estimator::{SensorFrame, Sides};
use std::borrow::Cow;

/// The readings with the changes that tests have asked for so far, and what was found.
pub struct Readings<'a> {
    pub stated: &'a Stated<'a>,
    pub frames: Cow<'a, [SensorFrame]>,
    pub recording: Recording,
    pub findings: Vec<Finding>,
    /// Whether it is a side of a log of both.
    pub is_of_both: bool,
    /// Tests that do not hold in this drive: their faults stop no other test.
    pub excused: &'a [&'static str],
    /// How the other side pushes this one, as far as that shows.
    pub pushed: Option<Pushed>,
}

/// A push of the other side, and what it looks like.
#[derive(Clone, Copy)]
pub struct Pushed {
    /// Push by the torques that the slope does not need, over the weight, -.
    pub push: f64,
    /// Tests that know no such push; of a test with a channel that one alone.
    pub tests: &'static [(&'static str, Option<&'static str>)],
}

impl Pushed {
    /// The finding, unless it is a fault that the push explains as well.
    fn judge(&self, finding: Finding) -> Finding {
        let is_of = |(test, channel): &(&str, Option<&str>)| {
            *test == finding.test && channel.is_none_or(|channel| channel == finding.channel)
        };
        if !(finding.is_fault() && self.tests.iter().any(is_of)) {
            return finding;
        }
        let way = if self.push > 0.0 { "push" } else { "brake" };
        finding.unless(&format!(
            "the other side holds it back, or drives it, as in a skid turn: the torques {way} harder than the slope needs, by {:.2} of this side's weight; record a drive straight on",
            self.push.abs()
        ))
    }
}

impl<'a> Readings<'a> {
    /// Of a side of both, without a finding; `None` without three frames.
    pub fn of_side(
        frames: impl Into<Cow<'a, [SensorFrame]>>,
        stated: &'a Stated<'a>,
    ) -> Option<Self> {
        let frames = frames.into();
        Some(Self {
            recording: Recording::new(&Clock::of(&frames), stated.robot)?,
            stated,
            frames,
            findings: Vec::new(),
            is_of_both: true,
            excused: &[],
            pushed: None,
        })
    }

    /// Mean NIS from which on a contradiction between the readings is one: see [`Recording::certain`].
    pub fn certain(&self) -> f64 {
        self.recording.certain(self.stated.robot)
    }

    /// Whether the robot has another side, which may push this one.
    pub fn has_other_side(&self) -> bool {
        self.is_of_both || self.stated.settings.sides == Sides::OneOfTwo
    }

    /// Whether one of the findings is a fault of this kind, of a test that holds in this drive: all that need what is
    /// wrong are left out.
    pub fn stops(&self, findings: &[Finding], is_of_kind: impl Fn(&Finding) -> bool) -> bool {
        let holds = |f: &&Finding| f.is_fault() && !self.excused.contains(&f.test);
        findings.iter().filter(holds).any(is_of_kind)
    }

    /// Takes what a test found. Later tests see the readings with its changes.
    pub fn take(&mut self, findings: impl IntoIterator<Item = Finding>) {
        let known = self.findings.len();
        let pushed = self.pushed;
        let unless_pushed = |finding: Finding| match pushed {
            Some(pushed) => pushed.judge(finding),
            None => finding,
        };
        self.findings
            .extend(findings.into_iter().map(unless_pushed));
        let found = &self.findings[known..];
        if found.iter().all(|finding| finding.changes.is_empty()) {
            return;
        }
        for frame in self.frames.to_mut() {
            let changes = found.iter().flat_map(|finding| &finding.changes);
            changes.for_each(|change| change.of(frame, self.stated));
        }
        if let Some(recording) = Recording::new(&Clock::of(&self.frames), self.stated.robot) {
            self.recording = recording;
        }
    }
}

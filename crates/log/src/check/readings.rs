//! The readings of a log, and what was found so far.

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
    /// How hard the other side pushes this one, as far as that shows: see `Level`.
    pub pushed: Option<f64>,
}

impl<'a> Readings<'a> {
    /// Without a finding; `None` without three frames.
    pub fn new(
        frames: impl Into<Cow<'a, [SensorFrame]>>,
        stated: &'a Stated<'a>,
        is_of_both: bool,
    ) -> Option<Self> {
        let frames = frames.into();
        Some(Self {
            recording: Recording::new(&frames, stated.robot)?,
            stated,
            frames,
            findings: Vec::new(),
            is_of_both,
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
        self.findings.extend(findings);
        let found = &self.findings[known..];
        if found.iter().all(|finding| finding.changes.is_empty()) {
            return;
        }
        for frame in self.frames.to_mut() {
            let changes = found.iter().flat_map(|finding| &finding.changes);
            changes.for_each(|change| change.of(frame, self.stated));
        }
        if let Some(recording) = Recording::new(&self.frames, self.stated.robot) {
            self.recording = recording;
        }
    }
}

//! What is stated of a log, its readings, and what was found so far.

use crate::check::clock::Clock;
use crate::check::recorded::BodyNoise;
use crate::check::recording::Recording;
use crate::check::report::Finding;
use robhaz_estimator::{NoiseBudget, SensorFrame, Sides};
use robhaz_model::{Robot, Suspension};
use std::borrow::Cow;

/// What is stated of the robot and its sensors.
#[derive(Clone, Copy, Debug)]
pub struct Stated<'a> {
    /// The nominal robot.
    pub robot: &'a Robot,
    /// Standard deviations of all sensor errors.
    pub budget: NoiseBudget,
    /// Nominal damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Nominal compression of wheel and ground, m.
    pub compression: f64,
    /// Whether the log is of one side of a robot with two.
    pub sides: Sides,
    /// The sensors of body and pin Q of which the readings of the links are made; `None` of sensors
    /// on the links.
    pub body: Option<BodyNoise>,
}

impl Stated<'_> {
    /// The link that the body is fixed to, from 0, if the readings of the links are made of those
    /// of the body; `None` of a four-bar.
    pub(super) fn body_link(&self) -> Option<usize> {
        match self.robot.geometry.suspension {
            Suspension::Bogie { body } if self.body.is_some() => Some(body.index()),
            _ => None,
        }
    }
}

/// The readings with the changes that tests have asked for so far, and what was found.
pub struct Readings<'a> {
    pub stated: &'a Stated<'a>,
    pub frames: Cow<'a, [SensorFrame]>,
    pub recording: Recording,
    pub findings: Vec<Finding>,
}

impl Readings<'_> {
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
        if let Some(recording) = Recording::new(&Clock::of(&self.frames), self.stated.robot) {
            self.recording = recording;
        }
    }
}

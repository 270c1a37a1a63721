//! The readings of a log, its motion, and what was found so far.

use crate::check::clock::Clock;
use crate::check::motion::Motion;
use crate::check::recording::Recording;
use crate::check::report::Finding;
use crate::check::rewire::{Change, Tested};
use robhaz_estimator::{NoiseBudget, SensorFrame};
use robhaz_model::Robot;
use std::borrow::Cow;

/// The readings with the changes that tests have asked for so far, and what was found.
pub struct Readings<'a> {
    pub robot: &'a Robot,
    /// Standard deviations of all sensor errors.
    pub budget: &'a NoiseBudget,
    pub frames: Cow<'a, [SensorFrame]>,
    pub recording: Recording,
    pub motion: Motion,
    pub findings: Vec<Finding>,
}

impl Readings<'_> {
    /// Takes what a test found. Later tests see the readings with its changes.
    pub fn take(&mut self, tested: Tested) {
        self.findings.extend(tested.findings);
        if tested.changes.is_empty() {
            return;
        }
        let frames = Change::all(&tested.changes, &self.frames);
        if let Some(recording) = Recording::new(&Clock::of(&frames)) {
            self.motion = Motion::of(&recording, self.robot);
            self.recording = recording;
        }
        self.frames = Cow::Owned(frames);
    }
}

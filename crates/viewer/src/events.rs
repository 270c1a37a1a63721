//! Events and state changes of a run, in the form in which the viewer shows them.

use crate::colours::{Colour, NEUTRAL, WHEELS, by_index};
use crate::felt::FeltFrame;
use crate::friction_tests::{self, TestMark};
use crate::series::WHEEL_NAMES;
use rerun::components::TextLogLevel;
use robhaz_estimator::{ContactEstimate, ContactState, Estimate, EstimateError, Flags};
use robhaz_model::Bar;
use robhaz_run::{Frame, RunDescription, RunEnd};
use robhaz_score::events::{self, EventDetector, EventKind, WheelState};
use robhaz_sim::Truth;
use robhaz_sim::clearance::Clearances;

/// A message with its time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    /// Time, s.
    pub(crate) time: f64,
    /// Text of the message.
    pub(crate) text: String,
    /// Severity, one of the viewer's levels.
    pub(crate) level: &'static str,
    /// Colour of the wheel or estimator.
    pub(crate) colour: Colour,
}

/// State of an estimator at one record: its flags, or no estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Confidence {
    /// An estimate with its flags.
    Estimates(Flags),
    /// No estimate.
    Refuses,
}

impl Confidence {
    /// Name of the state in the recording.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Estimates(flags) if flags.is_empty() => "trusted".to_owned(),
            Self::Estimates(flags) => flags.names().collect::<Vec<_>>().join(", "),
            Self::Refuses => "no estimate".to_owned(),
        }
    }

    fn of(estimate: &Result<Estimate, EstimateError>) -> Self {
        estimate
            .as_ref()
            .map_or(Self::Refuses, |e| Self::Estimates(e.flags))
    }
}

/// State of a wheel in its lane, true or estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WheelLane {
    /// One contact.
    Grips,
    /// One contact, and slip.
    Slips,
    /// Two contacts.
    TwoContacts,
    /// Two contacts, and slip.
    TwoContactsSlips,
    /// No contact.
    InTheAir,
}

impl WheelLane {
    /// All states.
    pub(crate) const ALL: [Self; 5] = [
        Self::Grips,
        Self::Slips,
        Self::TwoContacts,
        Self::TwoContactsSlips,
        Self::InTheAir,
    ];

    /// Its name in the recording.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Grips => WheelState::Grips.name(),
            Self::Slips => WheelState::Slips.name(),
            Self::TwoContacts => "two contacts",
            Self::TwoContactsSlips => "two contacts, slips",
            Self::InTheAir => WheelState::InTheAir.name(),
        }
    }

    /// The true state of a wheel with a number of contacts.
    fn of_truth(state: WheelState, contacts: u32) -> Self {
        match (state, contacts > 1) {
            (WheelState::InTheAir, _) => Self::InTheAir,
            (WheelState::Grips, false) => Self::Grips,
            (WheelState::Slips, false) => Self::Slips,
            (WheelState::Grips, true) => Self::TwoContacts,
            (WheelState::Slips, true) => Self::TwoContactsSlips,
        }
    }

    /// An estimated state.
    fn of_estimate(contact: &ContactEstimate) -> Self {
        match (contact.state, contact.sliding) {
            (ContactState::InAir, _) => Self::InTheAir,
            (ContactState::OneContact, false) => Self::Grips,
            (ContactState::OneContact, true) => Self::Slips,
            (ContactState::TwoContacts, false) => Self::TwoContacts,
            (ContactState::TwoContacts, true) => Self::TwoContactsSlips,
        }
    }
}

/// A change of the state of a wheel or estimator.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change<S> {
    /// Time, s.
    pub(crate) time: f64,
    /// Index of the wheel or estimator. Of an estimated wheel: three times the index of the estimator, plus that of the
    /// wheel.
    pub(crate) index: usize,
    /// The new state.
    pub(crate) state: S,
}

/// Detected events and state changes that are not logged yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    /// Messages.
    pub(crate) events: Vec<Event>,
    /// Changes of the states of wheels.
    pub(crate) wheels: Vec<Change<WheelLane>>,
    /// Changes of the estimated states of wheels.
    pub(crate) contacts: Vec<Change<WheelLane>>,
    /// Changes of the states of estimators.
    pub(crate) estimators: Vec<Change<Confidence>>,
    /// The ground that the estimator of the animation has found.
    pub(crate) felt: Vec<FeltFrame>,
    /// Results of friction tests.
    pub(crate) tests: Vec<TestMark>,
}

impl Found {
    /// Appends later events and changes.
    pub(crate) fn append(&mut self, mut later: Self) {
        self.events.append(&mut later.events);
        self.wheels.append(&mut later.wheels);
        self.contacts.append(&mut later.contacts);
        self.estimators.append(&mut later.estimators);
        self.felt.append(&mut later.felt);
        self.tests.append(&mut later.tests);
    }

    /// Whether there are no events and no changes.
    pub(crate) fn is_empty(&self) -> bool {
        self.events.is_empty()
            && self.wheels.is_empty()
            && self.contacts.is_empty()
            && self.estimators.is_empty()
            && self.felt.is_empty()
            && self.tests.is_empty()
    }
}

/// Detects events and state changes.
pub(crate) struct Watch {
    names: Vec<String>,
    /// `None` for recorded readings: they have no truth, from which events are detected.
    detector: Option<EventDetector>,
    /// True states of the wheels at the last record.
    wheels: [Option<WheelLane>; 3],
    /// Estimated states at the last record, by estimator.
    contacts: Vec<[Option<WheelLane>; 3]>,
    confidence: Vec<Option<Confidence>>,
    last_time: f64,
    found: Found,
}

impl Watch {
    /// A watch before the first record of a scene. Its first event names the scene.
    pub(crate) fn new(run: &RunDescription) -> Self {
        let stop = run.robot.robot.geometry.stop;
        let mut watch = Self {
            names: run.estimators.iter().map(|e| e.label.clone()).collect(),
            detector: run.world.as_ref().map(|_| EventDetector::new(stop)),
            wheels: [None; 3],
            contacts: vec![[None; 3]; run.estimators.len()],
            confidence: vec![None; run.estimators.len()],
            last_time: 0.0,
            found: Found::default(),
        };
        let kind = if run.world.is_some() { "scene" } else { "log" };
        let text = format!("{kind} {}: {} s", run.name, run.record.duration);
        watch.add(0.0, text, TextLogLevel::INFO, NEUTRAL);
        watch
    }

    /// Detects the events of one record.
    pub(crate) fn sample(&mut self, frame: &Frame<'_>) {
        self.last_time = frame.time;
        if let Some(truth) = frame.truth {
            self.sample_robot(truth, frame.clearances.as_ref());
        }
        self.sample_estimates(frame);
    }

    /// Adds the results of the friction tests at their times, and the event of the end of the run.
    pub(crate) fn end(&mut self, end: Option<&RunEnd>) {
        for result in end.iter().flat_map(|end| &end.friction_tests) {
            let text = friction_tests::in_words(result);
            let colour = WHEELS[result.wheel];
            self.add(result.time, text, TextLogLevel::INFO, colour);
        }
        let (text, level) = if end.is_some_and(RunEnd::is_complete) {
            ("end of the run", TextLogLevel::INFO)
        } else {
            (
                "the run broke off: this is its last record",
                TextLogLevel::ERROR,
            )
        };
        self.add(self.last_time, text.to_owned(), level, NEUTRAL);
        // The results are known at the end alone.
        let events = &mut self.found.events;
        events.sort_by(|a, b| a.time.total_cmp(&b.time));
    }

    /// Takes the events and changes since the last call.
    pub(crate) fn take(&mut self) -> Found {
        std::mem::take(&mut self.found)
    }

    fn add(&mut self, time: f64, text: String, level: &'static str, colour: Colour) {
        self.found.events.push(Event {
            time,
            text,
            level,
            colour,
        });
    }

    fn sample_robot(&mut self, truth: &Truth, clearances: Option<&Clearances>) {
        let Some(detector) = &mut self.detector else {
            return;
        };
        let mut events = Vec::new();
        detector.sample(truth, clearances, &mut |event| events.push(event));
        for (index, last) in self.wheels.iter_mut().enumerate() {
            let contacts = truth.wheels[index].contacts;
            let now = detector.wheel(index);
            let now = now.map(|state| WheelLane::of_truth(state, contacts));
            note_change(&mut self.found.wheels, truth.time, index, last, now);
        }
        for event in events {
            self.add_event(&event, truth);
        }
    }

    /// Adds a message about a detected event, with the position of the wheel.
    fn add_event(&mut self, event: &events::Event, truth: &Truth) {
        let (wheel, what, level) = match event.kind {
            EventKind::ContactLost(i) => (i, "leaves the ground", TextLogLevel::WARN),
            EventKind::ContactRegained(i) => (i, "touches the ground again", TextLogLevel::INFO),
            EventKind::TwoContacts(i) => (i, "touches at two places", TextLogLevel::INFO),
            EventKind::OneContact(i) => (i, "touches at one place again", TextLogLevel::INFO),
            EventKind::Spins(i) => (i, "starts to spin", TextLogLevel::WARN),
            EventKind::Slides(i) => (i, "starts to slide", TextLogLevel::WARN),
            EventKind::Grips(i) => (i, "grips again", TextLogLevel::INFO),
            EventKind::StopReached(stop, angle) => {
                return self.add_stop(event.time, "reaches", stop, angle, TextLogLevel::WARN);
            }
            EventKind::StopLeft(stop, angle) => {
                return self.add_stop(event.time, "leaves", stop, angle, TextLogLevel::INFO);
            }
            EventKind::BarTouches(bar) => {
                let what = "touches the ground, whose force on it is not modelled";
                return self.add_bar(event.time, bar, what, truth, TextLogLevel::ERROR);
            }
            EventKind::BarClear(bar) => {
                let what = "is clear of the ground again";
                return self.add_bar(event.time, bar, what, truth, TextLogLevel::INFO);
            }
        };
        let x = rounded(truth.wheels[wheel].position.x, 1e3);
        let text = format!("{} wheel {what} at x = {x:.3} m", WHEEL_NAMES[wheel]);
        self.add(event.time, text, level, WHEELS[wheel]);
    }

    /// Adds a message about body or a link, with the position of its centre of mass.
    fn add_bar(&mut self, time: f64, bar: Bar, what: &str, truth: &Truth, level: &'static str) {
        let x = rounded(truth.bar(bar).position.x, 1e3);
        let text = format!(
            "{} {what}, with its centre of mass at x = {x:.3} m",
            bar.name()
        );
        self.add(time, text, level, NEUTRAL);
    }

    /// Adds a message about an end stop at theta1 - theta2 (rad).
    fn add_stop(
        &mut self,
        time: f64,
        what: &str,
        stop: events::EndStop,
        angle: f64,
        level: &'static str,
    ) {
        let text = format!(
            "pin Q {what} its {} stop: theta1 - theta2 = {:.1} deg",
            stop.name(),
            rounded(angle.to_degrees(), 10.0)
        );
        self.add(time, text, level, NEUTRAL);
    }

    fn sample_estimates(&mut self, frame: &Frame<'_>) {
        for (k, estimate) in frame.estimates.iter().enumerate() {
            if let Ok(contact) = estimate.as_ref().map(|e| e.contact) {
                for (i, last) in self.contacts[k].iter_mut().enumerate() {
                    let now = contact.map(|c| WheelLane::of_estimate(&c[i]));
                    let changes = &mut self.found.contacts;
                    note_change(changes, frame.time, 3 * k + i, last, now);
                }
            }
            let now = Confidence::of(estimate);
            let before = self.confidence[k].replace(now);
            if before == Some(now) {
                continue;
            }
            self.found.estimators.push(Change {
                time: frame.time,
                index: k,
                state: now,
            });
            let what = match (before, estimate) {
                (_, Err(error)) => Some((format!("no estimate, {error}"), TextLogLevel::WARN)),
                (Some(Confidence::Refuses), Ok(e)) if e.flags.is_empty() => {
                    Some(("estimates again".to_owned(), TextLogLevel::INFO))
                }
                (None, Ok(e)) if e.flags.is_empty() => None,
                (_, Ok(e)) if e.flags.is_empty() => {
                    Some(("no flag any more".to_owned(), TextLogLevel::INFO))
                }
                (_, Ok(e)) => {
                    let suspects = suspects(e).unwrap_or_default();
                    Some((
                        format!("flags: {}{suspects}", now.name()),
                        TextLogLevel::WARN,
                    ))
                }
            };
            if let Some((what, level)) = what {
                let text = format!("{}: {what}", self.names[k]);
                self.add(frame.time, text, level, by_index(k));
            }
        }
    }
}

/// The channels whose readings contradict others, in words.
fn suspects(estimate: &Estimate) -> Option<String> {
    let names: Vec<&str> = estimate.health?.suspect.names().collect();
    (!names.is_empty()).then(|| format!(" ({})", names.join(", ")))
}

/// Adds a change if the state of a wheel is known and differs from the last one.
fn note_change(
    changes: &mut Vec<Change<WheelLane>>,
    time: f64,
    index: usize,
    last: &mut Option<WheelLane>,
    now: Option<WheelLane>,
) {
    if let Some(state) = now.filter(|now| *last != Some(*now)) {
        *last = now;
        changes.push(Change { time, index, state });
    }
}

/// Rounds a value to a multiple of 1/`fractions`. Adding 0 turns -0 into 0.
fn rounded(value: f64, fractions: f64) -> f64 {
    (value * fractions).round() / fractions + 0.0
}

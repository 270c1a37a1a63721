//! Events as messages, and lanes with the state of each wheel and estimator over time. They are
//! detected at every record.

use crate::colours::{NEUTRAL, WHEELS, by_index, light, rgb};
use crate::draw::rounded;
use crate::error::Result;
use crate::friction_tests;
use crate::series::WHEEL_NAMES;
use crate::writer::Writer;
use re_sdk_types::archetypes::{StateChange, StateConfiguration, TextLog};
use re_sdk_types::components::{Color, TextLogLevel};
use robhaz_estimator::{Confirmation, ContactState, Estimate, Flags};
use robhaz_run::{Frame, RunDescription, RunEnd};
use robhaz_score::events::{self, EventDetector, EventKind, WheelState};
use robhaz_sim::Truth;
use robhaz_sim::clearance::Clearances;

/// A normal state, drawn inconspicuously.
const CALM: Color = rgb(0x303030);
/// A state with flags.
const WARNING: Color = rgb(0xE69F00);
/// Two contacts.
const TWO_CONTACTS: Color = rgb(0x808080);
/// No contact, or no estimate.
const ABSENT: Color = rgb(0xF0F0F0);
/// State of an estimator without flags, and of one without an estimate.
const TRUSTED: &str = "trusted";
const NO_ESTIMATE: &str = "no estimate";

/// A message with its time.
struct Event {
    /// Time, s.
    time: f64,
    text: String,
    /// Severity, one of the viewer's levels.
    level: &'static str,
    /// Colour of the wheel or estimator.
    colour: Color,
}

/// The state of a wheel, true or estimated, or of an estimator: its changes that are not logged
/// yet.
#[derive(Default)]
struct Lane {
    entity: String,
    last: String,
    times: Vec<f64>,
    states: Vec<String>,
}

impl Lane {
    fn new(entity: String) -> Self {
        Self {
            entity,
            ..Self::default()
        }
    }

    /// Adds a state at a time (s) if it differs from the last one.
    fn note(&mut self, time: f64, state: &str) {
        if self.last != state {
            state.clone_into(&mut self.last);
            self.times.push(time);
            self.states.push(state.to_owned());
        }
    }

    fn flush(&mut self, out: &mut Writer) -> Result {
        let (times, states) = (std::mem::take(&mut self.times), self.states.drain(..));
        let states = StateChange::update_fields().with_state(states);
        let entity = self.entity.as_str();
        out.columns(entity, &times, states.columns_of_unit_batches())
    }
}

/// The state of a wheel in the air, or with one or two contacts, in words.
fn wheel_state(state: WheelState, two_contacts: bool) -> &'static str {
    match (state, two_contacts) {
        (WheelState::Grips, true) => "two contacts",
        (WheelState::Slips, true) => "two contacts, slips",
        _ => state.name(),
    }
}

/// Detects and logs events and changes of states.
pub(crate) struct Events {
    /// `None` for recorded readings: they have no truth, from which events are detected.
    detector: Option<EventDetector>,
    /// True states of the wheels.
    wheels: [Lane; 3],
    estimators: Vec<EstimatorLanes>,
    /// Names of the states of estimators so far. The viewer needs a colour for each.
    seen: Vec<String>,
    last_time: f64,
    events: Vec<Event>,
}

struct EstimatorLanes {
    name: String,
    /// Of an estimator that states contact states.
    wheels: Option<[Lane; 3]>,
    trust: Lane,
    /// Its flags at the last record, if it had an estimate.
    flags: Option<Option<Flags>>,
    /// What its torques said of the weight.
    weight: Confirmation,
}

impl Events {
    /// Before the first record of a run. The first event names it.
    pub(crate) fn new(run: &RunDescription) -> Self {
        let lanes = |end: &str| WHEEL_NAMES.map(|name| Lane::new(format!("wheels/{name}{end}")));
        let estimators = run.estimators.iter().map(|e| EstimatorLanes {
            name: e.label.clone(),
            wheels: (e.settings.states_covariance()).then(|| lanes(&format!("/{}", e.label))),
            trust: Lane::new(format!("trust/{}", e.label)),
            flags: None,
            weight: Confirmation::Unconfirmed,
        });
        let stop = run.robot.robot.geometry.stop;
        let mut events = Self {
            detector: run.world.as_ref().map(|_| EventDetector::new(stop)),
            wheels: lanes(""),
            estimators: estimators.collect(),
            seen: [TRUSTED, NO_ESTIMATE].map(str::to_owned).into(),
            last_time: 0.0,
            events: Vec::new(),
        };
        let kind = if run.world.is_some() { "scene" } else { "log" };
        let text = format!("{kind} {}: {} s", run.name, run.record.duration);
        events.add(0.0, text, TextLogLevel::INFO, NEUTRAL);
        events
    }

    /// Logs the colours of the lanes.
    pub(crate) fn declare(&self, out: &mut Writer) -> Result {
        let truth = self.detector.as_ref().map(|_| &self.wheels);
        let estimated = self.estimators.iter().filter_map(|e| e.wheels.as_ref());
        for lanes in truth.into_iter().chain(estimated) {
            for (lane, colour) in lanes.iter().zip(WHEELS) {
                let states = [
                    (wheel_state(WheelState::Grips, false), CALM),
                    (wheel_state(WheelState::Slips, false), colour),
                    (wheel_state(WheelState::Grips, true), TWO_CONTACTS),
                    (wheel_state(WheelState::Slips, true), light(colour)),
                    (wheel_state(WheelState::InTheAir, false), ABSENT),
                ];
                let configuration = StateConfiguration::new()
                    .with_values(states.map(|(name, _)| name))
                    .with_colors(states.map(|(_, colour)| colour));
                out.constant(lane.entity.as_str(), &configuration)?;
            }
        }
        self.declare_trust(out)
    }

    /// Logs the colours of the lanes of estimators.
    fn declare_trust(&self, out: &mut Writer) -> Result {
        let colours = [CALM, ABSENT].into_iter().chain(std::iter::repeat(WARNING));
        let configuration = StateConfiguration::new()
            .with_values(self.seen.iter().map(String::as_str))
            .with_colors(colours.take(self.seen.len()));
        for estimator in &self.estimators {
            out.constant(estimator.trust.entity.as_str(), &configuration)?;
        }
        Ok(())
    }

    /// Detects the events of one record.
    pub(crate) fn sample(&mut self, frame: &Frame<'_>) {
        self.last_time = frame.time;
        if let Some(truth) = frame.truth {
            self.sample_robot(truth, frame.clearances.as_ref());
        }
        for (k, estimate) in frame.estimates.iter().enumerate() {
            if let Ok(estimate) = estimate {
                self.sample_contacts(k, frame.time, estimate);
                self.sample_weight(k, frame.time, estimate);
            }
            let flags = estimate.as_ref().ok().map(|e| e.flags);
            let before = self.estimators[k].flags.replace(flags);
            if before == Some(flags) {
                continue;
            }
            let state = match flags {
                None => NO_ESTIMATE.to_owned(),
                Some(flags) if flags.is_empty() => TRUSTED.to_owned(),
                Some(flags) => flags.names().collect::<Vec<_>>().join(", "),
            };
            self.estimators[k].trust.note(frame.time, &state);
            let (text, level) = match (before, estimate) {
                (_, Err(error)) => (format!("no estimate, {error}"), TextLogLevel::WARN),
                (_, Ok(e)) if !e.flags.is_empty() => {
                    let channels = faulty_channels(e).unwrap_or_default();
                    (format!("flags: {state}{channels}"), TextLogLevel::WARN)
                }
                (None, Ok(_)) => continue,
                (Some(None), Ok(_)) => ("estimates again".to_owned(), TextLogLevel::INFO),
                (Some(Some(_)), Ok(_)) => ("no flag any more".to_owned(), TextLogLevel::INFO),
            };
            let text = format!("{}: {text}", self.estimators[k].name);
            self.add(frame.time, text, level, by_index(k));
        }
    }

    /// Whether the torques confirm the described weight, where that changes.
    fn sample_weight(&mut self, k: usize, time: f64, estimate: &Estimate) {
        let scale = estimate.kalman.and_then(|k| k.torque_scale);
        let now = scale.map(|scale| scale.confirmation).unwrap_or_default();
        if std::mem::replace(&mut self.estimators[k].weight, now) == now {
            return;
        }
        let level = match now {
            Confirmation::Contradicts => TextLogLevel::WARN,
            Confirmation::Confirmed | Confirmation::Unconfirmed => TextLogLevel::INFO,
        };
        let text = format!("{}: weight {}", self.estimators[k].name, now.name());
        self.add(time, text, level, by_index(k));
    }

    /// Adds the results of the friction tests at their times, and the event of the end of the run.
    pub(crate) fn end(&mut self, end: Option<&RunEnd>) {
        for result in end.iter().flat_map(|end| &end.friction_tests) {
            let text = friction_tests::in_words(result);
            let colour = WHEELS[result.wheel];
            self.add(result.time, text, TextLogLevel::INFO, colour);
        }
        let broke_off = "the run broke off: this is its last record";
        let (text, level) = match end.is_some_and(RunEnd::is_complete) {
            true => ("end of the run", TextLogLevel::INFO),
            false => (broke_off, TextLogLevel::ERROR),
        };
        self.add(self.last_time, text.to_owned(), level, NEUTRAL);
        // The results are known at the end alone.
        self.events.sort_by(|a, b| a.time.total_cmp(&b.time));
    }

    /// Logs the events and changes since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result {
        let events = std::mem::take(&mut self.events);
        let times: Vec<f64> = events.iter().map(|e| e.time).collect();
        let columns = TextLog::update_fields()
            .with_many_text(events.iter().map(|e| e.text.as_str()))
            .with_many_level(events.iter().map(|e| e.level))
            .with_many_color(events.iter().map(|e| e.colour));
        out.columns("events", &times, columns.columns_of_unit_batches())?;

        let before = self.seen.len();
        for state in self.estimators.iter().flat_map(|e| &e.trust.states) {
            if !self.seen.contains(state) {
                self.seen.push(state.clone());
            }
        }
        if self.seen.len() > before {
            self.declare_trust(out)?;
        }
        let lanes = self.estimators.iter_mut();
        let lanes = lanes.flat_map(|e| e.wheels.iter_mut().flatten().chain([&mut e.trust]));
        (self.wheels.iter_mut().chain(lanes)).try_for_each(|lane| lane.flush(out))
    }

    fn add(&mut self, time: f64, text: String, level: &'static str, colour: Color) {
        self.events.push(Event {
            time,
            text,
            level,
            colour,
        });
    }

    fn sample_contacts(&mut self, estimator: usize, time: f64, estimate: &Estimate) {
        let lanes = self.estimators[estimator].wheels.iter_mut().flatten();
        for (lane, contact) in lanes.zip(estimate.kalman.iter().flat_map(|k| &k.contact)) {
            let state = match (contact.state, contact.sliding) {
                (ContactState::InAir, _) => WheelState::InTheAir,
                (_, false) => WheelState::Grips,
                (_, true) => WheelState::Slips,
            };
            let two_contacts = contact.state == ContactState::TwoContacts;
            lane.note(time, wheel_state(state, two_contacts));
        }
    }

    fn sample_robot(&mut self, truth: &Truth, clearances: Option<&Clearances>) {
        let Some(detector) = &mut self.detector else {
            return;
        };
        let mut events = Vec::new();
        detector.sample(truth, clearances, &mut |event| events.push(event));
        for (i, lane) in self.wheels.iter_mut().enumerate() {
            if let Some(state) = detector.wheel(i) {
                let two_contacts = truth.wheels[i].contacts > 1;
                lane.note(truth.time, wheel_state(state, two_contacts));
            }
        }
        for event in events {
            let (text, level, colour) = message(&event, truth);
            self.add(event.time, text, level, colour);
        }
    }
}

/// The message about a detected event, its severity and its colour.
fn message(event: &events::Event, truth: &Truth) -> (String, &'static str, Color) {
    let (info, warn) = (TextLogLevel::INFO, TextLogLevel::WARN);
    let wheel = |i: usize, what: &str, level| {
        let x = rounded(truth.wheels[i].position.x, 1e3);
        let text = format!("{} wheel {what} at x = {x:.3} m", WHEEL_NAMES[i]);
        (text, level, WHEELS[i])
    };
    let stop = |what: &str, stop: events::EndStop, angle: f64, level| {
        let (stop, angle) = (stop.name(), rounded(angle.to_degrees(), 10.0));
        let text = format!("pin Q {what} its {stop} stop: theta1 - theta2 = {angle:.1} deg");
        (text, level, NEUTRAL)
    };
    let bar = |bar: robhaz_model::Bar, what: &str, level| {
        let x = rounded(truth.bar(bar).position.x, 1e3);
        let name = bar.name();
        let text = format!("{name} {what}, with its centre of mass at x = {x:.3} m");
        (text, level, NEUTRAL)
    };
    match event.kind {
        EventKind::ContactLost(i) => wheel(i, "leaves the ground", warn),
        EventKind::ContactRegained(i) => wheel(i, "touches the ground again", info),
        EventKind::TwoContacts(i) => wheel(i, "touches at two places", info),
        EventKind::OneContact(i) => wheel(i, "touches at one place again", info),
        EventKind::Spins(i) => wheel(i, "starts to spin", warn),
        EventKind::Slides(i) => wheel(i, "starts to slide", warn),
        EventKind::Grips(i) => wheel(i, "grips again", info),
        EventKind::StopReached(which, angle) => stop("reaches", which, angle, warn),
        EventKind::StopLeft(which, angle) => stop("leaves", which, angle, info),
        EventKind::BarTouches(which) => {
            let what = "touches the ground, whose force on it is not modelled";
            bar(which, what, TextLogLevel::ERROR)
        }
        EventKind::BarClear(which) => bar(which, "is clear of the ground again", info),
    }
}

/// The channels whose readings contradict others, in words.
fn faulty_channels(estimate: &Estimate) -> Option<String> {
    let names: Vec<&str> = estimate.kalman?.health.faulty.names().collect();
    (!names.is_empty()).then(|| format!(" ({})", names.join(", ")))
}

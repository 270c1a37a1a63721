//! What happens at one instant, found by comparing each record with the one before.

use crate::colours::{Colour, NEUTRAL, WHEELS, by_place};
use crate::series::WHEEL_NAMES;
use rerun::components::TextLogLevel;
use robhaz_estimator::{Estimate, EstimateError, Flags};
use robhaz_model::PinStop;
use robhaz_run::Frame;
use robhaz_scene::Scene;
use robhaz_sim::{Truth, WheelTruth};

/// A line of text at its time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    /// When, s.
    pub(crate) time: f64,
    /// What.
    pub(crate) text: String,
    /// How grave, in the viewer's words.
    pub(crate) level: &'static str,
    /// Colour of what it happens to.
    pub(crate) colour: Colour,
}

/// What a wheel does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WheelState {
    /// It touches and keeps below the slip speed of the static coefficient.
    Grips,
    /// It touches and slips faster.
    Slips,
    /// It touches nothing.
    InTheAir,
}

impl WheelState {
    /// All states.
    pub(crate) const ALL: [Self; 3] = [Self::Grips, Self::Slips, Self::InTheAir];

    /// Its name in the recording.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Grips => "grips",
            Self::Slips => "slips",
            Self::InTheAir => "in the air",
        }
    }
}

/// What an estimator says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Confidence {
    /// An estimate, with the reasons to trust it less, if any.
    Estimates(Flags),
    /// No estimate.
    Refuses,
}

impl Confidence {
    /// Its name in the recording.
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

/// A lane that takes another state from a time (s) on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Change<S> {
    /// When, s.
    pub(crate) time: f64,
    /// Which wheel or estimator, by its place.
    pub(crate) place: usize,
    /// The state from now on.
    pub(crate) state: S,
}

/// What was found and is not logged yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    /// Lines of text.
    pub(crate) events: Vec<Event>,
    /// States of wheels.
    pub(crate) wheels: Vec<Change<WheelState>>,
    /// States of estimators.
    pub(crate) estimators: Vec<Change<Confidence>>,
}

impl Found {
    /// Adds what was found later.
    pub(crate) fn append(&mut self, mut later: Self) {
        self.events.append(&mut later.events);
        self.wheels.append(&mut later.wheels);
        self.estimators.append(&mut later.estimators);
    }

    /// Nothing was found.
    pub(crate) fn is_empty(&self) -> bool {
        self.events.is_empty() && self.wheels.is_empty() && self.estimators.is_empty()
    }
}

/// Finds events.
pub(crate) struct Watch {
    names: Vec<String>,
    stop: PinStop,
    /// Slip speed of the static coefficient, m/s.
    v_s: f64,
    contacts: [u32; 3],
    wheels: [Option<WheelState>; 3],
    on_stop: bool,
    confidence: Vec<Option<Confidence>>,
    last_time: f64,
    found: Found,
}

impl Watch {
    /// Nothing has happened: wheels on the ground, stops free, estimators at work.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut watch = Self {
            names: scene.estimators.iter().map(|e| e.name.clone()).collect(),
            stop: scene.robot.robot.geometry.stop,
            v_s: scene.friction.v_s,
            contacts: [1; 3],
            wheels: [None; 3],
            on_stop: false,
            confidence: vec![None; scene.estimators.len()],
            last_time: 0.0,
            found: Found::default(),
        };
        let text = format!("scene {}: {} s", scene.name, scene.record.duration);
        watch.add(0.0, text, TextLogLevel::INFO, NEUTRAL);
        watch
    }

    /// Looks at one record.
    pub(crate) fn look(&mut self, frame: &Frame<'_>) {
        self.last_time = frame.truth.time;
        self.look_at_contacts(frame.truth);
        self.look_at_stops(frame.truth);
        self.look_at_estimates(frame);
    }

    /// The run has ended, or broken off.
    pub(crate) fn end(&mut self, complete: bool) {
        let (text, level) = if complete {
            ("end of the run", TextLogLevel::INFO)
        } else {
            (
                "the run broke off: this is its last record",
                TextLogLevel::ERROR,
            )
        };
        self.add(self.last_time, text.to_owned(), level, NEUTRAL);
    }

    /// Hands over what was found since the last time.
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

    fn look_at_contacts(&mut self, truth: &Truth) {
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let contacts = std::mem::replace(&mut self.contacts[i], wheel.contacts);
            let what = match (contacts, wheel.contacts) {
                (before, now) if before == now => None,
                (_, 0) => Some(("leaves the ground", TextLogLevel::WARN)),
                (0, _) => Some(("touches the ground again", TextLogLevel::INFO)),
                (_, 1) => Some(("touches at one place again", TextLogLevel::INFO)),
                _ => Some(("touches at two places", TextLogLevel::INFO)),
            };
            if let Some((what, level)) = what {
                self.tell_of_wheel(truth.time, i, what, level, wheel);
            }
            self.look_at_slip(truth.time, i, wheel);
        }
    }

    fn look_at_slip(&mut self, time: f64, i: usize, wheel: &WheelTruth) {
        let before = self.wheels[i];
        let slips = if before == Some(WheelState::Slips) {
            // It grips again when it is well below: a wheel at the limit is told of once.
            wheel.slip_speed.abs() > 0.5 * self.v_s
        } else {
            wheel.slip_speed.abs() > self.v_s
        };
        let state = match (wheel.contacts, slips) {
            (0, _) => WheelState::InTheAir,
            (_, true) => WheelState::Slips,
            (_, false) => WheelState::Grips,
        };
        if before == Some(state) {
            return;
        }
        self.wheels[i] = Some(state);
        let change = Change {
            time,
            place: i,
            state,
        };
        self.found.wheels.push(change);
        match (before, state) {
            (_, WheelState::Slips) => {
                let what = if wheel.slip_speed > 0.0 {
                    "starts to spin"
                } else {
                    "starts to slide"
                };
                self.tell_of_wheel(time, i, what, TextLogLevel::WARN, wheel);
            }
            (Some(WheelState::Slips), WheelState::Grips) => {
                self.tell_of_wheel(time, i, "grips again", TextLogLevel::INFO, wheel);
            }
            _ => {}
        }
    }

    fn tell_of_wheel(
        &mut self,
        time: f64,
        i: usize,
        what: &str,
        level: &'static str,
        wheel: &WheelTruth,
    ) {
        let x = rounded(wheel.position.x, 1e3);
        let text = format!("{} wheel {what} at x = {x:.3} m", WHEEL_NAMES[i]);
        self.add(time, text, level, WHEELS[i]);
    }

    fn look_at_stops(&mut self, truth: &Truth) {
        let on_stop = truth.stop_torque.abs() > 0.0;
        if std::mem::replace(&mut self.on_stop, on_stop) == on_stop {
            return;
        }
        let angle = truth.links[0].angle - truth.links[1].angle;
        let (what, level) = if on_stop {
            ("reaches", TextLogLevel::WARN)
        } else {
            ("leaves", TextLogLevel::INFO)
        };
        let text = format!(
            "pin Q {what} its {} stop: theta1 - theta2 = {:.1} deg",
            nearest_stop(&self.stop, angle),
            rounded(angle.to_degrees(), 10.0)
        );
        self.add(truth.time, text, level, NEUTRAL);
    }

    fn look_at_estimates(&mut self, frame: &Frame<'_>) {
        for (k, estimate) in frame.estimates.iter().enumerate() {
            let now = Confidence::of(estimate);
            let before = self.confidence[k].replace(now);
            if before == Some(now) {
                continue;
            }
            self.found.estimators.push(Change {
                time: frame.truth.time,
                place: k,
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
                (_, Ok(_)) => Some((format!("flags: {}", now.name()), TextLogLevel::WARN)),
            };
            if let Some((what, level)) = what {
                let text = format!("{}: {what}", self.names[k]);
                self.add(frame.truth.time, text, level, by_place(k));
            }
        }
    }
}

/// The stop that an angle theta_1 - theta_2 (rad) is nearer to.
pub(crate) fn nearest_stop(stop: &PinStop, angle: f64) -> &'static str {
    if (angle - stop.upper).abs() < (angle - stop.lower).abs() {
        "upper"
    } else {
        "lower"
    }
}

/// A value rounded to a fraction of its unit; never "-0".
fn rounded(value: f64, fractions: f64) -> f64 {
    (value * fractions).round() / fractions + 0.0
}

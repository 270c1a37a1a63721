//! What happens at one instant, as lines of text at their time.

use crate::ViewerError;
use crate::colours::{Colour, NEUTRAL, WHEELS};
use crate::rrd::RrdWriter;
use crate::series::WHEEL_NAMES;
use re_sdk_types::archetypes::TextLog;
use re_sdk_types::components::TextLogLevel;
use robhaz_model::PinStop;
use robhaz_run::Frame;
use robhaz_scene::Scene;
use robhaz_sim::Truth;

struct Event {
    time: f64,
    text: String,
    level: &'static str,
    colour: Colour,
}

/// Finds events by comparing each record with the one before.
pub(crate) struct Events {
    names: Vec<String>,
    stop: PinStop,
    contacts: [u32; 3],
    on_stop: bool,
    refusing: Vec<bool>,
    last_time: f64,
    found: Vec<Event>,
}

impl Events {
    /// Nothing has happened: wheels on the ground, stops free, estimators at work.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut events = Self {
            names: scene.estimators.iter().map(|e| e.name.clone()).collect(),
            stop: scene.robot.robot.geometry.stop,
            contacts: [1; 3],
            on_stop: false,
            refusing: vec![false; scene.estimators.len()],
            last_time: 0.0,
            found: Vec::new(),
        };
        let text = format!("scene {}: {} s", scene.name, scene.record.duration);
        events.add(0.0, text, TextLogLevel::INFO, NEUTRAL);
        events
    }

    /// Looks at one record.
    pub(crate) fn push(&mut self, frame: &Frame<'_>) {
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

    /// Logs what was found since the last time.
    pub(crate) fn flush(&mut self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let found = std::mem::take(&mut self.found);
        let times: Vec<f64> = found.iter().map(|e| e.time).collect();
        let columns = TextLog::update_fields()
            .with_many_text(found.iter().map(|e| e.text.as_str()))
            .with_many_level(found.iter().map(|e| e.level))
            .with_many_color(found.iter().map(|e| e.colour));
        out.columns("events", &times, columns.columns_of_unit_batches())
    }

    fn add(&mut self, time: f64, text: String, level: &'static str, colour: Colour) {
        self.found.push(Event {
            time,
            text,
            level,
            colour,
        });
    }

    fn look_at_contacts(&mut self, truth: &Truth) {
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let before = std::mem::replace(&mut self.contacts[i], wheel.contacts);
            let (what, level) = match (before, wheel.contacts) {
                (before, now) if before == now => continue,
                (_, 0) => ("leaves the ground", TextLogLevel::WARN),
                (0, _) => ("touches the ground again", TextLogLevel::INFO),
                (_, 1) => ("touches at one place again", TextLogLevel::INFO),
                _ => ("touches at two places", TextLogLevel::INFO),
            };
            let text = format!(
                "{} wheel {what} at x = {:.3} m",
                WHEEL_NAMES[i],
                rounded(wheel.position.x, 1e3)
            );
            self.add(truth.time, text, level, WHEELS[i]);
        }
    }

    fn look_at_stops(&mut self, truth: &Truth) {
        let on_stop = truth.stop_torque.abs() > 0.0;
        if std::mem::replace(&mut self.on_stop, on_stop) == on_stop {
            return;
        }
        let angle = truth.links[0].angle - truth.links[1].angle;
        let upper = (angle - self.stop.upper).abs() < (angle - self.stop.lower).abs();
        let which = if upper { "upper" } else { "lower" };
        let (what, level) = if on_stop {
            ("reaches", TextLogLevel::WARN)
        } else {
            ("leaves", TextLogLevel::INFO)
        };
        let text = format!(
            "pin Q {what} its {which} stop: theta1 - theta2 = {:.1} deg",
            rounded(angle.to_degrees(), 10.0)
        );
        self.add(truth.time, text, level, NEUTRAL);
    }

    fn look_at_estimates(&mut self, frame: &Frame<'_>) {
        for (k, estimate) in frame.estimates.iter().enumerate() {
            let before = std::mem::replace(&mut self.refusing[k], estimate.is_err());
            let (text, level) = match (before, estimate) {
                (false, Err(error)) => (
                    format!("{}: no estimate, {error}", self.names[k]),
                    TextLogLevel::WARN,
                ),
                (true, Ok(_)) => (
                    format!("{}: estimates again", self.names[k]),
                    TextLogLevel::INFO,
                ),
                _ => continue,
            };
            self.add(frame.truth.time, text, level, NEUTRAL);
        }
    }
}

/// A value rounded to a fraction of its unit; never "-0".
fn rounded(value: f64, fractions: f64) -> f64 {
    (value * fractions).round() / fractions + 0.0
}

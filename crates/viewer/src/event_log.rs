//! Events as messages, and lanes with the state of each wheel and estimator over time.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS};
use crate::events::{Change, Confidence, Found, WheelLane};
use crate::series::WHEEL_NAMES;
use crate::writer::Writer;
use rerun::archetypes::{StateChange, StateConfiguration, TextLog};
use robhaz_estimator::Flags;
use robhaz_run::RunDescription;

/// A normal state, drawn inconspicuously.
const CALM: Colour = Colour([0x30, 0x30, 0x30]);
/// A state with flags.
const WARNING: Colour = Colour([0xE6, 0x9F, 0x00]);
/// Two contacts.
const TWO_CONTACTS: Colour = Colour([0x80, 0x80, 0x80]);
/// No contact, or no estimate.
const ABSENT: Colour = Colour([0xF0, 0xF0, 0xF0]);

/// Logs events and state changes.
pub(crate) struct EventLog {
    /// Whether the states of the wheels are known.
    has_truth: bool,
    names: Vec<String>,
    /// Which estimators state contact states.
    states_contacts: Vec<bool>,
    /// Names of the states of estimators so far. The viewer needs a colour for each.
    seen: Vec<String>,
}

impl EventLog {
    /// The log of a run.
    pub(crate) fn new(run: &RunDescription) -> Self {
        Self {
            has_truth: run.world.is_some(),
            names: run.estimators.iter().map(|e| e.label.clone()).collect(),
            states_contacts: run
                .estimators
                .iter()
                .map(|e| e.settings.states_contacts())
                .collect(),
            seen: [Confidence::Estimates(Flags::default()), Confidence::Refuses]
                .map(Confidence::name)
                .into(),
        }
    }

    /// Logs the colours of the lanes.
    pub(crate) fn declare(&self, out: &mut Writer) -> Result<(), ViewerError> {
        self.declare_wheels(out)?;
        self.declare_estimators(out)
    }

    /// Logs events and changes of states.
    pub(crate) fn log(&mut self, found: Found, out: &mut Writer) -> Result<(), ViewerError> {
        let times: Vec<f64> = found.events.iter().map(|e| e.time).collect();
        let columns = TextLog::update_fields()
            .with_many_text(found.events.iter().map(|e| e.text.as_str()))
            .with_many_level(found.events.iter().map(|e| e.level))
            .with_many_color(found.events.iter().map(|e| e.colour));
        out.columns("events", &times, columns.columns_of_unit_batches())?;

        for (i, wheel) in WHEEL_NAMES.iter().enumerate() {
            let lane = format!("wheels/{wheel}");
            log_lane(&lane, i, &found.wheels, out, |s| s.name().to_owned())?;
            for k in self.with_contacts() {
                let lane = format!("{lane}/{}", self.names[k]);
                let index = 3 * k + i;
                log_lane(&lane, index, &found.contacts, out, |s| s.name().to_owned())?;
            }
        }
        let before = self.seen.len();
        for name in found.estimators.iter().map(|c| c.state.name()) {
            if !self.seen.contains(&name) {
                self.seen.push(name);
            }
        }
        if self.seen.len() > before {
            self.declare_estimators(out)?;
        }
        for (k, name) in self.names.iter().enumerate() {
            log_lane(
                &format!("trust/{name}"),
                k,
                &found.estimators,
                out,
                Confidence::name,
            )?;
        }
        Ok(())
    }

    /// Indices of the estimators that state contact states.
    fn with_contacts(&self) -> impl Iterator<Item = usize> {
        let stated = self.states_contacts.iter().enumerate();
        stated.filter(|(_, states)| **states).map(|(k, _)| k)
    }

    /// Logs the colours of the lanes of the wheels: true states, and those of each estimator that states them.
    fn declare_wheels(&self, out: &mut Writer) -> Result<(), ViewerError> {
        for (i, wheel) in WHEEL_NAMES.iter().enumerate() {
            let lane = format!("wheels/{wheel}");
            if self.has_truth {
                declare_wheel(out, &lane, i)?;
            }
            for k in self.with_contacts() {
                declare_wheel(out, &format!("{lane}/{}", self.names[k]), i)?;
            }
        }
        Ok(())
    }

    /// Logs the colours of the lanes of estimators.
    fn declare_estimators(&self, out: &mut Writer) -> Result<(), ViewerError> {
        let colours = self.seen.iter().enumerate().map(|(i, _)| match i {
            0 => CALM,
            1 => ABSENT,
            _ => WARNING,
        });
        let configuration = StateConfiguration::new()
            .with_values(self.seen.iter().map(String::as_str))
            .with_colors(colours);
        for name in &self.names {
            out.constant(format!("trust/{name}"), &configuration)?;
        }
        Ok(())
    }
}

/// Logs the colours of a lane of the wheel with an index.
fn declare_wheel(out: &mut Writer, lane: &str, wheel: usize) -> Result<(), ViewerError> {
    let colour = |state: WheelLane| match state {
        WheelLane::Grips => CALM,
        WheelLane::Slips => WHEELS[wheel],
        WheelLane::TwoContacts => TWO_CONTACTS,
        WheelLane::TwoContactsSlips => WHEELS[wheel].light(),
        WheelLane::InTheAir => ABSENT,
    };
    out.constant(
        lane,
        &StateConfiguration::new()
            .with_values(WheelLane::ALL.map(WheelLane::name))
            .with_colors(WheelLane::ALL.map(colour)),
    )
}

/// Logs the changes of the wheel or estimator with an index.
fn log_lane<S: Copy>(
    lane: &str,
    index: usize,
    changes: &[Change<S>],
    out: &mut Writer,
    name: impl Fn(S) -> String,
) -> Result<(), ViewerError> {
    let of_lane = || changes.iter().filter(|c| c.index == index);
    let times: Vec<f64> = of_lane().map(|c| c.time).collect();
    let columns = StateChange::update_fields().with_state(of_lane().map(|c| name(c.state)));
    out.columns(lane, &times, columns.columns_of_unit_batches())
}

//! The control of any kind.

use crate::input::{ControlInput, ControlSettings};
use crate::kind::ControlKind;
use crate::shared::Shared;
use robhaz_model::WheelCommand;

/// A control with its state from sample to sample.
#[derive(Clone, Debug)]
pub struct Controller {
    state: State,
}

#[derive(Clone, Debug)]
enum State {
    Speed,
    Shared(Shared),
}

impl Controller {
    /// A control before its first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        Self {
            state: match settings.kind {
                ControlKind::Speed => State::Speed,
                ControlKind::Shared => State::Shared(Shared::new(settings)),
            },
        }
    }

    /// The commands of front, middle and rear wheel, from the next sample on.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        match &mut self.state {
            State::Speed => [WheelCommand::Planned; 3],
            State::Shared(shared) => shared.update(input).map(WheelCommand::Torque),
        }
    }
}

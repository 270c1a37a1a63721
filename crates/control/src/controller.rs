//! The control of any kind.

use crate::friction_test::{FrictionTestResult, FrictionTests};
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
#[expect(
    clippy::large_enum_variant,
    reason = "one control, one state: nothing is boxed without an allocator"
)]
enum State {
    Speed,
    Shared(Shared),
    FrictionTest(FrictionTests),
}

impl Controller {
    /// A control before its first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        Self {
            state: match settings.kind {
                ControlKind::Speed => State::Speed,
                ControlKind::Shared => State::Shared(Shared::new(settings)),
                ControlKind::FrictionTest => State::FrictionTest(FrictionTests::new(settings)),
            },
        }
    }

    /// The commands of front, middle and rear wheel, from the next sample on.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        match &mut self.state {
            State::Speed => [WheelCommand::Planned; 3],
            State::Shared(shared) => shared.update(input).map(WheelCommand::Torque),
            State::FrictionTest(tests) => tests.update(input),
        }
    }

    /// Results of the friction tests so far, in their order; those of other kinds have none.
    pub fn friction_tests(&self) -> [Option<FrictionTestResult>; 3] {
        match &self.state {
            State::FrictionTest(tests) => tests.results(),
            State::Speed | State::Shared(_) => [None; 3],
        }
    }
}

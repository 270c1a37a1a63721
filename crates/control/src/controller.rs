//! The control of any kind.

use crate::friction_test::{FrictionTestResult, FrictionTests};
use crate::input::{ControlInput, ControlKind, ControlSettings, ControlSettingsError};
use crate::shared::Shared;
use robhaz_model::WheelCommand;

/// A control with its state from sample to sample.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one control, one state: nothing is boxed without an allocator"
)]
pub enum Controller {
    /// [`ControlKind::Speed`]
    Speed,
    /// [`ControlKind::Shared`]
    Shared(Shared),
    /// [`ControlKind::FrictionTest`]
    FrictionTest(FrictionTests),
}

impl Controller {
    /// A control before its first sample.
    ///
    /// # Errors
    /// As [`ControlSettings::check`].
    pub fn new(settings: &ControlSettings) -> Result<Self, ControlSettingsError> {
        settings.check()?;
        Ok(match settings.kind {
            ControlKind::Speed => Self::Speed,
            ControlKind::Shared => Self::Shared(Shared::new(settings)),
            ControlKind::FrictionTest => Self::FrictionTest(FrictionTests::new(settings)),
        })
    }

    /// The commands of front, middle and rear wheel, from the next sample on.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        match self {
            Self::Speed => [WheelCommand::Planned; 3],
            Self::Shared(shared) => shared.update(input).map(WheelCommand::Torque),
            Self::FrictionTest(tests) => tests.update(input),
        }
    }

    /// Results of the friction tests so far, in their order; those of other kinds have none.
    pub fn friction_tests(&self) -> [Option<FrictionTestResult>; 3] {
        match self {
            Self::FrictionTest(tests) => tests.results(),
            Self::Speed | Self::Shared(_) => [None; 3],
        }
    }
}

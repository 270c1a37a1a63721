//! The kinds of control.

use robhaz_model::named;

named! {
    /// Kind of control of the wheels.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ControlKind {
        /// Every drive follows its own plan with its continuous PI control. It needs no readings.
        #[default]
        Speed = "speed",
        /// One speed control, its torque shared so that every wheel needs the same T/N:
        /// [`crate::shared`].
        Shared = "shared",
        /// Torque ramps on one wheel after the other, which find mu_max: [`crate::friction_test`].
        FrictionTest = "friction-test",
    }
}

impl ControlKind {
    /// Whether its commands depend on readings and estimates.
    pub const fn is_closed_loop(self) -> bool {
        match self {
            Self::Speed => false,
            Self::Shared | Self::FrictionTest => true,
        }
    }
}

//! The kinds of control.

/// Kind of control of the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControlKind {
    /// Every drive follows its own plan with its continuous PI control. It needs no readings.
    #[default]
    Speed,
    /// One speed control, its torque shared so that every wheel needs the same T/N: [`crate::shared`].
    Shared,
    /// Torque ramps on one wheel after the other, which find mu_max: [`crate::friction_test`].
    FrictionTest,
}

impl ControlKind {
    /// All kinds, in the order of the enum.
    pub const ALL: [Self; 3] = [Self::Speed, Self::Shared, Self::FrictionTest];

    /// Name in scene files and summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Shared => "shared",
            Self::FrictionTest => "friction-test",
        }
    }

    /// Whether its commands depend on readings and estimates.
    pub const fn is_closed_loop(self) -> bool {
        match self {
            Self::Speed => false,
            Self::Shared | Self::FrictionTest => true,
        }
    }
}

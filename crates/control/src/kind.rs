//! The kinds of control.

/// Kind of control of the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControlKind {
    /// Every drive follows its own plan with its continuous PI control. It needs no readings.
    #[default]
    Speed,
    /// One speed control, its torque shared so that every wheel needs the same T/N: [`crate::shared`].
    Shared,
}

impl ControlKind {
    /// All kinds, in the order of the enum.
    pub const ALL: [Self; 2] = [Self::Speed, Self::Shared];

    /// Name in scene files and summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Shared => "shared",
        }
    }

    /// Whether its commands depend on readings and estimates.
    pub const fn is_closed_loop(self) -> bool {
        match self {
            Self::Speed => false,
            Self::Shared => true,
        }
    }
}

//! Contact state of a wheel: in the air, one contact, two contacts; and whether it slides.

/// How many contacts a wheel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactState {
    /// It does not touch the ground.
    InAir,
    /// It touches the ground at one place.
    #[default]
    OneContact,
    /// It touches the ground at two places: riser and tread, or both sides of a concave corner.
    TwoContacts,
}

/// Estimated contact state of a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactEstimate {
    /// How many contacts it has.
    pub state: ContactState,
    /// Whether it slides: its slip is beyond creep. Always `false` in the air.
    pub sliding: bool,
    /// Slip speed, m/s: the rim's speed less that of the wheel's centre along the ground, positive
    /// when the rim outruns the ground. Creep counts. 0 in the air, and before the wheel's speed is
    /// known.
    pub slip: f64,
}

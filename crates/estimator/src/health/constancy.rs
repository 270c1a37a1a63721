//! Torques that never change though their wheel turns.

/// How long a torque has been the same to the bit while it should vary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Constancy {
    /// Last reading, N m.
    last: f64,
    /// s
    pub time: f64,
}

impl Constancy {
    /// Time from which on a torque is stuck, s. Quantisation alone does not repeat a reading for so
    /// long: the torque of a wheel that rolls on real ground changes.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    pub const LONGEST: f64 = 1.0;

    /// Takes a reading, `dt` (s) after the last; a missing one does not count.
    pub fn update(&mut self, torque: Option<f64>, dt: f64) {
        let Some(value) = torque else {
            return;
        };
        if value.to_bits() == self.last.to_bits() {
            self.time = (self.time + dt).min(2.0 * Self::LONGEST);
        } else {
            self.time = 0.0;
        }
        self.last = value;
    }
}

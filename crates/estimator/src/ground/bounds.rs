//! Bounds of the friction at a place.

/// Bounds of the available friction mu_max at a place, each two standard deviations away from what
/// was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionBounds {
    /// mu_max is at least this: the largest |T/N| that a wheel has borne there without slip. 0
    /// where nothing was borne.
    pub at_least: f64,
    /// mu_max is at most this: a wheel began to slip there. `None` where none has.
    pub at_most: Option<f64>,
}

/// The bounds as they are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StoredBounds {
    at_least: f64,
    at_most: f64,
    /// Whether a wheel began to slip there.
    slipped: bool,
}

impl StoredBounds {
    /// A wheel began to slip between the two.
    pub fn measured(at_least: f64, at_most: f64) -> Self {
        Self {
            at_least: at_least.max(0.0),
            at_most,
            slipped: true,
        }
    }

    /// A wheel has borne `bound` without slip.
    pub fn hold(&mut self, bound: f64) {
        self.at_least = self.at_least.max(bound);
    }

    /// For a user.
    pub fn bounds(&self) -> FrictionBounds {
        FrictionBounds {
            at_least: self.at_least,
            at_most: self.slipped.then_some(self.at_most),
        }
    }
}

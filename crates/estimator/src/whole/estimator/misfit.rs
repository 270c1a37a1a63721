//! Whether the readings of the last way contradict the nine equations.

use crate::whole::WholeEstimate;

/// Mean of the misfit over the last way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanMisfit {
    mean: f64,
    /// How far the wheels have turned, rad, at most [`WholeEstimate::LONGEST_WAY`].
    rolled: f64,
}

impl MeanMisfit {
    /// Takes the `misfit` of a sample since whose last one the wheels have turned by `turn`, rad. Returns whether
    /// the mean is beyond what correct readings have.
    pub fn take(&mut self, misfit: f64, turn: f64) -> bool {
        self.rolled = (self.rolled + turn).min(WholeEstimate::LONGEST_WAY);
        if turn > 0.0 {
            self.mean += turn / self.rolled.max(turn) * (misfit - self.mean);
        }
        self.rolled > WholeEstimate::INDEPENDENT
            && self.mean > WholeEstimate::largest_misfit(self.rolled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: with the misfit of 3 that is right nothing contradicts; with three times the limit of a long way
    /// all does, once the wheels have turned by [`WholeEstimate::INDEPENDENT`] and the limit of that way, 21, is
    /// passed, and a limit's way after the misfit has become right nothing does any more.
    #[test]
    fn a_lasting_misfit_contradicts() {
        let mut mean = MeanMisfit::default();
        let mut run =
            |misfit: f64, turns: u32| (0..turns).fold(false, |_, _| mean.take(misfit, 0.01));
        assert!(!run(3.0, 10_000));
        assert!(run(22.0, 2_000));
        assert!(!run(3.0, 8_000));
    }
}

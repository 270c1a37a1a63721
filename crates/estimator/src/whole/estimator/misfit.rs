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
            let misfit = misfit.min(WholeEstimate::LARGEST_MISFIT);
            self.mean += turn / self.rolled.max(turn) * (misfit - self.mean);
        }
        self.rolled > WholeEstimate::INDEPENDENT
            && self.mean > WholeEstimate::largest_misfit(self.rolled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: with the misfit of 3 that is right nothing contradicts; one of 22 does, beyond the limit of a long way,
    /// until the mean has fallen below that limit again; none of less than [`WholeEstimate::INDEPENDENT`] does. An outlier
    /// counts 75 at most.
    #[test]
    fn a_misfit_over_a_long_way_contradicts() {
        let mut mean = MeanMisfit::default();
        let mut run =
            |misfit: f64, turns: u32| (0..turns).fold(false, |_, _| mean.take(misfit, 0.01));
        assert!(!run(3.0, 10_000));
        assert!(run(22.0, 2_000));
        assert!(!run(3.0, 20_000));
        assert!(!run(1e9, 200));
        let mut mean = MeanMisfit::default();
        assert!(!mean.take(30.0, 4.9));
        assert!(mean.take(30.0, 0.2));
    }
}

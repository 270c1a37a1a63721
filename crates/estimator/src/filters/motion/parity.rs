//! The parity residual as a pseudo-measurement of zero.

use super::filter::{INPUTS, MotionFilter};
use super::tuning::TUNING;
use crate::deviation::GATE;
use crate::filters::Innovation;
use crate::statics::input;

/// The parity residual of eq. (8) at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityResidual {
    /// N.
    pub value: f64,
    /// Derivatives with respect to the uncertain inputs, in the order of [`input`].
    pub gradient: [f64; input::COUNT],
    /// Variance at this sample from everything but the inputs, N^2.
    pub variance: f64,
}

/// Result of the test of a parity residual against its predicted standard deviation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityCheck {
    /// Zero minus the residual, N, and its predicted variance before the correction, N^2.
    pub innovation: Innovation,
    /// Whether the residual lies within its gate. An outlier shows an impact, or an external load
    /// on the robot.
    pub within_gate: bool,
    /// Whether it has corrected the states.
    pub corrected: bool,
}

impl MotionFilter {
    /// Tests a parity residual z against its predicted standard deviation sigma and, with
    /// `correct`, corrects the states by it. `dt` is the time since the last sample, s.
    ///
    /// The variance of the unmodelled load becomes the larger of its decayed old value and
    /// `z^2 - (2 sigma)^2`, N^2; sigma is that without unmodelled load. A residual beyond the gate
    /// is an impact.
    pub fn check_parity(
        &mut self,
        residual: &ParityResidual,
        dt: f64,
        correct: bool,
    ) -> ParityCheck {
        let square = residual.value * residual.value;
        let h: [_; input::COUNT] = core::array::from_fn(|k| (INPUTS + k, residual.gradient[k]));
        let projection = self.filter.project(&h);
        let innovation = Innovation {
            value: -residual.value,
            variance: projection.variance + residual.variance,
        };

        let explained = TUNING.modelled * TUNING.modelled * innovation.variance;
        let gate = GATE * GATE * innovation.variance;
        let excess = square - explained;
        self.unmodelled_load = self.unmodelled_load.max(excess);
        // True at a residual beyond the gate, and afterwards until the variance has decayed below
        // this bound.
        if self.unmodelled_load > gate - explained {
            self.impact = TUNING.impact_time;
        }
        let within_gate = square <= gate;
        let corrected = correct && within_gate;
        if corrected {
            // Correlated errors enter as the equivalent white noise, with at least the variance of
            // this sample.
            let correlated = (residual.variance + self.unmodelled_load)
                * (2.0 * TUNING.filter_time / dt).max(1.0);
            self.correct(&projection, -residual.value, correlated, f64::INFINITY);
        }
        ParityCheck {
            innovation,
            within_gate,
            corrected,
        }
    }
}

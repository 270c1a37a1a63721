//! The parity residual as a measurement: it should be zero.

use super::filter::MotionFilter;
use super::states::{CONSIDERED, COUNT, INPUTS};
use super::tuning::TUNING;
use crate::filters::{Innovation, Kalman};
use crate::statics::input;

/// The parity residual of eq. (8) at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityResidual {
    /// N.
    pub value: f64,
    /// Derivatives by the uncertain inputs, in the order of [`input`].
    pub gradient: [f64; input::COUNT],
    /// Variance from all but the inputs, at this instant, N^2.
    pub variance: f64,
}

/// How a parity residual compares with its prediction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityCheck {
    /// Prediction at this instant, N.
    pub innovation: Innovation,
    /// Whether the residual lies within its gate. Beyond, there was an impact, or a load on the robot.
    pub within_gate: bool,
}

impl MotionFilter {
    /// Compares a parity residual with its prediction and, with `correct`, corrects the states by it. `dt` is the time
    /// since the last sample, s.
    ///
    /// The part beyond two standard deviations becomes unexplained load. A residual beyond the gate makes all wheels
    /// suspect.
    pub fn check_parity(
        &mut self,
        residual: &ParityResidual,
        dt: f64,
        correct: bool,
    ) -> ParityCheck {
        let mut h = [(0, 0.0); input::COUNT];
        for (k, entry) in h.iter_mut().enumerate() {
            *entry = (INPUTS + k, residual.gradient[k]);
        }
        let linearisation = TUNING.parity.sigma * TUNING.parity.sigma;
        let at_once = residual.variance + linearisation;
        let ph = self.filter.covariance_times(&h);
        let of_states = Kalman::<COUNT, CONSIDERED>::along(&ph, &h);
        let innovation = Innovation {
            value: -residual.value,
            variance: of_states + at_once,
        };

        let square = residual.value * residual.value;
        let explained = TUNING.explained * TUNING.explained * innovation.variance;
        let gate = TUNING.gate * TUNING.gate * innovation.variance;
        let excess = (square - explained).min(TUNING.unexplained_cap);
        self.unexplained = self.unexplained.max(excess);
        // True at a residual beyond the gate, and until the unexplained load has decayed.
        if self.unexplained > gate - explained {
            self.suspect = [TUNING.suspect_time; 3];
        }
        let within_gate = square <= gate;
        if correct && within_gate {
            // Errors that last count as white noise of larger variance, but never less than at this instant.
            let lasting = (at_once + self.unexplained) * (2.0 * TUNING.parity.time / dt).max(1.0);
            self.filter.apply(&ph, -residual.value, of_states + lasting);
        }
        ParityCheck {
            innovation,
            within_gate,
        }
    }
}

//! Measurement: the parity residual of eq. (8), the combination of its rows in which no normal force
//! occurs, is zero. It relates tractions, contact angles, weight and inertia.
//!
//! | | |
//! |---|---|
//! | innovation | 0 less the residual `w' (F' - H_T T)`, N |
//! | states | all uncertain inputs of eq. (8) |
//! | noise | correlated: observers, errors of loads, push of the other side; in inflation: unmodelled load |
//! | gate | [`GATE`]: beyond it the residual shows an impact or an external load, and corrects nothing |
//! | channels | motor torques, encoders, gyroscopes, inclinometers |

use super::filter::MotionFilter;
use crate::common::FILTER_TIME;
use crate::deviation::{GATE, WITHIN};
use crate::filters::GaussMarkov;
use crate::filters::Measurement;
use crate::filters::{Innovation, PushFilter};
use crate::state;

/// The parity residual of eq. (8) at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityResidual {
    /// N.
    pub value: f64,
    /// Derivatives with respect to the uncertain inputs, in the order of [`state`].
    pub gradient: [f64; state::INPUTS],
    /// Variance at this sample from everything but the inputs, N^2.
    pub variance: f64,
    /// Errors of the torques' observers in the residual, N, a part of `variance`.
    pub observed: [GaussMarkov; 3],
    /// Part of the variance by the push of the other side, N^2, which lasts for [`PushFilter::LASTS`].
    pub of_push: f64,
}

impl MotionFilter {
    /// Tests a parity residual z against its predicted standard deviation sigma and, with
    /// `correct`, corrects the states by it. `dt` is the time since the last sample, s.
    ///
    /// The variance of the unmodelled load becomes the larger of its decayed old value and
    /// `z^2 - (2 sigma)^2`, N^2; sigma is that without unmodelled load. A residual beyond the gate
    /// is an impact.
    ///
    /// Returns zero minus the residual, N, with its predicted variance before the correction, N^2;
    /// and whether the residual lies within its gate: only then it has corrected the states.
    pub fn check_parity(
        &mut self,
        parity: &ParityResidual,
        dt: f64,
        correct: bool,
    ) -> (Innovation, bool) {
        let [o1, o2, o3] = parity.observed;
        let of_observers = o1.sigma * o1.sigma + o2.sigma * o2.sigma + o3.sigma * o3.sigma;
        let others = parity.variance - parity.of_push - of_observers;
        let others = robhaz_model::sqrt(others.max(0.0));
        let mut measurement = Measurement {
            row: core::array::from_fn::<_, { state::INPUTS }, _>(|k| (k, parity.gradient[k])),
            innovation: -parity.value,
            white: 0.0,
            correlated: [
                o1,
                o2,
                o3,
                GaussMarkov::new(others, FILTER_TIME),
                GaussMarkov::new(robhaz_model::sqrt(parity.of_push), PushFilter::LASTS),
            ],
            inflation: 0.0,
            // Tested here.
            gate: f64::INFINITY,
        };
        let expected = self.filter.expect(&measurement);
        let found = expected.innovation;
        let square = found.value * found.value;
        let explained = WITHIN * WITHIN * found.variance;
        let gate = GATE * GATE * found.variance;
        self.modes.load_at_least(square - explained);
        let load = self.modes.load();
        // True at a residual beyond the gate, and afterwards until the variance has decayed below
        // this bound.
        if load > gate - explained {
            self.modes.set_impact();
        }
        let within_gate = square <= gate;
        if correct && within_gate {
            let of_load = GaussMarkov::new(robhaz_model::sqrt(load), FILTER_TIME);
            measurement.inflation = of_load.white(dt);
            self.correct(&measurement, &expected, dt);
        }
        (found, within_gate)
    }

    /// Variance of the load that no reading shows, N^2.
    pub fn unmodelled_load(&self) -> f64 {
        self.modes.load()
    }
}

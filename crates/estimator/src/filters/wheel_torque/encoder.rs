//! Measurement: the angle of a wheel.
//!
//! | | |
//! |---|---|
//! | innovation | reading less the predicted angle, rad |
//! | states | spin angle |
//! | noise | white: a count |
//! | gate | none: beyond [`GATE`] an impact has changed speed and torque |
//! | channels | encoder |

use super::{ANGLE, RATE, SPEED, TORQUE, TorqueObserver, WheelParameters};
use crate::common::SMOOTHING;
use crate::deviation::GATE;
use crate::filters::{Innovation, Measurement};

impl TorqueObserver {
    /// Corrects the states by a reading of the spin angle, rad. `None` for the first reading, which
    /// sets the angle.
    pub fn measure(&mut self, parameters: &WheelParameters, angle: f64) -> Option<Innovation> {
        if !self.started {
            self.started = true;
            self.filter.set(ANGLE, angle, parameters.encoder_sigma);
            return None;
        }
        let measurement = Measurement {
            row: [(ANGLE, 1.0)],
            innovation: angle - self.filter.x[ANGLE],
            white: parameters.encoder_sigma * parameters.encoder_sigma,
            correlated: [],
            inflation: 0.0,
            gate: f64::INFINITY,
        };
        let mut expected = self.filter.expect(&measurement);
        if expected.innovation.nis() > GATE * GATE {
            self.meet_impact();
            expected = self.filter.expect(&measurement);
        }
        self.filter.correct(&measurement, &expected, 1.0);
        Some(expected.innovation)
    }

    /// What an impact may change within a sample is as uncertain.
    fn meet_impact(&mut self) {
        let p = &mut self.filter.p;
        p[SPEED][SPEED] += Self::IMPACT_SPEED * Self::IMPACT_SPEED;
        p[TORQUE][TORQUE] += Self::IMPACT_TORQUE * Self::IMPACT_TORQUE;
        let rate = Self::IMPACT_TORQUE / SMOOTHING;
        p[RATE][RATE] += rate * rate;
    }
}

//! Measurement: the inclination of a link.
//!
//! | | |
//! |---|---|
//! | innovation | reading less the angle and what the link's acceleration adds, after the inclinometer's low pass, rad |
//! | states | angle |
//! | noise | white: inclinometer, half of what the acceleration adds, lag while the link turns |
//! | gate | [`GATE`] |
//! | channels | inclinometer |

use super::{ANGLE, LinkAngleKalman};
use crate::deviation::GATE;
use crate::filters::{Innovation, Measurement};
use crate::frame::Inputs;
use crate::settings::NoiseBudget;

impl LinkAngleKalman {
    /// Relative error of the acceleration that is subtracted from the inclinometer.
    /// Chosen; sensitive.
    const ACCELERATION_ERROR: f64 = 0.5;

    /// Corrects the angle by an inclination (rad) where the specific force is at `force_angle` from
    /// gravity.
    pub(super) fn correct(
        &mut self,
        budget: &NoiseBudget,
        inclination: f64,
        force_angle: f64,
    ) -> Innovation {
        let noise = budget.inclinometer_noise();
        let uncertain = Self::ACCELERATION_ERROR * force_angle;
        let late = self.late(budget);
        let before = self.filter.x[ANGLE];
        let measurement = Measurement {
            row: [(ANGLE, 1.0)],
            innovation: inclination - self.expected,
            white: noise * noise + uncertain * uncertain + late * late,
            correlated: [],
            inflation: 0.0,
            gate: GATE,
        };
        let expected = self.filter.expect(&measurement);
        self.filter.correct(&measurement, &expected, 1.0);
        let turned = self.filter.x[ANGLE] - before;
        // The angle's error is older than the lag.
        self.expected += turned;
        if self.unread > Inputs::STALE_AFTER {
            // A loop of second order, damped by sqrt(2)/2, follows the inclinations in the place of the
            // gyroscope.
            self.rate += turned / (core::f64::consts::SQRT_2 * Inputs::STALE_AFTER);
        }
        expected.innovation
    }
}

//! The robot's acceleration in the readings of the inclinometers.

use super::BestFilters;
use crate::deviation::root_sum_square;
use crate::filters::LinkAngleKalman;
use crate::filters::motion::SensedAcceleration;
use crate::nominal::Nominal;
use crate::statics::Arms;
use robhaz_model::{Bar, GRAVITY, perp};

impl BestFilters {
    /// Least vertical specific force whose direction is that of gravity, m/s^2: half of gravity.
    /// Guard.
    const LEAST_UPWARD: f64 = 0.5 * GRAVITY;

    /// Corrects the motion by the innovations of the inclinometers (rad), `dt` seconds after the
    /// last sample.
    pub(super) fn correct_acceleration(
        &mut self,
        nominal: &Nominal,
        innovation: &[Option<f64>; 2],
        dt: f64,
    ) {
        let budget = &nominal.settings.budget;
        if !budget.specific_force {
            return;
        }
        let upward = (GRAVITY + self.motion.acceleration().y).max(Self::LEAST_UPWARD);
        let noise = upward * LinkAngleKalman::inclination_noise(budget);
        let readings = [0, 1].map(|k: usize| {
            let link = &self.links[k];
            innovation[k].map(|angle| {
                let of_place = budget.inclination_place * link.acceleration();
                let of_lag = upward * link.late(budget);
                SensedAcceleration {
                    innovation: upward * angle,
                    white: noise * noise,
                    of_angle: upward * link.settled_sigma(),
                    of_turning: root_sum_square(of_place, of_lag),
                }
            })
        });
        self.motion.correct_acceleration(&readings, dt);
    }

    /// Angle between the specific force and gravity at the centres of mass of links 1 and 2, rad,
    /// in the posture of `arms`.
    pub(super) fn force_angle(&self, arms: &Arms) -> [f64; 2] {
        [(0, Bar::Link1), (1, Bar::Link2)].map(|(k, bar): (usize, Bar)| {
            let (link, arm) = (&self.links[k], arms.centres[bar as usize]);
            let rate = link.smooth_rate();
            let force =
                self.motion.acceleration() + perp(arm) * link.acceleration() - arm * (rate * rate);
            force.x / (GRAVITY + force.y).max(Self::LEAST_UPWARD)
        })
    }
}

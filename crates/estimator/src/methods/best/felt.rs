//! What the inclinometers feel of the robot's acceleration.

use super::BestFilters;
use crate::filters::LinkAngleKalman;
use crate::filters::motion::FeltAcceleration;
use crate::nominal::Nominal;
use crate::quadrature::root_sum_square;
use crate::statics::Arms;
use robhaz_model::{Bar, GRAVITY, perp};

impl BestFilters {
    /// Least vertical specific force whose direction is that of gravity, m/s^2: half of gravity.
    const LEAST_UPWARD: f64 = 0.5 * GRAVITY;
    /// Largest angle between the specific force and gravity, rad. More is an impact, to which the filtered rates are no guide.
    const LARGEST_FELT: f64 = 0.5;

    /// Corrects the motion by what the inclinometers show beyond the expected readings, `felt` (rad), `dt` seconds after the last sample.
    pub(super) fn feel_acceleration(
        &mut self,
        nominal: &Nominal,
        felt: &[Option<f64>; 2],
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
            felt[k].map(|angle| {
                let of_place = budget.inclination_place * link.acceleration();
                let of_lag = upward * link.late(budget);
                let of_shaking = upward * self.shaking_felt(nominal, k);
                FeltAcceleration {
                    difference: upward * angle,
                    white: noise * noise,
                    of_angle: upward * link.settled_sigma(),
                    of_turning: root_sum_square(root_sum_square(of_place, of_lag), of_shaking),
                    lag: budget.inclination_lag,
                }
            })
        });
        self.motion.feel(&readings, dt);
    }

    /// Standard deviation of that angle at the inclinometer of link `k` from an angular acceleration that no filter follows, rad; 0 on
    /// ground that they follow.
    pub(super) fn shaking_felt(&self, nominal: &Nominal, k: usize) -> f64 {
        let unexplained = self.links[k].unexplained_acceleration();
        if !(unexplained > 0.0) {
            return 0.0;
        }
        let geometry = &nominal.robot.geometry;
        let arm = geometry.link_cg[k] - geometry.pins.q;
        let place = nominal.settings.budget.inclination_place;
        (robhaz_model::sqrt(arm.norm_squared()) + place) * unexplained / GRAVITY
    }

    /// Angle between the specific force and gravity at the centres of mass of links 1 and 2, rad, in the posture of `arms`.
    pub(super) fn expected_felt(&self, arms: &Arms) -> [f64; 2] {
        [(0, Bar::Link1), (1, Bar::Link2)].map(|(k, bar): (usize, Bar)| {
            let (link, arm) = (&self.links[k], arms.centres[bar as usize]);
            let rate = link.smooth_rate();
            let felt =
                self.motion.acceleration() + perp(arm) * link.acceleration() - arm * (rate * rate);
            let angle = felt.x / (GRAVITY + felt.y).max(Self::LEAST_UPWARD);
            angle.clamp(-Self::LARGEST_FELT, Self::LARGEST_FELT)
        })
    }
}

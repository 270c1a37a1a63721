//! The rolling constraints of a wheel: its centre moves along the ground (`direction.rs`), at the
//! speed of its rim less the slip (`slip.rs`).

use super::filter::MotionFilter;
use super::tuning;
use crate::common::{FILTER_TIME, ROLLING_SPEED};
use crate::contact::{ContactVelocity, RollingResiduals, SlipResidual};
use crate::deviation::{GATE, root_sum_square};
use crate::filters::GaussMarkov;
use crate::settings::{ContactAngles, NoiseBudget};
use crate::state::{CONTACT_ANGLE, CREEP};
use robhaz_model::Vec2;

/// Inputs of the rolling constraints of one wheel. T and N are those of the previous estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollingWheel {
    /// Velocity of the axle relative to Q, m/s, from the gyroscope.
    pub relative: Vec2,
    /// The same from the low-pass filtered rate.
    pub smooth_relative: Vec2,
    /// Part of the standard deviation of `relative` that the gyroscope's bias causes, m/s.
    pub bias_sigma: f64,
    /// Part of the standard deviation of `relative` that the gyroscope's white noise causes, m/s.
    pub noise_sigma: f64,
    /// Time over which that noise is averaged in `relative`, s; 0 where it is not.
    pub noise_time: f64,
    /// Part of the standard deviation of `relative` that the angle of a joint causes which gives the
    /// rate of its link, m/s.
    pub joint_noise: f64,
    /// Standard deviation of the speed along the wheel's plane by steering and dragging, m/s.
    pub across_sigma: f64,
    /// Whether the slip is that of T/N: [`crate::methods::Across::settled`].
    pub settled: bool,
    /// Given contact angle, rad.
    pub angle: f64,
    /// Rim speed relative to the axle, m/s, forward positive: r (omega - link rate). The spin omega
    /// relative to the link is positive forward (clockwise), the link rate counter-clockwise: hence
    /// the minus. `None` before the observer has settled, and when the encoder's last reading is
    /// too old.
    pub rim_speed: Option<f64>,
    /// Whether the wheel turns against its link: one that does not is held, and a link that turns
    /// with it is carried.
    pub turns: bool,
    /// T/N, limited to -1 to 1.
    pub ratio: f64,
    /// Correlation time of the product of the errors of creep and T/N, s.
    pub product_time: f64,
    /// Standard deviation of N over N, -.
    pub load_sigma: f64,
    /// Share of what resists the spin at the mean load that the slip shows, signed as the spin, -.
    pub resisted: f64,
    /// r N, N m.
    pub moment_of_load: f64,
    /// Smoothed torque reading minus the inertia torques of rotor and wheel disc, N m: observed r
    /// T + B omega. It multiplies the gain error.
    pub torque: f64,
    /// Standard deviation of the observed r T, N m.
    pub torque_sigma: f64,
    /// Standard deviation of the observed speed of the rim, m/s.
    pub rim_sigma: f64,
}

impl RollingWheel {
    /// What is left of the gyroscope's noise in `relative`, at samples every `dt` (s), m/s.
    pub(super) fn noise(&self, dt: f64) -> GaussMarkov {
        let averaged = self.noise_time > 0.0;
        let weight = if averaged {
            -libm::expm1(-dt / self.noise_time)
        } else {
            1.0
        };
        let left = robhaz_model::sqrt(weight / (2.0 - weight));
        GaussMarkov::new(self.noise_sigma * left, self.noise_time)
    }

    /// Standard deviation of `relative`, m/s.
    pub(super) fn turning_sigma(&self) -> f64 {
        let of_gyroscope = root_sum_square(self.bias_sigma, self.noise_sigma);
        root_sum_square(of_gyroscope, self.joint_noise)
    }

    /// Variance of `relative` that is new at each sample, m^2/s^2.
    pub(super) fn white(&self) -> f64 {
        self.noise_sigma * self.noise_sigma + self.joint_noise * self.joint_noise
    }

    /// Density of the noise of the wheel's slip at low frequencies, m^2/s, at samples every `dt`
    /// (s): white noise of the gyroscope, and what the observer of the rim's speed leaves.
    pub(super) fn slip_density(&self, dt: f64) -> f64 {
        let rim = GaussMarkov::new(self.rim_sigma, FILTER_TIME);
        (self.white() + rim.white(dt)) * dt
    }
}

/// Terms common to both constraints of one wheel.
pub(super) struct Sample<'a> {
    /// Number of the wheel, 0 to 2.
    pub i: usize,
    pub wheel: &'a RollingWheel,
    /// Of the wheel's centre.
    pub velocity: ContactVelocity,
    /// Time since the last sample, s.
    pub dt: f64,
    /// Whether the measurement rows contain contact angles and torques. If not, the angle's
    /// variance is added to the measurement noise, and the first-order effects of torque errors and
    /// creep are neglected.
    pub correct: bool,
}

impl MotionFilter {
    /// Applies the rolling constraints of the `wheels` that carry load, `dt` seconds after the last
    /// sample. Without `correct` the measurement rows contain the velocity only; states that are
    /// correlated with it still change. Returns the residuals before the corrections.
    pub fn roll(
        &mut self,
        budget: &NoiseBudget,
        wheels: &[Option<RollingWheel>; 3],
        dt: f64,
        correct: bool,
    ) -> [Option<RollingResiduals>; 3] {
        /// Speed from which on errors across change the size of the velocity by less than the slip is known
        /// to, m/s: 3 mm/s of poor sensors by 0.05 mm/s.
        /// Definition.
        const FAST: f64 = 0.1;
        let [_, _, vertical] = self.velocity_covariance();
        let mut found = [None; 3];
        for i in 0..3 {
            let Some(wheel) = &wheels[i] else { continue };
            let smooth = self.velocity() + wheel.smooth_relative;
            let noise = wheel.relative - wheel.smooth_relative;
            let (error, sigma) = self.input(CONTACT_ANGLE.of(i));
            // Unknown angles are those of the velocity. At the speed `fast` the error of a given one moves the velocity
            // across the ground as much as the velocity's own error.
            let (widest, fast) = match self.angles {
                ContactAngles::Given => (GATE * sigma, robhaz_model::sqrt(vertical) / sigma),
                ContactAngles::Unknown => (f64::INFINITY, FAST),
            };
            let sample = Sample {
                i,
                wheel,
                velocity: ContactVelocity::new(smooth, noise, wheel.angle - error, widest, fast),
                dt,
                correct,
            };
            let direction = self.correct_direction_of_wheel(budget, &sample);
            found[i] = Some(RollingResiduals {
                away: sample.velocity.away,
                away_sigma: robhaz_model::sqrt(direction.variance),
                slip: wheel.rim_speed.map(|rim| self.correct_slip(&sample, rim)),
            });
        }
        found
    }

    /// Correlation time of the product of the errors of creep and T/N in the plane, s.
    pub fn product_time(&self) -> f64 {
        let slower = tuning::REFERENCE_SPEED / self.speed();
        (tuning::PRODUCT_TIME * slower * slower).min(tuning::SLIP.time)
    }

    /// Speed from which on a wheel rolls, m/s: its velocity has a direction, and its slip depends on T/N.
    /// While a robot starts, its rims are ahead of the velocity: what that lags by is no slip.
    pub fn least_speed(&self) -> f64 {
        /// Time within which the velocity follows the rims, s.
        /// Chosen; held by `tests/readings`.
        const FOLLOWS: f64 = 1.0;
        /// Speed from which on a wheel rolls in any case, m/s.
        /// Chosen; held by `tests/readings`.
        const SURE: f64 = 0.02;
        (FOLLOWS * self.rims.abs()).clamp(ROLLING_SPEED, SURE)
    }

    /// Whether a wheel whose centre moves with this velocity rolls.
    pub(super) fn rolls(&self, velocity: &ContactVelocity) -> bool {
        velocity.speed.abs() > self.least_speed()
    }

    /// Creep speed of wheel `i`, the slip speed at T = N by the linear law, m/s: slip speed = creep
    /// times T/N while the wheel sticks.
    pub fn creep(&self, i: usize) -> f64 {
        libm::exp(self.filter.x[CREEP.of(i)])
    }

    /// Residuals of the rolling constraints of wheel `i` of a standing robot, which correct
    /// nothing: all of the rim's speed is slip.
    pub fn spin_in_place(&self, i: usize, wheel: &RollingWheel, dt: f64) -> RollingResiduals {
        let creep = self.creep(i) * wheel.ratio;
        let noise = wheel.turning_sigma();
        RollingResiduals {
            away: 0.0,
            away_sigma: noise,
            slip: wheel.rim_speed.map(|rim_speed| SlipResidual {
                beyond_creep: rim_speed - creep,
                creep,
                variance: noise * noise,
                noise,
                density: wheel.slip_density(dt),
            }),
        }
    }
}

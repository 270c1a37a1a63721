//! Rolling constraints: a wheel's centre moves along the ground, at the speed of the rim minus the
//! slip. And what wheels on mapped ground show: the direction of the velocity, and their contact
//! angles.

use super::filter::{
    CONTACT_ANGLE, CREEP, GEAR_FRICTION, MotionFilter, TORQUE_GAIN, TORQUE_OFFSET, VELOCITY,
};
use super::tuning::{GaussMarkov, TUNING};
use crate::contact::{ContactVelocity, RollingResiduals, SlipResidual};
use crate::deviation::{EDGE_GATE, GATE, root_sum_square};
use crate::settings::{ContactAngles, NoiseBudget};
use robhaz_model::{Vec2, perp};

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
    /// Given contact angle, rad.
    pub angle: f64,
    /// Rim speed relative to the axle, m/s, forward positive: r (omega - link rate). The spin omega
    /// relative to the link is positive forward (clockwise), the link rate counter-clockwise: hence
    /// the minus. `None` before the observer has settled, and when the encoder's last reading is
    /// too old.
    pub rim_speed: Option<f64>,
    /// T/N, limited to -1 to 1.
    pub ratio: f64,
    /// r N, N m.
    pub moment_of_load: f64,
    /// Smoothed sign of the spin, by which the gear friction acts: -1 to 1.
    pub friction_share: f64,
    /// Smoothed torque reading minus the inertia torques of rotor and wheel disc, N m: observed r
    /// T + B omega. It multiplies the gain error.
    pub torque: f64,
    /// Standard deviation of the observed r T, N m.
    pub torque_sigma: f64,
}

/// The linear creep law of one wheel at one instant: slip speed = creep times T/N while the wheel
/// sticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Creep {
    /// Creep speed, the slip speed at T = N by the linear law, m/s.
    pub speed: f64,
    /// T/N.
    pub ratio: f64,
}

impl Creep {
    /// T/N from which slip is no longer linear in it, -: on poor ground.
    /// Chosen; sensitive.
    const LINEAR_RATIO: f64 = 0.12;

    /// Slip speed by the linear law, m/s.
    pub fn slip(&self) -> f64 {
        self.speed * self.ratio
    }

    /// Factor on the variance of the slip speed for what the linear law leaves out: it grows with
    /// the fourth power of T/N.
    pub fn variance_factor(&self) -> f64 {
        let square = self.ratio * self.ratio / (Self::LINEAR_RATIO * Self::LINEAR_RATIO);
        1.0 + square * square
    }
}

/// Terms common to both constraints of one wheel.
struct Constrained<'a> {
    /// Number of the wheel, 0 to 2.
    i: usize,
    wheel: &'a RollingWheel,
    /// Of the wheel's centre.
    velocity: ContactVelocity,
    /// Time since the last sample, s.
    dt: f64,
    /// See [`MotionFilter::speed_ratio`].
    speed_ratio: f64,
    /// Whether the measurement rows contain contact angles and torques. If not, the angle's
    /// variance is added to the measurement noise, and the first-order effects of torque errors and
    /// creep are neglected.
    correct: bool,
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
        let mut found = [None; 3];
        for i in 0..3 {
            let Some(wheel) = &wheels[i] else { continue };
            let smooth = self.velocity() + wheel.smooth_relative;
            let noise = wheel.relative - wheel.smooth_relative;
            let slope = wheel.angle - self.filter.x[CONTACT_ANGLE + i];
            let sample = Constrained {
                i,
                wheel,
                velocity: ContactVelocity::new(smooth, noise, slope),
                dt,
                speed_ratio: self.speed_ratio(),
                correct,
            };
            let (shared, away_sigma) = self.constrain_direction(budget, &sample);
            let rim_speed = wheel.rim_speed;
            found[i] = Some(RollingResiduals {
                away: sample.velocity.away,
                away_sigma,
                slip: rim_speed.map(|speed| self.constrain_speed(&sample, speed, shared)),
            });
        }
        found
    }

    /// Creep of wheel `i`.
    pub(super) fn creep(&self, i: usize, wheel: &RollingWheel) -> Creep {
        Creep {
            speed: libm::exp(self.filter.x[CREEP + i]),
            ratio: wheel.ratio,
        }
    }

    /// The direction of the velocity is the contact angle: the speed away from the ground is zero.
    /// Without given contact angles a wheel beyond [`EDGE_GATE`] has met an edge.
    ///
    /// Returns the measurement-noise variance common to both constraints, m^2/s^2: gyroscope bias
    /// and noise, and the slip after an impact. And the standard deviation of the speed away from
    /// the ground at a single sample, m/s.
    fn constrain_direction(
        &mut self,
        budget: &NoiseBudget,
        sample: &Constrained<'_>,
    ) -> (f64, f64) {
        let (i, wheel, velocity, dt) = (sample.i, sample.wheel, sample.velocity, sample.dt);
        let (bias, noise) = (wheel.bias_sigma, wheel.noise_sigma);
        // Derivatives of the speed away from the ground.
        let x = (VELOCITY, -velocity.direction.y);
        let y = (VELOCITY + 1, velocity.direction.x);
        let h = [x, y, (CONTACT_ANGLE + i, velocity.smooth_speed)];
        let mut projection = self.filter.project(&h);

        let given = self.angles == ContactAngles::Given;
        // Below the speed at which a velocity has a direction, noise would pass for slopes.
        let correct = sample.correct && (given || velocity.rolls());
        let penetration = TUNING.penetration_speed.at_speed(sample.speed_ratio);
        let sample_variance = projection.variance
            + penetration.sigma * penetration.sigma
            + bias * bias
            + noise * noise;
        let leaves = velocity.away * velocity.away > EDGE_GATE * EDGE_GATE * sample_variance;
        if correct && !given && leaves {
            self.meet_edge(i, &velocity);
            projection = self.filter.project(&h);
        }

        let mut shared = GaussMarkov::new(bias, TUNING.slip.time).white(dt) + noise * noise;
        if self.is_after_impact() {
            let after_impact = if given {
                TUNING.impact_noise
            } else {
                TUNING.edge_noise
            };
            shared += after_impact.white(dt);
        }
        let r = penetration.white(dt) + shared;
        if correct {
            self.correct(&projection, -velocity.away, r, GATE);
        } else {
            let (_, sigma) = self.contact_angle_error(i);
            let of_angle =
                GaussMarkov::new(velocity.smooth_speed * sigma, budget.contact_angle_time);
            let r = r + of_angle.white(dt);
            self.filter.update(&[x, y], -velocity.away, r, GATE);
        }
        if !given {
            let angle = &mut self.filter.x[CONTACT_ANGLE + i];
            *angle = angle.clamp(-TUNING.steepest, TUNING.steepest);
        }
        (shared, robhaz_model::sqrt(sample_variance))
    }

    /// The velocity of wheel `i` does not lie along its ground, and no contact angle is given.
    ///
    /// A velocity away from the ground shows that the wheel has met an edge: its contact angle
    /// becomes as uncertain as the angle between both. A velocity into the ground is impossible:
    /// another wheel has met an edge, and the velocity of Q is wrong by that much. Without this
    /// distinction a wheel that meets a kerb looks like the other wheels on a downward slope.
    fn meet_edge(&mut self, i: usize, velocity: &ContactVelocity) {
        self.impact = TUNING.impact_time;
        let away = velocity.away;
        if away > 0.0 {
            let change = (away / velocity.speed).clamp(-TUNING.steepest, TUNING.steepest);
            self.filter.p[CONTACT_ANGLE + i][CONTACT_ANGLE + i] += change * change;
        } else {
            self.inflate_velocity(perp(velocity.direction) * away);
        }
    }

    /// Adds the square of `error` (m/s) to the covariance of the velocity.
    fn inflate_velocity(&mut self, error: Vec2) {
        for (i, a) in [error.x, error.y].into_iter().enumerate() {
            for (j, b) in [error.x, error.y].into_iter().enumerate() {
                self.filter.p[VELOCITY + i][VELOCITY + j] += a * b;
            }
        }
    }

    /// The speed along the ground is the rim's speed (m/s) minus the slip. A wheel that pulls and
    /// is beyond the gate counts as sliding. Returns the slip that the rim shows.
    fn constrain_speed(
        &mut self,
        sample: &Constrained<'_>,
        rim_speed: f64,
        shared: f64,
    ) -> SlipResidual {
        let (i, wheel, velocity, dt) = (sample.i, sample.wheel, sample.velocity, sample.dt);
        let creep = self.creep(i, wheel);
        let slip = creep.slip();
        // Derivative of the slip with respect to a torque error, which changes T/N.
        let by_offset = -creep.speed / wheel.moment_of_load;
        let rolls = velocity.rolls();
        let on = if sample.correct && rolls { 1.0 } else { 0.0 };
        let ratio_sigma = self.ratio_sigma(i, wheel);
        let pulls = wheel.ratio.abs() > TUNING.pulling * ratio_sigma;
        let shows_creep = pulls && wheel.ratio.abs() < TUNING.linear_ratio;
        let of_creep = if shows_creep { on } else { 0.0 };
        let h = [
            (VELOCITY, velocity.direction.x),
            (VELOCITY + 1, velocity.direction.y),
            (CREEP + i, of_creep * slip),
            (TORQUE_OFFSET + i, on * by_offset),
            (GEAR_FRICTION, on * by_offset * wheel.friction_share),
            (TORQUE_GAIN + i, on * by_offset * wheel.torque),
        ];
        let projection = self.filter.project(&h);
        let innovation = rim_speed - velocity.speed - slip;

        let unmodelled = TUNING.slip.at_speed(sample.speed_ratio);
        let factor = creep.variance_factor();
        let creep_sigma = creep.speed * robhaz_model::sqrt(self.filter.p[CREEP + i][CREEP + i]);
        let mut correlated = creep_sigma * ratio_sigma;
        if !shows_creep {
            correlated = root_sum_square(correlated, creep_sigma * wheel.ratio);
        }
        let of_torque = by_offset * wheel.torque_sigma;
        let square = |sigma: f64| sigma * sigma;
        let sample_variance = projection.variance
            + square(unmodelled.sigma) * factor
            + square(correlated)
            + square(of_torque)
            + square(wheel.bias_sigma)
            + square(wheel.noise_sigma);
        let residual = SlipResidual {
            beyond_creep: innovation,
            creep: slip,
            variance: sample_variance,
            noise: root_sum_square(wheel.bias_sigma, wheel.noise_sigma),
        };
        if square(innovation) > square(GATE) * sample_variance {
            if wheel.ratio.abs() > TUNING.sticking_ratio {
                self.sliding[i] = TUNING.sliding_time;
            } else if rolls && self.angles == ContactAngles::Unknown {
                // A wheel that hardly pulls does not slide: the velocity is wrong.
                self.inflate_velocity(velocity.direction * innovation);
                return residual;
            }
        }
        if self.sliding[i] > 0.0 {
            return residual;
        }
        let r = unmodelled.white(dt) * factor
            + GaussMarkov::new(correlated, TUNING.slip.time).white(dt)
            + GaussMarkov::new(of_torque, TUNING.filter_time).white(dt)
            + shared;
        self.correct(&projection, innovation, r, GATE);
        for creep in &mut self.filter.x[CREEP..CREEP + 3] {
            *creep = creep.clamp(TUNING.least_creep, TUNING.greatest_creep);
        }
        residual
    }

    /// Standard deviation of T/N of wheel `i` from the errors of its torque, -.
    fn ratio_sigma(&self, i: usize, wheel: &RollingWheel) -> f64 {
        let p = &self.filter.p;
        let (offset, gain) = (TORQUE_OFFSET + i, TORQUE_GAIN + i);
        let torque_variance = p[offset][offset]
            + p[GEAR_FRICTION][GEAR_FRICTION]
            + p[gain][gain] * wheel.torque * wheel.torque;
        robhaz_model::sqrt(torque_variance) / wheel.moment_of_load
    }

    /// Corrects the states by an error of the direction of the velocity of Q, as dy/dx, with its
    /// variance: see [`crate::ground::GroundMemory::take_direction_error`]. Returns the change of
    /// that direction, as dy/dx; zero while the robot hardly rolls, and after an impact: slopes of
    /// false readings would confirm themselves.
    ///
    /// A constant error of the direction and the sum of the torque offsets are one: the parity
    /// residual ties them. So this is what separates a slope from torque offsets on even ground.
    pub fn correct_direction(&mut self, error: f64, variance: f64) -> f64 {
        let velocity = self.velocity();
        let speed = robhaz_model::sqrt(velocity.norm_squared());
        let (cos, sin) = (velocity.x / speed, velocity.y / speed);
        // Written so that a NaN leaves, too.
        if !(speed > ContactVelocity::SLOW) || self.is_after_impact() {
            return 0.0;
        }
        // The angle changes with dy/dx by cos^2.
        let level = cos * cos;
        let h = [(VELOCITY, -sin / speed), (VELOCITY + 1, cos / speed)];
        let r = level * level * variance;
        self.update(&h, -level * error, r, GATE);
        let after = self.velocity();
        after.y / after.x - velocity.y / velocity.x
    }

    /// Corrects the states by what the ground shows of the contact angle of wheel `i`: it is
    /// `slope`, rad, with this variance; `given` is the given one. See
    /// [`crate::ground::GroundMemory::mapped_slope`]. Nothing while the robot hardly rolls, and
    /// after an impact.
    ///
    /// The direction of a wheel's velocity depends on the robot's speed, which nothing shows while
    /// two wheels slide. The ground that the wheels ahead have passed does not.
    pub fn correct_contact_angle(&mut self, i: usize, given: f64, slope: f64, variance: f64) {
        let slow = ContactVelocity::SLOW * ContactVelocity::SLOW;
        if !(self.velocity().norm_squared() > slow) || self.is_after_impact() {
            return;
        }
        let state = CONTACT_ANGLE + i;
        let error = given - slope - self.filter.x[state];
        self.update(&[(state, 1.0)], error, variance, GATE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: twice at the limit, 16 times more at twice the ratio.
    #[test]
    fn the_variance_grows_beyond_the_linear_range() {
        let factor = |ratio| Creep { speed: 0.01, ratio }.variance_factor();
        for (ratio, expected) in [(0.0, 1.0), (-0.12, 2.0), (0.24, 17.0)] {
            // Rounding of a dozen operations.
            assert!((factor(ratio) - expected).abs() < 1e-12 * expected);
        }
    }
}

//! The constraints as measurements. A wheel's centre moves along the ground, at the speed of the
//! rim minus the slip; wheels on mapped ground show the direction of the velocity, and their
//! contact angles; the inclinometers show the acceleration of the robot; the parity residual is
//! zero.

use super::filter::{
    ACCELERATION, CONTACT_ANGLE, COUNT, CREEP, GEAR_FRICTION, INPUTS, MotionFilter, PENETRATION,
    TORQUE_GAIN, TORQUE_OFFSET, VELOCITY,
};
use super::tuning::{self, GaussMarkov};
use crate::contact::{ContactVelocity, RollingResiduals, SlipResidual};
use crate::deviation::{GATE, SIGNIFICANT, WITHIN, root_sum_square};
use crate::filters::{Innovation, PushFilter};
use crate::settings::{ContactAngles, NoiseBudget};
use crate::statics::input;
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
    /// Standard deviation of N over N, -.
    pub load_sigma: f64,
    /// r N, N m.
    pub moment_of_load: f64,
    /// Smoothed sign of the spin, by which the gear friction acts: -1 to 1.
    pub friction_share: f64,
    /// Smoothed torque reading minus the inertia torques of rotor and wheel disc, N m: observed r
    /// T + B omega. It multiplies the gain error.
    pub torque: f64,
    /// Standard deviation of the observed r T, N m.
    pub torque_sigma: f64,
    /// Standard deviation of the observed speed of the rim, m/s.
    pub rim_sigma: f64,
}

impl RollingWheel {
    /// Density of the noise of the wheel's slip at low frequencies, m^2/s, at samples every `dt`
    /// (s): white noise of the gyroscope, and what the observer of the rim's speed leaves.
    fn slip_density(&self, dt: f64) -> f64 {
        let rim = GaussMarkov::new(self.rim_sigma, tuning::FILTER_TIME);
        (self.noise_sigma * self.noise_sigma + rim.white(dt)) * dt
    }
}

/// Factor on the variance of the slip speed for what the linear law of creep leaves out: it grows
/// with the fourth power of T/N.
fn variance_factor(ratio: f64) -> f64 {
    /// T/N from which slip is no longer linear in it, -: on poor ground.
    /// Chosen; sensitive.
    const NONLINEAR_RATIO: f64 = 0.12;
    let square = ratio * ratio / (NONLINEAR_RATIO * NONLINEAR_RATIO);
    1.0 + square * square
}

/// Terms common to both constraints of one wheel.
struct Sample<'a> {
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

/// What one inclinometer shows of the horizontal acceleration of Q at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensedAcceleration {
    /// Acceleration of Q that it shows, less the estimated one after the same low pass, m/s^2,
    /// forward positive.
    pub innovation: f64,
    /// Variance of its white noise, m^2/s^4.
    pub white: f64,
    /// Standard deviation of the error of the link's angle, as acceleration, m/s^2.
    pub of_angle: f64,
    /// Standard deviation of what its place and the error of its lag add while the link turns,
    /// m/s^2.
    pub of_turning: f64,
}

/// The parity residual of eq. (8) at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParityResidual {
    /// N.
    pub value: f64,
    /// Derivatives with respect to the uncertain inputs, in the order of [`input`].
    pub gradient: [f64; input::COUNT],
    /// Variance at this sample from everything but the inputs, N^2.
    pub variance: f64,
    /// Part of it by the push of the other side, N^2, which lasts for [`PushFilter::LASTS`].
    pub of_push: f64,
}

impl MotionFilter {
    /// Least speed of the rim over that of its wheel's centre of a wheel that rolls, -: a wheel that
    /// spins has more, one that is dragged less.
    /// Guard.
    const LEAST_TURN: f64 = 0.5;

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
            let (error, sigma) = self.input(input::CONTACT_ANGLE + i);
            // Unknown angles are those of the velocity.
            let given = self.angles == ContactAngles::Given;
            let widest = if given { GATE * sigma } else { f64::INFINITY };
            let sample = Sample {
                i,
                wheel,
                velocity: ContactVelocity::new(smooth, noise, wheel.angle - error, widest),
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

    /// Creep speed of wheel `i`, the slip speed at T = N by the linear law, m/s: slip speed = creep
    /// times T/N while the wheel sticks.
    fn creep(&self, i: usize) -> f64 {
        libm::exp(self.filter.x[CREEP + i])
    }

    /// The direction of the velocity is the contact angle: the speed away from the ground is zero.
    /// Without given contact angles a wheel beyond [`SIGNIFICANT`] has met an edge.
    ///
    /// Returns the measurement-noise variance common to both constraints, m^2/s^2: gyroscope bias
    /// and noise, and the slip after an impact. And the standard deviation of the speed away from
    /// the ground at a single sample, m/s.
    fn constrain_direction(&mut self, budget: &NoiseBudget, sample: &Sample<'_>) -> (f64, f64) {
        let (i, wheel, velocity, dt) = (sample.i, sample.wheel, sample.velocity, sample.dt);
        let (bias, noise) = (wheel.bias_sigma, wheel.noise_sigma);
        // Derivatives of the speed away from the ground.
        let x = (VELOCITY, -velocity.direction.y);
        let y = (VELOCITY + 1, velocity.direction.x);
        let z = (PENETRATION + i, 1.0);
        let h = [x, y, z, (CONTACT_ANGLE + i, velocity.smooth_speed)];
        let innovation = -velocity.away - self.filter.x[PENETRATION + i];
        let mut projection = self.filter.project(&h);

        let given = self.angles == ContactAngles::Given;
        // Below the speed at which a velocity has a direction, noise would pass for slopes. And the
        // velocity of a wheel that does not turn is that of a robot that settles or is hit, not a
        // way along the ground.
        let least = ContactVelocity::SLOW.max(Self::LEAST_TURN * velocity.smooth_speed.abs());
        let turns = |rim: f64| rim.abs() > least;
        let rolls = velocity.rolls() && wheel.rim_speed.is_none_or(turns);
        let correct = sample.correct && (given || rolls);
        let sample_variance = projection.variance + bias * bias + noise * noise;
        let leaves = velocity.away * velocity.away > SIGNIFICANT * SIGNIFICANT * sample_variance;
        if correct && !given && leaves {
            self.meet_edge(i, &velocity);
            projection = self.filter.project(&h);
        }

        let mut shared = GaussMarkov::new(bias, tuning::SLIP.time).white(dt) + noise * noise;
        if self.is_after_impact() {
            let (impact, edge) = (tuning::IMPACT_NOISE, tuning::EDGE_NOISE);
            let noise = if given { impact } else { edge };
            shared += noise.white(dt);
        }
        if correct {
            self.correct(&projection, innovation, shared, GATE);
        } else {
            let (_, sigma) = self.input(input::CONTACT_ANGLE + i);
            let of_angle =
                GaussMarkov::new(velocity.smooth_speed * sigma, budget.contact_angle_time);
            let r = shared + of_angle.white(dt);
            let seen = self.filter.project(&[x, y, z]);
            self.filter.correct(COUNT, &seen, innovation, r, GATE);
        }
        if !given {
            let angle = &mut self.filter.x[CONTACT_ANGLE + i];
            *angle = angle.clamp(-tuning::STEEPEST, tuning::STEEPEST);
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
        self.impact = tuning::IMPACT_TIME;
        let away = velocity.away;
        if away > 0.0 {
            let change = (away / velocity.speed).clamp(-tuning::STEEPEST, tuning::STEEPEST);
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
    fn constrain_speed(&mut self, sample: &Sample<'_>, rim: f64, shared: f64) -> SlipResidual {
        let (i, wheel, velocity, dt) = (sample.i, sample.wheel, sample.velocity, sample.dt);
        let creep = self.creep(i);
        let slip = creep * wheel.ratio;
        // Derivative of the slip with respect to a torque error, which changes T/N.
        let by_offset = -creep / wheel.moment_of_load;
        let rolls = velocity.rolls();
        // The derivatives by the torque errors are those at the estimated N. Where N is not beyond
        // its own deviation, T/N has no slope that the torques could be found from.
        let load_known = wheel.load_sigma < 1.0;
        let on = if sample.correct && rolls && load_known {
            1.0
        } else {
            0.0
        };
        let ratio_sigma = self.ratio_sigma(i, wheel);
        let pulls = wheel.ratio.abs() > tuning::PULLING * ratio_sigma;
        let shows_creep = pulls && wheel.ratio.abs() < tuning::LINEAR_RATIO;
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
        let innovation = rim - velocity.speed - slip;

        let unmodelled = tuning::SLIP.at_speed(sample.speed_ratio);
        let factor = variance_factor(wheel.ratio);
        let creep_sigma = creep * robhaz_model::sqrt(self.filter.p[CREEP + i][CREEP + i]);
        let mut correlated = root_sum_square(creep_sigma * ratio_sigma, slip * wheel.load_sigma);
        if !shows_creep {
            correlated = root_sum_square(correlated, creep_sigma * wheel.ratio);
        }
        let of_observer = root_sum_square(by_offset * wheel.torque_sigma, wheel.rim_sigma);
        let square = |sigma: f64| sigma * sigma;
        let sample_variance = projection.variance
            + square(unmodelled.sigma) * factor
            + square(correlated)
            + square(of_observer)
            + square(wheel.bias_sigma)
            + square(wheel.noise_sigma);
        let residual = SlipResidual {
            beyond_creep: innovation,
            creep: slip,
            variance: sample_variance,
            noise: root_sum_square(wheel.bias_sigma, wheel.noise_sigma),
            density: wheel.slip_density(dt),
        };
        if square(innovation) > square(GATE) * sample_variance {
            if wheel.ratio.abs() > tuning::STICKING_RATIO {
                self.sliding[i] = tuning::SLIDING_TIME;
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
            + GaussMarkov::new(correlated, tuning::SLIP.time).white(dt)
            + GaussMarkov::new(of_observer, tuning::FILTER_TIME).white(dt)
            + shared;
        self.correct(&projection, innovation, r, GATE);
        for creep in &mut self.filter.x[CREEP..CREEP + 3] {
            *creep = creep.clamp(tuning::LEAST_CREEP, tuning::GREATEST_CREEP);
        }
        residual
    }

    /// Standard deviation of T/N of wheel `i` from the errors of its torque and of N, -.
    fn ratio_sigma(&self, i: usize, wheel: &RollingWheel) -> f64 {
        let p = &self.filter.p;
        let (offset, gain) = (TORQUE_OFFSET + i, TORQUE_GAIN + i);
        let torque_variance = p[offset][offset]
            + p[GEAR_FRICTION][GEAR_FRICTION]
            + p[gain][gain] * wheel.torque * wheel.torque;
        let of_torque = robhaz_model::sqrt(torque_variance) / wheel.moment_of_load;
        root_sum_square(of_torque, wheel.ratio * wheel.load_sigma)
    }

    /// Corrects the states by an error of the direction of the velocity of Q, as dy/dx, with its
    /// variance: see [`crate::ground::GroundMemory::take_direction_error`]. Returns the change of
    /// that direction, as dy/dx; zero while the robot hardly rolls.
    ///
    /// A constant error of the direction and the sum of the torque offsets are one: the parity
    /// residual ties them. So this is what separates a slope from torque offsets on even ground.
    pub fn correct_direction(&mut self, error: f64, variance: f64) -> f64 {
        let velocity = self.velocity();
        let speed = robhaz_model::sqrt(velocity.norm_squared());
        let (cos, sin) = (velocity.x / speed, velocity.y / speed);
        // Written so that a NaN leaves, too.
        if !(speed > ContactVelocity::SLOW) {
            return 0.0;
        }
        // The angle changes with dy/dx by cos^2.
        let level = cos * cos;
        let h = [(VELOCITY, -sin / speed), (VELOCITY + 1, cos / speed)];
        let r = level * level * variance;
        self.correct(&self.filter.project(&h), -level * error, r, GATE);
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
        let projection = self.filter.project(&[(state, 1.0)]);
        self.correct(&projection, error, variance, GATE);
    }

    /// Residuals of the rolling constraints of wheel `i` of a standing robot, which correct
    /// nothing: all of the rim's speed is slip.
    pub fn spin_in_place(&self, i: usize, wheel: &RollingWheel, dt: f64) -> RollingResiduals {
        let creep = self.creep(i) * wheel.ratio;
        let noise = root_sum_square(wheel.bias_sigma, wheel.noise_sigma);
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

    /// Measurement update by the acceleration of Q that the inclinometers of links 1 and 2 show,
    /// `dt` seconds after the last sample: `None` without a reading. Skipped after an impact: what
    /// it does to the filtered rates of the links would pass for an acceleration.
    ///
    /// An inclinometer measures the direction of the specific force, and the gyroscope the angle of
    /// the link: what is left is the acceleration along the link, within seconds. It is the only
    /// measurement of the robot's motion that does not need a wheel that grips.
    ///
    /// Both links measure the same acceleration of Q. Half of the excess of their difference over
    /// [`WITHIN`] deviations is added to the correlated noise: otherwise a gyroscope with a
    /// wrong sign would pass for an acceleration, and no inclination would contradict it.
    pub fn correct_acceleration(&mut self, readings: &[Option<SensedAcceleration>; 2], dt: f64) {
        self.since_acceleration += dt;
        let share = match readings {
            [None, None] => return,
            [Some(_), Some(_)] => 0.5,
            _ => 1.0,
        };
        let time = core::mem::take(&mut self.since_acceleration);
        if self.is_after_impact() {
            return;
        }
        let (mut innovation, mut white) = (0.0, 0.0);
        let (mut of_angle, mut of_turning) = (0.0, 0.0);
        for sensed in readings.iter().flatten() {
            innovation += share * sensed.innovation;
            white += share * share * sensed.white;
            // Both links' errors of these kinds may have the same sign.
            of_angle += share * sensed.of_angle;
            of_turning += share * sensed.of_turning;
        }
        // Not less than once the variance, where readings are rarer than errors last.
        let white_of =
            |sigma: f64, lasts: f64| GaussMarkov::new(sigma, lasts.max(0.5 * time)).white(time);
        let apart = match readings {
            [Some(first), Some(second)] => (first.innovation - second.innovation).abs(),
            _ => 0.0,
        };
        let square = |sigma: f64| sigma * sigma;
        // Of the difference of two independent links; `white` is that of their mean.
        let agreeing = 4.0 * white + 2.0 * (square(of_angle) + square(of_turning));
        let excess = 0.5 * (apart - WITHIN * robhaz_model::sqrt(agreeing)).max(0.0);
        let r = white
            + white_of(of_angle, tuning::ANGLE_TIME)
            + white_of(excess, tuning::ANGLE_TIME)
            + white_of(of_turning, tuning::FILTER_TIME);
        // No gate: an impact is an acceleration, too.
        let projection = self.filter.project(&[(ACCELERATION, 1.0)]);
        self.correct(&projection, innovation, r, f64::INFINITY);
    }

    /// Tests a parity residual z against its predicted standard deviation sigma and, with
    /// `correct`, corrects the states by it. `dt` is the time since the last sample, s.
    ///
    /// The variance of the unmodelled load becomes the larger of its decayed old value and
    /// `z^2 - (2 sigma)^2`, N^2; sigma is that without unmodelled load. A residual beyond the gate
    /// is an impact.
    ///
    /// Returns zero minus the residual, N, with its predicted variance before the correction, N^2;
    /// and whether the residual lies within its gate: only then it has corrected the states. An
    /// outlier shows an impact, or an external load on the robot.
    pub fn check_parity(
        &mut self,
        parity: &ParityResidual,
        dt: f64,
        correct: bool,
    ) -> (Innovation, bool) {
        let square = parity.value * parity.value;
        let h: [_; input::COUNT] = core::array::from_fn(|k| (INPUTS + k, parity.gradient[k]));
        let projection = self.filter.project(&h);
        let innovation = Innovation {
            value: -parity.value,
            variance: projection.variance + parity.variance,
        };

        let explained = WITHIN * WITHIN * innovation.variance;
        let gate = GATE * GATE * innovation.variance;
        let excess = square - explained;
        self.unmodelled_load = self.unmodelled_load.max(excess);
        // True at a residual beyond the gate, and afterwards until the variance has decayed below
        // this bound.
        if self.unmodelled_load > gate - explained {
            self.impact = tuning::IMPACT_TIME;
        }
        let within_gate = square <= gate;
        if correct && within_gate {
            // Correlated errors enter as the equivalent white noise, with at least the variance of
            // this sample.
            let white_of = |lasts: f64| (2.0 * lasts / dt).max(1.0);
            let passing = parity.variance - parity.of_push + self.unmodelled_load;
            let correlated = passing * white_of(tuning::FILTER_TIME)
                + parity.of_push * white_of(PushFilter::LASTS);
            self.correct(&projection, -parity.value, correlated, f64::INFINITY);
        }
        (innovation, within_gate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    /// A robot that accelerates by `acceleration` (m/s^2) while all its wheels slide: nothing but
    /// the inclinometers of the links `read` shows it.
    fn accelerated(acceleration: f64, read: [bool; 2], lag: f64) -> MotionFilter {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
        let measured = [acceleration, 0.0];
        let mut expected = 0.0;
        for _ in 0..1000 {
            motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
            // What the sensor and the expected reading pass through.
            let weight = if lag > 0.0 {
                -libm::expm1(-DT / lag)
            } else {
                1.0
            };
            expected += weight * (motion.acceleration().x - acceleration - expected);
            let sensed = SensedAcceleration {
                innovation: -expected,
                white: 0.017 * 0.017,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            motion.correct_acceleration(&read.map(|read| read.then_some(sensed)), DT);
        }
        motion
    }

    /// Closed form: with any of the inclinometers and any lag the speed after a second is the
    /// acceleration times the second, less what the filter takes to follow: 30 ms without a lag, at
    /// most 100 ms with one of 20 ms.
    #[test]
    fn the_speed_of_a_robot_that_slides_is_found() {
        for read in [[true, false], [false, true], [true, true]] {
            for (lag, late) in [(0.0, 0.05), (0.02, 0.1)] {
                for acceleration in [0.3, -0.3] {
                    let motion = accelerated(acceleration, read, lag);
                    let missing = 1.0 - motion.velocity().x / acceleration;
                    assert!(missing > 0.0 && missing < late, "{read:?} {lag}: {missing}");
                    let found = motion.acceleration().x;
                    // The process decays towards zero in the meantime.
                    assert!((found / acceleration - 1.0).abs() < 0.06, "{found}");
                }
            }
        }
        assert!(accelerated(0.3, [false; 2], 0.0).velocity().x.abs() < 1e-12);
    }

    /// Property: inclinometers that are read at every tenth sample only show the acceleration, too:
    /// the process of 0.6 m/s^2 is the larger part of its deviation.
    #[test]
    fn rare_readings_show_the_acceleration() {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
        let measured = [0.3, 0.0];
        for k in 0..1000 {
            motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
            let sensed = SensedAcceleration {
                innovation: 0.3 - motion.acceleration().x,
                white: 0.017 * 0.017,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            motion.correct_acceleration(&[(k % 10 == 0).then_some(sensed); 2], DT);
        }
        let (found, sigma) = motion.filter.estimated(ACCELERATION);
        assert!((found - 0.3).abs() < 0.02 && sigma < 0.3, "{found} {sigma}");
    }

    /// Property: a second link narrows the acceleration, by less than the root of two, because the
    /// angles' errors count as common.
    #[test]
    fn two_links_tell_more_than_one() {
        let sigma = |read| accelerated(0.3, read, 0.0).filter.estimated(ACCELERATION).1;
        let (one, two) = (sigma([true, false]), sigma([true, true]));
        assert!(
            two < one && two > one * core::f64::consts::FRAC_1_SQRT_2,
            "{one} {two}"
        );
    }

    /// Property: what only one of two links shows counts by less, the more it is.
    #[test]
    fn links_that_differ_count_by_less() {
        let budget = NoiseBudget::typical();
        let found = |difference: f64| {
            let mut motion = MotionFilter::new(&budget, ContactAngles::Unknown);
            let sensed = |innovation| SensedAcceleration {
                innovation,
                white: 1e-4,
                of_angle: 0.005,
                of_turning: 0.0,
            };
            let measured = [0.0; 2];
            for _ in 0..3 {
                motion.predict(&budget, DT, [false; 3], &[0.0; 3], measured);
                motion.correct_acceleration(&[Some(sensed(difference)), Some(sensed(0.0))], DT);
            }
            motion.acceleration().x / difference
        };
        assert!(found(1.0) < 0.1 * found(0.01) && found(0.01) > 0.0);
    }

    /// Property: after an impact what the inclinometers measure changes nothing.
    #[test]
    fn an_impact_is_no_acceleration() {
        let mut motion = accelerated(0.3, [true; 2], 0.0);
        motion.impact = 0.2;
        let before = motion;
        let sensed = SensedAcceleration {
            innovation: 5.0,
            white: 1e-4,
            of_angle: 0.0,
            of_turning: 0.0,
        };
        for _ in 0..10 {
            motion.correct_acceleration(&[Some(sensed); 2], DT);
        }
        assert_eq!(motion.filter, before.filter);
    }

    /// Closed form: twice at the limit, 16 times more at twice the ratio.
    #[test]
    fn the_variance_grows_beyond_the_linear_range() {
        for (ratio, expected) in [(0.0, 1.0), (-0.12, 2.0), (0.24, 17.0)] {
            // Rounding of a dozen operations.
            assert!((variance_factor(ratio) - expected).abs() < 1e-12 * expected);
        }
    }
}

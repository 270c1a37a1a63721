//! What hides behind the readings: motion of the robot, errors of contact angles and torques, creep of the wheels; one
//! Kalman filter over all of them.
//!
//! Three things must hold, and each is a measurement of these states:
//! - a wheel's centre moves along the ground: the direction of its velocity is the contact angle, up to the rate of its penetration;
//! - a wheel rolls: the speed of its centre is that of its rim less the slip, and while it sticks slip grows with T/N (creep), through
//!   zero;
//! - the parity residual of eq. (8) is zero.
//!
//! The first ties the contact angles to each other and to the gyroscopes; the second tells offsets of the torques from
//! tractions, because a wheel that does not slip does not pull; the third ties the sum of it all to the weight.

use crate::kalman::{Innovation, Kalman};
use crate::settings::NoiseBudget;
use crate::visit::visit_fields;
use robhaz_model::Vec2;

/// Places of the states.
pub(crate) mod state {
    /// Velocity of Q, m/s: x, y.
    pub const VELOCITY: usize = 0;
    /// Slip for T = N, m/s.
    pub const CREEP: usize = 2;
    /// Acceleration of Q, m/s^2: x, y. From here on are the states that the forces depend on.
    pub const ACCELERATION: usize = 3;
    /// Errors of the contact angles given, rad.
    pub const CONTACT_ANGLE: usize = 5;
    /// Offsets of the motor torques read, N m.
    pub const TORQUE_OFFSET: usize = 8;
    /// Dry friction in the gears, common to all, N m against the spin.
    pub const GEAR_FRICTION: usize = 11;
    /// Relative errors of the motor torques read: considered, not estimated. What tells them apart from creep and contact angles are
    /// products of these, which a linear filter gets wrong: it would be surer the longer it errs.
    pub const TORQUE_GAIN: usize = 12;
    /// How many.
    pub const COUNT: usize = 15;
    /// How many of them, at the end, are considered only.
    pub const CONSIDERED: usize = COUNT - TORQUE_GAIN;
}
use state::*;

/// How the states change and how well the measurements hold: one tuning for all sensors and grounds. Errors that last are
/// given by size and correlation time: see [`Noise::white`].
mod tuning {
    /// Speed for which what depends on the ground is given, m/s: faster, the same ground changes in proportion to the speed, and
    /// accelerations grow with its square. Up to 10 m/s, as fast as a set speed may be.
    pub const PACE: (f64, f64) = (0.2, 10.0);
    /// Acceleration of Q while nothing shakes, at that speed: Gauss-Markov, m/s^2 and s. It is what contact angles off by
    /// [`COARSE_ANGLE`] can follow; finer ones follow more, in inverse proportion to the root of their error.
    pub const ACCELERATION: (f64, f64) = (0.015, 1.0);
    /// Error of a contact angle, rad: 2 deg.
    pub const COARSE_ANGLE: f64 = 0.0349;
    /// Time over which what was found of it fades after a blow, s.
    pub const ACCELERATION_AFTER_BLOW: f64 = 0.03;
    /// More than any robot is pushed, m/s^2: what readings show beyond is false, and numbers must not outgrow their rounding.
    pub const GREATEST_ACCELERATION: f64 = 1e3;
    /// How much more of it there may be than encoders (all wheels spin faster) and gyroscopes (links turn faster) show.
    pub const PUSHED: f64 = 2.0;
    /// See [`PUSHED`].
    pub const SHAKEN: f64 = 0.3;
    /// Velocity at the start, m/s.
    pub const START_VELOCITY: f64 = 0.01;
    /// Velocity after a gap, m/s.
    pub const UNKNOWN_VELOCITY: f64 = 0.5;
    /// Speed below which a velocity has no direction to be told from, and slip tells nothing of traction, m/s.
    pub const SLOW: f64 = 0.02;
    /// Rate of penetration at that speed, m/s and s: 0.5 mm of penetration change by a fiftieth of themselves over 50 ms.
    pub const PENETRATION_RATE: (f64, f64) = (2e-4, 0.05);
    /// How much larger the gyroscopes' noise counts than it is: besides its own part in the equations it makes the direction waver
    /// about which they are linear.
    pub const GYRO_NOISE: f64 = 3.0;
    /// Slip beyond creep at that speed, m/s and s: the wheel radius without the penetration's changes errs by 0.1 % of the speed.
    pub const SLIP: (f64, f64) = (2e-4, 0.3);
    /// Time over which errors of the torque observer last, s.
    pub const OBSERVER_TIME: f64 = 0.05;
    /// T/N beyond which slip is no longer linear in it, and beyond which wheels begin to slide on poor ground: the noise of slip
    /// grows with the fourth power of T/N over the first, and the eighth over the second.
    pub const STICKING: (f64, f64) = (0.2, 0.31);
    /// Creep at T = N, m/s: of the order of 10 mm/s for small hard wheels. It is held so sure because a creep of zero explains readings
    /// with any offset, so that a filter in doubt may end there. What other wheels cost: `docs/estimators.md`.
    pub const CREEP: (f64, f64) = (0.015, 0.003);
    /// Least creep, m/s: harder wheels than these are not told from rigid ones.
    pub const LEAST_CREEP: f64 = 5e-4;
    /// Random walks: torque offset (N m/sqrt(s)), gear friction (N m/sqrt(s)), creep (m/s/sqrt(s)).
    pub const WALK: (f64, f64, f64) = (1e-3, 2e-3, 2e-4);
    /// Parity residual: errors of its linearisation, N, beside those of the loads, and the time over which all of them and those of the
    /// torque observer last, s.
    pub const PARITY: (f64, f64) = (0.1, 0.03);
    /// Walk of a contact angle while none comes, rad/sqrt(s).
    pub const ANGLE_UNSEEN: f64 = 0.5;
    /// Least error of a contact angle, rad, so that a budget of zero does not make the filter deaf.
    pub const LEAST_ANGLE: f64 = 1e-3;
    /// Innovations beyond so many standard deviations are left out.
    pub const GATE: f64 = 5.0;
    /// Standard deviations beyond which a wheel's direction tells that it does not roll on the ground that is given: it stands on an
    /// edge, or on riser and tread.
    pub const DOUBT_GATE: f64 = 6.0;
    /// Time for which it is then doubted, s, and all wheels after a blow, a parity residual beyond its gate.
    pub const DOUBT_TIME: f64 = 0.2;
    /// Velocity of a doubted wheel beside the ground given, m/s and s.
    pub const DOUBT: (f64, f64) = (0.1, 0.1);
    /// Standard deviations of the parity residual beyond which what it shows counts as load that nobody knows.
    pub const EXPECTED: f64 = 2.0;
    /// Time over which such a load fades, s; what of it is as good as nothing, N^2; and the greatest that is told, N^2: 10 kN.
    pub const BLOW: (f64, f64, f64) = (0.02, 1e-6, 1e8);
}

/// A wheel as the filter sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// Velocity of the axle relative to Q, m/s, as the gyroscope reads it.
    pub relative: Vec2,
    /// The same, smoothed.
    pub smooth_relative: Vec2,
    /// Contact angle given, rad.
    pub angle: f64,
    /// Speed of the rim, r Omega, m/s; `None` while no encoder tells.
    pub rim_speed: Option<f64>,
    /// T/N.
    pub ratio: f64,
    /// r N, N m.
    pub moment_of_load: f64,
    /// How much of the gears' friction acts: -1 to 1.
    pub turning: f64,
    /// Torque read but for what accelerates the rotor, N m.
    pub torque: f64,
    /// Standard deviation of the axle's velocity relative to Q, m/s: the gyroscope's bias, and its noise in a sample.
    pub relative_sigma: (f64, f64),
    /// Standard deviation of r T as observed, N m.
    pub torque_sigma: f64,
}

/// The velocity of a wheel's centre against the ground.
struct Course {
    /// Unit vector along it, forwards.
    direction: Vec2,
    /// Speed along it, m/s, negative backwards.
    speed: f64,
    /// Velocity away from the ground, m/s.
    away: f64,
}

impl Course {
    /// Of a velocity `smooth + noise` on ground that rises with `slope` (rad).
    ///
    /// The direction is that of the velocity, and of the smooth one. About the ground's direction or with the noise the same equation
    /// would be linear too; but errors of the slope or the noise would stand in the difference and in its sensitivity both, and
    /// every correction would make the velocity smaller or larger.
    fn new(smooth: Vec2, noise: Vec2, slope: f64) -> Self {
        let (sin, cos) = libm::sincos(slope);
        let (away, along) = (
            smooth.y * cos - smooth.x * sin,
            smooth.x * cos + smooth.y * sin,
        );
        let size = libm::sqrt(smooth.norm_squared());
        let (direction, speed, away) = if size < tuning::SLOW {
            (Vec2::new(cos, sin), along, away)
        } else {
            let speed = libm::copysign(size, along);
            (smooth / speed, speed, speed * libm::atan(away / along))
        };
        Self {
            direction,
            speed: speed + noise.dot(&direction),
            away: away + noise.y * direction.x - noise.x * direction.y,
        }
    }

    /// How `away` changes with the velocity of Q and with the error of contact angle `i`.
    fn aside_and_slope(&self, i: usize) -> [(usize, f64); 3] {
        [
            (VELOCITY, -self.direction.y),
            (VELOCITY + 1, self.direction.x),
            (CONTACT_ANGLE + i, self.speed),
        ]
    }
}

/// Errors that last, as a filter of independent samples must take them.
struct Noise {
    /// Time between samples, s.
    dt: f64,
    /// See [`pace`].
    pace: f64,
}

impl Noise {
    /// The variance of white noise that tells as little as an error of size sigma that lasts for a time: `sigma^2 2 time/dt`.
    fn white(&self, (sigma, time): (f64, f64)) -> f64 {
        sigma * sigma * 2.0 * time / self.dt
    }

    /// What the ground makes, at this speed.
    fn paced(&self, (sigma, time): (f64, f64)) -> (f64, f64) {
        (sigma * self.pace, time / self.pace)
    }
}

/// How many times faster than [`tuning::PACE`], at least 1.
fn pace(velocity: Vec2) -> f64 {
    let (least, greatest) = tuning::PACE;
    libm::sqrt(velocity.norm_squared()).max(least).min(greatest) / least
}

/// The filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionFilter {
    pub filter: Kalman<COUNT, CONSIDERED>,
    /// Time for which each wheel is still doubted, s.
    doubt: [f64; 3],
    /// Square of the load that nobody knows, N^2.
    unexplained: f64,
}

visit_fields!(MotionFilter: filter, doubt, unexplained);

impl MotionFilter {
    /// Knows of the errors what the budget says; the robot stands.
    pub fn new(budget: &NoiseBudget) -> Self {
        let mut sigma = [0.0; COUNT];
        let mut x = [0.0; COUNT];
        for i in 0..2 {
            sigma[VELOCITY + i] = tuning::START_VELOCITY;
            sigma[ACCELERATION + i] = tuning::ACCELERATION.0;
        }
        for i in 0..3 {
            sigma[CONTACT_ANGLE + i] = budget.contact_angle.max(tuning::LEAST_ANGLE);
            sigma[TORQUE_OFFSET + i] = budget.torque_offset;
            sigma[TORQUE_GAIN + i] = budget.torque_gain;
        }
        sigma[GEAR_FRICTION] = budget.gear_friction;
        (x[CREEP], sigma[CREEP]) = tuning::CREEP;
        Self {
            filter: Kalman::new(x, sigma),
            doubt: [0.0; 3],
            unexplained: 0.0,
        }
    }

    /// The robot may be moving already.
    pub fn forget_velocity(&mut self) {
        for v in [VELOCITY, VELOCITY + 1] {
            self.filter.p[v][v] = tuning::UNKNOWN_VELOCITY * tuning::UNKNOWN_VELOCITY;
        }
    }

    /// Goes on by `dt`, s. `seen` tells for which wheels a contact angle came with this frame; `pushed` and `shaken` what encoders and
    /// gyroscopes show of accelerations, m/s^2.
    pub fn predict(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        seen: [bool; 3],
        pushed: f64,
        shaken: f64,
    ) {
        let Kalman { x, p } = &mut self.filter;
        let pace = pace(Vec2::new(x[VELOCITY], x[VELOCITY + 1]));
        let (calm, calm_time) = tuning::ACCELERATION;
        let slope = budget.contact_angle.max(tuning::LEAST_ANGLE);
        let fine = libm::sqrt((tuning::COARSE_ANGLE / slope).max(1.0));
        let (calm, mut push_time) = (calm * fine * pace * pace, calm_time / pace);
        if self.doubt.iter().all(|time| *time > 0.0) {
            push_time = tuning::ACCELERATION_AFTER_BLOW;
        }
        let (pushed, shaken) = (tuning::PUSHED * pushed, tuning::SHAKEN * shaken);
        let push = libm::sqrt(calm * calm + pushed * pushed + shaken * shaken)
            .min(tuning::GREATEST_ACCELERATION);
        let keep_push = libm::exp(-dt / push_time);
        let keep_slope = libm::exp(-dt / budget.contact_angle_time.max(1e-6));

        // F P F': velocities take in accelerations, accelerations and contact angles fade. Only the first MOVING states do
        // so: their rows are computed from the diagonal on, their columns are copies, so that P stays symmetric to the bit.
        const MOVING: usize = TORQUE_OFFSET;
        let mut keep = [1.0; COUNT];
        for i in 0..2 {
            let (v, a) = (VELOCITY + i, ACCELERATION + i);
            keep[a] = keep_push;
            x[v] += dt * x[a];
            for k in 0..COUNT {
                p[v][k] += dt * p[a][k];
            }
        }
        for i in 0..2 {
            for k in i..2 {
                p[VELOCITY + i][VELOCITY + k] += dt * p[VELOCITY + i][ACCELERATION + k];
            }
        }
        for i in 0..3 {
            keep[CONTACT_ANGLE + i] = keep_slope;
        }
        for i in 0..MOVING {
            x[i] *= keep[i];
            for k in 0..COUNT {
                p[i][k] *= keep[i] * keep[k];
            }
        }
        for i in 0..MOVING {
            for k in i + 1..COUNT {
                p[k][i] = p[i][k];
            }
        }

        let mut walk = |state: usize, variance: f64| p[state][state] += variance;
        for i in 0..2 {
            walk(
                ACCELERATION + i,
                push * push * (1.0 - keep_push * keep_push),
            );
        }
        let (offset, friction, creep) = tuning::WALK;
        for i in 0..3 {
            let unseen = if seen[i] { 0.0 } else { tuning::ANGLE_UNSEEN };
            let fresh = slope * slope * (1.0 - keep_slope * keep_slope);
            walk(CONTACT_ANGLE + i, fresh + unseen * unseen * dt);
            walk(TORQUE_OFFSET + i, offset * offset * dt);
        }
        walk(GEAR_FRICTION, friction * friction * dt);
        walk(CREEP, creep * creep * dt);

        for time in &mut self.doubt {
            *time = (*time - dt).max(0.0);
        }
        let (fading, nothing, _) = tuning::BLOW;
        self.unexplained *= libm::exp(-dt / fading);
        if self.unexplained < nothing {
            self.unexplained = 0.0;
        }
    }

    /// Velocity of Q, m/s.
    pub fn velocity(&self) -> Vec2 {
        Vec2::new(self.filter.x[VELOCITY], self.filter.x[VELOCITY + 1])
    }

    /// Acceleration of Q, m/s^2.
    pub fn acceleration(&self) -> Vec2 {
        Vec2::new(self.filter.x[ACCELERATION], self.filter.x[ACCELERATION + 1])
    }

    /// Variance of the load that nobody knows, N^2: what parity residuals have lately shown beyond what was expected of them.
    pub fn unexplained(&self) -> f64 {
        self.unexplained
    }

    /// A state and its standard deviation.
    pub fn found(&self, state: usize) -> (f64, f64) {
        (
            self.filter.x[state],
            libm::sqrt(self.filter.p[state][state].max(0.0)),
        )
    }

    /// Wheel `i` moves along the ground and rolls. With `correct` that may change what is known of angles and torques;
    /// else it only tells velocity and acceleration, and the angles count as noise.
    pub fn roll(
        &mut self,
        budget: &NoiseBudget,
        i: usize,
        wheel: &Rolling,
        dt: f64,
        correct: bool,
    ) {
        let noise = Noise {
            dt,
            pace: pace(self.velocity()),
        };
        let smooth = self.velocity() + wheel.smooth_relative;
        let trembling = wheel.relative - wheel.smooth_relative;
        let slope = wheel.angle - self.filter.x[CONTACT_ANGLE + i];
        let course = Course::new(smooth, trembling, slope);
        let shared = self.follow_ground(budget, i, wheel, &course, &noise, correct);
        if let Some(rim_speed) = wheel.rim_speed {
            self.slip(i, wheel, &course, rim_speed, shared, &noise, correct);
        }
    }

    /// The direction of the velocity is the contact angle. A wheel whose velocity leaves the ground by more than all that is unsure at this
    /// instant is doubted.
    ///
    /// Returns the variance that the wheel's other equation shares: the gyroscope's noise and doubt in the wheel, m^2/s^2.
    fn follow_ground(
        &mut self,
        budget: &NoiseBudget,
        i: usize,
        wheel: &Rolling,
        course: &Course,
        noise: &Noise,
        correct: bool,
    ) -> f64 {
        let (bias, sample) = wheel.relative_sigma;
        let h = course.aside_and_slope(i);
        let ph = self.filter.covariance_times(&h);
        let of_states = Kalman::<COUNT, CONSIDERED>::along(&ph, &h);
        let (rate, _) = noise.paced(tuning::PENETRATION_RATE);
        let at_once = of_states + rate * rate + bias * bias + sample * sample;
        if course.away * course.away > tuning::DOUBT_GATE * tuning::DOUBT_GATE * at_once {
            self.doubt[i] = tuning::DOUBT_TIME;
        }
        let wavering = tuning::GYRO_NOISE * sample;
        let mut shared = noise.white((bias, tuning::SLIP.1)) + wavering * wavering;
        if self.doubt[i] > 0.0 {
            shared += noise.white(tuning::DOUBT);
        }
        let r = noise.white(noise.paced(tuning::PENETRATION_RATE)) + shared;
        if correct {
            let variance = of_states + r;
            self.filter
                .apply_within(&ph, -course.away, variance, tuning::GATE);
        } else {
            let (_, sigma) = self.found(CONTACT_ANGLE + i);
            let unknown = noise.white((course.speed * sigma, budget.contact_angle_time));
            let [x, y, _] = h;
            self.filter
                .update(&[x, y], -course.away, r + unknown, tuning::GATE);
        }
        shared
    }

    /// The size of the velocity is the rim's speed less the slip.
    #[expect(
        clippy::too_many_arguments,
        reason = "two of them are what the caller has computed for both equations"
    )]
    fn slip(
        &mut self,
        i: usize,
        wheel: &Rolling,
        course: &Course,
        rim_speed: f64,
        shared: f64,
        noise: &Noise,
        correct: bool,
    ) {
        let creep = self.filter.x[CREEP];
        let slip = creep * wheel.ratio;
        // An error of the torque shifts T/N.
        let by_offset = -creep / wheel.moment_of_load;
        let observed = by_offset * wheel.torque_sigma;
        // What the linear filter leaves out: creep and T/N are both unsure, and their product is what slips.
        let p = &self.filter.p;
        let ratio_variance = (p[TORQUE_OFFSET + i][TORQUE_OFFSET + i]
            + p[GEAR_FRICTION][GEAR_FRICTION]
            + p[TORQUE_GAIN + i][TORQUE_GAIN + i] * wheel.torque * wheel.torque)
            / (wheel.moment_of_load * wheel.moment_of_load);
        let product = libm::sqrt(p[CREEP][CREEP] * ratio_variance);
        let (sticking, sliding) = tuning::STICKING;
        let fourth = |limit: f64| {
            let square = wheel.ratio * wheel.ratio / (limit * limit);
            square * square
        };
        let excess = fourth(sticking) + fourth(sliding) * fourth(sliding);
        let mut r = noise.white(noise.paced(tuning::SLIP)) * (1.0 + excess)
            + noise.white((product, tuning::SLIP.1))
            + noise.white((observed, tuning::OBSERVER_TIME))
            + shared;
        let rolls = course.speed.abs() > tuning::SLOW;
        if !rolls {
            // A wheel at rest holds its traction with slip or without.
            r += noise.white((slip, tuning::SLIP.1));
        }
        let difference = rim_speed - course.speed - slip;
        let [x, y] = [
            (VELOCITY, course.direction.x),
            (VELOCITY + 1, course.direction.y),
        ];
        let (_, used) = if correct && rolls {
            let h = [
                x,
                y,
                (CREEP, wheel.ratio),
                (TORQUE_OFFSET + i, by_offset),
                (GEAR_FRICTION, by_offset * wheel.turning),
                (TORQUE_GAIN + i, by_offset * wheel.torque),
            ];
            self.filter.update(&h, difference, r, tuning::GATE)
        } else {
            self.filter.update(&[x, y], difference, r, tuning::GATE)
        };
        if !used {
            self.doubt_velocity(noise.dt);
        }
        // A wheel that is driven never creeps backwards.
        let creep = &mut self.filter.x[CREEP];
        *creep = creep.max(tuning::LEAST_CREEP);
    }

    /// A rim's speed says otherwise: within a second nothing is known of the velocity any more, so that it can be found anew.
    fn doubt_velocity(&mut self, dt: f64) {
        for v in [VELOCITY, VELOCITY + 1] {
            self.filter.p[v][v] += tuning::UNKNOWN_VELOCITY * tuning::UNKNOWN_VELOCITY * dt;
        }
    }

    /// The parity residual, N, should be zero. `h` is its sensitivity to the states from [`ACCELERATION`] on, `variance` (N^2) that
    /// of what no state covers, at this instant.
    ///
    /// Returns what was expected of it at this instant, and whether it lies within its gate. Beyond, the robot was struck.
    pub fn parity(
        &mut self,
        h: &[f64; SENSITIVE],
        value: f64,
        variance: f64,
        dt: f64,
        correct: bool,
    ) -> (Innovation, bool) {
        let mut row = [(0, 0.0); SENSITIVE];
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = (ACCELERATION + k, h[k]);
        }
        let (unknown, time) = tuning::PARITY;
        let at_once = variance + unknown * unknown;
        let ph = self.filter.covariance_times(&row);
        let of_states = Kalman::<COUNT, CONSIDERED>::along(&ph, &row);
        let innovation = Innovation {
            value: -value,
            variance: of_states + at_once,
        };
        let square = value * value;
        let (expected, gate) = (
            tuning::EXPECTED * tuning::EXPECTED * innovation.variance,
            tuning::GATE * tuning::GATE * innovation.variance,
        );
        let shown = (square - expected).min(tuning::BLOW.2);
        self.unexplained = self.unexplained.max(shown);
        // A blow, or what is left of one.
        if self.unexplained > gate - expected {
            self.doubt = [tuning::DOUBT_TIME; 3];
        }
        let within_gate = square <= gate;
        if correct && within_gate {
            let lasting = (at_once + self.unexplained) * (2.0 * time / dt).max(1.0);
            self.filter.apply(&ph, -value, of_states + lasting);
        }
        (innovation, within_gate)
    }
}

/// States that the forces depend on: from [`state::ACCELERATION`] up to the gains.
pub(crate) const SENSITIVE: usize = COUNT - ACCELERATION;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use nalgebra::SMatrix;

    const DT: f64 = 1e-3;

    fn wheel(random: &mut Random) -> Rolling {
        Rolling {
            relative: Vec2::new(random.normal(), random.normal()) * 0.02,
            smooth_relative: Vec2::zeros(),
            angle: 0.2 * random.normal(),
            rim_speed: Some(0.2 + 0.01 * random.normal()),
            ratio: (0.3 * random.normal()).clamp(-1.0, 1.0),
            moment_of_load: 4.5,
            turning: 1.0,
            torque: random.normal(),
            relative_sigma: (1e-3, 1e-3),
            torque_sigma: 0.05,
        }
    }

    /// Asymmetry and the least eigenvalue of the covariance scaled to a correlation (whose trace is the number of states).
    fn defects(motion: &MotionFilter) -> (bool, f64) {
        let p = &motion.filter.p;
        let symmetric = (0..COUNT).all(|i| (0..i).all(|j| p[i][j].to_bits() == p[j][i].to_bits()));
        let scaled =
            SMatrix::<f64, COUNT, COUNT>::from_fn(|i, j| p[i][j] / libm::sqrt(p[i][i] * p[j][j]));
        (symmetric, scaled.symmetric_eigenvalues().min())
    }

    /// Over 20 000 steps of random readings, gaps and outliers the covariance stays symmetric to the bit and positive. At the
    /// start nothing is known, then states differ in certainty by up to 1e4: rounding in the scaled matrix is 1e-12.
    #[test]
    fn covariance_stays_symmetric_and_positive() {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget);
        let mut random = Random::new();
        let mut least = f64::INFINITY;
        for k in 0..20_000_u32 {
            let dt = if k % 997 == 0 { 0.4 } else { DT };
            let shaken = if k % 300 < 20 { 3.0 } else { 0.0 };
            motion.predict(&budget, dt, [k % 3 != 0, k % 500 > 100, true], 0.1, shaken);
            for i in 0..3 {
                let correct = k % 5 != 0;
                motion.roll(&budget, i, &wheel(&mut random), dt, correct);
            }
            let h = core::array::from_fn(|_| 5.0 * random.normal());
            let value = if k % 100 == 0 { 1e6 } else { random.normal() };
            motion.parity(&h, value, 0.5, dt, true);
            if k % 100 == 0 {
                let (symmetric, eigenvalue) = defects(&motion);
                assert!(symmetric, "step {k}");
                least = least.min(eigenvalue);
            }
        }
        assert!(least > 1e-12, "{least}");
        assert!(motion.filter.x.iter().all(|x| x.is_finite()));
    }

    /// Wheels that roll on known slopes at a known speed tell the velocity: along the ground, at the speed of the rims.
    #[test]
    fn rolling_tells_the_velocity() {
        let budget = NoiseBudget::typical();
        let mut motion = MotionFilter::new(&budget);
        let (slope, speed) = (0.2_f64, 0.2);
        for _ in 0..2000 {
            motion.predict(&budget, DT, [true; 3], 0.0, 0.0);
            for i in 0..3 {
                let wheel = Rolling {
                    relative: Vec2::zeros(),
                    smooth_relative: Vec2::zeros(),
                    angle: slope,
                    rim_speed: Some(speed),
                    ratio: 0.0,
                    moment_of_load: 4.5,
                    turning: 1.0,
                    torque: 0.0,
                    relative_sigma: (0.0, 0.0),
                    torque_sigma: 0.05,
                };
                motion.roll(&budget, i, &wheel, DT, true);
            }
        }
        let along = Vec2::new(libm::cos(slope), libm::sin(slope)) * speed;
        // The contact angles' own error, 2 deg over three wheels, tilts the velocity; along the ground the prior of the
        // acceleration pulls by less than 1e-3.
        assert!(
            (motion.velocity() - along).norm() < 0.01 * speed,
            "{}",
            motion.velocity()
        );
    }

    /// Contact angles that err by 6 deg tell where the velocity points, not how large it is: without encoders a second changes it by
    /// a tenth. That tenth is what is left of an inconsistency: the direction about which the equations are linear wavers. About the
    /// contact angles themselves they would stop the robot within that second.
    #[test]
    fn erring_slopes_do_not_slow_the_robot_down() {
        let budget = NoiseBudget {
            contact_angle: 0.1,
            ..NoiseBudget::typical()
        };
        let mut motion = MotionFilter::new(&budget);
        motion.filter.x[VELOCITY] = 0.2;
        let mut random = Random::new();
        let keep = libm::exp(-DT / budget.contact_angle_time);
        let fresh = budget.contact_angle * libm::sqrt(1.0 - keep * keep);
        let mut errors = [0.0; 3];
        for _ in 0..1000 {
            motion.predict(&budget, DT, [true; 3], 0.0, 0.0);
            for (i, error) in errors.iter_mut().enumerate() {
                *error = keep * *error + fresh * random.normal();
                let wheel = Rolling {
                    relative: Vec2::new(0.0, 2e-3 * random.normal()),
                    smooth_relative: Vec2::zeros(),
                    angle: *error,
                    rim_speed: None,
                    relative_sigma: (0.0, 2e-3),
                    ..wheel(&mut random)
                };
                motion.roll(&budget, i, &wheel, DT, true);
            }
        }
        let speed = libm::sqrt(motion.velocity().norm_squared());
        assert!((speed - 0.2).abs() < 0.04, "{}", motion.velocity());
    }

    /// A wheel whose velocity leaves the ground by more than all that is unsure does not roll on it: it is doubted, so that it tells
    /// a tenth of what it would, until a fifth of a second has passed without that.
    #[test]
    fn a_wheel_that_leaves_its_ground_is_doubted() {
        let budget = NoiseBudget::typical();
        let told = |slope: f64, after: u32| {
            let mut random = Random::new();
            let mut motion = MotionFilter::new(&budget);
            motion.filter.x[VELOCITY] = 0.2;
            let rolling = |motion: &mut MotionFilter, slope: f64, random: &mut Random| {
                let wheel = Rolling {
                    relative: Vec2::zeros(),
                    angle: slope,
                    rim_speed: None,
                    ..wheel(random)
                };
                motion.roll(&budget, 0, &wheel, DT, true);
            };
            rolling(&mut motion, slope, &mut random);
            for _ in 0..after {
                motion.predict(&budget, DT, [true; 3], 0.0, 0.0);
            }
            let before = motion.filter.x[CONTACT_ANGLE];
            rolling(&mut motion, 0.05, &mut random);
            (motion.filter.x[CONTACT_ANGLE] - before).abs()
        };
        let (calm, doubted) = (told(0.0, 150), told(1.5, 150));
        assert!(calm > 0.0 && doubted < 0.1 * calm, "{calm} {doubted}");
        assert!(told(1.5, 250) > 0.5 * told(0.0, 250));
    }

    /// A parity residual beyond what is expected counts as load that nobody knows: all of it but two standard deviations. It fades
    /// with its time constant, and no wheel is believed to roll meanwhile.
    #[test]
    fn a_blow_is_told_and_fades() {
        let budget = NoiseBudget::typical();
        let h = [0.0; SENSITIVE];
        let mut motion = MotionFilter::new(&budget);
        let (innovation, believed) = motion.parity(&h, 20.0, 1.0, DT, true);
        assert!(!believed && innovation.nis() > 300.0);
        let expected = 400.0 - 4.0 * innovation.variance;
        assert!((motion.unexplained() - expected).abs() < 1e-9);
        assert!(motion.doubt.iter().all(|time| *time >= tuning::DOUBT_TIME));
        for _ in 0..100 {
            motion.predict(&budget, DT, [true; 3], 0.0, 0.0);
        }
        let faded = expected * libm::exp(-0.1 / tuning::BLOW.0);
        assert!((motion.unexplained() - faded).abs() < 1e-9 * expected);
        // What was expected of the residual itself does not change by that: its NIS tells of blows.
        let (innovation, _) = motion.parity(&h, 0.0, 1.0, DT, true);
        assert!((innovation.variance - 1.0 - tuning::PARITY.0.powi(2)).abs() < 1e-12);
        for _ in 0..1000 {
            motion.predict(&budget, DT, [true; 3], 0.0, 0.0);
        }
        assert_eq!(motion.unexplained().to_bits(), 0.0_f64.to_bits());
    }

    /// A gated parity residual moves no state; an accepted one moves the states towards what explains it. No parity residual tells
    /// of gains.
    #[test]
    fn parity_moves_the_states_that_explain_it() {
        let budget = NoiseBudget::typical();
        let offset = TORQUE_OFFSET - ACCELERATION;
        let mut h = [0.0; SENSITIVE];
        h[offset] = 10.0;
        h[TORQUE_GAIN - ACCELERATION] = 10.0;
        let new = MotionFilter::new(&budget);
        let mut motion = new;
        // The residual stands for an offset of -0.05 N m: value + h x = 0.
        let (innovation, believed) = motion.parity(&h, 0.5, 1e-4, DT, true);
        assert!(believed && innovation.nis() < 1.0);
        let x = motion.filter.x[TORQUE_OFFSET];
        assert!(x < 0.0 && x > -0.05, "{x}");
        assert!(
            motion.filter.p[TORQUE_OFFSET][TORQUE_OFFSET]
                < new.filter.p[TORQUE_OFFSET][TORQUE_OFFSET]
        );
        assert_eq!(motion.found(TORQUE_GAIN), new.found(TORQUE_GAIN));
        let mut motion = new;
        assert!(!motion.parity(&h, 100.0, 1e-4, DT, true).1);
        assert_eq!(motion.filter, new.filter);
        motion.parity(&h, 0.5, 1e-4, DT, false);
        assert_eq!(motion.filter, new.filter);
    }
}

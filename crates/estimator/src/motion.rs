//! What hides behind the readings: motion of the robot, errors of contact angles and torques, creep of the wheels; one
//! Kalman filter over all of them.
//!
//! Three things must hold, and each is a measurement of these states:
//! - a wheel's centre moves along the ground: `v . n(gamma) = 0` up to the rate of its penetration;
//! - a wheel rolls: `v . t(gamma) = r Omega - slip`, and while it sticks slip grows with T/N (creep), through zero;
//! - the parity residual of eq. (8) is zero.
//!
//! The first ties the contact angles to each other and to the gyroscopes; the second tells offsets of the torques from
//! tractions, because a wheel that does not slip does not pull; the third ties the sum of it all to the weight.

use crate::kalman::{Innovation, Kalman};
use crate::settings::NoiseBudget;
use crate::visit::Visit;
use robhaz_model::Vec2;

/// Places of the states.
pub(crate) mod state {
    /// Velocity of Q, m/s: x, y.
    pub const VELOCITY: usize = 0;
    /// Acceleration of Q, m/s^2: x, y.
    pub const ACCELERATION: usize = 2;
    /// Errors of the contact angles given, rad.
    pub const CONTACT_ANGLE: usize = 4;
    /// Offsets of the motor torques read, N m.
    pub const TORQUE_OFFSET: usize = 7;
    /// Dry friction in the gears, common to all, N m against the spin.
    pub const GEAR_FRICTION: usize = 10;
    /// Relative errors of the motor torques read.
    pub const TORQUE_GAIN: usize = 11;
    /// Slip for T = N, linear part, m/s.
    pub const CREEP: usize = 14;
    /// Slip for T = N, cubic part, m/s.
    pub const CREEP_CUBE: usize = 15;
    /// How many.
    pub const COUNT: usize = 16;
}
use state::*;

/// How the states change and how well the measurements hold: one tuning for all sensors and grounds. Errors that last are
/// given by size and correlation time `tau`; a filter that takes them as white at every sample `dt` must take
/// `sigma^2 2 tau/dt` for their variance.
mod tuning {
    /// Acceleration of Q: Gauss-Markov, m/s^2 and s. At 0.2 m/s a course with radii of 0.4 m gives 0.1 m/s^2.
    pub const ACCELERATION: (f64, f64) = (0.07, 0.3);
    /// Velocity at the start, m/s.
    pub const START_VELOCITY: f64 = 0.01;
    /// Velocity after a gap, m/s.
    pub const UNKNOWN_VELOCITY: f64 = 0.5;
    /// Rate of penetration, m/s and s: 0.5 mm of penetration change by a tenth of themselves over 50 ms.
    pub const PENETRATION_RATE: (f64, f64) = (3e-4, 0.05);
    /// Slip beyond creep, m/s and s: the wheel radius without the penetration's changes errs by 0.1 % of the speed.
    pub const SLIP: (f64, f64) = (3e-4, 0.3);
    /// Time over which errors of the torque observer last, s.
    pub const OBSERVER_TIME: f64 = 0.05;
    /// T/N beyond which slip is no longer cubic in it: trust falls with the second power of the excess.
    pub const STICKING: f64 = 0.2;
    /// Creep at T = N, m/s: of the order of 10 mm/s for small hard wheels, unknown within as much.
    pub const CREEP: (f64, f64) = (0.015, 0.01);
    /// Least creep, m/s: harder wheels than these are not told from rigid ones.
    pub const LEAST_CREEP: f64 = 5e-4;
    /// Cubic part of the creep, m/s.
    pub const CREEP_CUBE: f64 = 0.01;
    /// Random walks: torque offset (N m/sqrt(s)), gear friction (N m/sqrt(s)), gain (1/sqrt(s)), creep (m/s/sqrt(s)).
    pub const WALK: (f64, f64, f64, f64) = (1e-3, 5e-3, 2e-4, 1e-3);
    /// Parity residual: errors of load that no state covers, N, and the time over which they and those of the torque
    /// observer last, s.
    pub const PARITY: (f64, f64) = (0.1, 0.02);
    /// Walk of a contact angle while none comes, rad/sqrt(s).
    pub const ANGLE_UNSEEN: f64 = 0.5;
    /// Least error of a contact angle, rad, so that a budget of zero does not make the filter deaf.
    pub const LEAST_ANGLE: f64 = 1e-3;
    /// Innovations beyond so many standard deviations are left out.
    pub const GATE: f64 = 5.0;
}

/// A wheel as the filter sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rolling {
    /// Velocity of the axle relative to Q, m/s.
    pub relative: Vec2,
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
    /// Standard deviation of the axle's velocity relative to Q, m/s: the gyroscope's bias.
    pub relative_sigma: f64,
    /// Standard deviation of r T as observed, N m.
    pub torque_sigma: f64,
}

/// The filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionFilter {
    pub filter: Kalman<COUNT>,
}

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
        sigma[CREEP_CUBE] = tuning::CREEP_CUBE;
        Self {
            filter: Kalman::new(x, sigma),
        }
    }

    /// The robot may be moving already.
    pub fn forget_velocity(&mut self) {
        for v in [VELOCITY, VELOCITY + 1] {
            self.filter.p[v][v] = tuning::UNKNOWN_VELOCITY * tuning::UNKNOWN_VELOCITY;
        }
    }

    /// Goes on by `dt`, s. `seen` tells for which wheels a contact angle came with this frame.
    pub fn predict(&mut self, budget: &NoiseBudget, dt: f64, seen: [bool; 3]) {
        let Kalman { x, p } = &mut self.filter;
        let (push, push_time) = tuning::ACCELERATION;
        let slope = budget.contact_angle.max(tuning::LEAST_ANGLE);
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
        let (offset, friction, gain, creep) = tuning::WALK;
        for i in 0..3 {
            let unseen = if seen[i] { 0.0 } else { tuning::ANGLE_UNSEEN };
            let fresh = slope * slope * (1.0 - keep_slope * keep_slope);
            walk(CONTACT_ANGLE + i, fresh + unseen * unseen * dt);
            walk(TORQUE_OFFSET + i, offset * offset * dt);
            walk(TORQUE_GAIN + i, gain * gain * dt);
        }
        walk(GEAR_FRICTION, friction * friction * dt);
        walk(CREEP, creep * creep * dt);
    }

    /// Velocity of Q, m/s.
    pub fn velocity(&self) -> Vec2 {
        Vec2::new(self.filter.x[VELOCITY], self.filter.x[VELOCITY + 1])
    }

    /// Acceleration of Q, m/s^2.
    pub fn acceleration(&self) -> Vec2 {
        Vec2::new(self.filter.x[ACCELERATION], self.filter.x[ACCELERATION + 1])
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
        let e = CONTACT_ANGLE + i;
        let white = |(sigma, time): (f64, f64)| sigma * sigma * 2.0 * time / dt;
        let v = self.velocity() + wheel.relative;
        let (sin, cos) = libm::sincos(wheel.angle - self.filter.x[e]);
        let (normal, along) = (v.y * cos - v.x * sin, v.x * cos + v.y * sin);
        let gyro = white((wheel.relative_sigma, tuning::SLIP.1));
        let mut r = white(tuning::PENETRATION_RATE) + gyro;
        if correct {
            let h = [(VELOCITY, -sin), (VELOCITY + 1, cos), (e, along)];
            self.filter.update(&h, -normal, r, tuning::GATE);
        } else {
            let unknown = along * libm::sqrt(self.filter.p[e][e]);
            r += white((unknown, budget.contact_angle_time));
            let h = [(VELOCITY, -sin), (VELOCITY + 1, cos)];
            self.filter.update(&h, -normal, r, tuning::GATE);
        }

        let Some(rim_speed) = wheel.rim_speed else {
            return;
        };
        let (linear, cubic) = (self.filter.x[CREEP], self.filter.x[CREEP_CUBE]);
        let square = wheel.ratio * wheel.ratio;
        let slip = (linear + cubic * square) * wheel.ratio;
        let excess = square / (tuning::STICKING * tuning::STICKING);
        let difference = rim_speed - along - slip;
        // An error of the torque shifts T/N.
        let by_offset = -(linear + 3.0 * cubic * square) / wheel.moment_of_load;
        let observed = by_offset * wheel.torque_sigma;
        // What the linear filter leaves out: creep and T/N are both unsure, and their product is what slips.
        let p = &self.filter.p;
        let ratio_variance = (p[TORQUE_OFFSET + i][TORQUE_OFFSET + i]
            + p[GEAR_FRICTION][GEAR_FRICTION]
            + p[TORQUE_GAIN + i][TORQUE_GAIN + i] * wheel.torque * wheel.torque)
            / (wheel.moment_of_load * wheel.moment_of_load);
        let product = libm::sqrt(p[CREEP][CREEP] * ratio_variance);
        let r = white(tuning::SLIP) * (1.0 + excess * excess)
            + white((product, tuning::SLIP.1))
            + gyro
            + white((observed, tuning::OBSERVER_TIME));
        if correct {
            let h = [
                (VELOCITY, cos),
                (VELOCITY + 1, sin),
                (e, -normal),
                (CREEP, wheel.ratio),
                (CREEP_CUBE, wheel.ratio * square),
                (TORQUE_OFFSET + i, by_offset),
                (GEAR_FRICTION, by_offset * wheel.turning),
                (TORQUE_GAIN + i, by_offset * wheel.torque),
            ];
            self.filter.update(&h, difference, r, tuning::GATE);
            // A wheel that is driven never creeps backwards.
            let creep = &mut self.filter.x[CREEP];
            *creep = creep.max(tuning::LEAST_CREEP);
            let cube = &mut self.filter.x[CREEP_CUBE];
            *cube = cube.max(0.0);
        } else {
            let h = [(VELOCITY, cos), (VELOCITY + 1, sin)];
            self.filter.update(&h, difference, r, tuning::GATE);
        }
    }

    /// The parity residual, N, should be zero. `h` is its sensitivity to the states from [`ACCELERATION`] on, `variance` (N^2) that
    /// of what no state covers, at this instant.
    ///
    /// Returns what was expected of it at this instant.
    pub fn parity(
        &mut self,
        h: &[f64; SENSITIVE],
        value: f64,
        variance: f64,
        dt: f64,
        correct: bool,
    ) -> Innovation {
        let mut row = [(0, 0.0); SENSITIVE];
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = (ACCELERATION + k, h[k]);
        }
        let (unknown, time) = tuning::PARITY;
        let at_once = variance + unknown * unknown;
        let ph = self.filter.covariance_times(&row);
        let mut expected = at_once;
        for &(k, value) in &row {
            expected += ph[k] * value;
        }
        let innovation = Innovation {
            value: -value,
            variance: expected,
        };
        if correct && innovation.nis() <= tuning::GATE * tuning::GATE {
            let lasting = at_once * (2.0 * time / dt).max(1.0);
            self.filter.apply(&ph, -value, expected - at_once + lasting);
        }
        innovation
    }
}

/// States from [`state::ACCELERATION`] up to the gains: those that the forces depend on.
pub(crate) const SENSITIVE: usize = CREEP - ACCELERATION;

/// Standard deviations beyond which an innovation is left out.
pub(crate) const GATE: f64 = tuning::GATE;

impl Visit for MotionFilter {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        self.filter.visit(f);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use nalgebra::SMatrix;

    const DT: f64 = 1e-3;

    fn wheel(random: &mut Random) -> Rolling {
        Rolling {
            relative: Vec2::new(random.normal(), random.normal()) * 0.02,
            angle: 0.2 * random.normal(),
            rim_speed: Some(0.2 + 0.01 * random.normal()),
            ratio: (0.3 * random.normal()).clamp(-1.0, 1.0),
            moment_of_load: 4.5,
            turning: 1.0,
            torque: random.normal(),
            relative_sigma: 1e-3,
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
            motion.predict(&budget, dt, [k % 3 != 0, k % 500 > 100, true]);
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
            motion.predict(&budget, DT, [true; 3]);
            for i in 0..3 {
                let wheel = Rolling {
                    relative: Vec2::zeros(),
                    angle: slope,
                    rim_speed: Some(speed),
                    ratio: 0.0,
                    moment_of_load: 4.5,
                    turning: 1.0,
                    torque: 0.0,
                    relative_sigma: 0.0,
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

    /// A gated parity residual changes nothing; an accepted one moves the states towards what explains it.
    #[test]
    fn parity_moves_the_states_that_explain_it() {
        let budget = NoiseBudget::typical();
        let offset = TORQUE_OFFSET - ACCELERATION;
        let mut h = [0.0; SENSITIVE];
        h[offset] = 10.0;
        let new = MotionFilter::new(&budget);
        let mut motion = new;
        // The residual stands for an offset of -0.05 N m: value + h x = 0.
        let innovation = motion.parity(&h, 0.5, 1e-4, DT, true);
        assert!(innovation.nis() < 1.0);
        let x = motion.filter.x[TORQUE_OFFSET];
        assert!(x < 0.0 && x > -0.05, "{x}");
        assert!(
            motion.filter.p[TORQUE_OFFSET][TORQUE_OFFSET]
                < new.filter.p[TORQUE_OFFSET][TORQUE_OFFSET]
        );
        let mut motion = new;
        assert!(motion.parity(&h, 100.0, 1e-4, DT, true).nis() > GATE * GATE);
        assert_eq!(motion, new);
        motion.parity(&h, 0.5, 1e-4, DT, false);
        assert_eq!(motion, new);
    }
}

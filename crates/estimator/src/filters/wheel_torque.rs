//! Torque of the ground on a wheel by a Kalman filter on the encoder's angle: the task of eq. (3),
//! without its lag.

use super::kalman::Kalman;
mod encoder;

use super::motion::REFERENCE_SPEED;
use crate::common::TYPICAL;
use crate::deviation::{UNIFORM, root_sum_square};

/// Parameters of wheel, drive and sensors at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelParameters {
    /// J_wheel, kg m^2: resists the absolute spin.
    pub wheel_inertia: f64,
    /// J_rotor, kg m^2: resists the relative spin.
    pub rotor_inertia: f64,
    /// Internal damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Standard deviation of the encoder's reading, rad.
    pub encoder_sigma: f64,
    /// Standard deviation of the torque's white noise, a sample, N m.
    pub torque_sigma: f64,
    /// Speed of the rim relative to the link, m/s.
    pub rim_speed: f64,
    /// Random walk of the motor torque while it is not read, N m/sqrt(s); 0 with a reading.
    pub unread_walk: f64,
}

/// States: spin angle (rad), spin speed (rad/s), torque of the ground `d T` (N m) and its rate (N
/// m/s).
///
/// The second derivative of that torque is white noise. Eq. (2), with separate inertias of wheel
/// and rotor, relates torque and speed:
/// `(J_wheel + J_rotor) domega/dt = tau - B omega - d T + J_wheel alpha_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueObserver {
    filter: Kalman<4>,
    /// Whether a reading has set the angle: not where the encoder counts from a new zero.
    pub started: bool,
}

/// Standard deviation of the angle of a typical encoder, rad: a count over sqrt(12).
/// Definition.
pub(crate) const COUNT_SIGMA: f64 = 2.0 * core::f64::consts::PI / TYPICAL.encoder_counts * UNIFORM;

const ANGLE: usize = 0;
const SPEED: usize = 1;
const TORQUE: usize = 2;
const RATE: usize = 3;

impl TorqueObserver {
    /// Density of the white second derivative of the ground's torque, N m/s^2/sqrt(Hz), for
    /// readings of typical sensors, up to [`REFERENCE_SPEED`] of the rim. At this value the lag on
    /// the PI drive's fast torques and the noise of the encoder cost the same error. Above that
    /// speed it grows with the speed to the power of 3/2: the torque changes along the ground, so
    /// that its second derivative is v^2 times that along the ground, whose white noise over the
    /// length is by 1/v less dense over the time.
    ///
    /// For finer readings the density is larger, so the observer is faster: in inverse proportion
    /// to the coarser of the two readings, down to [`Self::FINEST`] of these.
    /// Chosen; sensitive.
    const TORQUE_JERK: f64 = 5.0;
    /// See [`Self::TORQUE_JERK`].
    /// Guard.
    const FINEST: f64 = 0.04;
    /// Standard deviation of the change of the ground's torque in an impact, N m; its rate changes
    /// by that over [`SMOOTHING`].
    ///
    /// This and the next one were chosen from 0.5 to 5 N m and 0.01 to 0.5 rad/s for the least
    /// error behind a ramp's corner and a ditch's edges. On rolling ground no innovation exceeds
    /// the gate.
    /// Chosen; sensitive.
    const IMPACT_TORQUE: f64 = 1.0;
    /// Standard deviation of the change of the spin speed, rad/s. Without it the filter would
    /// explain the speed change of the impact by a constant torque.
    /// Chosen; sensitive.
    const IMPACT_SPEED: f64 = 0.02;

    /// Damping over inertia times a step of the prediction, at most.
    /// Guard.
    const LARGEST_STEP: f64 = 0.5;
    /// Steps of a prediction, at most: of 0.5 s from a damping over inertia of 1000/s on.
    /// Guard.
    const MOST_STEPS: f64 = 1000.0;
    /// Standard deviation of the speed of a wheel at rest, rad/s.
    /// Guard.
    pub const AT_REST: f64 = 0.01;
    /// The same of a wheel that may be spinning: 2 m/s at the rim.
    /// Guard.
    pub const SPINNING: f64 = 20.0;
    /// Standard deviation of a speed that is known, rad/s: 0.1 m/s at the rim.
    /// Guard.
    const SETTLED: f64 = 1.0;

    /// Starts with a wheel whose speed is within a standard deviation of 0, rad/s:
    /// [`Self::AT_REST`], [`Self::SPINNING`]. The ground's torque is within 5 N m.
    pub fn new(speed_sigma: f64) -> Self {
        Self {
            filter: Kalman::new([0.0; 4], [0.0, speed_sigma, 5.0, 5.0]),
            started: false,
        }
    }

    /// Advances by `dt` (s) under the motor torque `torque` (N m, mean over the interval) with the
    /// link's angular acceleration `alpha_link` (rad/s^2, counter-clockwise).
    pub fn predict(&mut self, parameters: &WheelParameters, dt: f64, torque: f64, alpha_link: f64) {
        let inertia = parameters.wheel_inertia + parameters.rotor_inertia;
        let (b, j) = (parameters.viscous_damping / inertia, 1.0 / inertia);
        let of_link = parameters.wheel_inertia * alpha_link;
        // A step is of second order in b dt: with b dt > 2 it would amplify the speed that damping reduces.
        let steps = libm::ceil(b * dt / Self::LARGEST_STEP).clamp(1.0, Self::MOST_STEPS);
        for _ in 0..steps as u32 {
            self.advance(dt / steps, [torque, of_link], [b, j]);
        }
        self.add_process_noise(parameters, dt, j);
    }

    /// A step of `dt` (s) under the torques of motor and link (N m), with the damping over the inertia (1/s) and the
    /// inverse inertia (1/(kg m^2)).
    fn advance(&mut self, dt: f64, [motor, link]: [f64; 2], [b, j]: [f64; 2]) {
        let [_, omega, z, rate] = self.filter.x;
        let half = 0.5 * dt * dt;
        let acceleration = (motor - z + link) * j - b * omega;
        let jerk = -rate * j - b * acceleration;
        self.filter.x[ANGLE] += omega * dt + acceleration * half;
        self.filter.x[SPEED] += acceleration * dt + jerk * half;
        self.filter.x[TORQUE] += rate * dt;
        let speed = [
            1.0 - b * dt + b * b * half,
            -j * dt + b * j * half,
            -j * half,
        ];
        self.filter.p = propagate([dt - b * half, -j * half], speed, dt, &self.filter.p);
    }

    /// Noise of the torque reading, held over the interval `dt` (s), and of the ground's torque.
    /// `j` is the inverse inertia, 1/(kg m^2).
    ///
    /// The second derivative of the ground's torque is white, with the density q: what kicks within the step do to the
    /// four states. The motor's torque is as smooth, and known at both ends: what it differs by from the line between them
    /// changes the speed by an impulse with the variance q dt^5/120, and the angle besides with q dt^7/30240. Over a gap,
    /// all of these are more than the noise.
    fn add_process_noise(&mut self, parameters: &WheelParameters, dt: f64, j: f64) {
        let p = &mut self.filter.p;
        let coarse = (parameters.encoder_sigma / COUNT_SIGMA)
            .max(parameters.torque_sigma / TYPICAL.torque_noise);
        let faster = (parameters.rim_speed.abs() / REFERENCE_SPEED).max(1.0);
        let faster = faster * robhaz_model::sqrt(faster);
        let jerk = Self::TORQUE_JERK * faster / coarse.clamp(Self::FINEST, 1.0);
        let q = jerk * jerk * dt;
        let between = dt * dt * robhaz_model::sqrt(q / 120.0);
        // An error of the torque changes the speed, and turns the wheel at half of that speed.
        let kick = root_sum_square(parameters.torque_sigma * dt, between) * j;
        let turn = 0.5 * dt * kick;
        let early = dt * dt * dt * j * robhaz_model::sqrt(q / 30_240.0);
        p[ANGLE][ANGLE] += turn * turn + early * early;
        p[SPEED][SPEED] += kick * kick;
        p[TORQUE][TORQUE] += parameters.unread_walk * parameters.unread_walk * dt;
        let mut add = |a: usize, b: usize, value: f64| {
            p[a][b] += value;
            if a != b {
                p[b][a] += value;
            }
        };
        add(ANGLE, SPEED, turn * kick);
        // A kick has changed rate, torque, speed and angle after the time t by 1, t, -j t^2/2 and -j t^3/6.
        let (of_torque, of_speed, of_angle) = (q * dt, -j * q * dt * dt, -j * q * dt * dt * dt);
        add(RATE, RATE, q);
        add(TORQUE, RATE, of_torque / 2.0);
        add(TORQUE, TORQUE, of_torque * dt / 3.0);
        add(SPEED, RATE, of_speed / 6.0);
        add(SPEED, TORQUE, of_speed * dt / 8.0);
        add(SPEED, SPEED, of_speed * -j * dt * dt / 20.0);
        add(ANGLE, RATE, of_angle / 24.0);
        add(ANGLE, TORQUE, of_angle * dt / 30.0);
        add(ANGLE, SPEED, of_angle * -j * dt * dt / 72.0);
        add(ANGLE, ANGLE, of_angle * -j * dt * dt * dt / 252.0);
    }

    /// Turn of the wheel (rad) from the last prediction to an `angle` that is read `dt` (s) later,
    /// and the standard deviation of its prediction. `None` before the observer has settled.
    pub fn turn(&self, parameters: &WheelParameters, angle: f64, dt: f64) -> Option<(f64, f64)> {
        if !(self.started && self.settled()) {
            return None;
        }
        let p = &self.filter.p;
        let of_states = p[ANGLE][ANGLE] + dt * (2.0 * p[ANGLE][SPEED] + dt * p[SPEED][SPEED]);
        let variance = of_states.max(0.0) + parameters.encoder_sigma * parameters.encoder_sigma;
        Some((angle - self.filter.x[ANGLE], robhaz_model::sqrt(variance)))
    }

    /// Spin speed relative to the link and its standard deviation, rad/s.
    pub fn speed(&self) -> (f64, f64) {
        self.filter.estimated(SPEED)
    }

    /// Whether the speed of a wheel that may have been spinning has been found.
    pub fn settled(&self) -> bool {
        self.filter.p[SPEED][SPEED] < Self::SETTLED * Self::SETTLED
    }

    /// Torque of the ground on the wheel `d T`, N m, and its standard deviation.
    pub fn ground_torque(&self) -> (f64, f64) {
        self.filter.estimated(TORQUE)
    }

    /// Correlation time of the error of that torque, s.
    ///
    /// A settled filter of a torque of white second derivative has two poles at the frequency
    /// `w = (q/r)^(1/4)`, damped by 1/sqrt(2); q and r are the densities of that and of the reading's noise.
    /// The variance of the torque is `sqrt(2) r w`, that of its rate `sqrt(2) q/w`, and at low frequencies
    /// the density of the torque's error is 2 r. A Gauss-Markov error of this variance has `2 time variance`
    /// there, so `time = 1/(sqrt(2) w)`; `w^2` is the variance of the rate over that of the torque.
    pub fn error_time(&self) -> f64 {
        let p = &self.filter.p;
        robhaz_model::sqrt(0.5 * p[TORQUE][TORQUE] / p[RATE][RATE])
    }
}

/// `F P F'`, symmetric to the bit, for the transition matrix F of a step, of second order in it:
/// the factors of the angle by speed and torque, of the speed by speed, torque and its rate, of the
/// torque by its rate. What is not listed is that of the identity.
fn propagate(
    [by_speed, by_torque]: [f64; 2],
    [keep, from_torque, from_rate]: [f64; 3],
    by_rate: f64,
    p: &[[f64; 4]; 4],
) -> [[f64; 4]; 4] {
    // Angle, speed and torque of F x, for a row or column x of P or F P.
    let angle = |x: [f64; 4]| x[ANGLE] + by_speed * x[SPEED] + by_torque * x[TORQUE];
    let speed = |x: [f64; 4]| keep * x[SPEED] + from_torque * x[TORQUE] + from_rate * x[RATE];
    let torque = |x: [f64; 4]| x[TORQUE] + by_rate * x[RATE];
    let (of_angle, of_speed, of_torque) = (p.map(angle), p.map(speed), p.map(torque));
    let (aa, at, av) = (angle(of_angle), torque(of_angle), speed(of_angle));
    let (vv, vt, tt) = (speed(of_speed), torque(of_speed), torque(of_torque));
    let [ar, vr, tr] = [of_angle, of_speed, of_torque].map(|x| x[RATE]);
    [
        [aa, av, at, ar],
        [av, vv, vt, vr],
        [at, vt, tt, tr],
        [ar, vr, tr, p[RATE][RATE]],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use nalgebra::Matrix4;
    use proptest::prelude::*;

    const PARAMETERS: WheelParameters = WheelParameters {
        wheel_inertia: 0.0075,
        rotor_inertia: 0.0864,
        viscous_damping: 0.15,
        encoder_sigma: 1e-6,
        torque_sigma: 1e-3,
        rim_speed: 0.0,
        unread_walk: 0.0,
    };
    const INERTIA: f64 = PARAMETERS.wheel_inertia + PARAMETERS.rotor_inertia;

    proptest! {
        /// Equivalence: the propagated covariance is the product of full matrices. Entries are of
        /// order 1: 1e-13 is their rounding.
        #[test]
        fn the_propagated_covariance_is_that_of_the_matrix_product(
            root in prop::array::uniform16(-1.0_f64..1.0), f in prop::array::uniform6(-1.0_f64..1.0),
        ) {
            let root = Matrix4::from_row_slice(&root);
            let p = root * root.transpose();
            let [a1, a2, s1, s2, s3, t] = f;
            let entries = core::array::from_fn(|i| core::array::from_fn(|j| p[(i, j)]));
            let found = propagate([a1, a2], [s1, s2, s3], t, &entries);
            let f = Matrix4::new(
                1.0, a1, a2, 0.0, //
                0.0, s1, s2, s3, //
                0.0, 0.0, 1.0, t, //
                0.0, 0.0, 0.0, 1.0,
            );
            let expected = f * p * f.transpose();
            for i in 0..4 {
                for j in 0..4 {
                    prop_assert!((found[i][j] - expected[(i, j)]).abs() < 1e-13 * (1.0 + p.norm()), "{i} {j}");
                    prop_assert!(found[i][j].to_bits() == found[j][i].to_bits(), "not symmetric");
                }
            }
        }
    }

    /// A wheel under constant torques, integrated exactly:
    /// `omega = rest + (omega - rest) exp(-B t/J)`.
    #[derive(Default)]
    struct Wheel {
        angle: f64,
        speed: f64,
    }

    impl Wheel {
        fn step(&mut self, dt: f64, motor: f64, ground: f64, alpha_link: f64) {
            let b = PARAMETERS.viscous_damping;
            let rest = (motor - ground + PARAMETERS.wheel_inertia * alpha_link) / b;
            let decay = libm::exp(-b / INERTIA * dt);
            let above = self.speed - rest;
            self.angle += rest * dt + above * (1.0 - decay) * INERTIA / b;
            self.speed = rest + above * decay;
        }
    }

    /// Closed form: of torques of motor and ground between two readings, whose second derivatives are white, impulse and turn
    /// of the wheel have the variances of the integrals over what each kick of these derivatives does: the motor's to the
    /// line between its readings, the ground's to its course before. Within a thousandth of a sum in 2000 steps.
    #[test]
    fn a_torque_between_readings_is_not_known() {
        let (dt, parts) = (0.4, 2000);
        let parameters = WheelParameters {
            encoder_sigma: COUNT_SIGMA,
            torque_sigma: 0.0,
            ..PARAMETERS
        };
        let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
        observer.filter.p = [[0.0; 4]; 4];
        observer.predict(&parameters, dt, 0.0, 0.0);
        let step = dt / f64::from(parts);
        let [mut speed, mut both, mut angle, mut with_torque] = [0.0; 4];
        for k in 0..parts {
            let kick = (f64::from(k) + 0.5) * step;
            let (mut impulse, mut turn) = (0.0, 0.0);
            for l in 0..parts {
                let time = (f64::from(l) + 0.5) * step;
                let off = time.min(kick) * (dt - time.max(kick)) / dt;
                impulse += off * step;
                turn += (dt - time) * off * step;
            }
            let left = dt - kick;
            let (of_ground, turn_of_ground) = (left * left / 2.0, left * left * left / 6.0);
            speed += (impulse * impulse + of_ground * of_ground) * step;
            both += (impulse * turn + of_ground * turn_of_ground) * step;
            angle += (turn * turn + turn_of_ground * turn_of_ground) * step;
            with_torque -= INERTIA * of_ground * left * step;
        }
        let density = TorqueObserver::TORQUE_JERK / INERTIA;
        let p = &observer.filter.p;
        for (found, expected) in [
            (p[SPEED][SPEED], speed),
            (p[ANGLE][SPEED], both),
            (p[ANGLE][ANGLE], angle),
            (p[TORQUE][SPEED], with_torque),
        ] {
            let expected = density * density * expected;
            assert!(
                (found - expected).abs() < 1e-3 * expected.abs(),
                "{found} {expected}"
            );
        }
    }

    /// Closed form: a constant speed is predicted exactly by any step, and so is the torque of the ground,
    /// `tau - B omega`. In one step of 0.5 s, in which its damping would stop the wheel three times over, the variance of the
    /// speed would grow sixfold with each reading; it is 14 rad/s, for what a torque may do in half a second.
    #[test]
    fn a_wheel_that_is_rarely_read_has_its_speed() {
        let parameters = WheelParameters {
            viscous_damping: 6.0 * INERTIA,
            ..PARAMETERS
        };
        let mut observer = TorqueObserver::new(TorqueObserver::SPINNING);
        observer.measure(&parameters, 0.0);
        for k in 1..200 {
            observer.predict(&parameters, 0.5, 2.0, 0.0);
            observer.measure(&parameters, 0.5 * f64::from(k));
        }
        let (torque, expected) = (observer.ground_torque().0, 2.0 - 6.0 * INERTIA);
        assert!((torque - expected).abs() < 1e-9, "{torque} {expected}");
        let (speed, sigma) = observer.speed();
        assert!(
            (speed - 1.0).abs() < 1e-9 && sigma < 20.0,
            "{speed} {sigma}"
        );
    }

    /// Closed form: motor torque, damping and the link's angular acceleration account for all of
    /// the motion, so that a constant torque of the ground is found exactly: up to what an
    /// integration of second order leaves, (B dt/J)^2/6 = 4e-7 of 2 N m.
    #[test]
    fn a_constant_torque_is_found() {
        let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
        let mut wheel = Wheel {
            angle: 5.0,
            speed: 0.0,
        };
        assert_eq!(observer.measure(&PARAMETERS, wheel.angle), None);
        for _ in 0..5000 {
            wheel.step(1e-3, 2.5, 2.0, -3.0);
            observer.predict(&PARAMETERS, 1e-3, 2.5, -3.0);
            observer.measure(&PARAMETERS, wheel.angle);
        }
        let (torque, sigma) = observer.ground_torque();
        assert!((torque - 2.0).abs() < 1e-5, "{torque}");
        assert!((observer.speed().0 - wheel.speed).abs() < 1e-5);
        assert!(sigma > 0.0 && sigma < 0.1, "{sigma}");
    }

    /// A step of the ground's torque without one of the motor's torque is followed. With a jerk of
    /// 5 N m/s^2/sqrt(Hz) against the noise of the encoder the filter's time constant is some 20
    /// ms: after 0.2 s less than 1 % is left.
    #[test]
    fn a_step_settles() {
        let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
        let mut wheel = Wheel::default();
        observer.measure(&PARAMETERS, 0.0);
        let mut run = |seconds: f64, ground: f64| {
            for _ in 0..libm::round(seconds / 1e-3) as u32 {
                wheel.step(1e-3, 0.0, ground, 0.0);
                observer.predict(&PARAMETERS, 1e-3, 0.0, 0.0);
                observer.measure(&PARAMETERS, wheel.angle);
            }
            observer.ground_torque().0
        };
        assert!(run(1.0, 0.0).abs() < 1e-9);
        let soon = run(0.005, 1.0);
        assert!(soon > 0.0 && soon < 0.9, "{soon}");
        let later = run(0.2, 1.0);
        assert!((later - 1.0).abs() < 0.01, "{later}");
    }

    /// Consistency: with counts as noise the torque's error over many independent stretches is as
    /// large as stated. Errors over 40 s are worth some 500 independent ones; 0.8 to 1.25 is four
    /// standard errors of their RMS.
    #[test]
    fn the_stated_deviation_is_the_real_one() {
        let mut random = Random::new();
        let parameters = WheelParameters {
            encoder_sigma: 2e-5,
            ..PARAMETERS
        };
        let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
        let mut wheel = Wheel::default();
        observer.measure(&parameters, 0.0);
        let (mut ground, mut rate, dt) = (0.0, 0.0, 1e-3);
        let (mut square, mut count) = (0.0, 0.0);
        for k in 0..40_000 {
            // The model's own torque: white second derivative. Held at its mean over the step.
            let jerk = TorqueObserver::TORQUE_JERK * random.normal() / libm::sqrt(dt);
            wheel.step(dt, 0.0, ground + 0.5 * rate * dt, 0.0);
            ground += rate * dt + 0.5 * jerk * dt * dt;
            rate += jerk * dt;
            observer.predict(&parameters, dt, 0.0, 0.0);
            observer.measure(&parameters, wheel.angle + 2e-5 * random.normal());
            if k > 1000 {
                let (torque, sigma) = observer.ground_torque();
                square += (torque - ground) * (torque - ground) / (sigma * sigma);
                count += 1.0;
            }
        }
        let ratio = libm::sqrt(square / count);
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
    }

    /// Closed form: an error of the torque that is held over a step changes the speed by `k`, and
    /// the angle by `k dt/2`.
    #[test]
    fn an_error_of_the_torque_turns_the_wheel() {
        let (dt, torque_sigma) = (0.05, 0.5);
        let step = |torque_sigma: f64| {
            let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
            // The noise of the torque makes the observer slower.
            let parameters = WheelParameters {
                torque_sigma,
                encoder_sigma: COUNT_SIGMA,
                ..PARAMETERS
            };
            observer.predict(&parameters, dt, 0.0, 0.0);
            observer.filter.p
        };
        let (with, without) = (step(torque_sigma), step(0.0));
        let k = torque_sigma * dt / INERTIA;
        let by = [0.5 * dt * k, k];
        for i in [ANGLE, SPEED] {
            for j in [ANGLE, SPEED] {
                let found = with[i][j] - without[i][j];
                // Rounding of variances of order 1.
                assert!((found - by[i] * by[j]).abs() < 1e-12, "{i} {j}: {found}");
            }
        }
    }

    /// Property: at 20 Hz the noise of the torque could change the speed by 0.27 rad/s in a step,
    /// but the encoder shows how far the wheel has turned. The speed is known to a fifth of that.
    #[test]
    fn the_speed_of_a_wheel_that_is_rarely_read_is_known() {
        let (dt, torque_sigma) = (0.05, 0.5);
        let parameters = WheelParameters {
            encoder_sigma: COUNT_SIGMA,
            torque_sigma,
            ..PARAMETERS
        };
        let mut random = Random::new();
        let mut observer = TorqueObserver::new(TorqueObserver::SPINNING);
        let mut wheel = Wheel {
            angle: 0.0,
            speed: 2.0,
        };
        let (mut square, mut count) = (0.0, 0.0);
        for k in 0..2000 {
            let torque = PARAMETERS.viscous_damping * 2.0;
            wheel.step(dt, torque, 0.0, 0.0);
            observer.predict(
                &parameters,
                dt,
                torque + torque_sigma * random.normal(),
                0.0,
            );
            observer.measure(&parameters, wheel.angle + COUNT_SIGMA * random.normal());
            if k > 100 {
                let (speed, sigma) = observer.speed();
                assert!(sigma < 0.06, "{sigma}");
                square += (speed - wheel.speed) * (speed - wheel.speed) / (sigma * sigma);
                count += 1.0;
            }
        }
        // Less than stated, since the ground's torque is constant.
        let ratio = libm::sqrt(square / count);
        assert!(ratio < 1.0, "{ratio}");
    }

    /// Closed form: at four times the reference speed the rate of the ground's torque becomes 4^1.5
    /// times as uncertain in a step, and no less uncertain below that speed.
    #[test]
    fn the_torque_changes_faster_at_higher_speed() {
        let step = |rim_speed: f64| {
            let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
            let before = observer.filter.p[RATE][RATE];
            let parameters = WheelParameters {
                rim_speed,
                encoder_sigma: COUNT_SIGMA,
                ..PARAMETERS
            };
            observer.predict(&parameters, 1e-3, 0.0, 0.0);
            observer.filter.p[RATE][RATE] - before
        };
        let slow = step(0.2);
        // Rounding of a variance of 25 (N m/s)^2, to which 25e-3 are added.
        assert!((step(-0.8) / slow - 64.0).abs() < 1e-9);
        assert!((step(0.01) / slow - 1.0).abs() < 1e-9);
    }

    /// Without readings of the motor torque the standard deviation of the ground's torque grows;
    /// with readings it falls back.
    #[test]
    fn an_unread_torque_has_a_larger_deviation() {
        let mut observer = TorqueObserver::new(TorqueObserver::AT_REST);
        observer.measure(&PARAMETERS, 0.0);
        let mut run = |steps: u32, unread_walk: f64| {
            for _ in 0..steps {
                let parameters = WheelParameters {
                    unread_walk,
                    ..PARAMETERS
                };
                observer.predict(&parameters, 1e-3, 0.0, 0.0);
                observer.measure(&parameters, 0.0);
            }
            observer.ground_torque().1
        };
        let settled = run(1000, 0.0);
        assert!(run(100, 5.0) > 1.5 * settled);
        // The rate's part decays with the filter's slow pole.
        assert!((run(1000, 0.0) - settled).abs() < 1e-3 * settled);
    }
}

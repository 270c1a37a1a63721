//! Traction of a wheel by a Kalman filter on the encoder's count: what eq. (3) does, without its lag and its noise.

use crate::kalman::{Innovation, Kalman};
use crate::visit::visit_fields;

/// What the observer knows of wheel, drive and sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueObserverParameters {
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
    /// Standard deviation of a step in the torque since the last prediction, N m: unknown gear friction at a change of direction.
    pub step: f64,
    /// Walk of the motor torque while no sensor reads it, N m/sqrt(s); 0 with a reading.
    pub unseen: f64,
}

/// States: spin angle (rad), spin speed (rad/s), torque of the ground `d T` (N m) and its rate (N m/s). The second derivative of the
/// torque is taken as white; eq. (2) with its inertias told apart links torque and speed:
/// `(J_wheel + J_rotor) domega/dt = tau - B omega - d T + J_wheel alpha_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueObserver {
    filter: Kalman<4>,
    started: bool,
}

visit_fields!(TorqueObserver: filter, started);

/// Standard deviation of an angle that is counted in steps of 40 urad, rad.
pub(crate) const COUNT_SIGMA: f64 = 1.13e-5;

const ANGLE: usize = 0;
const SPEED: usize = 1;
const TORQUE: usize = 2;
const RATE: usize = 3;

impl Default for TorqueObserver {
    fn default() -> Self {
        Self::new()
    }
}

impl TorqueObserver {
    /// Density of the white second derivative of the ground's torque, N m/s^2/sqrt(Hz), for readings as coarse as [`Self::COARSE`]: the value
    /// at which the lag on the PI drive's fast torques and the noise of a count of 40 urad cost the same. Finer readings
    /// let the observer be faster: in inverse proportion to what is coarser of the two, up to a twenty-fifth.
    const TORQUE_JERK: f64 = 5.0;
    /// Standard deviations of an encoder's angle, rad, and of a torque, N m.
    const COARSE: (f64, f64) = (COUNT_SIGMA, 0.1);
    /// See [`Self::TORQUE_JERK`].
    const FINEST: f64 = 0.04;
    /// Standard deviations beyond which an encoder's reading tells of a blow.
    const BLOW_GATE: f64 = 5.0;
    /// What a blow may change in one sample: the ground's torque, N m, its rate, N m/s, and the spin speed, rad/s. Without the last, what
    /// the blow's own impulse has changed of the speed is taken for a torque that goes on. Of 0.5 to 5 N m, 30 to 300 N m/s and 0.01 to
    /// 0.5 rad/s the values that leave least error behind a ramp's corner and a ditch's edges. Rolling ground never asks for them.
    const BLOW: (f64, f64, f64) = (1.0, 30.0, 0.02);

    /// An observer that knows nothing yet: the wheel stands still within 0.01 rad/s, the ground's torque is within 5 N m.
    pub fn new() -> Self {
        Self {
            filter: Kalman::new([0.0; 4], [0.0, 0.01, 5.0, 5.0]),
            started: false,
        }
    }

    /// An observer of a wheel that may be turning already, within 20 rad/s (2 m/s at the rim).
    pub fn turning() -> Self {
        Self {
            filter: Kalman::new([0.0; 4], [0.0, 20.0, 5.0, 5.0]),
            started: false,
        }
    }

    /// Goes on by `dt` (s) under the motor torque `torque` (N m, mean over the interval) with the link's angular
    /// acceleration `alpha_link` (rad/s^2, counter-clockwise).
    pub fn predict(
        &mut self,
        parameters: &TorqueObserverParameters,
        dt: f64,
        torque: f64,
        alpha_link: f64,
    ) {
        let inertia = parameters.wheel_inertia + parameters.rotor_inertia;
        let (b, j) = (parameters.viscous_damping / inertia, 1.0 / inertia);
        let [_, omega, z, rate] = self.filter.x;
        let half = 0.5 * dt * dt;
        let acceleration = (torque - z + parameters.wheel_inertia * alpha_link) * j - b * omega;
        let jerk = -rate * j - b * acceleration;
        self.filter.x[ANGLE] += omega * dt + acceleration * half;
        self.filter.x[SPEED] += acceleration * dt + jerk * half;
        self.filter.x[TORQUE] += rate * dt;

        // F P F' with F of second order in dt.
        let f = [
            [1.0, dt - b * half, -j * half, 0.0],
            [
                0.0,
                1.0 - b * dt + b * b * half,
                -j * dt + b * j * half,
                -j * half,
            ],
            [0.0, 0.0, 1.0, dt],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let p = &self.filter.p;
        let mut fp = [[0.0; 4]; 4];
        for i in 0..4 {
            for k in i..4 {
                for m in 0..4 {
                    fp[i][m] += f[i][k] * p[k][m];
                }
            }
        }
        let mut next = [[0.0; 4]; 4];
        for i in 0..4 {
            for m in 0..=i {
                let mut sum = 0.0;
                for k in m..4 {
                    sum += fp[i][k] * f[m][k];
                }
                next[i][m] = sum;
                next[m][i] = sum;
            }
        }
        // Noise of the torque read, held over the interval, and of the ground's torque.
        let kick = parameters.torque_sigma * dt * j;
        next[SPEED][SPEED] += kick * kick;
        let (angle, torque_noise) = Self::COARSE;
        let coarse = (parameters.encoder_sigma / angle).max(parameters.torque_sigma / torque_noise);
        let jerk = Self::TORQUE_JERK / coarse.clamp(Self::FINEST, 1.0);
        let q = jerk * jerk * dt;
        next[TORQUE][TORQUE] += q * dt * dt / 3.0
            + parameters.unseen * parameters.unseen * dt
            + parameters.step * parameters.step;
        next[TORQUE][RATE] += 0.5 * q * dt;
        next[RATE][TORQUE] += 0.5 * q * dt;
        next[RATE][RATE] += q;
        self.filter.p = next;
    }

    /// The encoder counts from a new zero: its next reading sets the angle.
    pub fn forget_angle(&mut self) {
        self.started = false;
    }

    /// Takes a reading of the spin angle, rad. `None` for the first one, which sets the angle.
    pub fn measure(
        &mut self,
        parameters: &TorqueObserverParameters,
        angle: f64,
    ) -> Option<Innovation> {
        let r = parameters.encoder_sigma * parameters.encoder_sigma;
        if !self.started {
            self.started = true;
            self.filter.x[ANGLE] = angle;
            for i in 0..4 {
                self.filter.p[ANGLE][i] = 0.0;
                self.filter.p[i][ANGLE] = 0.0;
            }
            self.filter.p[ANGLE][ANGLE] = r;
            return None;
        }
        let difference = angle - self.filter.x[ANGLE];
        let expected = self.filter.p[ANGLE][ANGLE] + r;
        if difference * difference > Self::BLOW_GATE * Self::BLOW_GATE * expected {
            // The ground has struck: what was known of its torque holds no more.
            let (torque, rate, speed) = Self::BLOW;
            self.filter.p[SPEED][SPEED] += speed * speed;
            self.filter.p[TORQUE][TORQUE] += torque * torque;
            self.filter.p[RATE][RATE] += rate * rate;
        }
        let (innovation, _) = self
            .filter
            .update(&[(ANGLE, 1.0)], difference, r, f64::INFINITY);
        Some(innovation)
    }

    /// Spin speed relative to the link, rad/s.
    pub fn speed(&self) -> f64 {
        self.filter.x[SPEED]
    }

    /// Standard deviation of that speed, rad/s.
    pub fn speed_sigma(&self) -> f64 {
        libm::sqrt(self.filter.p[SPEED][SPEED].max(0.0))
    }

    /// Whether the speed is known well enough to be used, to 0.1 rad/s.
    pub fn settled(&self) -> bool {
        self.filter.p[SPEED][SPEED] < 0.01
    }

    /// Torque of the ground on the wheel `d T`, N m, and its standard deviation.
    pub fn ground_torque(&self) -> (f64, f64) {
        (
            self.filter.x[TORQUE],
            libm::sqrt(self.filter.p[TORQUE][TORQUE].max(0.0)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    const PARAMETERS: TorqueObserverParameters = TorqueObserverParameters {
        wheel_inertia: 0.0075,
        rotor_inertia: 0.0864,
        viscous_damping: 0.15,
        encoder_sigma: 1e-6,
        torque_sigma: 1e-3,
        step: 0.0,
        unseen: 0.0,
    };
    const INERTIA: f64 = PARAMETERS.wheel_inertia + PARAMETERS.rotor_inertia;

    /// A wheel under constant torques, integrated exactly: `omega = rest + (omega - rest) exp(-B t/J)`.
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

    /// Closed form: motor torque, damping and the link's angular acceleration account for all of the motion, so that a constant
    /// torque of the ground is found exactly: up to what an integration of second order leaves, (B dt/J)^2/6 = 4e-7 of 2 N m.
    #[test]
    fn a_constant_torque_is_found() {
        let mut observer = TorqueObserver::new();
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
        assert!((observer.speed() - wheel.speed).abs() < 1e-5);
        assert!(sigma > 0.0 && sigma < 0.1, "{sigma}");
    }

    /// A step of the ground's torque, which no motor torque announces, is followed. With a jerk of 5 N m/s^2/sqrt(Hz) against the
    /// noise of the encoder the filter's time constant is some 20 ms: after 0.2 s less than 1 % is left.
    #[test]
    fn a_step_settles() {
        let mut observer = TorqueObserver::new();
        let mut wheel = Wheel {
            angle: 0.0,
            speed: 0.0,
        };
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

    /// Consistency: with counts as noise the torque's error over many independent stretches is as large as stated. Errors
    /// over 40 s are worth some 500 independent ones; 0.8 to 1.25 is four standard errors of their RMS.
    #[test]
    fn the_stated_deviation_is_the_real_one() {
        let mut random = Random::new();
        let parameters = TorqueObserverParameters {
            encoder_sigma: 2e-5,
            ..PARAMETERS
        };
        let mut observer = TorqueObserver::new();
        let mut wheel = Wheel {
            angle: 0.0,
            speed: 0.0,
        };
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

    /// Without a reading of the motor torque the ground's torque is known less from step to step; with one again, as before.
    #[test]
    fn an_unread_torque_is_less_sure() {
        let mut observer = TorqueObserver::new();
        observer.measure(&PARAMETERS, 0.0);
        let mut run = |steps: u32, unseen: f64| {
            for _ in 0..steps {
                let parameters = TorqueObserverParameters {
                    unseen,
                    ..PARAMETERS
                };
                observer.predict(&parameters, 1e-3, 0.0, 0.0);
                observer.measure(&parameters, 0.0);
            }
            observer.ground_torque().1
        };
        let settled = run(1000, 0.0);
        assert!(run(100, 5.0) > 1.5 * settled);
        // The rate's part fades with the filter's slow pole.
        assert!((run(1000, 0.0) - settled).abs() < 1e-3 * settled);
    }
}

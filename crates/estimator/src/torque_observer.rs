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
    /// Density of the white second derivative of the ground's torque, N m/s^2/sqrt(Hz): the value at which the lag on the PI
    /// drive's fast torques and the noise of a count of 40 urad cost the same.
    const TORQUE_JERK: f64 = 5.0;

    /// An observer that knows nothing yet: the wheel stands still within 0.01 rad/s, the ground's torque is within 5 N m.
    pub fn new() -> Self {
        Self {
            filter: Kalman::new([0.0; 4], [0.0, 0.01, 5.0, 5.0]),
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
        let q = Self::TORQUE_JERK * Self::TORQUE_JERK * dt;
        next[TORQUE][TORQUE] += q * dt * dt / 3.0
            + parameters.unseen * parameters.unseen * dt
            + parameters.step * parameters.step;
        next[TORQUE][RATE] += 0.5 * q * dt;
        next[RATE][TORQUE] += 0.5 * q * dt;
        next[RATE][RATE] += q;
        self.filter.p = next;
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
            self.filter.p[ANGLE][ANGLE] = r;
            return None;
        }
        let difference = angle - self.filter.x[ANGLE];
        let (innovation, _) = self
            .filter
            .update(&[(ANGLE, 1.0)], difference, r, f64::INFINITY);
        Some(innovation)
    }

    /// Spin speed relative to the link, rad/s.
    pub fn speed(&self) -> f64 {
        self.filter.x[SPEED]
    }

    /// Torque of the ground on the wheel `d T`, N m, and its standard deviation.
    pub fn ground_torque(&self) -> (f64, f64) {
        (
            self.filter.x[TORQUE],
            libm::sqrt(self.filter.p[TORQUE][TORQUE].max(0.0)),
        )
    }
}

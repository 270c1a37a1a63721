//! The motion filter: prediction of its states ([`crate::state`]) from one sample to the next, and
//! its readout.

use super::modes::Modes;
use super::tuning;
use crate::common::{FILTER_TIME, ROLLING_SPEED};
use crate::deviation::GATE;
use crate::filters::GaussMarkov;
use crate::filters::{Expected, Kalman, Measurement};
use crate::resistance::Resistance;
use crate::settings::{ContactAngles, NoiseBudget};
use crate::state::{
    ACCELERATION, CONTACT_ANGLE, COUNT, CREEP, INPUTS, PENETRATION, RADIUS, RESISTANCE,
    TORQUE_GAIN, TORQUE_OFFSET, VELOCITY,
};
use robhaz_model::{Units, Vec2};

/// Covariance of each state with each of another filter's.
pub(crate) type Guests = [[f64; COUNT]; COUNT];

/// Motion of the robot, errors of contact angles and torques, creep: one Kalman filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionFilter {
    /// Where the contact angles come from. Not part of the filter state.
    pub(super) angles: ContactAngles,
    pub(super) filter: Kalman<COUNT, { TORQUE_GAIN.of(0) }, { TORQUE_GAIN.len() }>,
    pub(super) modes: Modes,
    /// Acceleration of the rims at the last sample, m/s^2.
    pub(super) rims: f64,
    /// Time since the inclinometers last showed the acceleration, s.
    pub(super) since_acceleration: f64,
    /// Covariance with the other side's states: of a side of a whole rover (`coupled.rs`).
    pub(super) guests: Option<Guests>,
}

impl MotionFilter {
    /// Creates the filter of a robot at rest, with the prior of the budget and, for unknown contact
    /// angles, that of the ground.
    pub fn new(budget: &NoiseBudget, angles: ContactAngles) -> Self {
        let mut sigma = [0.0; COUNT];
        let mut x = [0.0; COUNT];
        x[CREEP.all()].fill(tuning::CREEP);
        sigma[VELOCITY.all()].fill(tuning::VELOCITY_AT_REST);
        sigma[CREEP.all()].fill(tuning::CREEP_SIGMA);
        sigma[PENETRATION.all()].fill(tuning::PENETRATION_SPEED.sigma);
        sigma[RADIUS.all()].fill(budget.wheel_radius);
        sigma[ACCELERATION.all()].fill(tuning::ACCELERATION.sigma);
        sigma[CONTACT_ANGLE.all()].fill(angle_sigma(budget, angles));
        sigma[TORQUE_OFFSET.all()].fill(budget.torque_offset);
        sigma[RESISTANCE.of(0)] = Resistance::prior(budget);
        sigma[TORQUE_GAIN.all()].fill(budget.torque_gain);
        let mut filter = Kalman::new(x, sigma);
        let common = tuning::COMMON_CREEP * tuning::CREEP_SIGMA * tuning::CREEP_SIGMA;
        for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            filter.p[CREEP.of(i)][CREEP.of(j)] = common;
        }
        Self {
            angles,
            filter,
            modes: Modes::default(),
            rims: 0.0,
            since_acceleration: 0.0,
            guests: None,
        }
    }

    /// Corrects the states by a measurement, `dt` seconds after the last of its kind.
    pub(super) fn correct<const K: usize, const L: usize>(
        &mut self,
        measurement: &Measurement<K, L>,
        expected: &Expected<COUNT>,
        dt: f64,
    ) {
        if let Some(s) = measurement.weight(expected, dt) {
            let ph = &expected.projection.ph;
            self.correct_guests(&measurement.row, ph, s);
            self.filter.apply(ph, measurement.innovation, s);
        }
    }

    /// Sets a state, independent of all others.
    pub(super) fn set(&mut self, state: usize, value: f64, sigma: f64) {
        self.filter.set(state, value, sigma);
        if let Some(row) = self
            .guests
            .as_mut()
            .and_then(|guests| guests.get_mut(state))
        {
            *row = [0.0; COUNT];
        }
    }

    /// Unknown contact angles start at `slopes`, rad.
    pub fn start_at(&mut self, slopes: &[f64; 3]) {
        if self.angles == ContactAngles::Unknown {
            for (i, slope) in slopes.iter().enumerate() {
                self.filter.x[CONTACT_ANGLE.of(i)] = -slope;
            }
        }
    }

    /// Marks the velocity as unknown, because the robot may be moving: raises its two variances,
    /// keeps its value and correlations.
    pub fn reset_velocity_variance(&mut self) {
        for v in VELOCITY.all() {
            self.filter.p[v][v] = tuning::UNKNOWN_VELOCITY * tuning::UNKNOWN_VELOCITY;
        }
    }

    /// Takes `velocity` (m/s) for that of Q, as uncertain as before, unless no reading could
    /// correct it any more.
    pub fn assume_velocity(&mut self, velocity: Vec2) {
        let largest = GATE * tuning::UNKNOWN_VELOCITY;
        // Written so that a NaN is not taken.
        if velocity.norm_squared() < largest * largest {
            (self.filter.x[VELOCITY.of(0)], self.filter.x[VELOCITY.of(1)]) =
                (velocity.x, velocity.y);
        }
    }

    /// Velocity of Q, m/s.
    pub fn velocity(&self) -> Vec2 {
        Vec2::new(self.filter.x[VELOCITY.of(0)], self.filter.x[VELOCITY.of(1)])
    }

    /// Covariance of the velocity of Q, m^2/s^2: xx, xy, yy.
    pub fn velocity_covariance(&self) -> [f64; 3] {
        let p = &self.filter.p;
        let (x, y) = (VELOCITY.of(0), VELOCITY.of(1));
        [p[x][x], p[x][y], p[y][y]]
    }

    /// Whether an impact or an edge was found within the last `tuning::IMPACT_TIME`.
    pub fn is_after_impact(&self) -> bool {
        self.modes.is_after_impact()
    }

    /// Acceleration of Q, m/s^2.
    pub fn acceleration(&self) -> Vec2 {
        Vec2::new(
            self.filter.x[ACCELERATION.of(0)],
            self.filter.x[ACCELERATION.of(1)],
        )
    }

    /// Estimated value of an uncertain input, in the order of [`crate::state`], and its standard
    /// deviation. An unknown contact angle counts as given with 0.
    pub fn input(&self, k: usize) -> (f64, f64) {
        self.filter.estimated(k)
    }

    /// Part of the motor torque read of wheel `i` that is no traction, N m: offset, gain error of the
    /// reading `torque` (N m), and the share `resisted` of what resists the spin.
    pub fn torque_error(&self, i: usize, torque: f64, resisted: f64) -> f64 {
        let x = &self.filter.x;
        x[TORQUE_OFFSET.of(i)] + x[RESISTANCE.of(0)] * resisted + x[TORQUE_GAIN.of(i)] * torque
    }

    /// The uncertain inputs of eq. (8), in the order of [`crate::state`].
    pub fn inputs(&self) -> [f64; INPUTS] {
        core::array::from_fn(|k| self.filter.x[k])
    }

    /// Covariance of the inputs `a` and `b`, SI.
    pub fn input_covariance(&self, a: usize, b: usize) -> f64 {
        self.filter.p[a][b]
    }

    /// The process of the speeds of penetration: loads change along the ground.
    pub(super) fn penetration_process(&self) -> GaussMarkov {
        let least = ROLLING_SPEED / tuning::REFERENCE_SPEED;
        let speed = (self.speed() / tuning::REFERENCE_SPEED).max(least);
        tuning::PENETRATION_SPEED.at_speed(speed)
    }

    /// Amount of the velocity of Q, m/s.
    pub fn speed(&self) -> f64 {
        robhaz_model::sqrt(self.velocity().norm_squared())
    }

    /// Advances by `dt`, s. `fresh_angles` says which wheels have a contact angle of this instant;
    /// unknown angles revert to `expected_slopes`, rad.
    ///
    /// `measured` accelerations of rims and links, m/s^2, scale the process noise; they are not
    /// inputs of the prediction.
    pub fn predict(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        fresh_angles: [bool; 3],
        expected_slopes: &[f64; 3],
        measured: [f64; 2],
    ) {
        self.rims = measured[0];
        let acceleration = self.acceleration_process(measured);
        // Factors over the step: `exp(-dt/time)`.
        let keep = libm::exp(-dt / acceleration.time);
        let keep_angle = self.angle_decay(budget, dt);
        let penetration = self.penetration_process();
        let keep_penetration = libm::exp(-dt / penetration.time);
        self.propagate(dt, keep_penetration, keep, keep_angle);
        if self.angles == ContactAngles::Unknown {
            for (i, slope) in expected_slopes.iter().enumerate() {
                self.filter.x[CONTACT_ANGLE.of(i)] -= (1.0 - keep_angle) * slope;
            }
        }
        // It makes `sigma` the stationary standard deviation.
        let noise = |sigma: f64, keep: f64| sigma * sigma * (1.0 - keep * keep);
        for state in PENETRATION.all() {
            self.filter.p[state][state] += noise(penetration.sigma, keep_penetration);
        }
        for state in ACCELERATION.all() {
            self.filter.p[state][state] += noise(acceleration.sigma, keep);
        }
        self.add_angle_noise(budget, dt, fresh_angles, keep_angle, expected_slopes);
        self.add_walks(budget, dt);
        self.modes.advance(dt);
    }

    /// Factor of the contact-angle errors over `dt` (s): a process in time for given angles, along
    /// the ground for unknown ones.
    fn angle_decay(&self, budget: &NoiseBudget, dt: f64) -> f64 {
        let steps = match self.angles {
            ContactAngles::Given => dt / budget.contact_angle_time.max(1e-6),
            ContactAngles::Unknown => dt * self.speed() / tuning::SLOPE_LENGTH,
        };
        libm::exp(-steps)
    }

    /// The Gauss-Markov process of the acceleration of Q, m/s^2 and s.
    fn acceleration_process(&self, [rims, links]: [f64; 2]) -> GaussMarkov {
        let GaussMarkov { sigma, time } = tuning::ACCELERATION;
        let rims = tuning::RIM_FACTOR * rims;
        let sigma = robhaz_model::sqrt(sigma * sigma + rims * rims + links * links);
        let after = self.is_after_impact();
        GaussMarkov {
            sigma,
            time: if after { FILTER_TIME } else { time },
        }
    }

    /// `F x` and `F P F'`: accelerations add to velocities; speeds of penetration, accelerations and
    /// contact angles decay, each by its factor.
    ///
    /// Each entry of P gets the same operations as its mirror image, so P stays symmetric to the
    /// bit.
    fn propagate(
        &mut self,
        dt: f64,
        keep_penetration: f64,
        keep_acceleration: f64,
        keep_angle: f64,
    ) {
        let Kalman { x, p } = &mut self.filter;
        for i in 0..2 {
            let (v, a) = (VELOCITY.of(i), ACCELERATION.of(i));
            x[v] += dt * x[a];
            for k in 0..COUNT {
                p[v][k] += dt * p[a][k];
            }
        }
        for i in 0..2 {
            let v = VELOCITY.of(i);
            for k in i..2 {
                p[v][VELOCITY.of(k)] += dt * p[v][ACCELERATION.of(k)];
            }
            for k in 0..COUNT {
                p[k][v] = p[v][k];
            }
        }
        let mut keep = [1.0; COUNT];
        keep[PENETRATION.all()].fill(keep_penetration);
        keep[ACCELERATION.all()].fill(keep_acceleration);
        keep[CONTACT_ANGLE.all()].fill(keep_angle);
        for (i, row) in p.iter_mut().enumerate() {
            x[i] *= keep[i];
            for (entry, of_other) in row.iter_mut().zip(keep) {
                *entry *= keep[i] * of_other;
            }
        }
        if let Some(guests) = &mut self.guests {
            for i in 0..2 {
                let of_acceleration = guests[ACCELERATION.of(i)];
                for (entry, added) in guests[VELOCITY.of(i)].iter_mut().zip(of_acceleration) {
                    *entry += dt * added;
                }
            }
            for (row, keep) in guests.iter_mut().zip(keep) {
                for entry in row {
                    *entry *= keep;
                }
            }
        }
    }

    /// Adds `sigma^2 (1 - keep^2)`, which makes `sigma` (rad) the stationary standard deviation of
    /// contact angles; keep = exp(-dt/time). A given angle whose reading is missing gets a random
    /// walk in addition. An unknown one changes more where it is far from the `expected` slope (rad):
    /// on an edge, or on rough ground.
    fn add_angle_noise(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        fresh: [bool; 3],
        keep: f64,
        expected: &[f64; 3],
    ) {
        let angle = angle_sigma(budget, self.angles);
        for i in 0..3 {
            let state = CONTACT_ANGLE.of(i);
            let mut variance = angle * angle;
            let mut walk = 0.0;
            match self.angles {
                ContactAngles::Given if fresh[i] => {}
                ContactAngles::Given => walk = tuning::UNREAD_ANGLE_WALK,
                ContactAngles::Unknown => {
                    // A wave's mean square is half of its amplitude's square.
                    let away = self.filter.x[state] + expected[i];
                    variance += 0.5 * away * away;
                }
            }
            self.filter.p[state][state] += variance * (1.0 - keep * keep) + walk * walk * dt;
        }
    }

    /// Random walks of torque offsets, of the wheels' resistance, and, along the ground, of rolling
    /// resistance and of the creep, which the wheels have in common.
    fn add_walks(&mut self, budget: &NoiseBudget, dt: f64) {
        let travelled = dt * self.speed();
        let of_ground = budget.rolling_resistance * Units::MEAN_MOMENT;
        let state = RESISTANCE.of(0);
        self.filter.p[state][state] += of_ground * of_ground * travelled / tuning::GROUND_LENGTH;
        for state in TORQUE_OFFSET.all().chain(RESISTANCE.all()) {
            self.filter.p[state][state] += tuning::TORQUE_WALK * tuning::TORQUE_WALK * dt;
        }
        let change = tuning::CREEP_WALK * tuning::CREEP_WALK * travelled;
        for row in &mut self.filter.p[CREEP.all()] {
            for entry in &mut row[CREEP.all()] {
                *entry += change;
            }
        }
    }

    /// Discards the estimated errors of torques and contact angles: they were found with other
    /// loads.
    pub fn discard_errors(&mut self, budget: &NoiseBudget) {
        for i in 0..3 {
            self.set(TORQUE_OFFSET.of(i), 0.0, budget.torque_offset);
            let angle = self.filter.x[CONTACT_ANGLE.of(i)];
            let sigma = angle_sigma(budget, self.angles);
            self.set(CONTACT_ANGLE.of(i), angle, sigma);
        }
        self.set(RESISTANCE.of(0), 0.0, Resistance::prior(budget));
    }

    /// The robot stands at this sample: velocity and acceleration are zero.
    ///
    /// Unknown contact angles are as uncertain as at first, however long it stands: one parity
    /// residual a sample, always the same, cannot tell three of them, and each linearisation of it
    /// about other angles would seem to tell more.
    ///
    /// A force F that errs in direction by an angle a errs by F a^2/2 along itself, which the
    /// linear covariance does not contain. For a Gaussian angle of deviation s its mean square is
    /// F^2 (3 s^4)/4, and three times that for three wheels of the load `mean_load` (N): the
    /// unmodelled load is at least that.
    pub fn stand(&mut self, mean_load: f64) {
        for i in 0..2 {
            self.set(VELOCITY.of(i), 0.0, tuning::VELOCITY_AT_REST);
            self.set(ACCELERATION.of(i), 0.0, tuning::ACCELERATION.sigma);
        }
        if self.angles == ContactAngles::Unknown {
            for state in CONTACT_ANGLE.all() {
                let angle = self.filter.x[state];
                self.set(state, angle, tuning::HELD_ANGLE);
            }
            // The root of three times 3/4.
            let second_order = 1.5 * mean_load * tuning::HELD_ANGLE * tuning::HELD_ANGLE;
            self.modes.load_at_least(second_order * second_order);
        }
        self.modes.set_impact();
    }

    /// For tests: adds `change` to the uncertain input `k`.
    #[cfg(test)]
    pub(crate) fn shift_input(&mut self, k: usize, change: f64) {
        self.filter.x[k] += change;
    }
}

/// Stationary standard deviation of a contact-angle error, rad: that of the reading, or of the
/// slope where the angle is unknown.
fn angle_sigma(budget: &NoiseBudget, angles: ContactAngles) -> f64 {
    match angles {
        ContactAngles::Given => budget.contact_angle.max(tuning::LEAST_ANGLE),
        ContactAngles::Unknown => tuning::SLOPE,
    }
}

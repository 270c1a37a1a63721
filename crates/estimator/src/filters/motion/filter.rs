//! The motion filter's states with their indices, their prediction from one sample to the next, and
//! its readout.
//!
//! From [`INPUTS`] on the states are the uncertain inputs of eq. (8), in the order of [`input`].

use super::modes::Modes;
use super::tuning::{self, GaussMarkov};
use crate::deviation::GATE;
use crate::filters::Kalman;
use crate::settings::{ContactAngles, NoiseBudget};
use crate::statics::input;
use robhaz_model::Vec2;

/// Velocity of Q, m/s: x, y.
pub const VELOCITY: usize = 0;
/// Natural logarithm of the creep speed c (m/s) of each wheel: slope of the slip speed over T/N at
/// small T/N (slip = c T/N), the inverse of its slip stiffness. It is not the dimensionless
/// creepage, which is c over the rolling speed.
pub const CREEP: usize = 2;
/// Speed at which each wheel comes out of the ground, m/s, because its load falls.
pub const PENETRATION: usize = 5;
/// Relative error of each wheel's rolling radius, true over nominal less 1.
pub const RADIUS: usize = 8;
/// The first of the uncertain inputs.
pub const INPUTS: usize = 11;
/// Acceleration of Q, m/s^2: x, y.
pub const ACCELERATION: usize = INPUTS + input::ACCELERATION;
/// Contact-angle errors, reading minus true, rad.
pub const CONTACT_ANGLE: usize = INPUTS + input::CONTACT_ANGLE;
/// Torque offsets, reading minus true, N m.
pub const TORQUE_OFFSET: usize = INPUTS + input::TORQUE_OFFSET;
/// Dry gear friction at the wheel, common to all wheels, N m; positive opposes the spin.
pub const GEAR_FRICTION: usize = INPUTS + input::GEAR_FRICTION;
/// Relative errors of the torque readings, positive for readings that are too large: consider
/// states. Only products with creep and contact angles make them observable. A linearised filter is
/// inconsistent there: its variance would fall while its error grows.
pub const TORQUE_GAIN: usize = INPUTS + input::TORQUE_GAIN;
/// Number of states.
pub const COUNT: usize = INPUTS + input::COUNT;
/// Number of consider states, at the end.
pub const CONSIDERED: usize = COUNT - TORQUE_GAIN;

/// Covariance of each state with each of another filter's.
pub(crate) type Guests = [[f64; COUNT]; COUNT];

/// Motion of the robot, errors of contact angles and torques, creep: one Kalman filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionFilter {
    /// Where the contact angles come from. Not part of the filter state.
    pub(super) angles: ContactAngles,
    /// Indices as above.
    pub(super) filter: Kalman<COUNT, CONSIDERED>,
    pub(super) modes: Modes,
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
        x[CREEP..PENETRATION].fill(tuning::CREEP);
        sigma[VELOCITY..CREEP].fill(tuning::VELOCITY_AT_REST);
        sigma[CREEP..PENETRATION].fill(tuning::CREEP_SIGMA);
        sigma[PENETRATION..RADIUS].fill(tuning::PENETRATION_SPEED.sigma);
        sigma[RADIUS..INPUTS].fill(budget.wheel_radius);
        sigma[ACCELERATION..CONTACT_ANGLE].fill(tuning::ACCELERATION.sigma);
        sigma[CONTACT_ANGLE..TORQUE_OFFSET].fill(angle_sigma(budget, angles));
        sigma[TORQUE_OFFSET..GEAR_FRICTION].fill(budget.torque_offset);
        sigma[GEAR_FRICTION] = budget.gear_friction;
        sigma[TORQUE_GAIN..].fill(budget.torque_gain);
        let mut filter = Kalman::new(x, sigma);
        let common = tuning::COMMON_CREEP * tuning::CREEP_SIGMA * tuning::CREEP_SIGMA;
        for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            filter.p[CREEP + i][CREEP + j] = common;
        }
        Self {
            angles,
            filter,
            modes: Modes::default(),
            since_acceleration: 0.0,
            guests: None,
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
                self.filter.x[CONTACT_ANGLE + i] = -slope;
            }
        }
    }

    /// Marks the velocity as unknown, because the robot may be moving: raises its two variances,
    /// keeps its value and correlations.
    pub fn reset_velocity_variance(&mut self) {
        for v in [VELOCITY, VELOCITY + 1] {
            self.filter.p[v][v] = tuning::UNKNOWN_VELOCITY * tuning::UNKNOWN_VELOCITY;
        }
    }

    /// Takes `velocity` (m/s) for that of Q, as uncertain as before, unless no reading could
    /// correct it any more.
    pub fn assume_velocity(&mut self, velocity: Vec2) {
        let largest = GATE * tuning::UNKNOWN_VELOCITY;
        // Written so that a NaN is not taken.
        if velocity.norm_squared() < largest * largest {
            (self.filter.x[VELOCITY], self.filter.x[VELOCITY + 1]) = (velocity.x, velocity.y);
        }
    }

    /// Velocity of Q, m/s.
    pub fn velocity(&self) -> Vec2 {
        Vec2::new(self.filter.x[VELOCITY], self.filter.x[VELOCITY + 1])
    }

    /// Covariance of the velocity of Q, m^2/s^2: xx, xy, yy.
    pub fn velocity_covariance(&self) -> [f64; 3] {
        let p = &self.filter.p;
        let (x, y) = (VELOCITY, VELOCITY + 1);
        [p[x][x], p[x][y], p[y][y]]
    }

    /// Whether an impact or an edge was found within the last `tuning::IMPACT_TIME`.
    pub fn is_after_impact(&self) -> bool {
        self.modes.is_after_impact()
    }

    /// Acceleration of Q, m/s^2.
    pub fn acceleration(&self) -> Vec2 {
        Vec2::new(self.filter.x[ACCELERATION], self.filter.x[ACCELERATION + 1])
    }

    /// Estimated value of an uncertain input, in the order of [`input`], and its standard
    /// deviation. An unknown contact angle counts as given with 0.
    pub fn input(&self, k: usize) -> (f64, f64) {
        self.filter.estimated(INPUTS + k)
    }

    /// Error of a torque reading of wheel `i`, N m: offset, gain error of the reading `torque` (N
    /// m), and gear friction times the smoothed sign of the spin `friction_share`, -1 to 1.
    pub fn torque_error(&self, i: usize, torque: f64, friction_share: f64) -> f64 {
        let x = &self.filter.x;
        x[TORQUE_OFFSET + i] + x[GEAR_FRICTION] * friction_share + x[TORQUE_GAIN + i] * torque
    }

    /// The uncertain inputs of eq. (8), in the order of [`input`].
    pub fn inputs(&self) -> [f64; input::COUNT] {
        core::array::from_fn(|k| self.filter.x[INPUTS + k])
    }

    /// Covariance of the inputs `a` and `b`, SI.
    pub fn input_covariance(&self, a: usize, b: usize) -> f64 {
        self.filter.p[INPUTS + a][INPUTS + b]
    }

    /// Speed over the reference speed, at least 1, by which the ground-dependent constants change.
    pub(super) fn speed_ratio(&self) -> f64 {
        self.speed().max(tuning::REFERENCE_SPEED) / tuning::REFERENCE_SPEED
    }

    /// The process of the speeds of penetration: loads change along the ground.
    pub(super) fn penetration_process(&self) -> GaussMarkov {
        let least = tuning::LEAST_SPEED / tuning::REFERENCE_SPEED;
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
        let acceleration = self.acceleration_process(measured);
        // Factors over the step: `exp(-dt/time)`.
        let keep = libm::exp(-dt / acceleration.time);
        let keep_angle = self.angle_decay(budget, dt);
        let penetration = self.penetration_process();
        let keep_penetration = libm::exp(-dt / penetration.time);
        self.propagate(dt, keep_penetration, keep, keep_angle);
        if self.angles == ContactAngles::Unknown {
            for (i, slope) in expected_slopes.iter().enumerate() {
                self.filter.x[CONTACT_ANGLE + i] -= (1.0 - keep_angle) * slope;
            }
        }
        // It makes `sigma` the stationary standard deviation.
        let noise = |sigma: f64, keep: f64| sigma * sigma * (1.0 - keep * keep);
        for state in PENETRATION..RADIUS {
            self.filter.p[state][state] += noise(penetration.sigma, keep_penetration);
        }
        for state in ACCELERATION..CONTACT_ANGLE {
            self.filter.p[state][state] += noise(acceleration.sigma, keep);
        }
        self.add_angle_noise(budget, dt, fresh_angles, keep_angle, expected_slopes);
        self.add_walks(dt);
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
        let speed_ratio = self.speed_ratio();
        let unmeasured = tuning::ACCELERATION.sigma * speed_ratio * speed_ratio;
        let rims = tuning::RIM_FACTOR * rims;
        let links = tuning::LINK_FACTOR * links;
        let sigma = robhaz_model::sqrt(unmeasured * unmeasured + rims * rims + links * links);
        let after = self.is_after_impact();
        let time = tuning::ACCELERATION.time / speed_ratio;
        GaussMarkov {
            sigma,
            time: if after { tuning::FILTER_TIME } else { time },
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
        const DECAYING: core::ops::Range<usize> = PENETRATION..CONTACT_ANGLE + 3;
        let Kalman { x, p } = &mut self.filter;
        for i in 0..2 {
            let (v, a) = (VELOCITY + i, ACCELERATION + i);
            x[v] += dt * x[a];
            for k in 0..COUNT {
                p[v][k] += dt * p[a][k];
            }
        }
        for i in 0..2 {
            for k in i..2 {
                p[VELOCITY + i][VELOCITY + k] += dt * p[VELOCITY + i][ACCELERATION + k];
            }
            for k in VELOCITY + i + 1..COUNT {
                p[k][VELOCITY + i] = p[VELOCITY + i][k];
            }
        }
        let mut keep = [1.0; COUNT];
        keep[PENETRATION..RADIUS].fill(keep_penetration);
        keep[ACCELERATION..CONTACT_ANGLE].fill(keep_acceleration);
        keep[CONTACT_ANGLE..DECAYING.end].fill(keep_angle);
        for i in 0..COUNT {
            if DECAYING.contains(&i) {
                x[i] *= keep[i];
                for k in 0..COUNT {
                    p[i][k] *= keep[i] * keep[k];
                }
            } else {
                for k in DECAYING {
                    p[i][k] *= keep[k];
                }
            }
        }
        if let Some(guests) = &mut self.guests {
            for i in 0..2 {
                let of_acceleration = guests[ACCELERATION + i];
                for (entry, added) in guests[VELOCITY + i].iter_mut().zip(of_acceleration) {
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
            let state = CONTACT_ANGLE + i;
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

    /// Random walks of torque offsets, of gear friction, and of the creep along the ground, which
    /// the wheels have in common.
    fn add_walks(&mut self, dt: f64) {
        let travelled = dt * self.speed();
        for state in TORQUE_OFFSET..=GEAR_FRICTION {
            self.filter.p[state][state] += tuning::TORQUE_WALK * tuning::TORQUE_WALK * dt;
        }
        let change = tuning::CREEP_WALK * tuning::CREEP_WALK * travelled;
        for row in &mut self.filter.p[CREEP..CREEP + 3] {
            for entry in &mut row[CREEP..CREEP + 3] {
                *entry += change;
            }
        }
    }

    /// Discards the estimated errors of torques and contact angles: they were found with other
    /// loads.
    pub fn discard_errors(&mut self, budget: &NoiseBudget) {
        for i in 0..3 {
            self.set(TORQUE_OFFSET + i, 0.0, budget.torque_offset);
            let angle = self.filter.x[CONTACT_ANGLE + i];
            let sigma = angle_sigma(budget, self.angles);
            self.set(CONTACT_ANGLE + i, angle, sigma);
        }
        self.set(GEAR_FRICTION, 0.0, budget.gear_friction);
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
            self.set(VELOCITY + i, 0.0, tuning::VELOCITY_AT_REST);
            self.set(ACCELERATION + i, 0.0, tuning::ACCELERATION.sigma);
        }
        if self.angles == ContactAngles::Unknown {
            for state in CONTACT_ANGLE..CONTACT_ANGLE + 3 {
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
        self.filter.x[INPUTS + k] += change;
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

//! Prediction of the motion filter: from one sample to the next.

use super::filter::{
    ACCELERATION, CONTACT_ANGLE, COUNT, CREEP, GEAR_FRICTION, MotionFilter, TORQUE_OFFSET,
    VELOCITY, angle_sigma,
};
use super::tuning::{GaussMarkov, TUNING};
use crate::filters::Kalman;
use crate::settings::{ContactAngles, NoiseBudget};

/// Measured accelerations, m/s^2. Their magnitudes scale the process noise; they are not inputs of
/// the prediction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MeasuredAccelerations {
    /// Mean over the wheels of r domega/dt, from the encoders; opposite signs cancel.
    pub rims: f64,
    /// Largest over the wheels of arm |alpha| + |v_Q| |omega|, from the gyroscopes: tangential
    /// acceleration of the axle, and normal acceleration of Q on a curved path. Not negative.
    pub links: f64,
}

impl MotionFilter {
    /// Advances by `dt`, s. `fresh_angles` says which wheels have a contact angle of this instant;
    /// unknown angles revert to `expected_slopes`, rad.
    pub fn predict(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        fresh_angles: [bool; 3],
        expected_slopes: &[f64; 3],
        measured: MeasuredAccelerations,
    ) {
        let acceleration = self.acceleration_process(measured);
        // Factors over the step: `exp(-dt/time)`.
        let keep = libm::exp(-dt / acceleration.time);
        let keep_angle = self.angle_decay(budget, dt);
        self.propagate(dt, keep, keep_angle);
        if self.angles == ContactAngles::Unknown {
            for (i, slope) in expected_slopes.iter().enumerate() {
                self.filter.x[CONTACT_ANGLE + i] -= (1.0 - keep_angle) * slope;
            }
        }
        // It makes `sigma` the stationary standard deviation.
        let noise = acceleration.sigma * acceleration.sigma * (1.0 - keep * keep);
        for state in ACCELERATION..ACCELERATION + 2 {
            self.filter.p[state][state] += noise;
        }
        self.add_angle_noise(budget, dt, fresh_angles, keep_angle);
        self.add_walks(dt);
        self.decay(dt);
    }

    /// Factor of the contact-angle errors over `dt` (s): a process in time for given angles, along
    /// the ground for unknown ones.
    fn angle_decay(&self, budget: &NoiseBudget, dt: f64) -> f64 {
        let steps = match self.angles {
            ContactAngles::Given => dt / budget.contact_angle_time.max(1e-6),
            ContactAngles::Unknown => {
                dt * robhaz_model::sqrt(self.velocity().norm_squared()) / TUNING.slope_length
            }
        };
        libm::exp(-steps)
    }

    /// The Gauss-Markov process of the acceleration of Q, m/s^2 and s.
    fn acceleration_process(&self, measured: MeasuredAccelerations) -> GaussMarkov {
        let speed_ratio = self.speed_ratio();
        let unmeasured = TUNING.acceleration.sigma * speed_ratio * speed_ratio;
        let rims = TUNING.rim_factor * measured.rims;
        let links = TUNING.link_factor * measured.links;
        let sigma = robhaz_model::sqrt(unmeasured * unmeasured + rims * rims + links * links);
        GaussMarkov {
            sigma,
            time: if self.is_after_impact() {
                TUNING.filter_time
            } else {
                TUNING.acceleration.time / speed_ratio
            },
        }
    }

    /// `F x` and `F P F'`: accelerations add to velocities; accelerations and contact angles decay.
    ///
    /// Each entry of P gets the same operations as its mirror image, so P stays symmetric to the
    /// bit.
    fn propagate(&mut self, dt: f64, keep_acceleration: f64, keep_angle: f64) {
        const DECAYING: core::ops::Range<usize> = ACCELERATION..CONTACT_ANGLE + 3;
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
    }

    /// Adds `sigma^2 (1 - keep^2)`, which makes `sigma` (rad) the stationary standard deviation of
    /// contact angles; keep = exp(-dt/time). A given angle whose reading is missing gets a random
    /// walk in addition.
    fn add_angle_noise(&mut self, budget: &NoiseBudget, dt: f64, fresh: [bool; 3], keep: f64) {
        let angle = angle_sigma(budget, self.angles);
        let given = self.angles == ContactAngles::Given;
        for i in 0..3 {
            let walk = if given && !fresh[i] {
                TUNING.unread_angle_walk
            } else {
                0.0
            };
            let stationary = angle * angle * (1.0 - keep * keep);
            let state = CONTACT_ANGLE + i;
            self.filter.p[state][state] += stationary + walk * walk * dt;
        }
    }

    /// Random walks of torque offsets, of gear friction, and of the creep along the ground, which
    /// the wheels have in common.
    fn add_walks(&mut self, dt: f64) {
        let travelled = dt * robhaz_model::sqrt(self.velocity().norm_squared());
        for state in TORQUE_OFFSET..=GEAR_FRICTION {
            self.filter.p[state][state] += TUNING.torque_walk * TUNING.torque_walk * dt;
        }
        let change = TUNING.creep_walk * TUNING.creep_walk * travelled;
        for row in &mut self.filter.p[CREEP..CREEP + 3] {
            for entry in &mut row[CREEP..CREEP + 3] {
                *entry += change;
            }
        }
    }

    /// Counts down the times after impacts and of sliding, and lets the unmodelled load decay over
    /// `dt` (s).
    fn decay(&mut self, dt: f64) {
        self.impact = (self.impact - dt).max(0.0);
        for time in &mut self.sliding {
            *time = (*time - dt).max(0.0);
        }
        self.unmodelled_load *= libm::exp(-dt / TUNING.unmodelled_decay);
        if self.unmodelled_load < TUNING.unmodelled_floor {
            self.unmodelled_load = 0.0;
        }
    }
}

//! What the memory takes of one sample, and the contacts that follow from it.

use super::drift::Lever;
use robhaz_model::{Geometry, Vec2};

/// What the memory takes of one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundMotion {
    /// Time since the last sample, s.
    pub dt: f64,
    /// Velocity of Q, m/s.
    pub velocity: Vec2,
    /// Its covariance, m^2/s^2: xx, xy, yy.
    pub velocity_covariance: [f64; 3],
    /// Positions of the axles relative to Q, m.
    pub axles: [Vec2; 3],
    /// Contact angles, rad, and their standard deviations.
    pub contact_angle: [(f64, f64); 3],
    /// Whether each wheel touches the ground at one place: it is loaded.
    pub touches: [bool; 3],
}

/// A contact of a wheel, by its axle: wheels of one radius have the same contact angle wherever their
/// axles are at the same place. The contact point itself moves with each error of that angle, so that the
/// first time a wheel comes to a place would choose the errors that point ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Of the axle, relative to Q, or in the section's frame, m.
    pub x: f64,
    /// The same.
    pub y: f64,
    /// Contact angle, rad.
    pub slope: f64,
    /// Variance of the part of that angle's error that the wheels do not have in common, rad^2.
    pub slope_variance: f64,
    /// How the height errs with the link's angle.
    pub lever: Lever,
}

impl GroundMotion {
    /// Whether all numbers are finite and can be those of a robot.
    pub fn is_possible(&self) -> bool {
        /// Bound of the root of the sum of all squares, SI.
        /// Guard.
        const LARGEST: f64 = 1e6;
        let [xx, xy, yy] = self.velocity_covariance;
        let mut sum = self.velocity.norm_squared() + xx * xx + xy * xy + yy * yy;
        sum += self.dt * self.dt;
        for (axle, (angle, sigma)) in self.axles.iter().zip(self.contact_angle) {
            sum += axle.norm_squared() + angle * angle + sigma * sigma;
        }
        // Written so that a NaN fails, too.
        sum < LARGEST * LARGEST
    }

    /// Standard deviations of the velocity: across its direction, as an error of dy/dx, at most 1;
    /// and along it, m/s.
    pub fn velocity_sigma(&self) -> (f64, f64) {
        /// Speed below which a velocity has no direction, m/s.
        /// Guard.
        const LEAST_SPEED: f64 = 1e-6;
        let [xx, xy, yy] = self.velocity_covariance;
        let v = self.velocity;
        let square = v.norm_squared().max(LEAST_SPEED * LEAST_SPEED);
        let across = (v.x * v.x * yy - 2.0 * v.x * v.y * xy + v.y * v.y * xx).max(0.0);
        let along = (v.x * v.x * xx + 2.0 * v.x * v.y * xy + v.y * v.y * yy).max(0.0);
        // dy/dx changes with the angle by 1/cos^2.
        let level = (v.x * v.x / square).max(0.1);
        let across = robhaz_model::sqrt(across) / square / level;
        (across.min(1.0), robhaz_model::sqrt(along / square))
    }

    /// The contact of wheel `i` relative to Q. `shared`: standard deviation of the direction of the
    /// velocity, as dy/dx, which all wheels have in common.
    pub(super) fn contact(&self, geometry: &Geometry, shared: f64, i: usize) -> Contact {
        let (slope, sigma) = self.contact_angle[i];
        let axle = self.axles[i];
        let shared = shared * level(slope);
        Contact {
            x: axle.x,
            y: axle.y,
            slope,
            slope_variance: (sigma * sigma - shared * shared).max(0.0),
            lever: Lever {
                link: geometry.carriers[i].index(),
                arm: axle.x,
            },
        }
    }
}

impl Contact {
    /// The same contact, moved with Q to `place` (m).
    pub fn moved(self, place: [f64; 2]) -> Self {
        Self {
            x: self.x + place[0],
            y: self.y + place[1],
            ..self
        }
    }

    /// The contact at the place `x` (m) on the way from `last` (x, y, angle) to here.
    pub fn since(&self, last: [f64; 3], x: f64) -> Self {
        let [x0, y0, slope0] = last;
        let way = self.x - x0;
        let share = if way.abs() > 0.0 {
            ((x - x0) / way).clamp(0.0, 1.0)
        } else {
            1.0
        };
        Self {
            x,
            y: y0 + share * (self.y - y0),
            slope: slope0 + share * (self.slope - slope0),
            ..*self
        }
    }
}

/// Change of the angle (rad) per change of dy/dx.
pub(super) fn level(slope: f64) -> f64 {
    let cos = libm::cos(slope);
    cos * cos
}

/// dy/dx for an angle (rad), at most 5 upwards or downwards: a riser has none.
pub(super) fn tangent(slope: f64) -> f64 {
    let (sin, cos) = libm::sincos(slope);
    sin / cos.max(0.2)
}

//! Places on the ground at which a step must end.
//!
//! Where the curvature of the ground jumps by K, the normal force of a wheel of mass m that rolls
//! over it at the speed v jumps by m v^2 K, within the 75 us of the contact's damping. Where a
//! friction stretch ends, the traction jumps. A step across such a place has no order. It therefore
//! ends there, and the next one starts short.

use crate::mechanics::Kinematics;
use crate::setup::PlantSetup;
use nalgebra::Vector4;
use robhaz_model::{Robot, Vec2};
use robhaz_terrain::Jump;

/// Smallest jump of N at which a step ends, N.
const LEAST_FORCE: f64 = 5e-3;
/// Smallest jump of the curvature that is looked for, 1/m: at 3 m/s it is 7 mN for the default
/// wheel.
const LEAST_CURVATURE: f64 = 5e-4;
/// A centre this close to the normal of a place is at the place, m.
const REACHED: f64 = 1e-6;
/// From this time on a step aims at the place itself, s. Before, it aims short of it: over longer
/// times the prediction errs.
const NEAR: f64 = 2e-3;
/// Share of the predicted time that a step takes which aims short.
const SHORT: f64 = 0.97;

/// The places, from rear to front.
pub(super) struct Jumps {
    pub places: Vec<Jump>,
    /// Radius of the wheels, m.
    radius: f64,
}

impl Jumps {
    pub fn new(setup: &PlantSetup) -> Self {
        let mut places = setup.terrain.curvature_jumps(LEAST_CURVATURE);
        let ends = setup.stretches.iter().flat_map(|s| [s.from, s.to]);
        places.extend(ends.filter_map(|x| setup.terrain.jump_at(x)));
        places.sort_by(|a, b| a.point.x.total_cmp(&b.point.x));
        Self {
            places,
            radius: setup.robot.geometry.wheel_radius,
        }
    }

    /// Longest step up to the next place that a wheel reaches within `longest` (s), s, from the
    /// accelerations of the four coordinates; and whether that step ends at the place.
    pub fn next(
        &self,
        robot: &Robot,
        kinematics: &Kinematics,
        accelerations: &Vector4<f64>,
        longest: f64,
    ) -> (f64, bool) {
        let mut next = (longest, false);
        for wheel in 0..3 {
            let motion = kinematics.wheel(wheel);
            let acceleration = kinematics.axles[wheel].acceleration(accelerations);
            let speed = motion.velocity.norm();
            let reach = self.radius + speed * longest;
            let (from, to) = (motion.centre.x - reach, motion.centre.x + reach);
            let first = self.places.partition_point(|place| place.point.x < from);
            for place in self.places[first..].iter().take_while(|p| p.point.x <= to) {
                if robot.mass.wheel * speed * speed * place.curvature < LEAST_FORCE {
                    continue;
                }
                let along = |v: Vec2| v.dot(&place.tangent);
                let distance = along(motion.centre - place.point);
                let time = time_to_zero(distance, along(motion.velocity), along(acceleration));
                let Some(time) = time.filter(|_| distance.abs() > REACHED) else {
                    continue;
                };
                let arrives = time < NEAR;
                let time = if arrives { time } else { SHORT * time };
                if time < next.0 {
                    next = (time, arrives);
                }
            }
        }
        next
    }
}

/// Time after which a distance (m) is zero at a speed (m/s) and an acceleration (m/s^2) of it, s;
/// `None` if it grows. The acceleration is a small correction; a larger one is limited.
fn time_to_zero(distance: f64, speed: f64, acceleration: f64) -> Option<f64> {
    let time = -distance / speed;
    if !(time > 0.0 && time.is_finite()) {
        return None;
    }
    // distance + speed t + acceleration t^2/2 = 0, one step of Newton's method from `time`.
    let correction = 0.5 * acceleration * time * time / (speed + acceleration * time);
    let most = 0.5 * time;
    Some(time - correction.max(-most).min(most))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: free fall of a point, to the error of one step of Newton's method, and points
    /// that move away.
    #[test]
    fn times_to_a_place() {
        for sign in [-1.0, 1.0] {
            let found = time_to_zero(-0.01 * sign, 0.2 * sign, 0.0);
            assert!(found.is_some_and(|found| (found - 0.05).abs() < 1e-15));
        }
        assert_eq!(time_to_zero(0.01, 0.2, 0.0), None);
        assert_eq!(time_to_zero(-0.01, 0.0, 1.0), None);
        // -d + v t + a t^2/2 = 0 at t = (sqrt(v^2 + 2 a d) - v)/a.
        let exact = (f64::sqrt(0.04 + 2.0 * 0.5 * 0.01) - 0.2) / 0.5;
        let found = time_to_zero(-0.01, 0.2, 0.5);
        assert!(
            found.is_some_and(|found| (found - exact).abs() < 2e-4),
            "{found:?} {exact}"
        );
    }
}

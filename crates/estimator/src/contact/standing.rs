//! Detection of a robot that stands although its wheels turn.

use crate::common::TYPICAL;
use crate::deviation::GATE;
use robhaz_model::{Vec2, perp};

/// Finds a robot that does not move although its wheels turn.
///
/// A robot that moves without a change of its posture moves parallel to itself: after the distance
/// between two axles a wheel is where the wheel in front of it was. Then all axles lie on one line
/// along the ground. If they do not, and the wheels have turned by more than that distance, the
/// wheels spin in place. A quarter of it is enough if all the while the contact angles that the
/// estimated motion shows deviate much from the lines between the axles: the ground would have to
/// be a saw.
///
/// In front of a wall on even ground the axles lie on a line. Then the deviation alone must show
/// it, while the wheels push: what the filters take for a slope holds the robot. The tractions show
/// that deviation too, at once: see [`Self::resisted`]. Wheels that push and hardly turn need no
/// way to show it, only time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StandingDetector {
    /// Link angles at which the posture was last seen to change, rad.
    posture: [f64; 2],
    /// Distance by which the wheels have turned since then, m.
    turned: f64,
    /// The same since the contact angles deviate by [`Self::STEEP`].
    turned_steep: f64,
    /// Whether the robot stands while its wheels turn, by the last sample.
    pub stands: bool,
}

impl StandingDetector {
    /// Change of a link angle that is a change of the posture, rad: beyond the gate of an inclinometer's
    /// noise.
    /// Definition.
    const CHANGE: f64 = GATE * TYPICAL.inclination_noise;
    /// Angle between the lines from axle to axle from which on they are not one line, rad: beyond the
    /// gate of a posture that changes. Drawings that err by 2 mm make 0.015.
    /// Definition.
    const BEND: f64 = GATE * Self::CHANGE;
    /// Distance by which the wheels have to turn over the largest distance between neighbouring axles,
    /// for contact angles that deviate by [`Self::STEEP`].
    /// Chosen; held by `contact/standing.rs` and `tests/check/health.rs`.
    const STEEP_DISTANCES: f64 = 0.25;
    /// Mean deviation of the contact angles from the lines between the axles that no robot meets
    /// while its posture stays, rad.
    /// Chosen; held by `contact/standing.rs` and `tests/check/health.rs`.
    const STEEP: f64 = 0.35;

    /// Least speed at which wheels that push count as turning while the contact angles deviate by
    /// [`Self::STEEP`], m/s: a robot whose wheels are at rest stands. It takes 0.75 s with axles
    /// 0.3 m apart, longer than any impact.
    /// Chosen; held by `contact/standing.rs` and `tests/check/health.rs`.
    const LEAST_SPEED: f64 = 0.1;

    /// Mean deviation of the contact angles from the lines between the axles that would balance the
    /// tractions, rad: above 0 where they push more than the weight along these lines and the
    /// inertia of a robot that follows its rims can resist.
    ///
    /// `push`: sum of the tractions over the weight. `acceleration`: mean of the rims' over
    /// gravity. `slope`: mean of the lines, rad. Rims that spin up faster than the robot give a
    /// negative angle, and hide what resists.
    pub fn resisted(push: f64, acceleration: f64, slope: f64) -> f64 {
        let climbed = libm::asin((push - acceleration).clamp(-1.0, 1.0));
        (climbed - slope) * push.signum()
    }

    /// Takes a sample. Returns whether the robot stands while its wheels turn.
    ///
    /// `link_angles`: rad. `axles`: positions relative to Q, m. `rim_speeds`: of the wheels
    /// relative to the links, m/s. `deviation`: mean over the wheels of the contact angle's
    /// deviation from the line between axles, rad, estimated or [`Self::resisted`], whichever is
    /// larger, not negative. `pushes`: whether the sum of the tractions is beyond
    /// [`SLIPPING_RATIO`] of the weight.
    /// `dt`: time since the last sample, s.
    pub fn update(
        &mut self,
        link_angles: [f64; 2],
        axles: &[Vec2; 3],
        rim_speeds: [f64; 3],
        deviation: f64,
        pushes: bool,
        dt: f64,
    ) -> bool {
        let [front, middle, rear] = axles;
        let change = |i: usize| (link_angles[i] - self.posture[i]).abs();
        if change(0).max(change(1)) > Self::CHANGE {
            *self = Self {
                posture: link_angles,
                ..Self::default()
            };
        } else {
            // One wheel may spin while the others roll: the median counts.
            let [a, b, c] = rim_speeds.map(f64::abs);
            let turned = dt * a.min(b).max(a.max(b).min(c));
            self.turned += turned;
            self.turned_steep = if deviation > Self::STEEP {
                let least = if pushes { Self::LEAST_SPEED } else { 0.0 };
                self.turned_steep + turned.max(least * dt)
            } else {
                0.0
            };
        }
        let (ahead, behind) = (front - middle, middle - rear);
        let lengths = [ahead, behind].map(|line| robhaz_model::sqrt(line.norm_squared()));
        let bend = perp(behind).dot(&ahead).abs() / (lengths[0] * lengths[1]);
        let distance = lengths[0].max(lengths[1]);
        let off_a_line = bend > Self::BEND;
        let far = self.turned > distance;
        let steep = self.turned_steep > Self::STEEP_DISTANCES * distance;
        self.stands |= (off_a_line && (far || steep)) || (steep && pushes);
        if !off_a_line && !pushes {
            // Nothing holds a robot on even ground that does not push.
            (self.stands, self.turned_steep) = (false, 0.0);
        }
        self.stands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXLES: [Vec2; 3] = [
        Vec2::new(0.3, 0.0),
        Vec2::new(0.0, 0.0),
        Vec2::new(-0.3, 0.0),
    ];

    /// Time until it is found that the robot stands, s, over 10 s at rim speeds of 0.2 m/s.
    fn found(axles: &[Vec2; 3], rate: f64, rim_speeds: [f64; 3], deviation: f64) -> Option<f64> {
        let mut detector = StandingDetector::default();
        let dt = 1e-3;
        let mut times = (1..=10_000).map(|k| dt * f64::from(k));
        times.find(|time| {
            let angles = [rate * time, 0.3];
            detector.update(angles, axles, rim_speeds, deviation, false, dt)
        })
    }

    /// With a wheel above the line of the others it takes 1.05 times the distance of the axles, or
    /// a quarter of it; on a line, with a posture that changes by 0.01 rad on a shorter way, or
    /// with a single spinning wheel it is never found.
    #[test]
    fn wheels_that_turn_in_a_constant_posture_off_a_line_spin() {
        let turning = [0.2; 3];
        let mut bent = AXLES;
        bent[0].y = 0.06;
        let distance = libm::hypot(0.3, 0.06);
        for (deviation, distances) in [(0.1, 1.0), (0.5, 0.25)] {
            let expected = distances * distance / 0.2;
            // A sample, and the first one at which the posture is taken.
            let time = found(&bent, 0.0, turning, deviation).expect("it stands");
            assert!((time - expected).abs() < 2e-3, "{time} {expected}");
            assert_eq!(found(&AXLES, 0.0, turning, deviation), None);
            assert_eq!(found(&bent, 0.03, turning, deviation), None);
            assert_eq!(found(&bent, 0.0, [0.2, 0.0, 0.0], deviation), None);
        }
    }

    /// On even ground only a robot that pushes against a slope that is not there stands, and only
    /// as long as it pushes.
    #[test]
    fn a_wall_on_even_ground_holds_a_robot_that_pushes() {
        let mut detector = StandingDetector::default();
        let mut stands = |deviation: f64, pushes: bool| {
            let mut found = None;
            for _ in 0..1000 {
                let still = [0.0; 2];
                found = Some(detector.update(still, &AXLES, [0.2; 3], deviation, pushes, 1e-3));
            }
            found
        };
        assert_eq!(stands(0.1, true), Some(false));
        assert_eq!(stands(0.5, false), Some(false));
        assert_eq!(stands(0.5, true), Some(true));
        assert_eq!(stands(0.1, true), Some(true));
        assert_eq!(stands(0.1, false), Some(false));
    }

    /// Wheels that stand against a wall show it after the time for a quarter of the axles' distance
    /// at 0.1 m/s; a parked robot, which does not push, is never found.
    #[test]
    fn wheels_that_push_and_hardly_turn_stand_after_a_while() {
        let time = |pushes: bool| {
            let mut detector = StandingDetector::default();
            let mut samples = 1..=10_000;
            let slow = [0.01, 0.1, 0.01];
            let mut stands = |_: &i32| detector.update([0.0; 2], &AXLES, slow, 0.5, pushes, 1e-3);
            samples.find(&mut stands)
        };
        // 0.25 times 0.3 m at 0.1 m/s, and rounding.
        assert!(time(true).is_some_and(|sample| (sample - 750).abs() <= 1));
        assert_eq!(time(false), None);
    }

    /// Closed forms: nothing is resisted on a slope that the tractions climb, up or down, nor by a
    /// robot that accelerates by them; all of the push at a wall, forwards and backwards; and less
    /// than nothing while rims spin up on ice.
    #[test]
    fn what_slope_and_inertia_do_not_explain_is_resisted() {
        let zero = |angle: f64| assert!(angle.abs() < 1e-12, "{angle}");
        for slope in [-0.6, 0.3] {
            zero(StandingDetector::resisted(libm::sin(slope), 0.0, slope));
        }
        zero(StandingDetector::resisted(0.5, 0.5, 0.0));
        for push in [-0.68, 0.68] {
            zero(StandingDetector::resisted(push, 0.0, 0.0) - libm::asin(0.68));
        }
        assert!(StandingDetector::resisted(0.3, 1.0, 0.0) < 0.0);
    }
}

//! Positions and accelerations of pins, axles and centres of mass relative to Q, as unit vectors
//! instead of angles.

use robhaz_model::{
    Bar, Carrier, Dyad, Geometry, Posture, PostureError, Vec2, cross, direction, perp, turned,
};

/// Positions relative to Q in world axes, m, in the posture that links 1 and 2 give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arms {
    /// Unit vectors along the turned x axis of each bar, in the order of [`Bar::ALL`].
    pub axes: [Vec2; 4],
    /// Pin P.
    pub p: Vec2,
    /// Pin R.
    pub r: Vec2,
    /// Pin S.
    pub s: Vec2,
    /// Centres of mass of the bars, in the order of [`Bar::ALL`].
    pub centres: [Vec2; 4],
    /// Axles of the wheels.
    pub axles: [Vec2; 3],
}

/// Angular rates (rad/s) and accelerations (rad/s^2) of the bars, in the order of [`Bar::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turning {
    /// Rates.
    pub rates: [f64; 4],
    /// Accelerations.
    pub accelerations: [f64; 4],
}

/// The unit vector of the turn that takes the direction of `from` into that of `to`; both have the
/// length of one bar.
fn turn_between(from: Vec2, to: Vec2) -> Vec2 {
    Vec2::new(from.dot(&to), cross(from, to)) / from.norm_squared()
}

impl Arms {
    /// Closes the four-bar from the angles of links 1 and 2, rad, as [`Posture::close`] does.
    ///
    /// # Errors
    /// [`PostureError`] where the four-bar cannot close.
    pub fn new(geometry: &Geometry, theta1: f64, theta2: f64) -> Result<Self, PostureError> {
        let pins = &geometry.pins;
        let axis = |angle| {
            let (sin, cos) = libm::sincos(angle);
            Vec2::new(cos, sin)
        };
        let (axis1, axis2) = (axis(theta1), axis(theta2));
        let p = turned(axis1, pins.p - pins.q);
        let r = turned(axis2, pins.r - pins.q);
        let s = Dyad::new(geometry).s(p, r)?;
        let axis_body = turn_between(pins.s - pins.p, s - p);
        let axis3 = turn_between(pins.s - pins.r, s - r);
        let carried = |i: usize| [axis1, axis2][geometry.carriers[i].index()];
        let axle = |i: usize| turned(carried(i), geometry.axles[i] - pins.q);
        Ok(Self {
            axes: [axis_body, axis1, axis2, axis3],
            p,
            r,
            s,
            centres: [
                p + turned(axis_body, geometry.body_cg - pins.p),
                turned(axis1, geometry.link_cg[0] - pins.q),
                turned(axis2, geometry.link_cg[1] - pins.q),
                r + turned(axis3, geometry.link_cg[2] - pins.r),
            ],
            axles: [axle(0), axle(1), axle(2)],
        })
    }

    /// Slopes of the ground that the posture shows, rad: at the front and rear wheel that of the line
    /// to the middle wheel, at the middle wheel that of the line between the others. The ground under a
    /// wheel deviates from it, but over a distance the mean slope of the ground is that of the robot.
    pub fn expected_slopes(&self) -> [f64; 3] {
        let slope = |front: usize, rear: usize| direction(self.axles[front] - self.axles[rear]);
        [slope(0, 1), slope(0, 2), slope(1, 2)]
    }

    /// The same posture in angles, rad.
    pub fn posture(&self, theta1: f64, theta2: f64) -> Posture {
        let angle = |bar: Bar| direction(self.axes[bar as usize]);
        Posture {
            body: angle(Bar::Body),
            links: [theta1, theta2, angle(Bar::Link3)],
        }
    }

    /// Rates and accelerations of all bars for given rates (rad/s) and accelerations (rad/s^2) of
    /// links 1 and 2: the closure `w1 x P + wb x (S-P) = w2 x R + w3 x (S-R)` and its derivative.
    pub fn turning(&self, rates: [f64; 2], accelerations: [f64; 2]) -> Turning {
        let ([w1, w2], [a1, a2]) = (rates, accelerations);
        let (c, d) = (self.s - self.p, self.s - self.r);
        let det = -cross(c, d);
        // `perp` is common to all terms: wb c - w3 d = right.
        let solve = |right: Vec2| (-cross(right, d) / det, cross(c, right) / det);
        let (wb, w3) = solve(self.r * w2 - self.p * w1);
        // Centripetal terms, turned back by a quarter so that `perp` stays common.
        let g = self.p * (w1 * w1) + c * (wb * wb) - self.r * (w2 * w2) - d * (w3 * w3);
        let (ab, a3) = solve(self.r * a2 - self.p * a1 - perp(g));
        Turning {
            rates: [wb, w1, w2, w3],
            accelerations: [ab, a1, a2, a3],
        }
    }

    /// Accelerations of the bars' centres of mass ([`Bar::ALL`]) and of the axles, m/s^2, when Q
    /// accelerates with `q`.
    pub fn accelerations(
        &self,
        carriers: &[Carrier; 3],
        q: Vec2,
        turning: &Turning,
    ) -> ([Vec2; 4], [Vec2; 3]) {
        let relative = |bar: Bar, arm: Vec2| {
            let i = bar as usize;
            perp(arm) * turning.accelerations[i] - arm * (turning.rates[i] * turning.rates[i])
        };
        let a_p = q + relative(Bar::Link1, self.p);
        let a_r = q + relative(Bar::Link2, self.r);
        let [body, link1, link2, link3] = self.centres;
        let axle = |i: usize| q + relative(carriers[i].bar(), self.axles[i]);
        (
            [
                a_p + relative(Bar::Body, body - self.p),
                q + relative(Bar::Link1, link1),
                q + relative(Bar::Link2, link2),
                a_r + relative(Bar::Link3, link3 - self.r),
            ],
            [axle(0), axle(1), axle(2)],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{arms, geometry};
    use proptest::prelude::*;

    /// Positions of the bars' centres of mass and of the axles, relative to Q.
    fn points(geometry: &Geometry, theta: [f64; 2]) -> [Vec2; 7] {
        let arms = arms(geometry, theta);
        let ([b, l1, l2, l3], [w1, w2, w3]) = (arms.centres, arms.axles);
        [b, l1, l2, l3, w1, w2, w3]
    }

    proptest! {
        /// Equivalence: unit vectors and angles describe the same posture, everywhere inside the
        /// stops of both geometries. Points lie within 0.5 m and take a dozen operations: 1e-12 m
        /// is a thousand times their rounding.
        #[test]
        fn arms_are_the_posture(theta2 in -0.5_f64..0.5, opening in -0.69_f64..0.61, is_b in any::<bool>()) {
            let geometry = geometry(is_b);
            let theta = [theta2 + opening, theta2];
            let posture = Posture::close(&geometry, theta[0], theta[1]).expect("inside the stops");
            let arms = arms(&geometry, theta);
            let same = |a: Vec2, b: Vec2| (a - b).norm() < 1e-12;
            for bar in Bar::ALL {
                let (sin, cos) = libm::sincos(posture.angle(bar));
                prop_assert!(same(arms.axes[bar as usize], Vec2::new(cos, sin)), "{bar:?}");
                prop_assert!(same(arms.centres[bar as usize], posture.cg_from_q(&geometry, bar)), "{bar:?}");
                prop_assert!((arms.posture(theta[0], theta[1]).angle(bar) - posture.angle(bar)).abs() < 1e-12);
            }
            for (pin, found) in [(robhaz_model::Pin::P, arms.p), (robhaz_model::Pin::R, arms.r), (robhaz_model::Pin::S, arms.s)] {
                prop_assert!(same(found, posture.pin_from_q(&geometry, pin)), "{pin:?}");
            }
            for i in 0..3 {
                prop_assert!(same(arms.axles[i], posture.axle_from_q(&geometry, i)), "wheel {i}");
            }
        }

        /// Equivalence with the rates that the angles' closed form gives. Relative to the largest
        /// rate.
        #[test]
        fn rates_are_those_of_the_posture(
            theta2 in -0.5_f64..0.5, opening in -0.69_f64..0.61, w1 in -2.0_f64..2.0, w2 in -2.0_f64..2.0, is_b in any::<bool>(),
        ) {
            let geometry = geometry(is_b);
            let posture = Posture::close(&geometry, theta2 + opening, theta2).expect("inside the stops");
            let expected = posture.rates(&geometry, w1, w2);
            let found = arms(&geometry, [theta2 + opening, theta2]).turning([w1, w2], [0.0; 2]).rates;
            let scale = expected.iter().fold(1.0_f64, |m, w| m.max(w.abs()));
            for i in 0..4 {
                prop_assert!((found[i] - expected[i]).abs() < 1e-12 * scale, "{found:?} {expected:?}");
            }
        }

        /// Angular accelerations are the derivatives of the rates along a path, and accelerations
        /// of points the second derivatives of their positions. Central differences err by h^2
        /// times a higher derivative (some 100 here) and by rounding over h: 1e-8 with h = 1e-5 for
        /// the first, rounding over h^2 (1e-7) with h = 1e-4 for the second.
        #[test]
        fn accelerations_are_the_derivatives(
            theta2 in -0.3_f64..0.3, opening in -0.5_f64..0.5, w in prop::array::uniform2(-1.0_f64..1.0),
            a in prop::array::uniform2(-3.0_f64..3.0), is_b in any::<bool>(),
        ) {
            let geometry = geometry(is_b);
            let start = [theta2 + opening, theta2];
            let theta = |t: f64| [0, 1].map(|i| start[i] + w[i] * t + 0.5 * a[i] * t * t);
            let rates = |t: f64| arms(&geometry, theta(t)).turning([0, 1].map(|i| w[i] + a[i] * t), [0.0; 2]).rates;
            let now = arms(&geometry, start);
            let turning = now.turning(w, a);
            let h = 1e-5;
            let (after, before) = (rates(h), rates(-h));
            for i in 0..4 {
                let difference = (after[i] - before[i]) / (2.0 * h);
                prop_assert!((turning.accelerations[i] - difference).abs() < 1e-6, "bar {i}");
            }

            let q = Vec2::new(0.7, -0.4);
            let (centres, axles) = now.accelerations(&geometry.carriers, q, &turning);
            let h = 1e-4;
            let at = [-h, 0.0, h].map(|t| points(&geometry, theta(t)));
            for (i, found) in centres.into_iter().chain(axles).enumerate() {
                let difference = (at[2][i] - at[1][i] * 2.0 + at[0][i]) / (h * h);
                prop_assert!((found - q - difference).norm() < 1e-5, "point {i}: {found} {difference}");
            }
        }
    }

    #[test]
    fn a_linkage_that_cannot_close_is_refused() {
        assert!(Arms::new(&Geometry::a(), 1.5, -1.5).is_err());
        assert!(Arms::new(&Geometry::a(), f64::NAN, 0.0).is_err());
    }
}

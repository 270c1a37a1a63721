//! Where everything on the linkage is and how it accelerates, seen from Q: what eqs. (1) to (8) need, without angles.

use robhaz_model::{Bar, Carrier, Geometry, Posture, PostureError, Vec2, corner_s, cross};

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

/// `v` turned by the angle whose cosine and sine are `axis`.
fn turned(axis: Vec2, v: Vec2) -> Vec2 {
    Vec2::new(axis.x * v.x - axis.y * v.y, axis.y * v.x + axis.x * v.y)
}

/// The unit vector of the turn that takes the direction of `from` into that of `to`; both have the length of one bar.
fn turn_between(from: Vec2, to: Vec2) -> Vec2 {
    Vec2::new(from.dot(&to), cross(from, to)) / from.norm_squared()
}

/// `v` turned by a quarter, counter-clockwise.
pub(crate) fn perp(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
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
        let s = corner_s(geometry, p, r)?;
        let axis_body = turn_between(pins.s - pins.p, s - p);
        let axis3 = turn_between(pins.s - pins.r, s - r);
        let carried = |carrier: Carrier| match carrier {
            Carrier::Link1 => axis1,
            Carrier::Link2 => axis2,
        };
        let axle = |i: usize| turned(carried(geometry.carriers[i]), geometry.axles[i] - pins.q);
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

    /// The same posture in angles, rad.
    pub fn posture(&self, theta1: f64, theta2: f64) -> Posture {
        let angle = |bar: Bar| {
            let axis = self.axes[bar as usize];
            libm::atan2(axis.y, axis.x)
        };
        Posture {
            body: angle(Bar::Body),
            links: [theta1, theta2, angle(Bar::Link3)],
        }
    }

    /// How all bars turn when links 1 and 2 do with the given rates (rad/s) and accelerations (rad/s^2): the closure
    /// `w1 x P + wb x (S-P) = w2 x R + w3 x (S-R)` and its derivative.
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

    /// Accelerations of the bars' centres of mass ([`Bar::ALL`]) and of the axles, m/s^2, when Q accelerates with `q`.
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

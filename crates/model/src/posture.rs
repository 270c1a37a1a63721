//! The closed four-bar in any posture: the angles of links 1 and 2 give those of link 3 and body in
//! closed form.

use crate::plane::{cross, perp, rotate};
use crate::{Bar, Geometry, Pin, Vec2};

/// Angles of the four bars relative to the nominal pose, rad, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// Pitch of the body, theta_body.
    pub body: f64,
    /// Angles of links 1 to 3, theta_1 to theta_3.
    pub links: [f64; 3],
}

/// The four-bar cannot close at the given angles of links 1 and 2: body and link 3 do not reach
/// from P to R.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the four-bar cannot close: P and R are {pr:.4} m apart, body and link3 span {least:.4} to {greatest:.4} m"
)]
pub struct PostureError {
    /// Distance between P and R at these angles, m.
    pub pr: f64,
    /// Least distance that body and link 3 can span, m.
    pub least: f64,
    /// Greatest distance that body and link 3 can span, m.
    pub greatest: f64,
}

/// The dyad of body and link 3: two bars that are joined in S and end in P and R.
#[derive(Clone, Copy, Debug)]
pub struct Dyad {
    /// Least and greatest distance that both bars can span, m.
    least: f64,
    greatest: f64,
    /// Square of the distance PS, m^2.
    ps2: f64,
    /// PS^2 - RS^2, m^2.
    difference: f64,
    /// 1 if S lies to the left of PR in the nominal pose, else -1.
    side: f64,
}

impl Dyad {
    /// The dyad of a geometry.
    #[inline]
    pub fn new(geometry: &Geometry) -> Self {
        let pins = &geometry.pins;
        let [ps2, rs2] = [pins.p, pins.r].map(|pin| (pins.s - pin).norm_squared());
        let (ps, rs) = (crate::sqrt(ps2), crate::sqrt(rs2));
        Self {
            least: libm::fabs(ps - rs),
            greatest: ps + rs,
            ps2,
            difference: ps2 - rs2,
            side: libm::copysign(1.0, cross(pins.r - pins.p, pins.s - pins.p)),
        }
    }

    /// Position of S (m) from the positions of P and R (m), all relative to the same origin: the
    /// corner of a triangle with sides PS (body) and RS (link 3), on the side of PR where it lies
    /// in the nominal pose.
    ///
    /// # Errors
    /// [`PostureError`] where the triangle does not exist, or a coordinate is not finite.
    #[inline]
    pub fn s(&self, p: Vec2, r: Vec2) -> Result<Vec2, PostureError> {
        let pr = r - p;
        let d2 = pr.norm_squared();
        let (least, greatest) = (self.least, self.greatest);
        // In this form the condition refuses NaN as well.
        if !(d2 > least * least && d2 < greatest * greatest && d2 > 0.0) {
            return Err(PostureError {
                pr: crate::sqrt(d2),
                least,
                greatest,
            });
        }
        // Foot of S on PR, measured from P, and height above it, both as shares of the length of
        // PR.
        let per_d2 = 1.0 / d2;
        let foot = 0.5 + 0.5 * self.difference * per_d2;
        let height = crate::sqrt((self.ps2 * per_d2 - foot * foot).max(0.0));
        Ok(p + pr * foot + perp(pr) * (self.side * height))
    }
}

impl Posture {
    /// Closes the four-bar at given angles of link 1 and link 2, rad: the position analysis of Fig.
    /// 5.
    ///
    /// Relative to Q, the two links determine P and R; [`Dyad::s`] gives S.
    ///
    /// # Errors
    /// [`PostureError`] where the triangle does not exist, or an angle is not finite.
    pub fn close(geometry: &Geometry, theta1: f64, theta2: f64) -> Result<Self, PostureError> {
        let pins = &geometry.pins;
        let p = rotate(pins.p - pins.q, theta1);
        let r = rotate(pins.r - pins.q, theta2);
        let s = Dyad::new(geometry).s(p, r)?;
        let turn = |from: Vec2, to: Vec2| libm::atan2(cross(from, to), from.dot(&to));
        Ok(Self {
            body: turn(pins.s - pins.p, s - p),
            links: [theta1, theta2, turn(pins.s - pins.r, s - r)],
        })
    }

    /// Angular rates of all bars at given rates of link 1 and link 2, rad/s, in this posture.
    ///
    /// Velocity closure of the loop: `w1 x (P-Q) + wb x (S-P) = w2 x (R-Q) + w3 x (S-R)`. Returns
    /// `[body, link1, link2, link3]` in the order of [`Bar::ALL`]; not finite where P, R and S lie
    /// on one line.
    pub fn rates(&self, geometry: &Geometry, rate1: f64, rate2: f64) -> [f64; 4] {
        let pins = &geometry.pins;
        let a = rotate(pins.p - pins.q, self.links[0]);
        let b = rotate(pins.r - pins.q, self.links[1]);
        let c = rotate(pins.s - pins.p, self.body);
        let d = rotate(pins.s - pins.r, self.links[2]);
        // With `perp` common to all terms: wb c - w3 d = w2 b - w1 a.
        let right = b * rate2 - a * rate1;
        let det = -cross(c, d);
        [-cross(right, d) / det, rate1, rate2, cross(c, right) / det]
    }

    /// Angle of a bar, rad.
    pub fn angle(&self, bar: Bar) -> f64 {
        let [link1, link2, link3] = self.links;
        [self.body, link1, link2, link3][bar as usize]
    }

    /// Position relative to Q, in world axes, m, of a point of `bar` that is given by its nominal
    /// position `nominal` (m).
    pub fn from_q(&self, geometry: &Geometry, bar: Bar, nominal: Vec2) -> Vec2 {
        let pins = &geometry.pins;
        match bar {
            Bar::Link1 => rotate(nominal - pins.q, self.links[0]),
            Bar::Link2 => rotate(nominal - pins.q, self.links[1]),
            Bar::Body => {
                rotate(pins.p - pins.q, self.links[0]) + rotate(nominal - pins.p, self.body)
            }
            Bar::Link3 => {
                rotate(pins.r - pins.q, self.links[1]) + rotate(nominal - pins.r, self.links[2])
            }
        }
    }

    /// Position of a pin relative to Q, m, in world axes.
    pub fn pin_from_q(&self, geometry: &Geometry, pin: Pin) -> Vec2 {
        self.from_q(geometry, pin.bars().0, geometry.pins.get(pin))
    }

    /// Position of a wheel's axle relative to Q, m, in world axes.
    pub fn axle_from_q(&self, geometry: &Geometry, wheel: usize) -> Vec2 {
        let bar = geometry.carriers[wheel].bar();
        self.from_q(geometry, bar, geometry.axles[wheel])
    }

    /// Position of a bar's centre of mass relative to Q, m, in world axes.
    pub fn cg_from_q(&self, geometry: &Geometry, bar: Bar) -> Vec2 {
        self.from_q(geometry, bar, geometry.cg(bar))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Carrier;
    use proptest::prelude::*;

    #[test]
    fn the_nominal_pose_closes_at_zero() {
        for geometry in [Geometry::a(), Geometry::b()] {
            let posture = Posture::close(&geometry, 0.0, 0.0).expect("the nominal pose closes");
            assert!(posture.body.abs() < 1e-14 && posture.links[2].abs() < 1e-14);
        }
    }

    /// Closed form: the body of a bogie turns with its link, everywhere, and keeps its place on it.
    #[test]
    fn the_body_of_a_bogie_is_fixed_to_its_link() {
        for (body, own) in [(Carrier::Link1, 0), (Carrier::Link2, 1)] {
            let mut geometry = Geometry::a();
            geometry.make_bogie(body);
            for theta in [[0.3, -0.5], [-0.7, 0.2], [2.0, 1.0]] {
                let posture = Posture::close(&geometry, theta[0], theta[1]).expect("always closes");
                let rates = posture.rates(&geometry, 0.7, -0.4);
                let cg = rotate(geometry.body_cg - geometry.pins.q, theta[own]);
                // Rounding of a triangle's angles.
                assert!((posture.body - theta[own]).abs() < 1e-14);
                assert!((rates[0] - [0.7, -0.4][own]).abs() < 1e-14);
                assert!((posture.cg_from_q(&geometry, Bar::Body) - cg).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn links_folded_too_far_are_refused() {
        let folded = Posture::close(&Geometry::a(), 1.5, -1.5);
        assert!(matches!(folded, Err(e) if e.pr < e.least));
        assert!(Posture::close(&Geometry::a(), f64::NAN, 0.0).is_err());
    }

    proptest! {
        /// Property: S computed through link 1 and body equals S computed through links 2 and 3,
        /// everywhere inside the stops.
        #[test]
        fn the_loop_closes(theta2 in -0.5_f64..0.5, opening in -0.69_f64..0.61, is_b in any::<bool>()) {
            let geometry = if is_b { Geometry::b() } else { Geometry::a() };
            let posture = Posture::close(&geometry, theta2 + opening, theta2).expect("inside the stops");
            let over_body = posture.from_q(&geometry, Bar::Body, geometry.pins.s);
            let over_link3 = posture.from_q(&geometry, Bar::Link3, geometry.pins.s);
            // Rounding of four rotations of points within 0.5 m.
            prop_assert!((over_body - over_link3).norm() < 1e-14);
        }

        /// Closed form: rates against central differences of the angles, whose error at h = 1e-6 s
        /// is about 1e-9 rad/s.
        #[test]
        fn rates_are_the_derivatives_of_angles(
            theta1 in -0.3_f64..0.3, theta2 in -0.3_f64..0.3, rate1 in -1.0_f64..1.0, rate2 in -1.0_f64..1.0,
        ) {
            let geometry = Geometry::a();
            let at = |t: f64| Posture::close(&geometry, theta1 + rate1 * t, theta2 + rate2 * t).expect("inside the stops");
            let rates = at(0.0).rates(&geometry, rate1, rate2);
            let h = 1e-6;
            for (bar, rate) in Bar::ALL.into_iter().zip(rates) {
                let difference = (at(h).angle(bar) - at(-h).angle(bar)) / (2.0 * h);
                prop_assert!((rate - difference).abs() < 1e-7, "{bar:?}: {rate} {difference}");
            }
        }
    }
}

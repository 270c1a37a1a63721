//! What the kinematics need of the robot's geometry, computed once.

use robhaz_model::{Carrier, Dyad, Geometry, Vec2, cross};

/// Nominal positions of points on the bars, and the dyad that closes the loop.
#[derive(Clone)]
pub(crate) struct Linkage {
    /// Body and link 3.
    pub(super) dyad: Dyad,
    /// P from Q, m.
    pub(super) p: Vec2,
    /// R from Q, m.
    pub(super) r: Vec2,
    /// Centre of mass of the body from P, m.
    pub(super) body_cg: Vec2,
    /// Centre of mass of link 3 from R, m.
    pub(super) link3_cg: Vec2,
    /// Centres of mass of links 1 and 2 from Q, m.
    pub(super) link_cgs: [Vec2; 2],
    /// Of each wheel: the link that carries it, and the axle from Q, m.
    pub(super) axles: [(Carrier, Vec2); 3],
    /// S from P and from R, over the square of its length, 1/m.
    body: Vec2,
    link3: Vec2,
}

impl Linkage {
    pub fn new(geometry: &Geometry) -> Self {
        let pins = &geometry.pins;
        let of_wheel = |i: usize| (geometry.carriers[i], geometry.axles[i] - pins.q);
        let per_square = |arm: Vec2| arm / arm.norm_squared();
        Self {
            dyad: Dyad::new(geometry),
            p: pins.p - pins.q,
            r: pins.r - pins.q,
            body_cg: geometry.body_cg - pins.p,
            link3_cg: geometry.link_cg[2] - pins.r,
            link_cgs: [geometry.link_cg[0] - pins.q, geometry.link_cg[1] - pins.q],
            axles: [of_wheel(0), of_wheel(1), of_wheel(2)],
            body: per_square(pins.s - pins.p),
            link3: per_square(pins.s - pins.r),
        }
    }

    /// Unit vector along the turned x axis of the body from the vector PS, m, whose length is the
    /// nominal one.
    pub(super) fn body_axis(&self, ps: Vec2) -> Vec2 {
        Vec2::new(self.body.dot(&ps), cross(self.body, ps))
    }

    /// The same of link 3 from the vector RS, m.
    pub(super) fn link3_axis(&self, rs: Vec2) -> Vec2 {
        Vec2::new(self.link3.dot(&rs), cross(self.link3, rs))
    }
}

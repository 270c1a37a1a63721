//! Places where the curvature of the ground jumps.

use crate::Vec2;
use crate::edge::Edge;

/// A place of the ground that divides the motion of a wheel in two smooth parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The place, m.
    pub point: Vec2,
    /// Unit tangent there, pointing forward. The contact of a wheel passes the place when the
    /// wheel's centre passes the normal.
    pub tangent: Vec2,
    /// Magnitude of the jump of the curvature, 1/m.
    pub curvature: f64,
}

impl Jump {
    /// At the smooth joint of two edges.
    pub(crate) fn at_joint(before: &Edge, after: &Edge) -> Self {
        let tangent = after.tangents()[0].normalize();
        let second = after.second_derivatives[0] - before.second_derivatives[1];
        Self {
            point: after.from,
            tangent,
            curvature: (second * tangent.x.powi(3)).abs(),
        }
    }
}

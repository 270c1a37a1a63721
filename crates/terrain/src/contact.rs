//! A contact of a wheel with the ground.

use crate::Vec2;

/// A point of the ground where the distance to a wheel's centre has a local minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point on the ground, m.
    pub point: Vec2,
    /// Unit tangent of the ground, pointing forward.
    pub tangent: Vec2,
    /// Signed distance of the centre from the point, along the normal, m; negative if the centre is below the ground.
    pub distance: f64,
}

impl Contact {
    /// Contact angle gamma: slope of the tangent, rad. The tangent is `(cos gamma, sin gamma)`, the normal
    /// `(-sin gamma, cos gamma)`.
    pub fn angle(&self) -> f64 {
        self.tangent.y.atan2(self.tangent.x)
    }

    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(-self.tangent.y, self.tangent.x)
    }

    /// A contact where the ground has a tangent, which need not be a unit vector. `arm` goes from point to centre, m.
    pub(crate) fn on_edge(point: Vec2, tangent: Vec2, arm: Vec2) -> Self {
        let tangent = tangent / tangent.norm();
        Self {
            point,
            tangent,
            distance: tangent.x * arm.y - tangent.y * arm.x,
        }
    }

    /// A contact at a corner: the normal points from the corner to the centre.
    pub(crate) fn on_corner(point: Vec2, arm: Vec2) -> Self {
        let distance = arm.norm();
        Self {
            point,
            tangent: Vec2::new(arm.y, -arm.x) / distance,
            distance,
        }
    }
}

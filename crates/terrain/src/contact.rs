//! Where a wheel meets the ground.

use crate::Vec2;

/// A place where the ground is nearest to a wheel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point on the ground, m.
    pub point: Vec2,
    /// Unit tangent of the ground, pointing forward.
    pub tangent: Vec2,
    /// Distance of the centre from the point, along the normal, m; negative below the ground.
    pub distance: f64,
}

impl Contact {
    /// Contact angle gamma: slope of the tangent, rad. Tangent `(cos g, sin g)`, normal `(-sin g, cos g)`.
    pub fn angle(&self) -> f64 {
        self.tangent.y.atan2(self.tangent.x)
    }

    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(-self.tangent.y, self.tangent.x)
    }

    /// Inside an edge, where the ground has a tangent (not normalised). `arm` goes from the point to the centre, m.
    pub(crate) fn on_edge(point: Vec2, tangent: Vec2, arm: Vec2) -> Self {
        let tangent = tangent / tangent.norm();
        Self {
            point,
            tangent,
            distance: tangent.x * arm.y - tangent.y * arm.x,
        }
    }

    /// At a corner: its normal points at the centre.
    pub(crate) fn on_corner(point: Vec2, arm: Vec2) -> Self {
        let distance = arm.norm();
        Self {
            point,
            tangent: Vec2::new(arm.y, -arm.x) / distance,
            distance,
        }
    }
}

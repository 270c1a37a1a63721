//! A contact of a wheel with the ground.

use crate::Vec2;

/// A point of the ground where the distance to a wheel's centre has a local minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point on the ground, m.
    pub point: Vec2,
    /// Unit tangent of the ground, pointing forward.
    pub tangent: Vec2,
    /// Signed distance of the centre from the point, along the normal, m; negative if the centre is
    /// below the ground.
    pub distance: f64,
    /// Second derivative of the ground's height there, 1/m; minus infinity at a corner.
    pub(crate) second_derivative: f64,
}

impl Contact {
    /// Contact angle gamma: slope of the tangent, rad. The tangent is `(cos gamma, sin gamma)`, the
    /// normal `(-sin gamma, cos gamma)`.
    pub fn angle(&self) -> f64 {
        self.tangent.y.atan2(self.tangent.x)
    }

    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(-self.tangent.y, self.tangent.x)
    }

    /// Rate at which the contact angle changes when the centre moves along the tangent, rad/m:
    /// `kappa/(1 - kappa d)` with the distance d and the curvature kappa of the ground, positive in
    /// a hollow; `-1/d` at a corner.
    pub fn turning(&self) -> f64 {
        if self.second_derivative == f64::NEG_INFINITY {
            return -1.0 / self.distance;
        }
        // kappa = f''/(1 + f'^2)^(3/2), and 1/(1 + f'^2) is the square of the tangent's x.
        let curvature = self.second_derivative * self.tangent.x.powi(3);
        curvature / (1.0 - curvature * self.distance)
    }

    /// The contact after a small displacement of the centre (m): tangent and distance to first
    /// order. The point stays.
    #[must_use]
    pub fn displaced(&self, by: Vec2) -> Self {
        let normal = self.normal();
        Self {
            tangent: self.tangent + normal * (self.turning() * self.tangent.dot(&by)),
            distance: self.distance + normal.dot(&by),
            ..*self
        }
    }

    /// A contact where the ground has a tangent, which need not be a unit vector, and a second
    /// derivative (1/m). `arm` goes from point to centre, m.
    #[inline]
    pub(crate) fn on_edge(point: Vec2, tangent: Vec2, second_derivative: f64, arm: Vec2) -> Self {
        let tangent = tangent / tangent.norm();
        Self {
            point,
            tangent,
            distance: tangent.x * arm.y - tangent.y * arm.x,
            second_derivative,
        }
    }

    /// A contact at a corner: the normal points from the corner to the centre.
    pub(crate) fn on_corner(point: Vec2, arm: Vec2) -> Self {
        let distance = arm.norm();
        Self {
            point,
            tangent: Vec2::new(arm.y, -arm.x) / distance,
            distance,
            second_derivative: f64::NEG_INFINITY,
        }
    }
}

//! Pin forces from the impulses of rapier's joints.

use robhaz_model::{Vec2, cross, perp};

/// Poses of two bars at their pin, before a step.
pub(super) struct PinArms {
    /// Direction of the x axis of the first bar.
    pub axis: Vec2,
    /// From the centres of mass to the pin, m.
    pub arms: [Vec2; 2],
    /// Inverse mass (1/kg) and inverse inertia (1/(kg m^2)) of both bars.
    pub inverse: [(f64, f64); 2],
}

impl PinArms {
    /// Force on the first bar, N, from the impulses (N s) of rapier's two rows in a step `dt` (s).
    ///
    /// Rapier orthogonalises the rows of a joint (Gram-Schmidt, in the metric of the inverse
    /// masses). The second impulse therefore acts along a combination of both axes, and `d01/d00`
    /// is its share along the first one.
    pub fn force(&self, first: f64, second: f64, dt: f64) -> Vec2 {
        let ex = self.axis;
        let ey = perp(ex);
        let (mut d00, mut d01) = (0.0, 0.0);
        for (r, (inverse_mass, inverse_inertia)) in self.arms.iter().zip(self.inverse) {
            let (cx, cy) = (cross(*r, ex), cross(*r, ey));
            d00 += inverse_mass + cx * cx * inverse_inertia;
            d01 += cx * cy * inverse_inertia;
        }
        (ex * (first - d01 / d00 * second) + ey * second) / dt
    }
}

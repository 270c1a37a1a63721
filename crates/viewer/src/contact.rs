//! Where a wheel touches, from what the truth says of it.

use robhaz_model::Vec2;
use robhaz_sim::WheelTruth;

/// The point at which a wheel of a radius (m) touches, m.
pub(crate) fn contact_point(wheel: &WheelTruth, radius: f64) -> Vec2 {
    let (_, normal) = tangent_and_normal(wheel.contact_angle);
    wheel.position - normal * (radius - wheel.penetration)
}

/// Unit vectors along the ground and out of it, for a contact angle (rad).
pub(crate) fn tangent_and_normal(angle: f64) -> (Vec2, Vec2) {
    let (sin, cos) = angle.sin_cos();
    (Vec2::new(cos, sin), Vec2::new(-sin, cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a slope of 90 deg to the left the ground is ahead of the wheel, and the normal points back at it.
    #[test]
    fn the_contact_point_is_the_arm_away_from_the_centre() {
        let wheel = WheelTruth {
            position: Vec2::new(1.0, 0.5),
            contact_angle: std::f64::consts::FRAC_PI_2,
            penetration: 0.001,
            ..WheelTruth::default()
        };
        let found = contact_point(&wheel, 0.1);
        assert!((found - Vec2::new(1.099, 0.5)).norm() < 1e-12);
    }
}

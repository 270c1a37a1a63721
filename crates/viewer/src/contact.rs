//! The contact point of a wheel, from the truth.

use robhaz_model::Vec2;
use robhaz_sim::WheelTruth;

/// The contact point of a wheel of a radius (m), m: that of its equivalent contact. Where it has
/// none, it lies in the direction of the sum of its normal forces.
pub(crate) fn contact_point(wheel: &WheelTruth, radius: f64) -> Vec2 {
    let equivalent = wheel.equivalent_contact();
    let (_, normal) = tangent_and_normal(equivalent.map_or(wheel.contact_angle, |c| c.angle));
    wheel.position - normal * (radius - wheel.penetration)
}

/// Unit tangent (forward) and normal (out of the ground) for a contact angle (rad).
pub(crate) fn tangent_and_normal(angle: f64) -> (Vec2, Vec2) {
    let (sin, cos) = angle.sin_cos();
    (Vec2::new(cos, sin), Vec2::new(-sin, cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: at a contact angle of 90 deg the ground is a wall ahead of the wheel, and the
    /// normal points backward.
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

//! Vectors in the plane.

use crate::Vec2;

/// The z component of `a x b`.
pub fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// `v` turned counter-clockwise by 90 deg: the velocity of a point `v` that rotates about the
/// origin at 1 rad/s.
pub fn perp(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}

/// `v` turned counter-clockwise by the angle of the unit vector `axis` = (cos, sin).
pub fn turned(axis: Vec2, v: Vec2) -> Vec2 {
    Vec2::new(axis.x * v.x - axis.y * v.y, axis.y * v.x + axis.x * v.y)
}

/// `v` turned counter-clockwise by `angle`, rad.
pub fn rotate(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(angle);
    turned(Vec2::new(cos, sin), v)
}

/// Angle of a vector to the x axis, rad, counter-clockwise: that of `atan2`, to the same bits. For
/// a vector that points forward, as the directions of bars and ground do, it needs half the time.
pub fn direction(v: Vec2) -> f64 {
    if v.x > 0.0 {
        libm::atan(v.y / v.x)
    } else {
        libm::atan2(v.y, v.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equivalence: the bits of `atan2` in all directions, also along both axes and without length.
    #[test]
    fn directions_have_the_bits_of_atan2() {
        let parts = [0.0, -0.0, 1e-300, 1e-9, 0.3, 1.0, 7.0, 1e9, 1e300];
        for x in parts.into_iter().flat_map(|x| [x, -x]) {
            for y in parts.into_iter().flat_map(|y| [y, -y]) {
                let found = direction(Vec2::new(x, y));
                assert_eq!(found.to_bits(), libm::atan2(y, x).to_bits(), "{x} {y}");
            }
        }
    }
}

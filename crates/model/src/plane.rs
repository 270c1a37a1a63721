//! Vectors in the plane.

use crate::Vec2;

/// The z component of `a x b`.
pub fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// `v` turned counter-clockwise by 90 deg: the velocity of a point `v` that rotates about the origin at 1 rad/s.
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

//! Conversions from the model's types to the viewer's.

use rerun::datatypes::Quaternion;
use robhaz_model::Vec2;

/// A rotation in the plane by an angle (rad, counter-clockwise positive).
pub(crate) fn turn(angle: f64) -> Quaternion {
    let (sin, cos) = (0.5 * angle).sin_cos();
    Quaternion::from_xyzw([0.0, 0.0, narrow(sin), narrow(cos)])
}

/// A point of a 2-D shape, m.
pub(crate) fn flat(v: Vec2) -> [f32; 2] {
    [narrow(v.x), narrow(v.y)]
}

/// The position of a pose, m, with z = 0.
pub(crate) fn deep(v: Vec2) -> [f32; 3] {
    [narrow(v.x), narrow(v.y), 0.0]
}

/// Single precision. The error is at most 0.5 um at 10 m.
// The viewer uses single precision.
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}

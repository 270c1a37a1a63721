//! From the model's numbers to the viewer's.

use rerun::datatypes::Quaternion;
use robhaz_model::Vec2;

/// A turn in the plane (rad, counter-clockwise).
pub(crate) fn turn(angle: f64) -> Quaternion {
    let (sin, cos) = (0.5 * angle).sin_cos();
    Quaternion::from_xyzw([0.0, 0.0, narrow(sin), narrow(cos)])
}

/// A point of a 2-D shape.
pub(crate) fn flat(v: Vec2) -> [f32; 2] {
    [narrow(v.x), narrow(v.y)]
}

/// A point of a pose.
pub(crate) fn deep(v: Vec2) -> [f32; 3] {
    [narrow(v.x), narrow(v.y), 0.0]
}

/// To the viewer's precision: 1 um at 10 m.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the viewer draws in single precision"
)]
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}

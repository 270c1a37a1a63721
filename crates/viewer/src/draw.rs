//! What all parts of the animation draw with: the viewer's types, contact points, and rows that are
//! not logged yet.

use crate::error::Result;
use crate::writer::Writer;
use re_sdk_types::archetypes::{Arrows2D, LineStrips2D};
use re_sdk_types::components::{Color, Radius};
use re_sdk_types::datatypes::Quaternion;
use robhaz_estimator::whole::Vec3;
use robhaz_model::Vec2;
use robhaz_sim::WheelTruth;

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

/// A point or vector of a 3-D shape, m.
pub(crate) fn solid(v: &Vec3) -> [f32; 3] {
    [narrow(v.x), narrow(v.y), narrow(v.z)]
}

/// Single precision. The error is at most 0.5 um at 10 m.
// The viewer uses single precision.
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}

/// Rounds a value to a multiple of 1/`fractions`, against digits of binary fractions. Adding 0
/// turns -0 into 0.
pub(crate) fn rounded(value: f64, fractions: f64) -> f64 {
    (value * fractions).round() / fractions + 0.0
}

/// The look of lines of one colour and half a width in points, without the lines.
pub(crate) fn lines(colour: Color, radius: f32) -> LineStrips2D {
    LineStrips2D::update_fields()
        .with_colors([colour])
        .with_radii([Radius::new_ui_points(radius)])
}

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

/// Polylines of several times, m, any number at each.
#[derive(Default)]
pub(crate) struct Strips {
    times: Vec<f64>,
    counts: Vec<usize>,
    pub(crate) strips: Vec<Vec<[f32; 2]>>,
}

impl Strips {
    /// Adds the polylines of a time (s).
    pub(crate) fn push<S>(&mut self, time: f64, strips: impl IntoIterator<Item = S>)
    where
        S: IntoIterator<Item = Vec2>,
    {
        let before = self.strips.len();
        let points = |strip: S| strip.into_iter().map(flat).collect();
        self.strips.extend(strips.into_iter().map(points));
        self.times.push(time);
        self.counts.push(self.strips.len() - before);
    }

    /// Logs all of it.
    pub(crate) fn log(self, out: &mut Writer, entity: &str) -> Result {
        let columns = LineStrips2D::update_fields().with_strips(self.strips);
        out.columns(entity, &self.times, columns.columns(self.counts))
    }
}

/// Arrows of several times, any number at each: colour, origin and vector (m).
#[derive(Default)]
pub(crate) struct Arrows {
    counts: Vec<usize>,
    arrows: Vec<(Color, Vec2, Vec2)>,
}

impl Arrows {
    /// Adds the arrows of the next time.
    pub(crate) fn push(&mut self, arrows: Vec<(Color, Vec2, Vec2)>) {
        self.counts.push(arrows.len());
        self.arrows.extend(arrows);
    }

    /// Logs all of them, at their times (s).
    pub(crate) fn log(self, out: &mut Writer, entity: &str, times: &[f64]) -> Result {
        let arrows = self.arrows.iter();
        let columns = Arrows2D::update_fields()
            .with_colors(arrows.clone().map(|(colour, ..)| *colour))
            .with_origins(arrows.clone().map(|(_, origin, _)| flat(*origin)))
            .with_vectors(arrows.map(|(.., vector)| flat(*vector)));
        out.columns(entity, times, columns.columns(self.counts))
    }
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

//! One cosine bump.

use crate::Vec2;
use crate::shape::{Piece, SPACING, Shape};
use std::f64::consts::PI;

/// `height/2 (1 + cos(pi (x - centre)/half_width))` for `|x - centre| < half_width`, level
/// elsewhere; m.
///
/// Its curvature jumps where it meets the level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CosBump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// x of the summit, m.
    pub centre: f64,
    /// Half of the bump's length, m.
    pub half_width: f64,
}

impl Shape for CosBump {
    fn eval(&self, x: f64) -> [f64; 3] {
        let u = (x - self.centre) / self.half_width;
        if u.abs() > 1.0 {
            return [0.0; 3];
        }
        let (k, half) = (PI / self.half_width, 0.5 * self.height);
        let (sin, cos) = (PI * u).sin_cos();
        [half * (1.0 + cos), -half * k * sin, -half * k * k * cos]
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.centre - self.half_width, 0.0);
        let spacing = SPACING.min(self.half_width / 20.0);
        let end = self.centre + self.half_width;
        (start, vec![Piece::Curve(end, spacing)])
    }
}

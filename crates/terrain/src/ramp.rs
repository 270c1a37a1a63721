//! An incline between level ground.

use crate::Vec2;
use crate::shape::{Piece, Shape};

/// Level ground, an incline, level ground; two corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Slope of the incline, rad; negative downhill. Within +-80 deg.
    pub angle: f64,
    /// x of the start of the incline, m.
    pub start: f64,
    /// Length along the incline, m.
    pub length: f64,
}

impl Shape for Ramp {
    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.start, 0.0);
        let top = start + Vec2::new(self.angle.cos(), self.angle.sin()) * self.length;
        (start, vec![Piece::Line(top)])
    }
}

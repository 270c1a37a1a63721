//! A trench.

use crate::Vec2;
use crate::shape::{Piece, Shape};

/// A trench with vertical walls and a level bottom.
///
/// If it is narrower than a wheel's diameter and deep enough, the wheel rests on both upper
/// corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ditch {
    /// Depth of the bottom below the level ground, m.
    pub depth: f64,
    /// Distance between the walls, m.
    pub width: f64,
    /// x of the rear wall, m.
    pub start: f64,
}

impl Shape for Ditch {
    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let corner = |x, y| Piece::Line(Vec2::new(self.start + x, y));
        let walls = [
            (0.0, -self.depth),
            (self.width, -self.depth),
            (self.width, 0.0),
        ];
        let start = Vec2::new(self.start, 0.0);
        (start, walls.map(|(x, y)| corner(x, y)).to_vec())
    }
}

//! A trench.

use crate::Vec2;
use crate::check::{above_zero, finite};
use crate::error::ProfileError;
use crate::shape::{Piece, Shape};

/// A trench with vertical walls and a level bottom.
///
/// If it is narrower than a wheel's diameter and deep enough, the wheel rests on both upper corners.
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
    fn check(&self) -> Result<(), ProfileError> {
        finite("start", self.start)?;
        above_zero("depth", self.depth)?;
        above_zero("width", self.width)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_ditches_are_refused() {
        let ditch = Ditch {
            depth: 0.0,
            width: 0.1,
            start: 0.0,
        };
        let expected = "depth is 0; it must be a number above 0";
        assert_eq!(
            ditch.check().map_err(|e| e.to_string()),
            Err(expected.to_owned())
        );
    }
}

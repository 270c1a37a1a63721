//! Kerbs and stairs.

use crate::Vec2;
use crate::error::ProfileError;
use crate::shape::{Piece, Shape};

/// Steps with vertical risers: one is a kerb, several are stairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stairs {
    /// Height of each riser, m; negative for steps down.
    pub rise: f64,
    /// Length of each tread, m.
    pub run: f64,
    /// Number of risers.
    pub count: u32,
    /// x of the first riser, m.
    pub start: f64,
}

impl Shape for Stairs {
    fn check(&self) -> Result<(), ProfileError> {
        let allowed = "a finite number other than 0";
        ProfileError::unless(self.rise != 0.0, "rise", self.rise, allowed)
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.start, 0.0);
        let mut at = start;
        let mut pieces = Vec::new();
        for step in 0..self.count {
            if step > 0 {
                at.x += self.run;
                pieces.push(Piece::Line(at));
            }
            at.y += self.rise;
            pieces.push(Piece::Line(at));
        }
        (start, pieces)
    }
}

//! The interface of every kind of ground.

use crate::Vec2;
use crate::error::ProfileError;

/// The interface of every kind of ground.
pub(crate) trait Shape {
    /// See [`Profile::check`](crate::Profile::check).
    fn check(&self) -> Result<(), ProfileError> {
        Ok(())
    }

    /// See [`Profile::eval`](crate::Profile::eval).
    fn eval(&self, _x: f64) -> [f64; 3] {
        [0.0; 3]
    }

    /// End of the level ground before the profile (m), and the pieces from there to the level
    /// ground behind it.
    fn pieces(&self) -> (Vec2, Vec<Piece>);
}

/// One piece of the ground. It starts at the end of the last piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Piece {
    /// A straight line to a point, m.
    Line(Vec2),
    /// The curve of [`Profile::eval`](crate::Profile::eval) to x (first value, m), with knots at
    /// most a spacing apart (second value, m). The spacing must resolve the shape.
    Curve(f64, f64),
}

/// Greatest spacing of knots, m: so small that an edge has at most one point nearest to a wheel's
/// centre.
pub(crate) const SPACING: f64 = 0.01;

//! The interface of every kind of ground, and why a ground is refused.

use crate::Vec2;

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

/// Why a profile is refused: what was found, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ProfileError(pub(crate) String);

impl ProfileError {
    /// Refuses a value that is not `inside` its range; `allowed` completes the sentence "it must be
    /// ...".
    pub(crate) fn unless(inside: bool, entry: &str, found: f64, allowed: &str) -> Result<(), Self> {
        match inside {
            true => Ok(()),
            false => Err(Self(format!("{entry} is {found}; it must be {allowed}"))),
        }
    }
}

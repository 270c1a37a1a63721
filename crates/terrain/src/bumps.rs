//! Sums of Gaussian bumps.

use crate::Vec2;
use crate::shape::{Piece, SPACING, Shape};

/// Value of `((x - centre)/width)^2` beyond which a bump counts as zero: exp(-40) is 4e-18 of its
/// height.
const CUTOFF: f64 = 40.0;
/// Half length of a bump's curve in widths. The cutoff lies at 6.3 widths.
const EXTENT: f64 = 8.0;

/// One Gaussian bump (or hollow) `height exp(-((x - centre)/width)^2)`; m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// x of the summit, m.
    pub centre: f64,
    /// Half width at 1/e of the height, m.
    pub width: f64,
}

impl Shape for Vec<Bump> {
    fn eval(&self, x: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for b in self {
            let u = (x - b.centre) / b.width;
            if u * u > CUTOFF {
                continue;
            }
            let e = b.height * (-u * u).exp();
            sum[0] += e;
            sum[1] -= 2.0 * u / b.width * e;
            sum[2] += (4.0 * u * u - 2.0) / (b.width * b.width) * e;
        }
        sum
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let (mut from, mut to, mut spacing) = (f64::INFINITY, f64::NEG_INFINITY, SPACING);
        for b in self {
            from = from.min(b.centre - EXTENT * b.width);
            to = to.max(b.centre + EXTENT * b.width);
            spacing = spacing.min(b.width / 10.0);
        }
        if self.is_empty() {
            return (Vec2::zeros(), Vec::new());
        }
        let start = Vec2::new(from, self.eval(from)[0]);
        (start, vec![Piece::Curve(to, spacing)])
    }
}

//! Ground through given points.

mod monotone;
mod smoothing;

use crate::Vec2;
use crate::edge::Edge;
use crate::shape::{Piece, SPACING, Shape};
use robhaz_model::named;
use std::sync::Arc;

/// Edges of a curve are no shorter than this, m, unless its points are: below it no wheel can touch
/// an edge twice.
const SHORTEST: f64 = 1e-3;
/// A point this near to the straight line between its neighbours is no corner, m: 0.02 mN of normal
/// force.
const STRAIGHT: f64 = 1e-10;

named! {
    /// How the ground goes from point to point.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    pub enum Interpolation {
        /// Polynomials of fifth degree, each between the heights of its two points and monotone: no
        /// summit where there is no point. Height, slope and curvature are continuous, also where
        /// the level ground joins.
        #[default]
        Monotone = "monotone",
        /// The natural cubic spline: height, slope and curvature are continuous, the curvature is 0
        /// at both ends. It swings beyond its points where they jump.
        Spline = "spline",
        /// Straight, with a corner at every point.
        Corners = "corners",
    }
}

/// Ground through points. Its height counts from the first point, so that it joins the level ground
/// there.
///
/// Where a spline starts or ends with a slope, that makes a corner with the level ground. Copies
/// share the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights(Arc<Data>);

#[derive(Clone, Debug, PartialEq)]
struct Data {
    given: Vec<Vec2>,
    interpolation: Interpolation,
    smoothing: f64,
    /// The points after smoothing, where there is any.
    smooth: Option<Vec<Vec2>>,
    curve: Curve,
}

/// What is known of the curve at its points beside their heights.
#[derive(Clone, Debug, PartialEq)]
enum Curve {
    /// Slope (-) and second derivative (1/m).
    Quintic(Vec<[f64; 2]>),
    /// Second derivative, 1/m.
    Cubic(Vec<f64>),
    Straight,
}

/// How far a curve leaves the heights of the points between which it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overshoot {
    /// Where it is farthest beyond them, m.
    pub x: f64,
    /// How far, m.
    pub beyond: f64,
    /// The same as a share of the height from the lowest point to the highest one.
    pub share: f64,
}

impl Heights {
    /// Ground through points (m), whose x must increase.
    pub fn new(points: Vec<Vec2>, interpolation: Interpolation) -> Self {
        Self::with_smoothing(points, interpolation, 0.0)
    }

    /// Ground through the means of points (m) over windows about them: waves of the length
    /// `smoothing` (m) are halved, shorter ones taken out. 0 for none.
    pub fn with_smoothing(points: Vec<Vec2>, interpolation: Interpolation, smoothing: f64) -> Self {
        let smooth = (smoothing > 0.0).then(|| smoothing::smoothed(&points, smoothing));
        let through = smooth.as_ref().unwrap_or(&points);
        let curve = match interpolation {
            Interpolation::Monotone => Curve::Quintic(monotone::monotone(through)),
            Interpolation::Spline => Curve::Cubic(natural_bends(through)),
            Interpolation::Corners => Curve::Straight,
        };
        Self(Arc::new(Data {
            given: points,
            interpolation,
            smoothing,
            smooth,
            curve,
        }))
    }

    /// The points as they were given, m.
    pub fn points(&self) -> &[Vec2] {
        &self.0.given
    }

    /// How the ground goes from point to point.
    pub fn interpolation(&self) -> Interpolation {
        self.0.interpolation
    }

    /// Length of the waves that the smoothing halves, m; 0 for none.
    pub fn smoothing(&self) -> f64 {
        self.0.smoothing
    }

    /// The points that the ground goes through, m.
    fn through(&self) -> &[Vec2] {
        self.0.smooth.as_ref().unwrap_or(&self.0.given)
    }

    /// Where the curve leaves the heights of two neighbouring points most; `None` where it never
    /// does.
    pub fn overshoot(&self) -> Option<Overshoot> {
        let Curve::Cubic(bends) = &self.0.curve else {
            return None;
        };
        let points = self.through();
        let heights = points.iter().map(|p| p.y);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        let start = points.first()?.y;
        let mut most: Option<Overshoot> = None;
        for i in 1..points.len() {
            let (a, b) = (points[i - 1], points[i]);
            for x in turning_points(a, b, bends[i - 1], bends[i]) {
                let y = self.eval(x)[0] + start;
                let beyond = (y - a.y.max(b.y)).max(a.y.min(b.y) - y);
                if beyond > most.map_or(0.0, |m| m.beyond) {
                    let share = beyond / (high - low);
                    most = Some(Overshoot { x, beyond, share });
                }
            }
        }
        most
    }
}

/// Where the slope of a cubic between two points is 0: its slope is a quadratic of v = (x - a.x)/h.
fn turning_points(a: Vec2, b: Vec2, bend_a: f64, bend_b: f64) -> impl Iterator<Item = f64> {
    let h = b.x - a.x;
    let c0 = (b.y - a.y) / h - h / 6.0 * (2.0 * bend_a + bend_b);
    let (c1, c2) = (h * bend_a, 0.5 * h * (bend_b - bend_a));
    // Without cancellation where the quadratic term is small.
    let root = (c1 * c1 - 4.0 * c0 * c2).sqrt();
    let q = -0.5 * (c1 + root.copysign(c1));
    [q / c2, c0 / q]
        .into_iter()
        .filter(|v| *v > 0.0 && *v < 1.0)
        .map(move |v| a.x + v * h)
}

impl Shape for Heights {
    /// Level outside of the points.
    fn eval(&self, x: f64) -> [f64; 3] {
        let points = self.through();
        let Some((first, last)) = points.first().zip(points.last()) else {
            return [0.0; 3];
        };
        if points.len() < 2 || x < first.x {
            return [0.0; 3];
        }
        if x > last.x {
            return [last.y - first.y, 0.0, 0.0];
        }
        // At a point the piece before it counts, at the first one the piece after it.
        let to = points.partition_point(|p| p.x < x);
        let to = to.clamp(1, points.len() - 1);
        let (a, b) = (points[to - 1], points[to]);
        let (bend_a, bend_b) = match &self.0.curve {
            Curve::Quintic(ends) => {
                let knot = |p: Vec2, [slope, bend]: [f64; 2]| (p.x, [p.y - first.y, slope, bend]);
                return Edge::curve(knot(a, ends[to - 1]), knot(b, ends[to])).eval(x);
            }
            Curve::Cubic(bends) => (bends[to - 1], bends[to]),
            Curve::Straight => (0.0, 0.0),
        };
        let h = b.x - a.x;
        let (u, v) = ((b.x - x) / h, (x - a.x) / h);
        let h2 = h * h / 6.0;
        [
            u * (a.y - first.y)
                + v * (b.y - first.y)
                + h2 * ((u * u * u - u) * bend_a + (v * v * v - v) * bend_b),
            (b.y - a.y) / h
                + h / 6.0 * ((1.0 - 3.0 * u * u) * bend_a + (3.0 * v * v - 1.0) * bend_b),
            u * bend_a + v * bend_b,
        ]
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let points = self.through();
        let Some(first) = points.first() else {
            return (Vec2::zeros(), Vec::new());
        };
        let pieces = match self.0.interpolation {
            // One polynomial to a piece, and enough edges for its bend.
            Interpolation::Monotone | Interpolation::Spline => {
                let gaps = points.windows(2);
                let piece = |gap: &[Vec2]| {
                    let share = (gap[1].x - gap[0].x) / 4.0;
                    Piece::Curve(gap[1].x, share.clamp(SHORTEST, SPACING))
                };
                gaps.map(piece).collect()
            }
            Interpolation::Corners => {
                let corner = |p: &Vec2| Piece::Line(Vec2::new(p.x, p.y - first.y));
                corners(points).map(corner).collect()
            }
        };
        (Vec2::new(first.x, 0.0), pieces)
    }
}

/// The points behind the first without those that lie on the straight line between their
/// neighbours: however finely a straight stretch is measured, to a wheel it is one edge.
fn corners(points: &[Vec2]) -> impl Iterator<Item = &Vec2> {
    let mut kept = Vec::new();
    let mut from = points.first();
    // Slopes from the last corner that pass every point since then within STRAIGHT.
    let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
    for pair in points.windows(2) {
        let (last, next) = (&pair[0], &pair[1]);
        if let Some(start) = from {
            let slope = |y: f64| (y - start.y) / (next.x - start.x);
            let here = slope(next.y);
            if !(here >= least && here <= most) {
                kept.push(last);
                from = Some(last);
                (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
        if let Some(start) = from {
            let slope = |y: f64| (y - start.y) / (next.x - start.x);
            least = least.max(slope(next.y - STRAIGHT));
            most = most.min(slope(next.y + STRAIGHT));
        }
    }
    kept.extend(points.last());
    kept.into_iter()
}

/// Second derivatives of the natural cubic spline at its points, 1/m, by the tridiagonal algorithm.
fn natural_bends(points: &[Vec2]) -> Vec<f64> {
    let count = points.len();
    let mut bends = vec![0.0; count];
    let mut upper = vec![0.0; count];
    for i in 1..count.saturating_sub(1) {
        let (before, after) = (points[i].x - points[i - 1].x, points[i + 1].x - points[i].x);
        let slope = |a: Vec2, b: Vec2| (b.y - a.y) / (b.x - a.x);
        let kink = slope(points[i], points[i + 1]) - slope(points[i - 1], points[i]);
        let pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        bends[i] = (6.0 * kink - before * bends[i - 1]) / pivot;
    }
    for i in (1..count.saturating_sub(1)).rev() {
        bends[i] -= upper[i] * bends[i + 1];
    }
    bends
}

#[cfg(test)]
mod tests;

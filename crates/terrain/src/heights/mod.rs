//! Ground through given points.

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
    points: Vec<Vec2>,
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
    /// Ground through points (m), whose x must increase; with corners points of equal x are a riser
    /// ([`check_risers`](crate::check_risers)).
    pub fn new(points: Vec<Vec2>, interpolation: Interpolation) -> Self {
        Self::with_smoothing(points, interpolation, 0.0)
    }

    /// Ground through the means of points (m) over windows about them: waves of the length
    /// `smoothing` (m) are halved, shorter ones taken out. 0 for none.
    pub fn with_smoothing(points: Vec<Vec2>, interpolation: Interpolation, smoothing: f64) -> Self {
        let points = match smoothing > 0.0 {
            true => smoothed(&points, smoothing),
            false => points,
        };
        let curve = match interpolation {
            Interpolation::Monotone => Curve::Quintic(monotone(&points)),
            Interpolation::Spline => Curve::Cubic(natural_bends(&points)),
            Interpolation::Corners => Curve::Straight,
        };
        Self(Arc::new(Data { points, curve }))
    }

    /// The points that the ground goes through, m.
    pub fn points(&self) -> &[Vec2] {
        &self.0.points
    }

    /// Where the curve leaves the heights of two neighbouring points most; `None` where it never
    /// does.
    pub fn overshoot(&self) -> Option<Overshoot> {
        let Curve::Cubic(bends) = &self.0.curve else {
            return None;
        };
        let points = self.points();
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
        let points = self.points();
        let Some((first, last)) = points.first().zip(points.last()) else {
            return [0.0; 3];
        };
        // At a riser the ground before it counts.
        let starts_with_riser = points.get(1).is_some_and(|next| next.x <= first.x);
        if points.len() < 2 || x < first.x || starts_with_riser && x <= first.x {
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
        let points = self.points();
        let Some(first) = points.first() else {
            return (Vec2::zeros(), Vec::new());
        };
        let pieces = match self.0.curve {
            // One polynomial to a piece, and enough edges for its bend.
            Curve::Quintic(_) | Curve::Cubic(_) => {
                let gaps = points.windows(2);
                let piece = |gap: &[Vec2]| {
                    let share = (gap[1].x - gap[0].x) / 4.0;
                    Piece::Curve(gap[1].x, share.clamp(SHORTEST, SPACING))
                };
                gaps.map(piece).collect()
            }
            Curve::Straight => {
                let corner = |p: &Vec2| Piece::Line(Vec2::new(p.x, p.y - first.y));
                corners(points).into_iter().map(corner).collect()
            }
        };
        (Vec2::new(first.x, 0.0), pieces)
    }
}

/// The points behind the first without those that lie on the straight line between their
/// neighbours: however finely a straight stretch is measured, to a wheel it is one edge.
fn corners(points: &[Vec2]) -> Vec<&Vec2> {
    let mut kept = Vec::new();
    let Some(mut start) = points.first() else {
        return kept;
    };
    // Slopes from the last corner that pass every point since then within STRAIGHT.
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut least, mut most) = any;
    for pair in points.windows(2) {
        let (last, next) = (&pair[0], &pair[1]);
        let slope = |from: &Vec2, y: f64| (y - from.y) / (next.x - from.x);
        let here = slope(start, next.y);
        if !(here >= least && here <= most) {
            kept.push(last);
            start = last;
            (least, most) = any;
        }
        least = least.max(slope(start, next.y - STRAIGHT));
        most = most.min(slope(start, next.y + STRAIGHT));
    }
    kept.extend(points.last());
    kept
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

// Slopes and second derivatives that make the quintics between points monotone.
//
// A polynomial of fifth degree p on an interval of width h is given by height, slope m and second
// derivative b at both ends. Its derivative, in Bernstein form over the interval, has the five
// coefficients
//
// ```text
// d0 = m0      d1 = m0 + h b0/4      d2 = 5 D - d0 - d1 - d3 - d4      d3 = m1 - h b1/4      d4 = m1
// ```
//
// with D = (y1 - y0)/h. Where all of them have the sign of D, p is monotone: a Bernstein
// polynomial lies between its coefficients. The rules here keep these signs. Neighbours share m
// and b, so that the curve is C2.
//
// The idea of C2 quintics whose derivatives are estimated first and then shrunk until they are
// monotone is that of MQSI (Lux, Watson, Chang et al., ACM TOMS Algorithm 1031); estimates and
// conditions are simpler here, and one pass is enough.

/// Points on each side from which derivatives are estimated: a polynomial of fourth degree through
/// five points.
const NEIGHBOURS: usize = 2;

/// Slope (-) and second derivative (1/m) at each point; x must increase.
///
/// Both are 0 at the first and the last point, where level ground joins. At a point that is higher
/// or lower than both neighbours the slope is 0, beside a level piece both are.
fn monotone(points: &[Vec2]) -> Vec<[f64; 2]> {
    let mut ends = vec![[0.0; 2]; points.len()];
    for (i, end) in ends.iter_mut().enumerate() {
        if i > 0 && i + 1 < points.len() {
            let reach = NEIGHBOURS.min(i).min(points.len() - 1 - i);
            *end = limited(estimate(&points[i - reach..=i + reach], reach), points, i);
        }
    }
    // d2 of each piece has the sign of D where g0 + g1 is at most 5 |D|. Every g is at least 0
    // after `limited`, so that a point that shrinks for one of its pieces does no harm to the
    // other: one pass is enough.
    let shares: Vec<f64> = (1..points.len())
        .map(|i| {
            let gap = points[i] - points[i - 1];
            let share = |[m, b]: [f64; 2], h: f64| (2.0 * m + 0.25 * h * b) * gap.y.signum();
            let needed = share(ends[i - 1], gap.x) + share(ends[i], -gap.x);
            let most = 5.0 * gap.y.abs() / gap.x;
            if needed > most { most / needed } else { 1.0 }
        })
        .collect();
    for (i, end) in ends.iter_mut().enumerate() {
        let before = i.checked_sub(1).map_or(1.0, |k| shares[k]);
        let least = shares.get(i).map_or(before, |after| before.min(*after));
        *end = end.map(|v| v * least);
    }
    ends
}

/// Slope and second derivative at the middle one of some points, of the polynomial through all of
/// them.
///
/// Newton's form: with the nodes in the order middle, neighbours, farther ones, p(x) = sum of c_k
/// w_k(x), where w_k is the product of (x - x_j) over the first k nodes, and c_k are the divided
/// differences.
fn estimate(points: &[Vec2], reach: usize) -> [f64; 2] {
    const MOST: usize = 2 * NEIGHBOURS + 1;
    let middle = points[reach];
    let (mut x, mut c) = ([0.0; MOST], [0.0; MOST]);
    let count = points.len().min(MOST);
    for k in 1..count {
        let far = k.div_ceil(2);
        let point = points[if k % 2 == 1 { reach + far } else { reach - far }];
        (x[k], c[k]) = (point.x - middle.x, point.y - middle.y);
    }
    for order in 1..count {
        for k in (order..count).rev() {
            c[k] = (c[k] - c[k - 1]) / (x[k] - x[k - order]);
        }
    }
    // w_k = s (s - x1) ... has at s = 0 the slope P and the second derivative 2 Q, with P and Q the
    // coefficients of s and s^2.
    let (mut slope, mut bend) = (0.0, 0.0);
    let (mut p, mut q) = (1.0, 0.0);
    for k in 1..count {
        slope += c[k] * p;
        bend += 2.0 * c[k] * q;
        (p, q) = (-x[k] * p, p - x[k] * q);
    }
    [slope, bend]
}

/// An estimate with the signs of d0, d1, d3 and d4 of both pieces that meet at point `i`.
fn limited([slope, bend]: [f64; 2], points: &[Vec2], i: usize) -> [f64; 2] {
    let (before, after) = (points[i] - points[i - 1], points[i + 1] - points[i]);
    if before.y == 0.0 || after.y == 0.0 || !(slope.is_finite() && bend.is_finite()) {
        return [0.0; 2];
    }
    let sign = after.y.signum();
    if before.y * sign < 0.0 {
        // A summit bends down, a hollow up.
        return [0.0, if bend * sign > 0.0 { bend } else { 0.0 }];
    }
    let slope = (slope * sign).max(0.0);
    let bend = (bend * sign).clamp(-4.0 * slope / after.x, 4.0 * slope / before.x);
    [slope * sign, bend * sign]
}

/// Width of a window over the length of the waves that the smoothing halves: (sin(pi w)/(pi w))^3 =
/// 1/2.
const WINDOW: f64 = 0.366_063_256_638;
/// So many windows one after the other: near enough to a Gaussian that no wave comes back upside
/// down with more than 1.1 %.
const PASSES: usize = 3;

/// Points whose heights are the mean over a window about each, three times over; `length` above 0,
/// m.
///
/// Between points the ground is straight, before the first and after the last it is level. A wave
/// of wavelength l comes back with (sin(a)/a)^3 of its amplitude, a = pi w/l: a half at l =
/// `length`, 85 % at twice it, 3 % at half of it.
fn smoothed(points: &[Vec2], length: f64) -> Vec<Vec2> {
    (0..PASSES).fold(points.to_vec(), |smooth, _| {
        averaged(&smooth, 0.5 * WINDOW * length)
    })
}

/// Means over `half` to both sides of each point.
fn averaged(points: &[Vec2], half: f64) -> Vec<Vec2> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    // Integral of the height over the first one, from the first point to each.
    let mut sums = Vec::with_capacity(points.len());
    let mut sum = 0.0;
    sums.push(sum);
    for pair in points.windows(2) {
        sum += (pair[1].x - pair[0].x) * (0.5 * (pair[0].y + pair[1].y) - first.y);
        sums.push(sum);
    }
    // The same up to any x; `piece` is the piece that x was on last, and x never falls.
    let up_to = |x: f64, piece: &mut usize| {
        if x <= first.x {
            return 0.0;
        }
        if x >= last.x {
            return sum + (x - last.x) * (last.y - first.y);
        }
        while points[*piece + 1].x < x {
            *piece += 1;
        }
        let (a, b) = (points[*piece], points[*piece + 1]);
        let s = x - a.x;
        sums[*piece] + s * (a.y - first.y + 0.5 * s * (b.y - a.y) / (b.x - a.x))
    };
    let (mut rear, mut front) = (0, 0);
    let mean = |p: &Vec2| {
        let area = up_to(p.x + half, &mut front) - up_to(p.x - half, &mut rear);
        Vec2::new(p.x, first.y + area / (2.0 * half))
    };
    points.iter().map(mean).collect()
}

#[cfg(test)]
mod tests;

//! Slopes and second derivatives that make the quintics between points monotone.
//!
//! A polynomial of fifth degree p on an interval of width h is given by height, slope m and second
//! derivative b at both ends. Its derivative, in Bernstein form over the interval, has the five
//! coefficients
//!
//! ```text
//! d0 = m0      d1 = m0 + h b0/4      d2 = 5 D - d0 - d1 - d3 - d4      d3 = m1 - h b1/4      d4 = m1
//! ```
//!
//! with D = (y1 - y0)/h. Where all of them have the sign of D, p is monotone: a Bernstein
//! polynomial lies between its coefficients. The rules here keep these signs. Neighbours share m
//! and b, so that the curve is C2.
//!
//! The idea of C2 quintics whose derivatives are estimated first and then shrunk until they are
//! monotone is that of MQSI (Lux, Watson, Chang et al., ACM TOMS Algorithm 1031); estimates and
//! conditions are simpler here, and one pass is enough.

use crate::Vec2;

/// Points on each side from which derivatives are estimated: a polynomial of fourth degree through
/// five points.
const NEIGHBOURS: usize = 2;

/// Slope (-) and second derivative (1/m) at each point; x must increase.
///
/// Both are 0 at the first and the last point, where level ground joins. At a point that is higher
/// or lower than both neighbours the slope is 0, beside a level piece both are.
pub(crate) fn monotone(points: &[Vec2]) -> Vec<[f64; 2]> {
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

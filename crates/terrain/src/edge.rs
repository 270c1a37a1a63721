//! One piece of the ground between two neighbouring knots.

use crate::Vec2;
use crate::contact::Contact;

/// A Newton step shorter than this is the last, m: the next would be of the order of its square, 1e-11 m.
const LAST_STEP: f64 = 3.0e-6;
/// Tangents that differ by less than this are the same, rad: rounding, where a curve goes on.
const SMOOTH: f64 = 1e-9;

/// Height (m), slope (-) and second derivative (1/m) of a curve at one x (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Knot {
    pub x: f64,
    pub at: [f64; 3],
}

/// An edge, walked in the direction of travel (ground on the right): a riser, or the polynomial of fifth degree that has the
/// ground's height, slope and second derivative at both ends. Its height errs by at most `max|f''''''| h^6/46080`.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub from: Vec2,
    pub to: Vec2,
    /// Slopes at both ends, -; infinite on a riser.
    slopes: [f64; 2],
    /// Second derivatives at both ends, 1/m.
    bends: [f64; 2],
    /// Coefficients of (x - from.x)^3 to ^5.
    higher: [f64; 3],
    straight: bool,
    /// Number of corners between the start of the ground and this edge.
    pub run: u32,
}

impl Edge {
    /// A straight edge, upright where both ends have the same x.
    pub fn line(from: Vec2, to: Vec2) -> Self {
        let slope = (to.y - from.y) / (to.x - from.x);
        Self {
            from,
            to,
            slopes: [slope; 2],
            bends: [0.0; 2],
            higher: [0.0; 3],
            straight: true,
            run: 0,
        }
    }

    /// A piece of a curve.
    pub fn curve(from: Knot, to: Knot) -> Self {
        let ([y0, m0, b0], [y1, m1, b1]) = (from.at, to.at);
        let h = to.x - from.x;
        // What the parabola at `from` misses at `to`, in height, slope and second derivative.
        let y = y1 - y0 - h * (m0 + 0.5 * h * b0);
        let m = h * (m1 - m0 - h * b0);
        let b = 0.5 * h * h * (b1 - b0);
        Self {
            from: Vec2::new(from.x, y0),
            to: Vec2::new(to.x, y1),
            slopes: [m0, m1],
            bends: [b0, b1],
            higher: [
                (10.0 * y - 4.0 * m + b) / h.powi(3),
                (-15.0 * y + 7.0 * m - 2.0 * b) / h.powi(4),
                (6.0 * y - 3.0 * m + b) / h.powi(5),
            ],
            straight: false,
            run: 0,
        }
    }

    pub fn is_riser(&self) -> bool {
        self.slopes[0].is_infinite()
    }

    /// Whether it is straight.
    pub fn is_line(&self) -> bool {
        self.straight
    }

    /// Height less that of `from` (m), slope (-) and second derivative (1/m) at `s` (m) in front of `from`.
    fn rise(&self, s: f64) -> [f64; 3] {
        let [c3, c4, c5] = self.higher;
        let [m, b] = [self.slopes[0], self.bends[0]];
        [
            s * (m + s * (0.5 * b + s * (c3 + s * (c4 + s * c5)))),
            m + s * (b + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5))),
            b + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)),
        ]
    }

    /// Height (m), slope (-) and second derivative (1/m) at x, on any edge but a riser.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        if x >= self.to.x {
            return [self.to.y, self.slopes[1], self.bends[1]];
        }
        let [rise, slope, bend] = self.rise(x - self.from.x);
        [self.from.y + rise, slope, bend]
    }

    /// Height at x, m; on a riser that of its upper end.
    pub fn height(&self, x: f64) -> f64 {
        if self.is_riser() {
            return self.to.y;
        }
        self.from.y + self.rise(x - self.from.x)[0]
    }

    /// Bounds of the height, m; of a straight edge between two x on it only, since it can be long.
    pub fn heights(&self, from_x: f64, to_x: f64) -> (f64, f64) {
        let (a, b) = if self.is_riser() || !self.is_line() {
            (self.from.y, self.to.y)
        } else {
            (self.height(from_x), self.height(to_x))
        };
        // No farther from the chord than max|f''| h^2/8.
        let (low, high) = self.bend_bounds();
        let bulge = low.abs().max(high.abs()) * (self.to.x - self.from.x).powi(2) / 8.0;
        (a.min(b) - bulge, a.max(b) + bulge)
    }

    /// Bounds of the second derivative, 1/m: those of its Bezier points.
    pub fn bend_bounds(&self) -> (f64, f64) {
        let h = self.to.x - self.from.x;
        let [c3, c4, _] = self.higher;
        let (b0, b1) = (self.bends[0], self.bends[1]);
        let first = b0 + 2.0 * h * c3;
        let second = b0 + 4.0 * h * (c3 + h * c4);
        let low = b0.min(first).min(second).min(b1);
        let high = b0.max(first).max(second).max(b1);
        (low, high)
    }

    /// Tangents at both ends, pointing along the edge; not normalised.
    pub fn tangents(&self) -> [Vec2; 2] {
        self.slopes.map(tangent)
    }

    /// Sine of the turn where the next edge goes on; positive upward.
    pub fn turn_to(&self, next: &Self) -> f64 {
        let (a, b) = (self.tangents()[1], next.tangents()[0]);
        (a.x * b.y - a.y * b.x) / (a.norm() * b.norm())
    }

    /// Whether the ground goes on smoothly from this edge to the next.
    pub fn joins_smoothly(&self, next: &Self) -> bool {
        self.turn_to(next).abs() < SMOOTH
    }

    /// Whether the ground bends upward at once where this edge ends: a concave corner.
    pub fn opens_upward(&self, next: &Self) -> bool {
        self.turn_to(next) >= SMOOTH
    }

    /// Derivative of half the squared distance from `centre` along the edge at `from`: negative where the edge comes nearer.
    pub fn recedes_at_from(&self, centre: Vec2) -> f64 {
        recedes(self.from - centre, self.slopes[0])
    }

    /// The same at `to`.
    pub fn recedes_at_to(&self, centre: Vec2) -> f64 {
        recedes(self.to - centre, self.slopes[1])
    }

    /// x (m) where Newton's method, from `from`, looks for the nearest place. Not for risers.
    pub fn guess_at_from(&self, centre: Vec2) -> f64 {
        newton(self.from, centre, self.slopes[0], self.bends[0])
    }

    /// The same from `to`.
    pub fn guess_at_to(&self, centre: Vec2) -> f64 {
        newton(self.to, centre, self.slopes[1], self.bends[1])
    }

    /// The point between the ends whose normal goes through `centre`; at `from` the edge comes nearer, at `to` no longer.
    ///
    /// Newton's method on `(x - cx) + (f - cy) f' = 0`, kept inside a bracket that bisection shrinks where Newton leaves it.
    pub fn foot(&self, centre: Vec2) -> Contact {
        let arm = self.from - centre;
        if self.is_riser() {
            let point = Vec2::new(self.from.x, centre.y);
            let away = Vec2::new(-arm.x, 0.0);
            return Contact::on_edge(point, tangent(self.slopes[0]), away);
        }
        let at_from = self.recedes_at_from(centre);
        if self.is_line() {
            let slope = self.slopes[0];
            let s = -at_from / (1.0 + slope * slope);
            let foot = Vec2::new(s, s * slope);
            return Contact::on_edge(self.from + foot, Vec2::new(1.0, slope), -(arm + foot));
        }
        let (mut low, mut high) = (0.0, self.to.x - self.from.x);
        // The secant's root is within some 10 um already.
        let mut s = high * (at_from / (at_from - self.recedes_at_to(centre)));
        let [mut y, mut slope, mut bend] = self.rise(s);
        // Convergence is quadratic: two steps are the rule, 60 bisections the bound.
        for _ in 0..60 {
            let residual = (arm.x + s) + (arm.y + y) * slope;
            if residual > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let mut next = s - residual / (1.0 + slope * slope + (arm.y + y) * bend);
            // The bracket is closed: where the residual is zero already, Newton stays.
            if !(next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            let moved = next - s;
            s = next;
            // Over a last step this short Taylor's series errs by f''' 1e-17/2 m: no need to evaluate once more.
            if moved.abs() < LAST_STEP {
                y += moved * (slope + 0.5 * moved * bend);
                slope += moved * bend;
                break;
            }
            [y, slope, bend] = self.rise(s);
        }
        let foot = Vec2::new(s, y);
        Contact::on_edge(self.from + foot, Vec2::new(1.0, slope), -(arm + foot))
    }
}

fn tangent(slope: f64) -> Vec2 {
    if slope.is_finite() {
        Vec2::new(1.0, slope)
    } else {
        Vec2::new(0.0, slope.signum())
    }
}

fn recedes(arm: Vec2, slope: f64) -> f64 {
    if slope.is_finite() {
        arm.x + arm.y * slope
    } else {
        arm.y * slope.signum()
    }
}

fn newton(at: Vec2, centre: Vec2, slope: f64, bend: f64) -> f64 {
    let arm = at - centre;
    at.x - (arm.x + arm.y * slope) / (1.0 + slope * slope + arm.y * bend)
}

//! One edge of the ground, between two neighbouring knots; contacts with it, and jumps between two.

use crate::Vec2;

/// Chebyshev's method stops after a step shorter than this, m: the next step would be of the order
/// of its cube, below 1e-10 m on the tightest curves.
const LAST_STEP: f64 = 2.0e-5;
/// Sine of the angle between two tangents below which a joint is smooth, -: an allowance for
/// rounding.
const SMOOTH: f64 = 1e-9;

/// An x (m), and height (m), slope (-) and second derivative (1/m) of a curve there.
pub(crate) type Knot = (f64, [f64; 3]);

/// Appends an edge to a chain; where it meets the last one at a corner, a new run starts.
pub(crate) fn append(chain: &mut Vec<Edge>, mut edge: Edge) {
    if let Some(last) = chain.last() {
        let is_smooth = last.turn_to(&edge).abs() < SMOOTH;
        edge.run = last.run + u32::from(!is_smooth);
    }
    chain.push(edge);
}

/// An edge, directed forward with the ground on its right: a vertical riser, or the polynomial of
/// fifth degree that has the height, slope and second derivative of the curve f at both ends
/// (Hermite interpolation). Over a length h in x its height differs from f by at most
/// `max|f^(6)| h^6/46080`.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub from: Vec2,
    pub to: Vec2,
    /// Slopes at both ends, -; infinite on a riser.
    slopes: [f64; 2],
    /// Second derivatives at both ends, 1/m.
    pub second_derivatives: [f64; 2],
    /// Coefficients of (x - from.x)^3 to ^5.
    higher: [f64; 3],
    /// Whether it is straight; risers are.
    pub straight: bool,
    /// Number of corners behind this edge. Edges with the same number are joined smoothly.
    pub run: u32,
}

impl Edge {
    /// A straight edge; a riser if both ends have the same x.
    pub fn line(from: Vec2, to: Vec2) -> Self {
        let slope = (to.y - from.y) / (to.x - from.x);
        Self {
            from,
            to,
            slopes: [slope; 2],
            second_derivatives: [0.0; 2],
            higher: [0.0; 3],
            straight: true,
            run: 0,
        }
    }

    /// A curved edge between two knots.
    pub fn curve((from, [y0, m0, b0]): Knot, (to, [y1, m1, b1]): Knot) -> Self {
        let h = to - from;
        // Difference at `to` between the curve and the parabola that fits it at `from`, in height,
        // slope and second derivative.
        let y = y1 - y0 - h * (m0 + 0.5 * h * b0);
        let m = h * (m1 - m0 - h * b0);
        let b = 0.5 * h * h * (b1 - b0);
        Self {
            from: Vec2::new(from, y0),
            to: Vec2::new(to, y1),
            slopes: [m0, m1],
            second_derivatives: [b0, b1],
            higher: [
                (10.0 * y - 4.0 * m + b) / h.powi(3),
                (-15.0 * y + 7.0 * m - 2.0 * b) / h.powi(4),
                (6.0 * y - 3.0 * m + b) / h.powi(5),
            ],
            straight: false,
            run: 0,
        }
    }

    /// Whether it is vertical.
    pub fn is_riser(&self) -> bool {
        self.slopes[0].is_infinite()
    }

    /// Coefficients of Taylor's series of the height above `from` (m) at the distance `s` in x from
    /// `from` (m): height, slope, half the second derivative, a sixth of the third. By Horner's
    /// method, repeated.
    #[inline]
    fn series(&self, s: f64) -> [f64; 4] {
        let [c3, c4, c5] = self.higher;
        let (c2, last) = (0.5 * self.second_derivatives[0], s * c5);
        let a4 = c4 + last;
        let a3 = c3 + s * a4;
        let a2 = c2 + s * a3;
        let a1 = self.slopes[0] + s * a2;
        let b4 = a4 + last;
        let b3 = a3 + s * b4;
        let b2 = a2 + s * b3;
        let d4 = b4 + last;
        let d3 = b3 + s * d4;
        [s * a1, a1 + s * b2, b2 + s * d3, d3 + s * (d4 + last)]
    }

    /// x of points of the edge between two x (m): the two ends, and on a curve points between, at
    /// most `spacing` (m) apart.
    pub fn places(&self, from: f64, to: f64, spacing: f64) -> impl Iterator<Item = f64> {
        let (start, end) = (from.max(self.from.x), to.min(self.to.x));
        let count = match self.straight {
            true => 1.0,
            false => ((end - start) / spacing).ceil().max(1.0),
        };
        let between = (1..count as u64).map(move |i| start + (end - start) * i as f64 / count);
        std::iter::once(start).chain(between).chain([end])
    }

    /// Height (m), slope (-) and second derivative (1/m) at x, on any edge but a riser.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        if x >= self.to.x {
            return [self.to.y, self.slopes[1], self.second_derivatives[1]];
        }
        let [rise, slope, half_second, _] = self.series(x - self.from.x);
        [self.from.y + rise, slope, 2.0 * half_second]
    }

    /// Height at x (m), m; on a riser that of `to`.
    pub fn height(&self, x: f64) -> f64 {
        if self.is_riser() {
            return self.to.y;
        }
        self.from.y + self.series(x - self.from.x)[0]
    }

    /// Lower and upper bound of the height, m. For a straight edge, which can be long, between two
    /// x (m) only.
    pub fn heights(&self, from_x: f64, to_x: f64) -> (f64, f64) {
        let (a, b) = if self.is_riser() || !self.straight {
            (self.from.y, self.to.y)
        } else {
            (self.height(from_x), self.height(to_x))
        };
        // A curve departs from its chord by at most max|f''| h^2/8.
        let (low, high) = self.second_derivative_bounds();
        let bulge = low.abs().max(high.abs()) * (self.to.x - self.from.x).powi(2) / 8.0;
        (a.min(b) - bulge, a.max(b) + bulge)
    }

    /// Lower and upper bound of the second derivative, 1/m: the least and greatest of its Bezier
    /// coefficients.
    pub fn second_derivative_bounds(&self) -> (f64, f64) {
        let h = self.to.x - self.from.x;
        let [c3, c4, _] = self.higher;
        let [b0, b1] = self.second_derivatives;
        let first = b0 + 2.0 * h * c3;
        let second = b0 + 4.0 * h * (c3 + h * c4);
        let low = b0.min(first).min(second).min(b1);
        (low, b0.max(first).max(second).max(b1))
    }

    /// Tangents at both ends, directed along the edge; not unit vectors.
    pub fn tangents(&self) -> [Vec2; 2] {
        self.slopes.map(tangent)
    }

    /// Sine of the angle between this edge's last tangent and the first one of the next edge;
    /// positive upward.
    pub fn turn_to(&self, next: &Self) -> f64 {
        let (a, b) = (self.tangents()[1], next.tangents()[0]);
        (a.x * b.y - a.y * b.x) / (a.norm() * b.norm())
    }

    /// Whether the joint with the next edge is a concave corner.
    pub fn is_concave_corner_with(&self, next: &Self) -> bool {
        self.turn_to(next) >= SMOOTH
    }

    /// Derivatives of half the squared distance from `centre` along the edge, at `from` and at
    /// `to`; negative if the distance falls. With respect to x (m), on a riser to y (m).
    #[inline]
    pub fn distance_rates(&self, centre: Vec2) -> [f64; 2] {
        let [from, to] = self.tangents();
        [from.dot(&(self.from - centre)), to.dot(&(self.to - centre))]
    }

    /// x after one Newton step towards the point nearest to `centre`, m, from the end 0, `from`, or
    /// 1, `to`. Not for risers.
    pub fn newton_x(&self, centre: Vec2, end: usize) -> f64 {
        let at = [self.from, self.to][end];
        let (arm, slope) = (at - centre, self.slopes[end]);
        let rise = 1.0 + slope * slope + arm.y * self.second_derivatives[end];
        at.x - (arm.x + arm.y * slope) / rise
    }

    /// [`Self::foot`] if it lies on the edge; `None` elsewhere, and always on a riser.
    #[inline(always)]
    pub fn foot_if_between(&self, centre: Vec2) -> Option<Contact> {
        // Those of `distance_rates`; on a riser they are infinite or no numbers.
        let (from, to) = (self.from - centre, self.to - centre);
        let rates = [
            from.x + from.y * self.slopes[0],
            to.x + to.y * self.slopes[1],
        ];
        let lies_between = rates[0] <= 0.0 && rates[1] >= 0.0 && !self.is_riser();
        lies_between.then(|| self.foot(centre, rates))
    }

    /// The point of the edge nearest to `centre`, from the derivatives of [`Self::distance_rates`].
    /// The distance must fall at `from` and rise at `to`, or be stationary there.
    ///
    /// Chebyshev's method, of third order, on `(x - cx) + (f - cy) f' = 0` inside a bracket; a step
    /// that leaves the bracket is replaced by a bisection.
    #[inline(always)]
    pub fn foot(&self, centre: Vec2, rates: [f64; 2]) -> Contact {
        let arm = self.from - centre;
        let slope = self.slopes[0];
        if self.straight {
            if self.is_riser() {
                let point = Vec2::new(self.from.x, centre.y);
                let away = Vec2::new(-arm.x, 0.0);
                return Contact::on_edge(point, tangent(slope), 0.0, away);
            }
            let s = -rates[0] / (1.0 + slope * slope);
            let foot = Vec2::new(s, s * slope);
            return Contact::on_edge(self.from + foot, Vec2::new(1.0, slope), 0.0, -(arm + foot));
        }
        let (mut low, mut high) = (0.0, self.to.x - self.from.x);
        let mut s = self.first_guess(arm, rates);
        let [mut y, mut slope, mut half_second, mut sixth_third] = self.series(s);
        // One step usually suffices. 60 bisections would exhaust the precision.
        for _ in 0..60 {
            let above = arm.y + y;
            let residual = (arm.x + s) + above * slope;
            if residual > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let per_rate = 1.0 / (1.0 + slope * slope + 2.0 * above * half_second);
            // Half the second derivative of the residual.
            let bend = 3.0 * (slope * half_second + above * sixth_third);
            let newton = residual * per_rate;
            let mut next = s - newton * (1.0 + newton * bend * per_rate);
            // The bracket includes its ends: at a zero residual the step is zero and stays inside.
            if !(next >= low && next <= high) {
                next = 0.5 * (low + high);
            }
            let moved = next - s;
            s = next;
            // Over so short a step Taylor's series is exact: no further evaluation is needed.
            if moved.abs() < LAST_STEP {
                y += moved * (slope + moved * (half_second + moved * sixth_third));
                slope += moved * (2.0 * half_second + 3.0 * moved * sixth_third);
                break;
            }
            [y, slope, half_second, sixth_third] = self.series(s);
        }
        let foot = Vec2::new(s, y);
        let (point, tangent) = (self.from + foot, Vec2::new(1.0, slope));
        Contact::on_edge(point, tangent, 2.0 * half_second, -(arm + foot))
    }

    /// A place within some micrometres of the foot on a curve, as distance in x from `from`, m: a
    /// Newton step from the root of the secant, on the parabola with the derivatives at both ends
    /// and the second derivative at `from`.
    #[inline(always)]
    fn first_guess(&self, arm: Vec2, [at_from, at_to]: [f64; 2]) -> f64 {
        let length = self.to.x - self.from.x;
        let (slope, second) = (self.slopes[0], self.second_derivatives[0]);
        // Coefficients for shares of the length.
        let linear = length * (1.0 + slope * slope + arm.y * second);
        let quadratic = at_to - at_from - linear;
        let secant = at_from / (at_from - at_to);
        let value = at_from + secant * (linear + quadratic * secant);
        let guess = secant - value / (linear + 2.0 * quadratic * secant);
        if (0.0..=1.0).contains(&guess) {
            length * guess
        } else {
            length * secant
        }
    }
}

/// Tangent of a slope, vertical for an infinite one; not a unit vector.
fn tangent(slope: f64) -> Vec2 {
    if slope.is_finite() {
        Vec2::new(1.0, slope)
    } else {
        Vec2::new(0.0, slope.signum())
    }
}

/// A point of the ground where the distance to a wheel's centre has a local minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point on the ground, m.
    pub point: Vec2,
    /// Unit tangent of the ground, pointing forward.
    pub tangent: Vec2,
    /// Signed distance of the centre from the point, along the normal, m; negative if the centre is
    /// below the ground.
    pub distance: f64,
    /// Second derivative of the ground's height there, 1/m; minus infinity at a corner.
    pub(crate) second_derivative: f64,
}

impl Contact {
    /// Contact angle gamma: slope of the tangent, rad. The tangent is `(cos gamma, sin gamma)`, the
    /// normal `(-sin gamma, cos gamma)`.
    pub fn angle(&self) -> f64 {
        self.tangent.y.atan2(self.tangent.x)
    }

    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(-self.tangent.y, self.tangent.x)
    }

    /// Rate at which the contact angle changes when the centre moves along the tangent, rad/m:
    /// `kappa/(1 - kappa d)` with the distance d and the curvature kappa of the ground, positive in
    /// a hollow; `-1/d` at a corner.
    pub fn turning(&self) -> f64 {
        if self.second_derivative == f64::NEG_INFINITY {
            return -1.0 / self.distance;
        }
        // kappa = f''/(1 + f'^2)^(3/2), and 1/(1 + f'^2) is the square of the tangent's x.
        let curvature = self.second_derivative * self.tangent.x.powi(3);
        curvature / (1.0 - curvature * self.distance)
    }

    /// The contact after a small displacement of the centre (m): tangent and distance to first
    /// order. The point stays.
    #[must_use]
    pub fn displaced(&self, by: Vec2) -> Self {
        let normal = self.normal();
        Self {
            tangent: self.tangent + normal * (self.turning() * self.tangent.dot(&by)),
            distance: self.distance + normal.dot(&by),
            ..*self
        }
    }

    /// A contact where the ground has a tangent, which need not be a unit vector, and a second
    /// derivative (1/m). `arm` goes from point to centre, m.
    #[inline]
    pub(crate) fn on_edge(point: Vec2, tangent: Vec2, second_derivative: f64, arm: Vec2) -> Self {
        let tangent = tangent / tangent.norm();
        Self {
            point,
            tangent,
            distance: tangent.x * arm.y - tangent.y * arm.x,
            second_derivative,
        }
    }

    /// A contact at a corner: the normal points from the corner to the centre.
    pub(crate) fn on_corner(point: Vec2, arm: Vec2) -> Self {
        let distance = arm.norm();
        Self {
            point,
            tangent: Vec2::new(arm.y, -arm.x) / distance,
            distance,
            second_derivative: f64::NEG_INFINITY,
        }
    }
}

/// A place of the ground that divides the motion of a wheel in two smooth parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// The place, m.
    pub point: Vec2,
    /// Unit tangent there, pointing forward. The contact of a wheel passes the place when the
    /// wheel's centre passes the normal.
    pub tangent: Vec2,
    /// Magnitude of the jump of the curvature, 1/m.
    pub curvature: f64,
}

impl Jump {
    /// At the smooth joint of two edges.
    pub(crate) fn at_joint(before: &Edge, after: &Edge) -> Self {
        let tangent = after.tangents()[0].normalize();
        let second = after.second_derivatives[0] - before.second_derivatives[1];
        Self {
            point: after.from,
            tangent,
            curvature: (second * tangent.x.powi(3)).abs(),
        }
    }
}

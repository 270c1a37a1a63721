//! The curve on which the centre of a wheel moves while the wheel touches the ground.
//!
//! At x the centre is as low as the ground permits: y(x) is the largest
//! `p.y + sqrt(r^2 - (x - p.x)^2)` over all points p of the ground within one radius r. The tangent
//! of this curve is the tangent of the contact. Where the wheel touches two places the curve has a
//! kink; at a wall higher than r it is vertical.

use robhaz_model::Vec2;
use robhaz_terrain::{Contact, Terrain};

/// Distance of samples in x over the wheel radius.
const SPACING: f64 = 0.01;
/// Largest distance of two samples along the curve over the wheel radius. Hermite's cubic is then
/// exact to 1e-10 r.
const LONGEST: f64 = 0.02;
/// Largest turn of the tangent between two samples of a smooth piece, rad.
const LARGEST_TURN: f64 = 0.03;
/// Distance in x over the wheel radius at which a kink counts as found.
const KINK: f64 = 1e-9;
/// Largest number of contact queries for one x; three usually suffice.
const MOST_QUERIES: u32 = 200;

/// Position and direction of the curve at an arc length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnCurve {
    /// The wheel's centre, m.
    pub centre: Vec2,
    /// Derivative of the centre with respect to the arc length, nearly of length 1; of a sample the
    /// unit tangent.
    pub slope: Vec2,
}

/// A smooth piece between two kinks.
#[derive(Clone, Debug, Default)]
struct Piece {
    samples: Vec<OnCurve>,
    /// Arc length at each sample, m.
    lengths: Vec<f64>,
}

/// The curve of the centres from rear to front. All wheels have the same one.
#[derive(Clone, Debug)]
pub struct CentreCurve {
    pieces: Vec<Piece>,
}

impl CentreCurve {
    /// The curve of wheels of a radius (m) between two x (m).
    pub fn new(terrain: &Terrain, radius: f64, from: f64, to: f64) -> Self {
        let mut builder = Builder {
            terrain,
            radius,
            found: Vec::new(),
            pieces: vec![Piece::default()],
        };
        let first = builder.sample(from, None);
        builder.add(first);
        let count = ((to - from) / (SPACING * radius)).ceil().max(1.0);
        let (mut last, mut k) = (first, 1.0);
        while k <= count {
            let x = from + (to - from) * k / count;
            let next = builder.sample(x, Some(last.centre.y));
            builder.join(last, next);
            (last, k) = (next, k + 1.0);
        }
        let mut pieces = builder.pieces;
        // A kink at an end leaves a piece of one sample.
        pieces.retain(|piece| piece.samples.len() > 1);
        Self { pieces }
    }

    /// Number of smooth pieces.
    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Arc lengths of the ends of a piece, m.
    pub fn ends(&self, piece: usize) -> (f64, f64) {
        let lengths = &self.pieces[piece].lengths;
        let end = |s: Option<&f64>| s.copied().unwrap_or(0.0);
        (end(lengths.first()), end(lengths.last()))
    }

    /// Piece and arc length (m) at x (m); at a vertical part its lower end.
    pub fn at_x(&self, x: f64) -> Option<(usize, f64)> {
        let ends = |piece: &Piece| piece.samples.last().map_or(x, |s| s.centre.x);
        let index = self.pieces.partition_point(|piece| ends(piece) < x);
        let piece = self.pieces.get(index)?;
        let next = piece.samples.partition_point(|s| s.centre.x < x);
        let before = next.saturating_sub(1);
        let span = piece.samples[next].centre.x - piece.samples[before].centre.x;
        let share = if span > 0.0 {
            (x - piece.samples[before].centre.x) / span
        } else {
            0.0
        };
        let (a, b) = (piece.lengths[before], piece.lengths[next]);
        Some((index, a + (b - a) * share.clamp(0.0, 1.0)))
    }

    /// The curve of a piece at an arc length (m); beyond the piece's ends its tangent.
    pub fn at(&self, piece: usize, s: f64) -> OnCurve {
        let Piece { samples, lengths } = &self.pieces[piece];
        let last = samples.len() - 1;
        for (end, beyond) in [(0, s < lengths[0]), (last, s > lengths[last])] {
            if beyond {
                let end_of = samples[end];
                return OnCurve {
                    centre: end_of.centre + end_of.slope * (s - lengths[end]),
                    ..end_of
                };
            }
        }
        let next = lengths.partition_point(|l| *l < s).clamp(1, last);
        let (a, b) = (samples[next - 1], samples[next]);
        let h = lengths[next] - lengths[next - 1];
        hermite(a, b, h, (s - lengths[next - 1]) / h)
    }
}

/// Hermite's cubic between two samples at the chord length `h` (m), at the share `u` of it.
fn hermite(a: OnCurve, b: OnCurve, h: f64, u: f64) -> OnCurve {
    let chord = b.centre - a.centre;
    let (m0, m1) = (a.slope * h, b.slope * h);
    let c2 = chord * 3.0 - m0 * 2.0 - m1;
    let c3 = m0 + m1 - chord * 2.0;
    OnCurve {
        centre: a.centre + (m0 + (c2 + c3 * u) * u) * u,
        slope: (m0 + (c2 * 2.0 + c3 * (3.0 * u)) * u) / h,
    }
}

/// Finds centres of a wheel that touches the ground, and joins them.
struct Builder<'a> {
    terrain: &'a Terrain,
    radius: f64,
    found: Vec<Contact>,
    pieces: Vec<Piece>,
}

impl Builder<'_> {
    /// The sample at x (m), searched from a height near it (m).
    ///
    /// Blocked heights of the centre reach from the ground up to y(x), and each point of the ground
    /// gives a lower bound of y(x). The search starts at such a bound and raises it to that of the
    /// nearest points until nothing is nearer than the radius: Newton's method from below.
    fn sample(&mut self, x: f64, near: Option<f64>) -> OnCurve {
        let start = self.below(x);
        let mut best = start;
        // A good guess saves queries; it must be a lower bound, which the nearest point to it
        // gives.
        if let Some(y) = near
            && let Some(nearest) = self.terrain.nearest(Vec2::new(x, y))
        {
            best = self.higher(best, x, &nearest);
        }
        for _ in 0..MOST_QUERIES {
            let mut found = std::mem::take(&mut self.found);
            self.terrain.contacts(best.centre, self.radius, &mut found);
            let before = best.centre.y;
            for contact in &found {
                best = self.higher(best, x, contact);
            }
            self.found = found;
            let rise = best.centre.y - before;
            if rise <= 1e-13 * self.radius {
                break;
            }
            if rise < 1e-2 * self.radius && best.slope.y.abs() > 0.99 {
                best = self.climb(best);
            }
        }
        best
    }

    /// A bound near y(x) by bisection. Along a wall Newton's method rises in very short steps.
    fn climb(&self, from: OnCurve) -> OnCurve {
        let x = from.centre.x;
        let blocker = |y: f64| {
            let nearest = self.terrain.nearest(Vec2::new(x, y))?;
            (nearest.distance < self.radius).then_some(nearest)
        };
        let (mut low, mut step, mut best) = (from.centre.y, self.radius, from);
        while let Some(contact) = blocker(low + step) {
            (low, step) = (low + step, 2.0 * step);
            best = self.higher(best, x, &contact);
        }
        while step > 1e-6 * self.radius {
            step *= 0.5;
            if let Some(contact) = blocker(low + step) {
                low += step;
                best = self.higher(best, x, &contact);
            }
        }
        best
    }

    /// The bound that the ground near x gives. Above a trench the nearest point can be farther than
    /// the radius in x: the centre is lowered by the free distance until it is not.
    fn below(&self, x: f64) -> OnCurve {
        let mut height = self.terrain.height(x) + self.radius;
        for _ in 0..MOST_QUERIES {
            let Some(nearest) = self.terrain.nearest(Vec2::new(x, height)) else {
                break;
            };
            if (nearest.point.x - x).abs() < self.radius {
                let lowest = OnCurve {
                    centre: Vec2::new(x, f64::NEG_INFINITY),
                    slope: Vec2::x(),
                };
                return self.higher(lowest, x, &nearest);
            }
            height -= (nearest.distance - self.radius).max(1e-3 * self.radius);
        }
        OnCurve {
            centre: Vec2::new(x, height),
            slope: Vec2::x(),
        }
    }

    /// The higher one of a bound and that of a point of the ground.
    fn higher(&self, best: OnCurve, x: f64, contact: &Contact) -> OnCurve {
        let dx = x - contact.point.x;
        let square = self.radius * self.radius - dx * dx;
        if square < 0.0 {
            return best;
        }
        let centre = Vec2::new(x, contact.point.y + square.sqrt());
        // `>=`: of equal bounds the last one has the tangent of the ground at its point, not near
        // it.
        if centre.y >= best.centre.y {
            let arm = (centre - contact.point) / self.radius;
            let slope = Vec2::new(arm.y, -arm.x);
            OnCurve { centre, slope }
        } else {
            best
        }
    }

    /// Adds all samples behind `a` up to `b`, with further ones between them where the curve is
    /// steep or turns.
    fn join(&mut self, a: OnCurve, b: OnCurve) {
        let radius = self.radius;
        let chord = b.centre - a.centre;
        let turn = a.slope.dot(&b.slope).clamp(-1.0, 1.0).acos();
        if chord.norm() <= LONGEST * radius && turn <= LARGEST_TURN {
            self.add(b);
        } else if b.centre.x - a.centre.x > KINK * radius {
            let x = 0.5 * (a.centre.x + b.centre.x);
            let middle = self.sample(x, Some(a.centre.y));
            self.join(a, middle);
            self.join(middle, b);
        } else if chord.y.abs() > 1e3 * KINK * radius {
            self.wall(a, b);
        } else {
            self.pieces.push(Piece::default());
            self.add(b);
        }
    }

    /// A vertical part of the curve. It turns into the curve behind or before it smoothly where
    /// that is vertical, too.
    fn wall(&mut self, a: OnCurve, b: OnCurve) {
        let up = Vec2::new(0.0, (b.centre.y - a.centre.y).signum());
        let is_smooth = |s: &OnCurve| s.slope.dot(&up) > LARGEST_TURN.cos();
        let on_wall = |s: &OnCurve| OnCurve { slope: up, ..*s };
        if !is_smooth(&a) {
            self.pieces.push(Piece::default());
            self.add(on_wall(&a));
        }
        self.add(on_wall(&b));
        if !is_smooth(&b) {
            self.pieces.push(Piece::default());
            self.add(b);
        }
    }

    fn add(&mut self, sample: OnCurve) {
        let length = self.pieces.iter().rev().find_map(|p| p.lengths.last());
        let length = length.copied().unwrap_or(0.0);
        if let Some(piece) = self.pieces.last_mut() {
            let before = piece.samples.last();
            let step = before.map_or(0.0, |s| (sample.centre - s.centre).norm());
            // Two samples at one place would be an interval without length.
            if before.is_none() || step > 0.0 {
                piece.samples.push(sample);
                piece.lengths.push(length + step);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_terrain::{Profile, Stairs};

    fn kerb(rise: f64) -> Terrain {
        Terrain::new(Profile::Stairs(Stairs {
            start: 0.7,
            rise,
            run: 1.0,
            count: 1,
        }))
    }

    /// Closed form: before a kerb of 50 mm the curve is level, then an arc around the edge. The
    /// kink is where the wheel touches both, sqrt(r^2 - (r - h)^2) before the edge.
    #[test]
    fn a_kerb_makes_a_kink_and_an_arc() {
        let curve = CentreCurve::new(&kerb(0.05), 0.1, 0.0, 1.5);
        assert_eq!(curve.pieces(), 2);
        let kink = 0.7 - (0.01_f64 - 0.0025).sqrt();
        let (_, end) = curve.ends(0);
        assert!((curve.at(0, end).centre - Vec2::new(kink, 0.1)).norm() < 1e-9);
        let edge = Vec2::new(0.7, 0.05);
        for k in 1..20 {
            let x = kink + f64::from(k) / 20.0 * (0.7 - kink);
            let (piece, s) = curve.at_x(x).expect("on the curve");
            let at = curve.at(piece, s);
            let arm = at.centre - edge;
            // Hermite's cubic over an arc of 0.02 rad.
            assert!((arm.norm() - 0.1).abs() < 1e-10, "{x}: {}", arm.norm());
            let angle = at.slope.dot(&arm) / arm.norm();
            assert!(angle.abs() < 1e-6, "{x}: {angle}");
        }
    }

    /// The search for the curve starts on the tread, however high the stairs are: then its cost
    /// does not depend on the ground below.
    #[test]
    fn the_search_starts_at_the_ground() {
        let terrain = Terrain::new(Profile::Stairs(Stairs {
            start: 0.7,
            rise: 0.08,
            run: 0.3,
            count: 100,
        }));
        let ground = Builder {
            terrain: &terrain,
            radius: 0.1,
            found: Vec::new(),
            pieces: Vec::new(),
        };
        for step in 1..100 {
            let (middle, tread) = (0.55 + 0.3 * f64::from(step), 0.08 * f64::from(step));
            assert!((terrain.height(middle) - tread).abs() < 1e-12);
            let lowest = ground.below(middle).centre.y;
            assert!((lowest - (tread + 0.1)).abs() < 1e-12, "{step}: {lowest}");
        }
    }

    /// Closed form: at a kerb higher than the radius the curve is vertical up to the height of the
    /// edge.
    #[test]
    fn a_high_kerb_makes_a_wall() {
        let curve = CentreCurve::new(&kerb(0.15), 0.1, 0.0, 1.5);
        assert_eq!(curve.pieces(), 2);
        let (start, _) = curve.ends(1);
        let on_wall = curve.at(1, start + 0.03);
        assert!((on_wall.centre - Vec2::new(0.6, 0.13)).norm() < 1e-8);
        assert!((on_wall.slope - Vec2::y()).norm() < 1e-8);
    }
}

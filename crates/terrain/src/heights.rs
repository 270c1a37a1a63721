//! Ground through given points.

use crate::Vec2;
use crate::profile::{Piece, ProfileError, SPACING, Shape};

/// Edges of a spline are no shorter than this, m, unless its points are: below it no wheel can touch an edge twice.
const SHORTEST: f64 = 1e-3;
/// A point this near to the straight line between its neighbours is no corner, m: 0.02 mN of normal force.
const STRAIGHT: f64 = 1e-10;

/// How the ground goes from point to point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The natural cubic spline: height, slope and curvature are continuous, the curvature is 0 at both ends.
    Spline,
    /// Straight, with a corner at every point.
    Corners,
}

impl Interpolation {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Spline, Self::Corners];
}

/// Ground through points. Its height counts from the first point, so that it joins the level ground there.
///
/// Where a spline starts or ends with a slope, that makes a corner with the level ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    points: Vec<Vec2>,
    interpolation: Interpolation,
    /// Second derivative at each point, 1/m; 0 with corners.
    bends: Vec<f64>,
}

impl Heights {
    /// Ground through points (m), whose x must increase.
    pub fn new(points: Vec<Vec2>, interpolation: Interpolation) -> Self {
        let bends = match interpolation {
            Interpolation::Spline => natural_bends(&points),
            Interpolation::Corners => vec![0.0; points.len()],
        };
        Self {
            points,
            interpolation,
            bends,
        }
    }

    /// The points as they were given, m.
    pub fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// How the ground goes from point to point.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }
}

impl Shape for Heights {
    fn check(&self) -> Result<(), ProfileError> {
        if self.points.len() < 2 {
            return Err(ProfileError::FewPoints {
                found: self.points.len(),
            });
        }
        if let Some(point) = self.points.iter().position(|p| !(p.x + p.y).is_finite()) {
            return Err(ProfileError::Point { point });
        }
        match self.points.windows(2).position(|p| p[1].x <= p[0].x) {
            Some(i) => Err(ProfileError::Order {
                point: i + 1,
                found: self.points[i + 1].x,
                before: self.points[i].x,
            }),
            None => Ok(()),
        }
    }

    /// Level outside of the points.
    fn eval(&self, x: f64) -> [f64; 3] {
        let Some((first, last)) = self.points.first().zip(self.points.last()) else {
            return [0.0; 3];
        };
        if self.points.len() < 2 || x < first.x {
            return [0.0; 3];
        }
        if x > last.x {
            return [last.y - first.y, 0.0, 0.0];
        }
        // At a point the piece before it counts, at the first one the piece after it.
        let to = self.points.partition_point(|p| p.x < x);
        let to = to.clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[to - 1], self.points[to]);
        let (bend_a, bend_b) = (self.bends[to - 1], self.bends[to]);
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
        let Some(first) = self.points.first() else {
            return (Vec2::zeros(), Vec::new());
        };
        let pieces = match self.interpolation {
            // One cubic to a piece, and enough edges for its bend.
            Interpolation::Spline => {
                let gaps = self.points.windows(2);
                let piece = |gap: &[Vec2]| {
                    let share = (gap[1].x - gap[0].x) / 4.0;
                    Piece::Curve(gap[1].x, share.clamp(SHORTEST, SPACING))
                };
                gaps.map(piece).collect()
            }
            Interpolation::Corners => {
                let corner = |p: &Vec2| Piece::Line(Vec2::new(p.x, p.y - first.y));
                corners(&self.points).map(corner).collect()
            }
        };
        (Vec2::new(first.x, 0.0), pieces)
    }
}

/// The points behind the first without those that lie on the straight line between their neighbours: however finely a straight
/// stretch is measured, to a wheel it is one edge.
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
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(heights: &[f64]) -> Vec<Vec2> {
        let mut x = -0.3;
        let mut next = |y: &f64| {
            // Gaps of several lengths.
            x += 0.05 + 0.1 * (*y * 37.0).rem_euclid(1.0);
            Vec2::new(x, *y)
        };
        heights.iter().map(&mut next).collect()
    }

    /// Worked out by hand: from 0 to 1 the spline is (3 x - x^3)/2, then its mirror image.
    #[test]
    fn three_points_by_hand() {
        let given = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)].map(|(x, y)| Vec2::new(x, y));
        let ground = Heights::new(given.to_vec(), Interpolation::Spline);
        for (x, expected) in [
            (0.0, [0.0, 1.5, 0.0]),
            (0.5, [0.6875, 1.125, -1.5]),
            (1.0, [1.0, 0.0, -3.0]),
            (1.5, [0.6875, -1.125, -1.5]),
        ] {
            for (found, expected) in ground.eval(x).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "at {x}: {found}");
            }
        }
    }

    proptest! {
        /// Property: a spline goes through its points, and slope and curvature have no jump there.
        #[test]
        fn splines_are_smooth(y in proptest::collection::vec(-0.1..0.1_f64, 2..12)) {
            let given = points(&y);
            let ground = Heights::new(given.clone(), Interpolation::Spline);
            prop_assert!(ground.check().is_ok());
            for (i, p) in given.iter().enumerate() {
                prop_assert!((ground.eval(p.x)[0] - (p.y - y[0])).abs() < 1e-12);
                if i > 0 && i + 1 < given.len() {
                    let (before, after) = (ground.eval(p.x - 1e-9), ground.eval(p.x + 1e-9));
                    prop_assert!((before[1] - after[1]).abs() < 1e-5);
                    prop_assert!((before[2] - after[2]).abs() < 1e-3);
                }
            }
            let (first, last) = (given[0].x, given[given.len() - 1].x);
            prop_assert!(ground.eval(first)[2].abs() < 1e-12 && ground.eval(last)[2].abs() < 1e-12);
        }
    }

    #[test]
    fn corners_are_straight_between_the_points() {
        let given = vec![
            Vec2::new(1.0, 5.0),
            Vec2::new(2.0, 5.1),
            Vec2::new(4.0, 4.9),
        ];
        let ground = Heights::new(given, Interpolation::Corners);
        for (x, y) in [
            (0.0, 0.0),
            (1.5, 0.05),
            (3.0, 0.0),
            (4.0, -0.1),
            (9.0, -0.1),
        ] {
            assert!((ground.eval(x)[0] - y).abs() < 1e-12, "at {x}");
        }
    }

    /// Points in between on the straight lines are no corners, 1e-9 m beside them they are.
    #[test]
    fn points_on_a_straight_line_are_no_corners() {
        let line = |x: f64| {
            Vec2::new(
                x,
                if x < 2.0 {
                    100.0 + 0.1 * x
                } else {
                    100.6 - 0.2 * x
                },
            )
        };
        let mut points: Vec<Vec2> = (0..=4000).map(|i| line(1e-3 * f64::from(i))).collect();
        let count = |points: &[Vec2]| {
            let ground = Heights::new(points.to_vec(), Interpolation::Corners);
            ground.pieces().1.len()
        };
        assert_eq!(count(&points), 2);
        assert_eq!(count(&points[..2]), 1);
        points[700].y += 1e-9;
        assert_eq!(count(&points), 5);
    }

    #[test]
    fn points_out_of_order_are_refused() {
        let check = |x: [f64; 3]| {
            let given = x.map(|x| Vec2::new(x, 0.0)).to_vec();
            Heights::new(given, Interpolation::Spline).check()
        };
        assert_eq!(check([0.0, 1.0, 2.0]), Ok(()));
        let found = check([0.0, 1.0, 1.0]).map_err(|e| e.to_string());
        let expected = "point 2: x is 1 m; it must be above that of the point before, 1 m";
        assert_eq!(found, Err(expected.to_owned()));
        assert!(check([0.0, f64::NAN, 1.0]).is_err());
        let one = Heights::new(vec![Vec2::zeros()], Interpolation::Corners);
        assert_eq!(one.check(), Err(ProfileError::FewPoints { found: 1 }));
    }
}

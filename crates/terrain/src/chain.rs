//! Converts a profile into a chain of edges, and rounds blunt concave corners.
//!
//! At a concave corner a wheel has two contacts. The second one appears where the wheel's centre
//! passes the normal of the second side. There it is `r (1 - cos a)` less deep than the first, for
//! a wheel of radius r and a corner that turns by a. For a sharp corner that is more than any
//! penetration, and the second force grows from zero. For a blunt corner it is less: the second
//! force would appear at nearly its full size, and its spring would gain that energy. A parabola
//! tangent to both sides leaves one contact, which moves from one side to the other.

use crate::edge::{Edge, Knot, append};
use crate::profile::Part;
use crate::shape::Piece;
use crate::{Profile, Vec2};

/// Length of the level edge on either side of a profile, m: much more than a robot travels.
pub(crate) const REACH: f64 = 1.0e5;

/// The edges of a profile from rear to front; the first and the last are level ground. Blunt
/// concave corners are rounded for wheels of a radius (m).
pub(crate) fn chain(profile: &Profile, wheel_radius: f64) -> Vec<Edge> {
    let mut alone = None;
    let parts = match profile {
        Profile::Course(course) => &course.parts,
        one => std::slice::from_ref(alone.insert(Part::new(one.clone(), 0.0))),
    };
    let first = parts.first();
    let start = first.map_or(Vec2::zeros(), |p| p.profile.pieces().0);
    let mut chain = Chain {
        at: start - Vec2::new(REACH, 0.0),
        edges: Vec::new(),
    };
    chain.line(start);
    for part in parts {
        chain.append(part);
    }
    chain.line(chain.at + Vec2::new(REACH, 0.0));
    round(chain.edges, wheel_radius)
}

/// Edges under construction, from rear to front.
struct Chain {
    /// End of the last edge, m.
    at: Vec2,
    edges: Vec<Edge>,
}

impl Chain {
    fn push(&mut self, edge: Edge) {
        self.at = edge.to;
        append(&mut self.edges, edge);
    }

    /// Appends a straight edge to a point (m), unless it would have no length.
    fn line(&mut self, to: Vec2) {
        if to != self.at {
            self.push(Edge::line(self.at, to));
        }
    }

    /// Appends a part's curve up to `to_x` (m), in edges of equal length in x, at most `spacing`
    /// (m).
    fn curve(&mut self, part: &Part, to_x: f64, spacing: f64) {
        let from_x = self.at.x;
        if to_x <= from_x {
            return;
        }
        let count = ((to_x - from_x) / spacing).ceil().max(1.0);
        let knot = |i: f64| {
            let x = from_x + (to_x - from_x) * i / count;
            (x, part.eval(x))
        };
        let mut from = knot(0.0);
        for i in 1..=count as u64 {
            let to = knot(i as f64);
            self.push(Edge::curve(from, to));
            from = to;
        }
    }

    /// Appends level ground up to a part, and the part.
    fn append(&mut self, part: &Part) {
        let base = Vec2::new(0.0, part.base);
        let (start, pieces) = part.profile.pieces();
        if start.x > self.at.x {
            self.line(start + base);
        }
        for piece in pieces {
            match piece {
                Piece::Line(to) => self.line(to + base),
                Piece::Curve(to_x, spacing) => self.curve(part, to_x, spacing),
            }
        }
    }
}

/// Angle below which a concave corner is blunt, rad (9 deg): `r (1 - cos a)` is then 1.2 mm for r =
/// 0.1 m, a penetration of five times the mean wheel load.
const BLUNT: f64 = 0.157;
/// Radius of curvature of the rounding over the wheel's radius: above 1, so that there is one
/// contact, and otherwise small. For r = 0.1 m the ground changes by 0.4 mm at most, over 20 mm.
const RADIUS: f64 = 1.25;

/// Replaces each blunt concave corner of a chain by a parabola tangent to both sides, for wheels of
/// a radius (m). A chain without such corners stays as it is.
fn round(edges: Vec<Edge>, wheel_radius: f64) -> Vec<Edge> {
    let mut rounded = Vec::new();
    // Index of the edge at the end of the last parabola, and x there, m.
    let (mut first, mut from) = (0, f64::NEG_INFINITY);
    for [start, end] in cuts(&edges, RADIUS * wheel_radius) {
        let before = edges.partition_point(|edge| edge.to.x <= start);
        let after = edges.partition_point(|edge| edge.to.x < end);
        for edge in &edges[first..=before] {
            part(&mut rounded, edge, from, start);
        }
        let ends = [knot(&edges[before], start), knot(&edges[after], end)];
        append(&mut rounded, parabola(ends));
        (first, from) = (after, end);
    }
    for edge in &edges[first..] {
        part(&mut rounded, edge, from, f64::INFINITY);
    }
    rounded
}

/// The intervals of x (m) that parabolas replace, from rear to front. Neighbours do not overlap:
/// each takes at most half the way to the next corner.
fn cuts(edges: &[Edge], radius: f64) -> Vec<[f64; 2]> {
    let corners: Vec<usize> = (1..edges.len())
        .filter(|&i| edges[i].run != edges[i - 1].run)
        .collect();
    let place = |k: usize| corners.get(k).map(|&i| edges[i].from.x);
    let mut cuts = Vec::new();
    for (k, &i) in corners.iter().enumerate() {
        let (before, after) = (&edges[i - 1], &edges[i]);
        let turn = before.turn_to(after);
        if before.is_riser()
            || after.is_riser()
            || !before.is_concave_corner_with(after)
            || turn > BLUNT.sin()
        {
            continue;
        }
        let x = after.from.x;
        let [slope, next_slope] = [before.eval(x)[1], after.eval(x)[1]];
        let mean = 0.5 * (slope + next_slope);
        let wanted = 0.5 * radius * (next_slope - slope) * (1.0 + mean * mean).powf(1.5);
        let behind = k.checked_sub(1).and_then(place).map(|other| x - other);
        let ahead = place(k + 1).map(|other| other - x);
        let half = [behind, ahead]
            .into_iter()
            .flatten()
            .fold(wanted, |half, room| half.min(0.5 * room));
        cuts.push([x - half, x + half]);
    }
    cuts
}

fn knot(edge: &Edge, x: f64) -> Knot {
    (x, edge.eval(x))
}

/// Appends the part of an edge between two x (m); outside of the edge they stand for its ends.
fn part(rounded: &mut Vec<Edge>, edge: &Edge, from: f64, to: f64) {
    if from <= edge.from.x && to >= edge.to.x {
        return append(rounded, edge.clone());
    }
    let [start, end] = [from.max(edge.from.x), to.min(edge.to.x)].map(|x| knot(edge, x));
    if start.0 < end.0 {
        let [from, to] = [start, end].map(|(x, at)| Vec2::new(x, at[0]));
        let left = match edge.straight {
            true => Edge::line(from, to),
            false => Edge::curve(start, end),
        };
        append(rounded, left);
    }
}

/// The parabola between two knots: its second derivative is constant.
fn parabola([(from, [y0, m0, _]), (to, [y1, m1, _])]: [Knot; 2]) -> Edge {
    let second = (m1 - m0) / (to - from);
    Edge::curve((from, [y0, m0, second]), (to, [y1, m1, second]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Heights, Interpolation, Profile, Ramp, Terrain};

    fn ramp_for(degrees: f64, wheel_radius: f64) -> Terrain {
        let ramp = Ramp {
            angle: f64::to_radians(degrees),
            start: 0.7,
            length: 0.8,
        };
        Terrain::for_wheels(&Profile::Ramp(ramp), wheel_radius)
    }

    fn ramp(degrees: f64) -> Terrain {
        ramp_for(degrees, 0.1)
    }

    /// Closed form: a parabola tangent to both sides lies `half * turn / 4` above the corner,
    /// `half` its half length.
    #[test]
    fn the_parabola_touches_both_sides() {
        for degrees in [0.5, 4.0, 8.9] {
            let terrain = ramp(degrees);
            let slope = f64::tan(degrees.to_radians());
            let half = 0.5 * 0.125 * slope * (1.0 + 0.25 * slope * slope).powf(1.5);
            let parabola = terrain
                .edges()
                .iter()
                .find(|e| !e.straight)
                .expect("a parabola");
            assert!((parabola.from.x - (0.7 - half)).abs() < 1e-12);
            assert!((parabola.to.x - (0.7 + half)).abs() < 1e-12);
            assert!(parabola.from.y.abs() < 1e-12);
            assert!((parabola.to.y - half * slope).abs() < 1e-12);
            assert!((parabola.height(0.7) - 0.25 * half * slope).abs() < 1e-12);
            // The convex corner at the top stays.
            assert!(terrain.has_corners() == (degrees > 0.6));
        }
    }

    /// Property: over a blunt corner a wheel has one contact, and its depth is continuous.
    #[test]
    fn a_wheel_passes_a_blunt_corner_with_one_contact() {
        for (degrees, radius) in [0.8, 3.0, 6.0, 8.9]
            .into_iter()
            .flat_map(|degrees| [0.05, 0.1, 0.2].map(|radius| (degrees, radius)))
        {
            let terrain = ramp_for(degrees, radius);
            let slope = f64::tan(degrees.to_radians());
            let (mut last, mut found) = (f64::NAN, Vec::new());
            for k in 0..2000 {
                let x = 0.65 + 5e-5 * f64::from(k);
                let y = 0.99 * radius + slope * (x - 0.7).max(0.0);
                terrain.contacts(Vec2::new(x, y), radius, &mut found);
                assert_eq!(found.len(), 1, "{degrees} deg, {radius} m at {x}");
                let depth = radius - found[0].distance;
                // 50 um of way change the depth by at most 50 um times the sine of the corner.
                assert!(last.is_nan() || (depth - last).abs() < 5e-5 * 0.16);
                last = depth;
            }
        }
    }

    /// Corners that are sharp or convex stay, and the chain with them.
    #[test]
    fn other_corners_stay() {
        for profile in [
            Profile::Ramp(Default::default()),
            Profile::Stairs(crate::Stairs::step()),
            Profile::Stairs(Default::default()),
            Profile::Ditch(crate::Ditch::default()),
            Profile::smooth(),
        ] {
            let terrain = Terrain::new(profile);
            let rounded = round(terrain.edges().to_vec(), 0.1);
            assert_eq!(rounded.len(), terrain.edges().len());
        }
        // 9.5 deg is sharp.
        assert!(ramp(9.5).edges().iter().all(|e| e.straight));
    }

    /// Equivalence: points on the straight sides do not change the rounding. Corners closer than
    /// the rounding share the room between them.
    #[test]
    fn rounding_depends_on_corners_not_on_points() {
        let track = |points: &[(f64, f64)]| {
            let points = points.iter().map(|(x, y)| Vec2::new(*x, *y)).collect();
            Terrain::new(Profile::Heights(Heights::new(
                points,
                Interpolation::Corners,
            )))
        };
        let few = track(&[(0.5, 0.0), (1.0, 0.0), (1.4, 0.04), (1.8, 0.12)]);
        let many = track(&[
            (0.5, 0.0),
            (0.996, 0.0),
            (1.0, 0.0),
            (1.004, 0.0004),
            (1.4, 0.04),
            (1.41, 0.042),
            (1.8, 0.12),
        ]);
        for k in 0..1300 {
            let x = 0.5 + 1e-3 * f64::from(k);
            let height = |terrain: &Terrain| {
                let mut edges = terrain.edges().iter();
                edges.find(|e| x < e.to.x).map(|e| e.height(x))
            };
            let [a, b] = [&few, &many].map(|t| height(t).expect("ground"));
            assert!((a - b).abs() < 1e-12, "{x}: {a} {b}");
        }
        let close = track(&[(0.5, 0.0), (1.0, 0.0), (1.002, 0.0002), (1.4, 0.08)]);
        let mut edges = close.edges().iter().filter(|e| !e.straight);
        let [first, second] = [edges.next(), edges.next()].map(|e| e.expect("a parabola"));
        assert!((first.to.x - 1.001).abs() < 1e-12 && (second.from.x - 1.001).abs() < 1e-12);
    }
}

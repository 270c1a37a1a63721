//! Converts a profile into a chain of edges.

use crate::blunt;
use crate::edge::{Edge, append};
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
    blunt::round(chain.edges, wheel_radius)
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

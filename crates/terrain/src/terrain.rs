//! A profile made ready for contact: nearest points of a wheel on a chain of edges.

use crate::course::Part;
use crate::profile::Piece;
use crate::{Profile, Vec2};
use parry2d::bounding_volume::{Aabb, BoundingVolume};
use parry2d::math::Vector;
use parry2d::partitioning::{Bvh, BvhBuildStrategy};

/// Level ground goes on this far to both sides, m; the start is within 1 km of any profile.
const REACH: f64 = 1.0e5;
/// Edges under one leaf of the index: near a wheel there are some twenty, and a leaf costs more to visit than an edge.
const BLOCK: usize = 16;
/// Two nearest points of one curve whose normals differ by less than this are one, rad (8 deg): where a bend tighter than
/// the wheel splits its nearest point in two, to count both at once would double the ground's stiffness. Both sides of a
/// corner always count.
const SAME_NORMAL: f64 = 0.14;
/// Two nearest points closer than this are one, m: where edges meet smoothly rounding can put one on each side.
const SAME_POINT: f64 = 1.0e-6;

/// A place where the ground is nearest to a wheel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point on the ground, m.
    pub point: Vec2,
    /// Contact angle gamma: slope of the tangent, rad. Tangent `(cos g, sin g)`, normal `(-sin g, cos g)`.
    pub angle: f64,
    /// Distance of the centre from the point, along the normal, m; negative below the ground.
    pub distance: f64,
}

impl Contact {
    /// Unit tangent, pointing forward.
    pub fn tangent(&self) -> Vec2 {
        Vec2::new(self.angle.cos(), self.angle.sin())
    }

    /// Unit normal, pointing out of the ground.
    pub fn normal(&self) -> Vec2 {
        Vec2::new(-self.angle.sin(), self.angle.cos())
    }
}

/// A Newton step shorter than this is the last, m: the next would be of the order of its square.
const LAST_STEP: f64 = 3.0e-7;

/// One piece of the ground between two neighbouring knots, walked in the direction of travel (ground on the right).
#[derive(Clone, Debug)]
struct Edge {
    from: Vec2,
    to: Vec2,
    /// Tangents at both ends, not normalised.
    from_tangent: Vec2,
    to_tangent: Vec2,
    /// The part of the ground whose curve it follows; `None` for a straight edge.
    curve: Option<usize>,
}

impl Edge {
    fn line(from: Vec2, to: Vec2) -> Self {
        Self {
            from,
            to,
            from_tangent: to - from,
            to_tangent: to - from,
            curve: None,
        }
    }
}

/// A curve cut into edges.
fn curve(
    part: &Part,
    index: usize,
    from_x: f64,
    to_x: f64,
    spacing: f64,
) -> impl Iterator<Item = Edge> {
    let count = ((to_x - from_x) / spacing).ceil().max(1.0);
    let knot = move |i: f64| {
        let x = from_x + (to_x - from_x) * i / count;
        let [y, slope, _] = part.eval(x);
        (Vec2::new(x, y), Vec2::new(1.0, slope))
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of knots"
    )]
    (0..count as u32).map(move |i| {
        let (from, from_tangent) = knot(f64::from(i));
        let (to, to_tangent) = knot(f64::from(i) + 1.0);
        Edge {
            from,
            to,
            from_tangent,
            to_tangent,
            curve: Some(index),
        }
    })
}

/// How far a curve can leave its chord, m: max|f''| h^2/8; twice the greatest of three samples bounds it here.
fn bulge(part: &Part, edge: &Edge) -> f64 {
    let bend = [edge.from.x, 0.5 * (edge.from.x + edge.to.x), edge.to.x]
        .map(|x| part.eval(x)[2].abs())
        .into_iter()
        .fold(0.0, f64::max);
    2.0 * bend * (edge.to.x - edge.from.x).powi(2) / 8.0
}

/// Edges as they are laid one after the other, each with its box.
struct Chain {
    at: Vec2,
    edges: Vec<Edge>,
    boxes: Vec<Aabb>,
}

impl Chain {
    /// The level ground before the first part.
    fn from(first: Option<&Part>) -> Self {
        let start = first.map_or(Vec2::zeros(), |p| p.profile.pieces().0);
        let mut chain = Self {
            at: start - Vec2::new(REACH, 0.0),
            edges: Vec::new(),
            boxes: Vec::new(),
        };
        chain.line(start);
        chain
    }

    fn line(&mut self, to: Vec2) {
        let edge = Edge::line(self.at, to);
        self.boxes.push(aabb(&edge, 0.0));
        self.edges.push(edge);
        self.at = to;
    }

    /// Level ground up to a part, and the part.
    fn lay(&mut self, part: &Part, index: usize) {
        let lift = Vec2::new(0.0, part.lift);
        let (start, pieces) = part.profile.pieces();
        if start.x > self.at.x {
            self.line(start + lift);
        }
        for piece in pieces {
            match piece {
                Piece::Line(to) => self.line(to + lift),
                Piece::Curve(to_x, spacing) => {
                    for edge in curve(part, index, self.at.x, to_x, spacing) {
                        self.boxes.push(aabb(&edge, bulge(part, &edge)));
                        self.at = edge.to;
                        self.edges.push(edge);
                    }
                }
            }
        }
    }
}

/// The ground: a chain of straight and curved edges, and an index that finds those near a wheel.
#[derive(Clone)]
pub struct Terrain {
    profile: Profile,
    /// One, but for a course.
    parts: Vec<Part>,
    edges: Vec<Edge>,
    index: Bvh,
}

impl Terrain {
    /// Makes a profile ready for contact. The profile must have passed [`Profile::check`].
    pub fn new(profile: Profile) -> Self {
        let parts = match &profile {
            Profile::Course(course) => course.parts().to_vec(),
            one => vec![Part::new(one.clone(), 0.0)],
        };
        let mut chain = Chain::from(parts.first());
        for (index, part) in parts.iter().enumerate() {
            chain.lay(part, index);
        }
        chain.line(chain.at + Vec2::new(REACH, 0.0));
        let Chain { edges, boxes, .. } = chain;
        let blocks: Vec<Aabb> = boxes
            .chunks(BLOCK)
            .map(|block| block[1..].iter().fold(block[0], |sum, b| sum.merged(b)))
            .collect();
        let index = Bvh::from_leaves(BvhBuildStrategy::default(), &blocks);
        Self {
            profile,
            parts,
            edges,
            index,
        }
    }

    /// The profile behind this terrain.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Whether there are edges on it, where a wheel is hit within less than a millisecond: bends of more than 0.5 deg.
    pub fn has_corners(&self) -> bool {
        self.edges.windows(2).any(|pair| {
            let (a, b) = (pair[0].to_tangent, pair[1].from_tangent);
            cross(a, b).abs() > 0.01 * a.norm() * b.norm()
        })
    }

    /// All places within `radius` of `centre` where the ground is locally nearest, from rear to front; m.
    ///
    /// On smooth ground that is one place; a wheel that bridges a hollow has two. `out` is cleared first and keeps its
    /// storage from call to call.
    pub fn contacts(&self, centre: Vec2, radius: f64, out: &mut Vec<Contact>) {
        out.clear();
        let half = Vector::new(radius, radius);
        let middle = Vector::new(centre.x, centre.y);
        let query = Aabb::new(middle - half, middle + half);
        let (mut first, mut last) = (usize::MAX, 0);
        for leaf in self.index.intersect_aabb(&query) {
            first = first.min(leaf as usize);
            last = last.max(leaf as usize);
        }
        if first > last {
            return;
        }
        // The chain never turns back in x: what is under the wheel is one run of edges.
        let from = first * BLOCK;
        let edges = &self.edges[from..((last + 1) * BLOCK).min(self.edges.len())];
        let rear = edges.partition_point(|e| e.to.x < centre.x - radius);
        let front = edges.partition_point(|e| e.from.x <= centre.x + radius);
        self.nearest_on(&edges[rear..front], centre, radius, out);
    }

    /// The nearest place of the ground to `centre`, however far.
    pub fn nearest(&self, centre: Vec2) -> Option<Contact> {
        let mut found = Vec::new();
        let mut radius = 0.1;
        while radius < 2.0 * REACH {
            self.contacts(centre, radius, &mut found);
            if let Some(best) = found
                .iter()
                .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))
            {
                return Some(*best);
            }
            radius *= 2.0;
        }
        None
    }

    /// Points along the ground from `from` to `to`, for drawing: all corners, and curves at most `spacing` apart; m.
    pub fn outline(&self, from: f64, to: f64, spacing: f64) -> Vec<Vec2> {
        let on = |edge: &Edge, x: f64| {
            let x = x.clamp(edge.from.x, edge.to.x);
            if let Some(part) = edge.curve {
                return Vec2::new(x, self.parts[part].eval(x)[0]);
            }
            let length = edge.to.x - edge.from.x;
            let share = if length > 0.0 {
                (x - edge.from.x) / length
            } else {
                1.0
            };
            Vec2::new(x, edge.from.y + share * (edge.to.y - edge.from.y))
        };
        let mut points = Vec::new();
        let shown = self
            .edges
            .iter()
            .filter(|e| e.to.x >= from && e.from.x <= to);
        for edge in shown {
            let start = on(edge, from.max(edge.from.x));
            let end = on(edge, to.min(edge.to.x));
            if points.is_empty() {
                points.push(start);
            }
            if edge.curve.is_some() {
                let count = ((end.x - start.x) / spacing).ceil().max(1.0);
                let mut i = 1.0;
                while i < count {
                    points.push(on(edge, start.x + (end.x - start.x) * i / count));
                    i += 1.0;
                }
            }
            // A riser at the very start has its whole height.
            points.push(if edge.from.x < edge.to.x {
                end
            } else {
                edge.to
            });
        }
        points
    }

    /// Local minima of the distance on a run of edges.
    fn nearest_on(&self, edges: &[Edge], centre: Vec2, radius: f64, out: &mut Vec<Contact>) {
        let limit = radius * radius;
        let mut last_curve = None;
        let mut push = |point: Vec2, tangent: Option<Vec2>, curve: Option<usize>| {
            let arm = centre - point;
            if arm.norm_squared() >= limit {
                return;
            }
            let (angle, distance) = match tangent {
                Some(t) => {
                    let t = t.normalize();
                    (t.y.atan2(t.x), t.x * arm.y - t.y * arm.x)
                }
                // At a corner the normal points at the centre.
                None => ((-arm.x).atan2(arm.y), arm.norm()),
            };
            let contact = Contact {
                point,
                angle,
                distance,
            };
            match out.last_mut() {
                // One place found twice, or one bend of a curve: the deeper counts.
                Some(last)
                    if (last.point - point).norm() < SAME_POINT
                        || (curve.is_some()
                            && curve == last_curve
                            && (last.angle - contact.angle).abs() < SAME_NORMAL) =>
                {
                    if contact.distance < last.distance {
                        *last = contact;
                    }
                }
                _ => out.push(contact),
            }
            last_curve = curve;
        };
        // The edge before, and the derivative of half the squared distance along it at its end.
        let mut before: Option<(&Edge, f64)> = None;
        for edge in edges {
            let at_from = (edge.from - centre).dot(&edge.from_tangent);
            let at_to = (edge.to - centre).dot(&edge.to_tangent);
            if let Some((previous, rise)) = before
                && rise <= 0.0
                && at_from >= 0.0
            {
                let smooth = cross(previous.to_tangent, edge.from_tangent).abs()
                    < 1e-9 * edge.from_tangent.norm() * previous.to_tangent.norm();
                push(edge.from, smooth.then_some(edge.from_tangent), edge.curve);
            }
            if at_from < 0.0 && at_to > 0.0 {
                if let Some(part) = edge.curve {
                    let (point, tangent) = foot_on_curve(&self.parts[part], edge, centre);
                    push(point, Some(tangent), edge.curve);
                } else {
                    let t = edge.from_tangent;
                    push(edge.from - t * (at_from / t.norm_squared()), Some(t), None);
                }
            }
            before = Some((edge, at_to));
        }
    }
}

/// The point of a curved edge whose normal goes through `centre`, and the tangent there.
///
/// Newton's method on `(x - cx) + (f - cy) f' = 0`, kept inside a bracket that bisection shrinks where Newton leaves it.
fn foot_on_curve(part: &Part, edge: &Edge, centre: Vec2) -> (Vec2, Vec2) {
    let (mut low, mut high) = (edge.from.x, edge.to.x);
    let (at_low, at_high) = (
        (edge.from - centre).dot(&edge.from_tangent),
        (edge.to - centre).dot(&edge.to_tangent),
    );
    // The secant's root is within a few um already.
    let mut x = low - at_low * (high - low) / (at_high - at_low);
    let mut value = part.eval(x);
    // Convergence is quadratic: two steps are the rule, 60 bisections the bound.
    for _ in 0..60 {
        let [y, slope, bend] = value;
        let residual = (x - centre.x) + (y - centre.y) * slope;
        if residual > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let mut next = x - residual / (1.0 + slope * slope + (y - centre.y) * bend);
        // The bracket is closed: where the residual is zero already, Newton stays.
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        let moved = next - x;
        x = next;
        // Over a last step this short Taylor's series errs by f'' 1e-13/2 m: no need to evaluate once more.
        if moved.abs() < LAST_STEP {
            value = [
                y + moved * (slope + 0.5 * moved * bend),
                slope + moved * bend,
                bend,
            ];
            break;
        }
        value = part.eval(x);
    }
    (Vec2::new(x, value[0]), Vec2::new(1.0, value[1]))
}

fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

fn aabb(edge: &Edge, margin: f64) -> Aabb {
    let (a, b) = (edge.from, edge.to);
    let margin = Vector::new(1e-9 + margin, 1e-9 + margin);
    Aabb::new(
        Vector::new(a.x.min(b.x), a.y.min(b.y)) - margin,
        Vector::new(a.x.max(b.x), a.y.max(b.y)) + margin,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn contacts(terrain: &Terrain, x: f64, y: f64, radius: f64) -> Vec<Contact> {
        let mut out = Vec::new();
        terrain.contacts(Vec2::new(x, y), radius, &mut out);
        out
    }

    #[test]
    fn level_ground_is_met_straight_below() {
        let terrain = Terrain::new(Profile::Flat);
        let found = contacts(&terrain, 0.7, 0.0994, 0.1);
        assert_eq!(found.len(), 1);
        assert!((found[0].distance - 0.0994).abs() < 1e-15);
        assert!(found[0].angle.abs() < 1e-15);
        assert!(contacts(&terrain, 0.7, 0.1001, 0.1).is_empty());
    }

    #[test]
    fn below_the_ground_the_distance_is_negative() {
        let terrain = Terrain::new(Profile::smooth());
        let y = terrain.profile().eval(1.0)[0];
        let found = contacts(&terrain, 1.0, y - 0.01, 0.1);
        assert!(found.iter().any(|c| c.distance < 0.0));
    }

    #[test]
    fn a_narrow_hollow_is_bridged_at_two_places() {
        let terrain = Terrain::new(Profile::CosBump {
            height: -0.08,
            centre: 0.0,
            half_width: 0.08,
        });
        let found = contacts(&terrain, 0.0, 0.055, 0.1);
        assert_eq!(found.len(), 2);
        assert!((found[0].distance - found[1].distance).abs() < 1e-12);
        assert!((found[0].angle + found[1].angle).abs() < 1e-9);
        assert!(found[0].angle < 0.0);
    }

    #[test]
    fn a_wheel_against_a_riser_touches_riser_and_tread() {
        let terrain = Terrain::new(Profile::step());
        let found = contacts(&terrain, 0.7 - 0.085, 0.0995, 0.1);
        assert_eq!(found.len(), 2);
        // From rear to front: the tread below, then the riser's edge, 50 mm up, before the centre.
        assert!((found[0].distance - 0.0995).abs() < 1e-15 && found[0].angle.abs() < 1e-15);
        let edge = Vec2::new(0.7, 0.05);
        assert!((found[1].point - edge).norm() < 1e-15);
        let found = contacts(&terrain, 0.7 - 0.099, 0.04, 0.1);
        assert!(
            found
                .iter()
                .any(|c| (c.angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12)
        );
    }

    #[test]
    fn a_narrow_ditch_is_bridged_by_its_edges_a_wide_one_is_not() {
        let terrain = Terrain::new(Profile::ditch());
        let hanging = 0.0999_f64.powi(2) - 0.06_f64.powi(2);
        let found = contacts(&terrain, 0.76, hanging.sqrt(), 0.1);
        assert_eq!(found.len(), 2);
        for (contact, x) in found.iter().zip([0.7, 0.82]) {
            assert!((contact.point - Vec2::new(x, 0.0)).norm() < 1e-15);
            assert!((contact.distance - 0.0999).abs() < 1e-12);
        }
        // In a wide one: the bottom, and against the far wall that wall too.
        let terrain = Terrain::new(Profile::Ditch {
            depth: 0.2,
            width: 0.5,
            start: 0.7,
        });
        let found = contacts(&terrain, 1.1005, -0.1005, 0.1);
        assert_eq!(found.len(), 2);
        assert!((found[0].angle.abs()) < 1e-12 && (found[0].point.y + 0.2).abs() < 1e-12);
        assert!((found[1].angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn a_concave_corner_has_two_contacts_a_convex_one_a_corner() {
        let terrain = Terrain::new(Profile::ramp());
        // On the line that halves the corner both distances are equal.
        let half = 7.5_f64.to_radians();
        let found = contacts(&terrain, 0.7 - 0.0995 * half.tan(), 0.0995, 0.1);
        assert_eq!(found.len(), 2);
        assert!((found[0].distance - found[1].distance).abs() < 1e-12);
        assert!((found[1].angle - 15.0_f64.to_radians()).abs() < 1e-12);
        let top = Vec2::new(0.7, 0.0) + Vec2::new((2.0 * half).cos(), (2.0 * half).sin()) * 0.8;
        let up = Vec2::new(-half.sin(), half.cos());
        let centre = top + up * 0.0995;
        let found = contacts(&terrain, centre.x, centre.y, 0.1);
        assert_eq!(found.len(), 1);
        assert!((found[0].point - top).norm() < 1e-12);
        assert!((found[0].angle - half).abs() < 1e-12);
    }

    #[test]
    fn both_sides_of_a_blunt_corner_count() {
        let terrain = Terrain::new(Profile::Ramp {
            angle: 4.0_f64.to_radians(),
            start: 0.7,
            length: 0.8,
        });
        let x = 0.7 - 0.0995 * 2.0_f64.to_radians().tan();
        assert_eq!(contacts(&terrain, x, 0.0995, 0.1).len(), 2);
    }

    #[test]
    fn corners_are_told_from_smooth_joints() {
        for (profile, has) in [
            (Profile::Flat, false),
            (Profile::smooth(), false),
            (Profile::cosbump(), false),
            (Profile::ramp(), true),
            (Profile::step(), true),
        ] {
            assert_eq!(
                Terrain::new(profile.clone()).has_corners(),
                has,
                "{profile:?}"
            );
        }
    }

    #[test]
    fn measured_points_carry_a_wheel_as_spline_or_corners() {
        let points = [
            (0.5, 3.0),
            (0.7, 3.0),
            (0.9, 3.02),
            (1.2, 3.01),
            (1.3, 3.01),
        ];
        let points = points.map(|(x, y)| Vec2::new(x, y)).to_vec();
        for interpolation in crate::Interpolation::ALL {
            let heights = crate::Heights::new(points.clone(), interpolation);
            let terrain = Terrain::new(Profile::Heights(heights));
            for i in 0..100 {
                let x = 0.4 + 0.01 * f64::from(i);
                let [y, slope, _] = terrain.profile().eval(x);
                let centre = Vec2::new(x, y) + Vec2::new(-slope, 1.0).normalize() * 0.0995;
                let found = contacts(&terrain, centre.x, centre.y, 0.1);
                // A concave corner is touched on both sides.
                let most = match interpolation {
                    crate::Interpolation::Spline => 1,
                    crate::Interpolation::Corners => 2,
                };
                assert!(
                    (1..=most).contains(&found.len()),
                    "{interpolation:?} at {x}"
                );
                assert!(found[0].distance <= 0.0995 + 1e-12);
            }
            let end = terrain.outline(2.0, 3.0, 0.1)[0];
            assert!((end - Vec2::new(2.0, 0.01)).norm() < 1e-12);
        }
    }

    /// A course of one part is that part to the bit; a wheel on smooth joints of a course touches once.
    #[test]
    fn parts_join_without_double_contacts() {
        let one = |p: &Profile| Terrain::new(Profile::Course(crate::Course::new(vec![p.clone()])));
        let waves = |start| Profile::Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start,
            periods: 2,
        };
        let course = crate::Course::new(vec![Profile::ramp(), waves(1.6), waves(2.6)]);
        let course = Terrain::new(Profile::Course(course));
        let smooth = Terrain::new(Profile::smooth());
        let alone = one(&Profile::smooth());
        for i in 0..500 {
            let x = 0.01 * f64::from(i);
            let same = contacts(&alone, x, 0.09, 0.1);
            assert_eq!(same, contacts(&smooth, x, 0.09, 0.1));
            if i > 155 {
                let [y, slope, _] = course.profile().eval(x);
                let centre = Vec2::new(x, y) + Vec2::new(-slope, 1.0).normalize() * 0.0995;
                let found = contacts(&course, centre.x, centre.y, 0.1);
                assert_eq!(found.len(), 1, "at {x}");
                assert!((found[0].distance - 0.0995).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_outline_has_every_corner() {
        let terrain = Terrain::new(Profile::stairs());
        let points = terrain.outline(0.0, 3.0, 0.01);
        // Start, four risers of two points each, end.
        assert_eq!(points.len(), 10);
        assert!((points[9] - Vec2::new(3.0, 0.32)).norm() < 1e-12);
    }

    proptest! {
        /// Property: the nearest place found is the nearest of a dense sample of the curve, and lies on its own normal.
        #[test]
        fn nearest_is_nearest(x in -0.5_f64..4.5, gap in 0.09_f64..0.1, which in 0..4_usize) {
            let profile = [Profile::smooth(), Profile::cosbump(), Profile::sine(), Profile::rough(0)][which].clone();
            let terrain = Terrain::new(profile.clone());
            let [y, slope, _] = profile.eval(x);
            let up = Vec2::new(-slope, 1.0).normalize();
            let centre = Vec2::new(x, y) + up * gap;
            let found = contacts(&terrain, centre.x, centre.y, 0.1);
            prop_assert_eq!(found.len(), 1);
            let contact = found[0];
            prop_assert!((contact.point + contact.normal() * contact.distance - centre).norm() < 1e-9);
            let dense = (-2000..=2000)
                .map(|i| {
                    let u = centre.x + 1e-4 * f64::from(i);
                    (Vec2::new(u, profile.eval(u)[0]) - centre).norm()
                })
                .fold(f64::INFINITY, f64::min);
            // A sample 0.1 mm apart is farther than the nearest by at most (0.05 mm)^2 / 2r = 1.3e-8 m.
            prop_assert!(contact.distance <= dense + 1e-12 && contact.distance > dense - 5e-8);
        }
    }
}

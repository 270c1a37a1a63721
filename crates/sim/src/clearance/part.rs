//! The outline of a bar as lines about its centre of mass, and what is known of their distances to
//! the ground.

use parry2d::bounding_volume::Aabb;
use parry2d::math::{Pose, Vector};
use parry2d::partitioning::BvhNode;
use parry2d::query::details::distance_segment_segment;
use parry2d::shape::{ConvexPolygon, Polyline, Segment};
use robhaz_model::{Bar, Geometry, Vec2};

/// Rounding of a distance, m: much more than it can be.
const ROUNDING: f64 = 1e-9;

/// Where a bar is: its centre of mass (m) and its angle from the nominal pose (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarPlace {
    /// Centre of mass, m.
    pub centre: Vec2,
    /// Angle, rad, counter-clockwise.
    pub angle: f64,
}

impl BarPlace {
    /// Whether it is a place.
    pub(crate) fn is_finite(&self) -> bool {
        self.angle.is_finite() && self.centre.iter().all(|x| x.is_finite())
    }
}

/// A line of a bar's outline.
pub(crate) struct Part {
    /// About the bar's centre of mass, m.
    pub line: Segment,
    /// Largest distance of its points from the centre of mass, m.
    reach: f64,
    /// Distance to the ground when it was last measured (m), and where the bar was. `None` on a new
    /// ground.
    pub last: Option<(f64, BarPlace)>,
    /// The line of the ground to which that was.
    nearest: u32,
}

impl Part {
    /// A line between two points about the bar's centre of mass, m.
    pub fn new([a, b]: [Vec2; 2]) -> Self {
        Self {
            line: Segment::new(vector(a), vector(b)),
            reach: a.norm().max(b.norm()),
            last: None,
            nearest: 0,
        }
    }

    /// What the distance is at least, m: no point of the line has moved farther than its bar.
    #[inline]
    pub fn at_least(&self, bar: &BarPlace) -> f64 {
        self.last.map_or(f64::NEG_INFINITY, |(distance, at)| {
            let turned = self.reach * (bar.angle - at.angle).abs();
            distance - (bar.centre - at.centre).norm() - turned - ROUNDING
        })
    }

    /// Distance of the line to the ground, m. What was the nearest before leaves few lines of the
    /// ground to measure.
    pub fn measure(&mut self, bar: &BarPlace, ground: &Polyline) -> f64 {
        let pose = Pose::new(vector(bar.centre), bar.angle);
        let line = self.line.transformed(&pose);
        let of_line = |k: u32| {
            let own = ground.segment(k);
            distance_segment_segment(&Pose::IDENTITY, &line, &own)
        };
        // The line of the ground that was the nearest is near still.
        let most = match self.last {
            Some(_) => of_line(self.nearest) + ROUNDING,
            None => f64::MAX,
        };
        let box_of = Aabb::new(line.a.min(line.b), line.a.max(line.b));
        let normal = (line.b - line.a).perp().normalize_or_zero();
        // A box of the ground is at least as far as from the line's own box, and from the endless
        // line.
        let least_in = |node: &BvhNode, _| {
            // Negative where the boxes overlap.
            let gap = (node.mins() - box_of.maxs).max(box_of.mins - node.maxs());
            let half = 0.5 * (node.maxs() - node.mins());
            let beside = normal.dot(node.mins() + half - line.a).abs() - normal.abs().dot(half);
            gap.max(Vector::ZERO).length().max(beside - ROUNDING)
        };
        let found = (ground.bvh()).find_best(most, least_in, |k, _| Some(of_line(k)));
        // There is one below the bound. NaN would be seen in every table.
        let Some((nearest, distance)) = found else {
            self.last = None;
            return f64::NAN;
        };
        self.nearest = nearest;
        self.last = Some((distance, *bar));
        distance
    }
}

pub(crate) fn vector(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

/// The parts of a bar's outline without its half width, about the bar's centre of mass.
pub(crate) fn outline(geometry: &Geometry, bar: Bar) -> Vec<Part> {
    let cg = geometry.cg(bar);
    let mut points: Vec<Vec2> = geometry.outline_points(bar).map(|p| p - cg).collect();
    if bar == Bar::Body {
        let corners: Vec<_> = points.iter().copied().map(vector).collect();
        if let Some(hull) = ConvexPolygon::from_convex_hull(&corners) {
            let corners = hull.points();
            let point = |v: &Vector| Vec2::new(v.x, v.y);
            let next = corners.iter().cycle().skip(1);
            let edges = corners.iter().zip(next);
            let edges = edges.map(|(a, b)| Part::new([point(a), point(b)]));
            return edges.collect();
        }
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let axles = geometry.axles.iter().zip(&geometry.carriers);
    let own = axles.filter(|(_, carrier)| carrier.bar() == bar);
    let wheels: Vec<Vec2> = own.map(|(axle, _)| axle - cg).collect();
    let radius = geometry.wheel_radius;
    let pairs = points.windows(2);
    let pieces = pairs.flat_map(|pair| outside([pair[0], pair[1]], &wheels, radius));
    pieces.map(Part::new).collect()
}

/// The pieces of a line that lie outside of wheels of a radius (m): what is inside cannot touch the
/// ground before the wheel.
fn outside(line: [Vec2; 2], wheels: &[Vec2], radius: f64) -> Vec<[Vec2; 2]> {
    let [from, along] = [line[0], line[1] - line[0]];
    let square = along.norm_squared();
    if square <= 0.0 {
        return Vec::new();
    }
    // Shares of the line at which it enters or leaves a wheel.
    let mut ends = vec![0.0, 1.0];
    for wheel in wheels {
        let arm = from - wheel;
        let middle = -arm.dot(&along) / square;
        let half = middle * middle - (arm.norm_squared() - radius * radius) / square;
        if half > 0.0 {
            let crossings = [middle - half.sqrt(), middle + half.sqrt()];
            ends.extend(crossings.into_iter().filter(|t| *t > 0.0 && *t < 1.0));
        }
    }
    ends.sort_by(f64::total_cmp);
    let pieces = ends.windows(2).filter(|piece| {
        let middle = from + along * (0.5 * (piece[0] + piece[1]));
        wheels.iter().all(|wheel| (middle - wheel).norm() > radius)
    });
    let at = |share: f64| from + along * share;
    pieces.map(|piece| [at(piece[0]), at(piece[1])]).collect()
}

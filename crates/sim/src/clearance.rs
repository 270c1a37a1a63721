//! Distance of the robot's body and links to the ground, by parry2d.
//!
//! Contacts of wheels are the simulation's own. Body and links have an outline
//! ([`robhaz_model::Outline`]) whose contact is not modelled: no force acts where a bar touches the
//! ground. This module computes their distance to it. What a link's own wheels cover does not
//! count: there the wheel touches first.

use parry2d::bounding_volume::Aabb;
use parry2d::math::{Pose, Vector};
use parry2d::partitioning::BvhNode;
use parry2d::query::{details::distance_segment_segment, distance};
use parry2d::shape::{ConvexPolygon, Polyline, Segment};
use robhaz_model::{Bar, Geometry, Vec2};
use robhaz_terrain::Terrain;

/// Largest distance of the points of the ground, m. The chord of a curve of 0.1 m radius is 0.03 mm
/// off.
const SPACING: f64 = 0.005;
/// Ground on each side of the robot that is kept, and the part of it that the robot may use before
/// it is built anew, over the robot's length.
const KEPT: f64 = 6.0;
const USED: f64 = 3.0;
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
    fn is_finite(&self) -> bool {
        self.angle.is_finite() && self.centre.iter().all(|x| x.is_finite())
    }
}

/// Measures the clearance of a robot on its ground.
///
/// What it has measured bounds what follows, by the way of the bars since then: lines that cannot
/// be the nearest are not measured, and the others have few lines of the ground near them. The
/// results are those of a full search, up to rounding.
pub struct ClearanceMeter {
    terrain: Terrain,
    /// The lines of all bars, in the order of [`Bar::ALL`].
    parts: Vec<(Bar, Part)>,
    half_width: f64,
    /// Length of the robot, m.
    length: f64,
    /// The ground about a place x, m; `None` before the first measurement.
    ground: Option<(f64, Polyline)>,
}

impl ClearanceMeter {
    /// For a checked geometry on a ground.
    pub fn new(geometry: &Geometry, terrain: Terrain) -> Self {
        let [front, _, rear] = geometry.axles;
        let parts = Bar::ALL.into_iter().flat_map(|bar| {
            let lines = outline(geometry, bar).into_iter();
            lines.map(move |part| (bar, part))
        });
        Self {
            terrain,
            parts: parts.collect(),
            half_width: geometry.outline.half_width,
            length: front.x - rear.x + 2.0 * geometry.wheel_radius,
            ground: None,
        }
    }

    /// Clearance of the bars at their places, in the order of [`Bar::ALL`]. Nothing is known of a
    /// place that is not finite.
    pub fn measure(&mut self, bars: &[BarPlace; 4]) -> Clearances {
        let unknown = Clearances::of([f64::NAN; 4]);
        if !bars.iter().all(BarPlace::is_finite) {
            return unknown;
        }
        self.keep_ground_at(bars[Bar::Body as usize].centre.x);
        let at_least = |(bar, part): &(Bar, Part)| part.at_least(&bars[*bar as usize]);
        let found = self.parts.iter().map(at_least).enumerate();
        let nearest = found.min_by(|a, b| a.1.total_cmp(&b.1));
        let (Some((nearest, _)), Some((_, ground))) = (nearest, &self.ground) else {
            return unknown;
        };
        let half_width = self.half_width;
        let mut each = [f64::INFINITY; 4];
        let mut least = f64::INFINITY;
        let (before, from) = self.parts.split_at_mut(nearest);
        // The one that may be nearest first, so that most others need no measurement. Where it
        // touches, others may, too.
        for (bar, part) in from.iter_mut().chain(before) {
            let place = &bars[*bar as usize];
            if part.at_least(place) - half_width <= least.max(0.0) {
                let found = part.measure(place, ground) - half_width;
                let of_bar = &mut each[*bar as usize];
                *of_bar = of_bar.min(found);
                least = least.min(found);
            }
        }
        Clearances::of(each)
    }

    /// Clearance of each bar (m) in the order of [`Bar::ALL`], by parry2d's own search of the whole
    /// ground: nothing is known from before. Slow; [`Self::measure`] is held against it.
    pub fn measure_each(&mut self, bars: &[BarPlace; 4]) -> [f64; 4] {
        self.keep_ground_at(bars[Bar::Body as usize].centre.x);
        let Some((_, ground)) = &self.ground else {
            return [f64::NAN; 4];
        };
        let mut each = [f64::INFINITY; 4];
        for (bar, part) in &self.parts {
            let place = &bars[*bar as usize];
            let pose = Pose::new(vector(place.centre), place.angle);
            // This pair of shapes is supported.
            let found = distance(&pose, &part.line, &Pose::IDENTITY, ground);
            let found = found.map_or(f64::NAN, |d| d.distance);
            let of_bar = &mut each[*bar as usize];
            *of_bar = of_bar.min(found);
        }
        each.map(|distance| distance - self.half_width)
    }

    /// Builds the ground about x (m), if the robot is near the end of what is kept.
    fn keep_ground_at(&mut self, x: f64) {
        let is_near = |(at, _): &(f64, Polyline)| (x - at).abs() <= USED * self.length;
        if !x.is_finite() || self.ground.as_ref().is_some_and(is_near) {
            return;
        }
        let reach = KEPT * self.length;
        let points = self.terrain.outline(x - reach, x + reach, SPACING);
        let points: Vec<_> = points.into_iter().map(vector).collect();
        self.ground = (points.len() > 1).then(|| (x, Polyline::new(points, None)));
        for (_, part) in &mut self.parts {
            part.last = None;
        }
    }
}

/// The least clearance of body and links, and which of them touch the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearances {
    /// The bar with the least clearance, and its clearance, m; infinite where none is known. A bar
    /// at 0 or below touches the ground; how deep it is below 0 has no meaning.
    pub least: (Bar, f64),
    /// Whether each bar touches the ground, in the order of [`Bar::ALL`]; `None` where it is not
    /// known.
    pub touching: [Option<bool>; 4],
}

impl Clearances {
    /// Of the clearances (m) of the four bars, in the order of [`Bar::ALL`]. One that is not a
    /// number is not known.
    pub fn of(each: [f64; 4]) -> Self {
        let bars = Bar::ALL.into_iter().zip(each);
        let least = bars.fold((Bar::Body, f64::INFINITY), |least, of_bar| {
            if of_bar.1 < least.1 { of_bar } else { least }
        });
        Self {
            least,
            touching: each.map(|distance| (!distance.is_nan()).then_some(distance <= 0.0)),
        }
    }

    /// Whether a bar touches the ground.
    pub fn touches(&self) -> bool {
        self.least.1 <= 0.0
    }
}

/// A line of a bar's outline.
struct Part {
    /// About the bar's centre of mass, m.
    line: Segment,
    /// Largest distance of its points from the centre of mass, m.
    reach: f64,
    /// Distance to the ground when it was last measured (m), and where the bar was. `None` on a new
    /// ground.
    last: Option<(f64, BarPlace)>,
    /// The line of the ground to which that was.
    nearest: u32,
}

impl Part {
    /// A line between two points about the bar's centre of mass, m.
    fn new([a, b]: [Vec2; 2]) -> Self {
        Self {
            line: Segment::new(vector(a), vector(b)),
            reach: a.norm().max(b.norm()),
            last: None,
            nearest: 0,
        }
    }

    /// What the distance is at least, m: no point of the line has moved farther than its bar.
    #[inline]
    fn at_least(&self, bar: &BarPlace) -> f64 {
        self.last.map_or(f64::NEG_INFINITY, |(distance, at)| {
            let turned = self.reach * (bar.angle - at.angle).abs();
            distance - (bar.centre - at.centre).norm() - turned - ROUNDING
        })
    }

    /// Distance of the line to the ground, m. What was the nearest before leaves few lines of the
    /// ground to measure.
    fn measure(&mut self, bar: &BarPlace, ground: &Polyline) -> f64 {
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

fn vector(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

/// The parts of a bar's outline without its half width, about the bar's centre of mass.
fn outline(geometry: &Geometry, bar: Bar) -> Vec<Part> {
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

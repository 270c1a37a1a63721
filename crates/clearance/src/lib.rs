//! Distance of the robot's body and links to the ground, by parry2d.
//!
//! Contacts of wheels are the simulation's own. Body and links have an outline ([`robhaz_model::Outline`]) whose contact is
//! not modelled: no force acts where a bar touches the ground. This crate tells how far they are from it. What a link's own
//! wheels cover does not count: there the wheel touches first.

use parry2d::math::{Pose, Vector};
use parry2d::query::distance;
use parry2d::shape::{ConvexPolygon, Polyline, Segment};
use robhaz_model::{Bar, Geometry, Vec2};
use robhaz_terrain::Terrain;

/// Where a bar is: its centre of mass (m) and its angle from the nominal pose (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarPlace {
    /// Centre of mass, m.
    pub centre: Vec2,
    /// Angle, rad, counter-clockwise.
    pub angle: f64,
}

/// Clearance of the four bars, m, in the order of [`Bar::ALL`]. A bar at 0 or below touches the ground; how deep it is
/// below 0 has no meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearances(pub [f64; 4]);

impl Clearances {
    /// The bar with the least clearance, and its clearance, m.
    pub fn least(&self) -> (Bar, f64) {
        let each = Bar::ALL.into_iter().zip(self.0);
        each.fold((Bar::Body, f64::INFINITY), |least, (bar, distance)| {
            if distance < least.1 {
                (bar, distance)
            } else {
                least
            }
        })
    }

    /// Whether a bar touches the ground.
    pub fn touches(&self) -> bool {
        self.least().1 <= 0.0
    }
}

/// Largest distance of the points of the ground, m. The chord of a curve of 0.1 m radius is 0.03 mm off.
const SPACING: f64 = 0.005;
/// Ground on each side of the robot that is kept, and the part of it that the robot may use before it is built anew,
/// over the robot's length.
const KEPT: f64 = 6.0;
const USED: f64 = 3.0;

/// Rounding of a distance, m: much more than it can be.
const ROUNDING: f64 = 1e-9;

/// A line of a bar's outline, and what is known of its distance.
struct Part {
    /// About the bar's centre of mass, m.
    line: Segment,
    /// Largest distance of its points from the centre of mass, m.
    reach: f64,
    /// Distance to the ground when it was last measured (m), and where the bar was. `None` on a new ground.
    last: Option<(f64, BarPlace)>,
}

impl Part {
    fn new([a, b]: [Vec2; 2]) -> Self {
        Self {
            line: Segment::new(vector(a), vector(b)),
            reach: a.norm().max(b.norm()),
            last: None,
        }
    }

    /// What the distance is at least (m): no point of the line has moved farther than its bar.
    fn at_least(&self, bar: &BarPlace) -> f64 {
        self.last.map_or(f64::NEG_INFINITY, |(distance, at)| {
            let turned = self.reach * (bar.angle - at.angle).abs();
            distance - (bar.centre - at.centre).norm() - turned - ROUNDING
        })
    }

    /// Distance of the line to the ground, m.
    fn measure(&mut self, bar: &BarPlace, ground: &Polyline) -> f64 {
        let pose = Pose::new(vector(bar.centre), bar.angle);
        // This pair of shapes is supported; NaN would be seen in every table.
        let found = distance(&pose, &self.line, &Pose::IDENTITY, ground);
        let found = found.map_or(f64::NAN, |d| d.distance);
        self.last = found.is_finite().then_some((found, *bar));
        found
    }
}

/// Measures the clearance of a robot on its ground.
pub struct ClearanceMeter {
    terrain: Terrain,
    outlines: [Vec<Part>; 4],
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
        Self {
            terrain,
            outlines: Bar::ALL.map(|bar| outline(geometry, bar)),
            half_width: geometry.outline.half_width,
            length: front.x - rear.x + 2.0 * geometry.wheel_radius,
            ground: None,
        }
    }

    /// Clearance of the bars at their places, in the order of [`Bar::ALL`].
    pub fn measure(&mut self, bars: &[BarPlace; 4]) -> Clearances {
        let x = bars[Bar::Body as usize].centre.x;
        self.keep_ground_at(x);
        let Some((_, ground)) = &self.ground else {
            return Clearances([f64::NAN; 4]);
        };
        let half_width = self.half_width;
        let mut outlines = self.outlines.iter_mut().zip(bars);
        Clearances([(); 4].map(|()| {
            let Some((parts, bar)) = outlines.next() else {
                return f64::NAN;
            };
            least(parts, bar, ground) - half_width
        }))
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
        for part in self.outlines.iter_mut().flatten() {
            part.last = None;
        }
    }
}

/// Distance of a bar's lines to the ground, m. The line that may be nearest is measured first; those that cannot be nearer
/// are not.
fn least(parts: &mut [Part], bar: &BarPlace, ground: &Polyline) -> f64 {
    let nearest = |a: &&mut Part, b: &&mut Part| a.at_least(bar).total_cmp(&b.at_least(bar));
    let first = parts.iter_mut().min_by(nearest);
    let least = first.map_or(f64::INFINITY, |part| part.measure(bar, ground));
    parts.iter_mut().fold(least, |least, part| {
        let is_known = part.last.is_some_and(|(_, at)| at == *bar);
        if !is_known && part.at_least(bar) < least {
            least.min(part.measure(bar, ground))
        } else {
            least
        }
    })
}

/// The parts of a bar's outline without its half width, about the bar's centre of mass.
fn outline(geometry: &Geometry, bar: Bar) -> Vec<Part> {
    let cg = geometry.cg(bar);
    let mut points: Vec<Vec2> = geometry.outline_points(bar).map(|p| p - cg).collect();
    if bar == Bar::Body {
        let corners: Vec<_> = points.iter().copied().map(vector).collect();
        if let Some(hull) = ConvexPolygon::from_convex_hull(&corners) {
            let corners = hull.points();
            let next = corners.iter().cycle().skip(1);
            let edges = corners.iter().zip(next);
            return edges
                .map(|(a, b)| Part::new([point(a), point(b)]))
                .collect();
        }
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let axles = geometry.axles.iter().zip(&geometry.carriers);
    let own = axles.filter(|(_, carrier)| carrier.bar() == bar);
    let wheels: Vec<Vec2> = own.map(|(axle, _)| axle - cg).collect();
    let pairs = points.windows(2);
    pairs
        .flat_map(|pair| outside([pair[0], pair[1]], &wheels, geometry.wheel_radius))
        .map(Part::new)
        .collect()
}

/// The pieces of a line that lie outside of wheels of a radius (m): what is inside cannot touch the ground before the wheel.
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
    pieces
        .map(|piece| [from + along * piece[0], from + along * piece[1]])
        .collect()
}

fn point(v: &Vector) -> Vec2 {
    Vec2::new(v.x, v.y)
}

fn vector(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

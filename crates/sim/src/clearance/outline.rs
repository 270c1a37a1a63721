//! The outline of a bar as lines about its centre of mass.

use super::part::{Part, vector};
use parry2d::math::Vector;
use parry2d::shape::ConvexPolygon;
use robhaz_model::{Bar, Geometry, Vec2};

/// The parts of a bar's outline without its half width, about the bar's centre of mass.
pub(crate) fn outline(geometry: &Geometry, bar: Bar) -> Vec<Part> {
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
    pieces
        .map(|piece| [from + along * piece[0], from + along * piece[1]])
        .collect()
}

fn point(v: &Vector) -> Vec2 {
    Vec2::new(v.x, v.y)
}

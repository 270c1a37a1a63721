//! Outlines of the robot's parts, m. Each is in the part's own frame: origin at the centre of mass,
//! axes of the nominal pose.

use robhaz_model::{Bar, Geometry, MassSet, PinStop, Vec2};

/// Number of spokes of a wheel. With few spokes its rotation is visible.
const SPOKES: u32 = 5;
/// Distances from Q at which the mark of an end stop starts and ends, m.
const STOP_TICK: [f64; 2] = [0.03, 0.08];
/// Number of straight pieces of the arc between the end stops.
const STOP_PIECES: u32 = 24;

/// A link as a polyline through the points of its outline, from rear to front, m.
pub(crate) fn link(geometry: &Geometry, bar: Bar) -> Vec<Vec2> {
    let cg = geometry.cg(bar);
    let mut points: Vec<Vec2> = geometry.outline_points(bar).map(|p| p - cg).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    points
}

/// The body as a closed outline through its pins and a box, m. The box is three times as long as it
/// is high and has the body's mass and inertia.
pub(crate) fn body(geometry: &Geometry, mass: &MassSet) -> Vec<Vec2> {
    let height = (12.0 * mass.body_inertia / mass.body / 10.0).sqrt();
    let half = Vec2::new(1.5 * height, 0.5 * height);
    let cg = geometry.cg(Bar::Body);
    let mut points: Vec<Vec2> = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(x, y)| Vec2::new(x * half.x, y * half.y))
        .into_iter()
        .chain(pins_of(geometry, Bar::Body).map(|pin| pin - cg))
        .collect();
    // Corners in the order of their direction from the centre make an outline that does not cross
    // itself.
    points.sort_by(|a, b| a.y.atan2(a.x).total_cmp(&b.y.atan2(b.x)));
    points.extend(points.first().copied());
    points
}

/// Spokes of a wheel of a radius (m), each from the centre to the rim, m.
pub(crate) fn spokes(radius: f64) -> Vec<[Vec2; 2]> {
    (0..SPOKES)
        .map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(SPOKES);
            [Vec2::zeros(), Vec2::new(angle.cos(), angle.sin()) * radius]
        })
        .collect()
}

/// The end stops of pin Q in the frame of link 2, m: the arc over which the line from Q to P on
/// link 1 can turn, the mark of the lower stop, and that of the upper stop.
pub(crate) fn stops(geometry: &Geometry) -> [Vec<Vec2>; 3] {
    let q = geometry.pins.q - geometry.cg(Bar::Link2);
    let towards_p = geometry.pins.p - geometry.pins.q;
    let nominal = towards_p.y.atan2(towards_p.x);
    let at = |radius: f64, turn: f64| {
        let (sin, cos) = (nominal + turn).sin_cos();
        q + Vec2::new(cos, sin) * radius
    };
    let PinStop { lower, upper, .. } = geometry.stop;
    let tick = |turn: f64| STOP_TICK.map(|radius| at(radius, turn)).to_vec();
    let arc = (0..=STOP_PIECES)
        .map(|i| lower + (upper - lower) * f64::from(i) / f64::from(STOP_PIECES))
        .map(|turn| at(STOP_TICK[1], turn))
        .collect();
    [arc, tick(lower), tick(upper)]
}

/// Nominal positions of the pins of a bar, m.
fn pins_of(geometry: &Geometry, bar: Bar) -> impl Iterator<Item = Vec2> {
    let pins = geometry.suspension.pins().iter();
    pins.filter(move |pin| pin.bars().0 == bar || pin.bars().1 == bar)
        .map(|pin| geometry.pins.get(*pin))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: link 2 of geometry A goes from the rear axle through R and Q to the middle
    /// axle.
    #[test]
    fn a_link_goes_through_its_own_pins_and_axles() {
        let geometry = Geometry::a();
        let found = link(&geometry, Bar::Link2);
        let cg = geometry.cg(Bar::Link2);
        let expected = [
            geometry.axles[2],
            geometry.pins.r,
            geometry.pins.q,
            geometry.axles[1],
        ]
        .map(|p| p - cg);
        assert_eq!(found, expected);
    }

    /// Closed form: with link 1 turned to an end stop, its line from Q to P lies along the mark of
    /// that stop.
    #[test]
    fn link_1_meets_its_stops() {
        let geometry = Geometry::a();
        let [_, lower, upper] = stops(&geometry);
        let q = geometry.pins.q - geometry.cg(Bar::Link2);
        for (mark, turn) in [(lower, geometry.stop.lower), (upper, geometry.stop.upper)] {
            let line = robhaz_model::rotate(geometry.pins.p - geometry.pins.q, turn);
            for point in mark {
                // Rounding: lengths are below 1 m.
                assert!(robhaz_model::cross(line, point - q).abs() < 1e-12);
                assert!(line.dot(&(point - q)) > 0.0);
            }
        }
    }

    /// Closed form: the box has the body's inertia m (w^2 + h^2)/12, and the closed outline goes
    /// through P and S.
    #[test]
    fn the_body_has_its_own_inertia_and_pins() {
        let (geometry, mass) = (Geometry::a(), MassSet::caption());
        let outline = body(&geometry, &mass);
        assert_eq!(outline.len(), 7);
        assert_eq!(outline.first(), outline.last());
        for pin in [geometry.pins.p, geometry.pins.s] {
            assert!(outline.contains(&(pin - geometry.body_cg)));
        }
        let half = outline
            .iter()
            .fold(Vec2::zeros(), |m, p| Vec2::new(m.x.max(p.x), m.y.max(p.y)));
        let inertia = mass.body * (4.0 * half.norm_squared()) / 12.0;
        assert!((inertia - mass.body_inertia).abs() < 1e-12);
    }
}

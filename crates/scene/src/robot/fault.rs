//! Faults of a robot, and how they are reported; inertias that no part can have: in another unit, such as kg cm^2.

use robhaz_keys::prelude::*;
use robhaz_model::{Robot, WholeRover};

/// The key at fault, and why.
pub type Fault = (&'static str, String);

/// Reports a fault at its key of a table, or at the table that lacks it.
pub fn report(reader: &mut Reader, table: &Node, path: &str, (key, message): Fault) {
    let node = table.find(key).unwrap_or(table);
    let message = format!("found {}, but {message}", node.origin.found());
    reader.push(Problem::at(&node.origin, &join(path, key), message).whole());
}

/// A part in words, its mass, kg, and its size, m.
type Part = (&'static str, f64, f64);

/// Inertia of a wheel with its rotor over mass and radius squared, far below which none is: a disc has a half.
const LEAST_OF_WHEEL: f64 = 1e-3;

/// The key under `robot.mass` of an inertia beyond the mass of its part times the square of its size, or of a wheel that has
/// next to none, and why.
pub(crate) fn impossible(robot: &Robot) -> Option<Fault> {
    let (mass, size) = (&robot.mass, size(robot));
    let body = ("the body", mass.body, size);
    let wheel = ("a wheel", mass.wheel, robot.geometry.wheel_radius);
    // The rotors, through their gears, resist as a mass of inertia over radius squared at the rims would: that of the
    // whole robot is far above what a motor has.
    let whole = ("the robot", mass.total(), size);
    let own = [
        ("body_inertia", mass.body_inertia, body),
        ("wheel_inertia", mass.wheel_inertia, wheel),
        ("rotor_inertia", mass.rotor_inertia, whole),
    ];
    let links = mass.link_inertias.into_iter().zip(mass.links);
    let links = links.map(|(found, mass)| ("link_inertias", found, ("a link", mass, size)));
    let too_large = own.into_iter().chain(links).find_map(beyond);
    too_large.or_else(|| {
        let (_, own, radius) = wheel;
        let (least, found) = (LEAST_OF_WHEEL * own * radius * radius, mass.wheel_inertia + mass.rotor_inertia);
        let message = || format!(
            "with rotor_inertia {} kg m^2 is less than {} kg m^2, a thousandth of the mass of a wheel, {own} kg, times {radius} m squared; the unit is kg m^2",
            rounded(found),
            rounded(least)
        );
        (found < least).then(|| ("wheel_inertia", message()))
    })
}

/// The same of a key under `robot.across`.
pub(crate) fn too_large_across(rover: &WholeRover) -> Option<Fault> {
    let mass = &rover.side.mass;
    let width = 2.0 * rover.half_tracks.into_iter().fold(0.0, f64::max);
    let size = size(&rover.side).hypot(width);
    let body = ("the body", 2.0 * mass.body, size);
    let body = (rover.body_inertia).map(|found| ("body_inertia", found, body));
    let links = [0, 1].map(|i| {
        let link = ("a link", mass.links[i], size);
        rover.link_inertias[i].map(|found| ("link_inertias", found, link))
    });
    let wheel = ("a wheel", mass.wheel, rover.side.geometry.wheel_radius);
    let wheel = ("wheel_inertia", rover.wheel_inertia, wheel);
    let mut all = body.into_iter().chain(links.concat()).chain([wheel]);
    all.find_map(beyond)
}

/// No part of a side reaches farther than from wheel to wheel and as high as the highest pin or centre, m.
fn size(robot: &Robot) -> f64 {
    let geometry = &robot.geometry;
    let pins = &geometry.pins;
    let points = [pins.p, pins.q, pins.r, pins.s, geometry.body_cg];
    let points = points.iter().chain(&geometry.axles);
    let [mut low, mut high] = [geometry.axles[0]; 2];
    for point in points {
        (low, high) = (low.inf(point), high.sup(point));
    }
    (high - low).norm() + 2.0 * geometry.wheel_radius
}

/// The key of an inertia that is too large, and why.
fn beyond((key, found, (part, mass, size)): (&'static str, f64, Part)) -> Option<Fault> {
    let most = mass * size * size;
    (found > most).then(|| {
        let message = format!(
            "{found} kg m^2 is beyond {} kg m^2, the mass of {part}, {mass} kg, times {} m squared; the unit is kg m^2: {found} kg cm^2 are {}",
            rounded(most),
            rounded(size),
            rounded(found * 1e-4),
        );
        (key, message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each inertia of robot A is possible, and is not in kg cm^2.
    #[test]
    fn centimetres_are_found() {
        let robot = Robot::default_a();
        assert_eq!(impossible(&robot), None);
        type Inertia = fn(&mut Robot) -> &mut f64;
        let change: [(&str, Inertia); 4] = [
            ("body_inertia", |r| &mut r.mass.body_inertia),
            ("wheel_inertia", |r| &mut r.mass.wheel_inertia),
            ("rotor_inertia", |r| &mut r.mass.rotor_inertia),
            ("link_inertias", |r| &mut r.mass.link_inertias[1]),
        ];
        for (key, inertia) in change {
            let mut other = robot.clone();
            *inertia(&mut other) *= 1e4;
            let (found, message) = impossible(&other).expect("too large");
            assert_eq!(found, key);
            assert!(message.contains("kg cm^2 are"), "{message}");
        }
        let mut other = robot;
        (other.mass.wheel_inertia, other.mass.rotor_inertia) = (1e-6, 1e-6);
        assert_eq!(
            impossible(&other).map(|(key, _)| key),
            Some("wheel_inertia")
        );
    }
}

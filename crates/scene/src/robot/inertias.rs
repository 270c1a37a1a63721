//! Inertias that no part of a robot can have: in another unit, such as kg cm^2.

use robhaz_keys::quantity::rounded;
use robhaz_model::{Robot, WholeRover};

/// A key, the inertia found there, mass and size of its part, and the part.
type Inertia = (&'static str, f64, f64, f64, &'static str);

/// The key under `robot.mass` of an inertia beyond the mass of its part times the square of its size, and why.
pub(crate) fn too_large(robot: &Robot) -> Option<(&'static str, String)> {
    let (mass, size) = (&robot.mass, size(robot));
    let radius = robot.geometry.wheel_radius;
    let links = mass.links.into_iter().zip(mass.link_inertias);
    let links = links.map(|(mass, inertia)| ("link_inertias", inertia, mass, size, "a link"));
    // The rotors, through their gears, resist as a mass of inertia over radius squared at the rims would: that of the
    // whole robot is far above what a motor has.
    let [body, wheel, rotor] = [
        (
            "body_inertia",
            mass.body_inertia,
            mass.body,
            size,
            "the body",
        ),
        (
            "wheel_inertia",
            mass.wheel_inertia,
            mass.wheel,
            radius,
            "a wheel",
        ),
        (
            "rotor_inertia",
            mass.rotor_inertia,
            mass.total(),
            size,
            "the robot",
        ),
    ];
    [body, wheel, rotor]
        .into_iter()
        .chain(links)
        .find_map(beyond)
}

/// The same of a key under `robot.across`.
pub(crate) fn too_large_across(rover: &WholeRover) -> Option<(&'static str, String)> {
    let mass = &rover.side.mass;
    let width = 2.0 * rover.half_tracks.into_iter().fold(0.0, f64::max);
    let size = size(&rover.side).hypot(width);
    let body = rover
        .body_inertia
        .map(|inertia| ("body_inertia", inertia, 2.0 * mass.body, size, "the body"));
    let links = rover
        .link_inertias
        .into_iter()
        .zip(mass.links)
        .flat_map(|(inertias, mass)| {
            inertias.map(|inertia| ("link_inertias", inertia, mass, size, "a link"))
        });
    let radius = rover.side.geometry.wheel_radius;
    let wheel = (
        "wheel_inertia",
        rover.wheel_inertia,
        mass.wheel,
        radius,
        "a wheel",
    );
    body.into_iter()
        .chain(links)
        .chain([wheel])
        .find_map(beyond)
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
fn beyond((key, found, mass, size, part): Inertia) -> Option<(&'static str, String)> {
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
        assert_eq!(too_large(&robot), None);
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
            let (found, message) = too_large(&other).expect("too large");
            assert_eq!(found, key);
            assert!(message.contains("kg cm^2 are"), "{message}");
        }
    }
}

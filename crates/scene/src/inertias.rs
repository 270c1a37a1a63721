//! Inertias that no part of a robot can have: in another unit, such as kg cm^2.

use robhaz_keys::quantity::rounded;
use robhaz_model::Robot;

/// The key under `robot.mass` of an inertia beyond the mass of its part times the square of its size, and why.
pub(crate) fn too_large(robot: &Robot) -> Option<(&'static str, String)> {
    let (mass, geometry) = (&robot.mass, &robot.geometry);
    let radius = geometry.wheel_radius;
    // No part reaches farther than from wheel to wheel and as high as the highest pin or centre.
    let pins = &geometry.pins;
    let points = [pins.p, pins.q, pins.r, pins.s, geometry.body_cg];
    let points = points.iter().chain(&geometry.axles);
    let [mut low, mut high] = [geometry.axles[0]; 2];
    for point in points {
        (low, high) = (low.inf(point), high.sup(point));
    }
    let size = (high - low).norm() + 2.0 * radius;
    let links = mass.links.into_iter().zip(mass.link_inertias);
    let parts = links.map(|(mass, inertia)| ("link_inertias", inertia, mass, size, "a link"));
    // The rotors, through their gears, resist as a mass of inertia over radius squared at the rims would: that of the
    // whole robot is far above what a motor has.
    let drives = [
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
    let (key, found, mass, size, part) = drives
        .into_iter()
        .chain(parts)
        .find(|(_, inertia, mass, size, _)| *inertia > mass * size * size)?;
    let most = rounded(mass * size * size);
    let message = format!(
        "{found} kg m^2 is beyond {most} kg m^2, the mass of {part}, {mass} kg, times {} m squared; the unit is kg m^2: {found} kg cm^2 are {}",
        rounded(size),
        rounded(found * 1e-4),
    );
    Some((key, message))
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

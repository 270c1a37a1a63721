//! The unknowns: masses, centres of mass and pins, with the tolerances of nominal values as their
//! prior.

use nalgebra::{SMatrix, SVector};
use robhaz_model::{Bar, Pin, Pins, Robot, Suspension, Units, Vec2};

/// Number of unknowns of the robot.
pub(crate) const PARAMETERS: usize = 21;

/// Values of the unknowns, or their errors, in the order of [`names`].
pub(crate) type Values = SVector<f64, PARAMETERS>;
/// Of the parameters, in units of their deviations.
pub(crate) type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Index of the first coordinate of a centre of mass, and of a pin.
pub(crate) const CENTRES: usize = 5;
/// Index of the mass of a wheel, of which there are three.
pub(crate) const WHEEL: usize = 4;
const PINS: usize = 13;

/// The unknowns in words, in their order: five masses, then x and y of four centres of mass and of
/// four pins.
pub(crate) fn names() -> impl Iterator<Item = String> {
    let masses =
        ["body", "link1", "link2", "link3", "a wheel"].map(|part| format!("mass of {part}"));
    let centres = Bar::ALL.map(|bar| format!("centre of {}", bar.name()));
    let pins = Pin::ALL.map(|pin| format!("pin {}", pin.name().to_uppercase()));
    let points = centres.into_iter().chain(pins);
    let coordinates = points.flat_map(|point| ["x", "y"].map(|axis| format!("{point}, {axis}")));
    masses.into_iter().chain(coordinates)
}

/// How far a robot may be from its nominal values: standard deviations of the prior. Axles and
/// wheel radius count as exact; a ruler measures them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Relative error of each mass.
    pub mass: f64,
    /// Distance of each centre of mass from its nominal place (RMS), m.
    pub centre: f64,
    /// Distance of each pin from its nominal place (RMS), m.
    pub pin: f64,
}

impl Tolerances {
    /// CAD of a robot of this size: masses to 10 %, centres of mass to 10 mm, pins to 2 mm. Cables,
    /// connectors and screws are not in its masses; plates that are bent or welded keep positions to
    /// 1 to 2 mm (ISO 2768-1, class v: 1.5 mm up to 120 mm, 2.5 mm up to 400 mm).
    pub const NOMINAL: Self = Self {
        mass: 0.10,
        centre: 0.010,
        pin: 0.002,
    };

    /// A robot as people build them, whose parts were weighed before it was put together: masses to
    /// 3 %, of robot A centres of mass to 5 mm and pins to 1 mm, in proportion to its size.
    pub fn built(robot: &Robot) -> Self {
        let size = Units::of(robot).length;
        Self {
            mass: 0.03,
            centre: 0.005 * size,
            pin: 0.001 * size,
        }
    }

    /// Relative error of a wheel's rolling radius: a ruler, wear, load.
    pub const RADIUS: f64 = 0.005;

    /// Relative error of the mass of the whole robot: its owner has put it on scales, with
    /// batteries and cables.
    pub const TOTAL: f64 = 0.01;

    /// Standard deviations of the unknowns, kg and m.
    pub(crate) fn deviations(&self, nominal: &Robot) -> Values {
        // A distance has two coordinates.
        let axis = std::f64::consts::FRAC_1_SQRT_2;
        let mass = values(nominal) * self.mass;
        let suspension = nominal.geometry.suspension;
        let (pins, bars) = (suspension.pins(), suspension.bars());
        // Link and pins that a bogie has not do not err.
        Values::from_fn(|i, _| match i {
            i if i < CENTRES => mass[i],
            i if i < PINS && !bars.contains(&Bar::ALL[(i - CENTRES) / 2]) => 0.0,
            i if i < PINS => self.centre * axis,
            i if !pins.contains(&Pin::ALL[(i - PINS) / 2]) => 0.0,
            _ => self.pin * axis,
        })
    }
}

/// The unknowns of a robot, kg and m.
pub(crate) fn values(robot: &Robot) -> Values {
    let (geometry, mass) = (&robot.geometry, &robot.mass);
    let [l1, l2, l3] = mass.links;
    let centres = Bar::ALL.map(|bar| geometry.cg(bar)).into_iter();
    let points = centres.chain(Pin::ALL.map(|pin| geometry.pins.get(pin)));
    let coordinates = points.flat_map(|p| [p.x, p.y]);
    let masses = [mass.body, l1, l2, l3, mass.wheel];
    Values::from_iterator(masses.into_iter().chain(coordinates))
}

/// The robot of the nominal values with other values of the unknowns. A part's inertia changes with
/// its mass: its radius of gyration stays.
pub(crate) fn with_values(nominal: &Robot, values: &Values) -> Robot {
    let mut robot = nominal.clone();
    let (geometry, mass) = (&mut robot.geometry, &mut robot.mass);
    let point =
        |first: usize, i: usize| Vec2::new(values[first + 2 * i], values[first + 2 * i + 1]);
    mass.body_inertia *= values[0] / mass.body;
    mass.body = values[0];
    for i in 0..3 {
        if mass.links[i] > 0.0 {
            mass.link_inertias[i] *= values[1 + i] / mass.links[i];
        }
        mass.links[i] = values[1 + i];
        geometry.link_cg[i] = point(CENTRES, 1 + i);
    }
    // A wheel module is motor, gear and disc; only the disc's share is its inertia. It stays.
    mass.wheel = values[WHEEL];
    geometry.body_cg = point(CENTRES, 0);
    let [p, q, r, s] = [0, 1, 2, 3].map(|i| point(PINS, i));
    geometry.pins = Pins { p, q, r, s };
    if let Suspension::Bogie { body } = geometry.suspension {
        geometry.make_bogie(body);
    }
    robot
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equivalence: values read from a robot give that robot again, and every value is used.
    #[test]
    fn values_are_those_of_the_robot() {
        let robot = Robot::default_a();
        let there = values(&robot);
        assert_eq!(with_values(&robot, &there), robot);
        for i in 0..PARAMETERS {
            let mut changed = there;
            changed[i] *= 1.125;
            changed[i] += 0.125;
            assert_eq!(values(&with_values(&robot, &changed)), changed);
        }
    }
}

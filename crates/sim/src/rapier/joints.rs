//! The bars as rapier's bodies, and the convergence of its iterations over the four pins.

use nalgebra::SMatrix;
use robhaz_model::{Bar, Pin, Robot, Vec2};

/// Smallest number of iterations, sufficient for the default robots: the gaps of the pins are at
/// most 80 nm. With 8 they are a fifth of that.
const FEWEST: usize = 4;
/// Largest number of iterations, a limit of computing time.
const MOST: usize = 64;
/// Share of an error that may remain after the iterations of a step: 4 iterations leave 0.503 with
/// geometry B and the masses `text`. With 4 iterations for all robots, four of 500 random robots
/// created energy; for these, 4 iterations leave 0.75 and more.
const LEFT: f64 = 0.51;

/// A bar with its wheels as point masses on their axles. The spins of the wheels are not part of
/// rapier's bodies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lump {
    /// kg
    pub mass: f64,
    /// About its own centre of mass, kg m^2.
    pub inertia: f64,
    /// Its centre of mass from the bar's own, in the nominal pose, m.
    pub centre: Vec2,
}

impl Lump {
    /// A bar and its wheels.
    pub fn new(robot: &Robot, bar: Bar) -> Self {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let (own_mass, own_inertia) = mass.of(bar);
        let own = (0..3).filter(|&i| geometry.carriers[i].bar() == bar);
        let axles: Vec<Vec2> = own.map(|i| geometry.axles[i] - geometry.cg(bar)).collect();
        let mut lump = Self {
            mass: own_mass,
            inertia: own_inertia,
            centre: Vec2::zeros(),
        };
        for axle in &axles {
            lump.mass += mass.wheel;
            lump.centre += axle * mass.wheel;
        }
        lump.centre /= lump.mass;
        lump.inertia += own_mass * lump.centre.norm_squared();
        for axle in &axles {
            lump.inertia += mass.wheel * (axle - lump.centre).norm_squared();
        }
        lump
    }
}

/// Number of iterations over the joints that a robot needs in a step.
///
/// Rapier solves the pins one after the other (block Gauss-Seidel, 2x2 blocks). Each iteration
/// multiplies the error by `-L^-1 U`, with L and U the lower and the strictly upper part of
/// `J W J'` (J: Jacobian of the gaps' rates, W: inverse masses). The spectral radius r of this
/// matrix is near 1 if a heavy bar is attached to a light one. The number n of iterations is the
/// smallest with `r^n` at most [`LEFT`], in the nominal pose. r is 0.64 (geometry A) to 0.84 (B)
/// for the default robots.
pub(super) fn iterations(robot: &Robot) -> usize {
    let radius = spectral_radius(robot);
    (FEWEST..MOST)
        .find(|n| radius.powi(i32::try_from(*n).unwrap_or(i32::MAX)) <= LEFT)
        .unwrap_or(MOST)
}

/// Spectral radius of one iteration over the pins, -.
fn spectral_radius(robot: &Robot) -> f64 {
    let geometry = &robot.geometry;
    let lumps = Bar::ALL.map(|bar| Lump::new(robot, bar));
    let mut gaps = SMatrix::<f64, 8, 12>::zeros();
    for (i, pin) in Pin::ALL.into_iter().enumerate() {
        let (receiver, giver) = pin.bars();
        for (sign, bar) in [(1.0, receiver), (-1.0, giver)] {
            let column = 3 * (bar as usize);
            let arm = geometry.pins.get(pin) - geometry.cg(bar) - lumps[bar as usize].centre;
            gaps[(2 * i, column)] = sign;
            gaps[(2 * i + 1, column + 1)] = sign;
            gaps[(2 * i, column + 2)] = -sign * arm.y;
            gaps[(2 * i + 1, column + 2)] = sign * arm.x;
        }
    }
    let mut weighted = gaps;
    for (bar, lump) in lumps.iter().enumerate() {
        let inverse = [1.0 / lump.mass, 1.0 / lump.mass, 1.0 / lump.inertia];
        for (column, inverse) in inverse.into_iter().enumerate() {
            weighted.column_mut(3 * bar + column).scale_mut(inverse);
        }
    }
    let all = weighted * gaps.transpose();
    let lower = SMatrix::<f64, 8, 8>::from_fn(|row, column| match column / 2 <= row / 2 {
        true => all[(row, column)],
        false => 0.0,
    });
    lower.lu().solve(&(lower - all)).map_or(1.0, |iteration| {
        let values = iteration.complex_eigenvalues();
        let sizes = values.iter().map(|v| v.norm_sqr().sqrt());
        sizes.fold(0.0, f64::max)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::{Geometry, MassSet};

    /// The shipped robots need 4 iterations. A light link 3 under a heavy body needs more, within
    /// the limit.
    #[test]
    fn a_light_bar_between_heavy_ones_needs_more_iterations() {
        for geometry in [Geometry::a(), Geometry::b()] {
            for mass in [MassSet::caption(), MassSet::text()] {
                let robot = Robot {
                    geometry: geometry.clone(),
                    mass,
                    ..Robot::default_a()
                };
                let radius = spectral_radius(&robot);
                assert!((0.6..0.85).contains(&radius), "{radius}");
                assert_eq!(iterations(&robot), FEWEST);
            }
        }
        let mut robot = Robot {
            geometry: Geometry::b(),
            ..Robot::default_a()
        };
        robot.mass.body *= 4.0;
        robot.mass.links[2] *= 0.4;
        robot.mass.link_inertias[2] *= 0.4;
        let found = iterations(&robot);
        assert!((6..MOST).contains(&found), "{found}");
        robot.mass.links[2] = 1e-9;
        robot.mass.link_inertias[2] = 1e-12;
        assert!(iterations(&robot) <= MOST);
    }
}

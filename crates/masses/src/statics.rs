//! Forces of a robot at rest on horizontal plates: eq. (8) with contact angles of 0.

use crate::error::{Result, WeighError};
use nalgebra::Vector4;
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::Robot;

/// Normal forces of the wheels at rest on horizontal plates, N, with links 1 and 2 turned by
/// `angles` (rad, nose up positive) from the nominal pose, and horizontal forces of the plates on
/// the wheels `horizontal` (N, forward positive).
///
/// At rest the horizontal forces sum to 0; that row of eq. (8) is then fulfilled, and three rows
/// determine three forces.
///
/// # Errors
/// [`WeighError`]: a four-bar that cannot close, forces that are not determined.
pub fn plate_forces(robot: &Robot, angles: [f64; 2], horizontal: [f64; 3]) -> Result<[f64; 3]> {
    // The rows are consistent, so that their scale, the lever of 1 m, does not matter.
    let e = equilibrium(robot, angles, 1.0)?;
    let inverse = e.least_squares().ok_or_else(WeighError::undetermined)?;
    let found = inverse.solve(&e.right_side(&horizontal));
    let is_finite = found.iter().all(|n| n.is_finite());
    is_finite
        .then_some(found)
        .ok_or_else(WeighError::undetermined)
}

/// What is missing to the balance of eq. (8) at rest on plates with these normal forces (N):
/// `F' - H_N N`, N. Moment rows are over `lever`, m.
pub(crate) fn imbalance(
    robot: &Robot,
    angles: [f64; 2],
    forces: &[f64; 3],
    lever: f64,
) -> Result<Vector4<f64>> {
    let e = equilibrium(robot, angles, lever)?;
    let carried = e.h_n.iter().zip(forces);
    Ok(e.f - carried.map(|(column, n)| column * *n).sum::<Vector4<f64>>())
}

/// Eq. (8) at rest on level plates; moment rows over `lever`, m.
fn equilibrium(robot: &Robot, angles: [f64; 2], lever: f64) -> Result<Equilibrium> {
    let geometry = &robot.geometry;
    let arms = Arms::new(geometry, angles[0], angles[1])?;
    let loads = Loads::at_rest(&robot.mass.true_points());
    let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
    Equilibrium::new(&arms, carriers, radius, &loads, &[0.0; 3], lever)
        .ok_or_else(WeighError::undetermined)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::{GRAVITY, Geometry, MassSet, Posture, Vec2, cross};

    /// Equivalence: on level ground in the nominal pose the forces are those that virtual work
    /// gives.
    #[test]
    fn level_ground_is_the_stance() {
        for geometry in [Geometry::a(), Geometry::b()] {
            let mass = MassSet::caption();
            let robot = Robot {
                geometry,
                mass,
                gravity: GRAVITY,
            };
            let found = plate_forces(&robot, [0.0; 2], [0.0; 3]).expect("determined");
            let expected = robot.static_loads().expect("determined");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }

    /// Newton and Euler for the whole robot on blocks: forces carry the weight, and their moments
    /// about Q balance it. Horizontal forces act at the rims' lowest points.
    #[test]
    fn forces_balance_the_weight_in_any_posture() {
        let robot = Robot::default_a();
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        for angles in [[0.2, -0.1], [-0.2, 0.15], [0.3, 0.3]] {
            let horizontal = [3.0, -1.0, -2.0];
            let found = plate_forces(&robot, angles, horizontal).expect("determined");
            let posture = Posture::close(geometry, angles[0], angles[1]).expect("closes");
            assert!((found.iter().sum::<f64>() - mass.total() * GRAVITY).abs() < 1e-9);
            let mut moment = 0.0;
            for i in 0..3 {
                let axle = posture.axle_from_q(geometry, i);
                let rim = axle - Vec2::new(0.0, geometry.wheel_radius);
                moment += cross(rim, Vec2::new(horizontal[i], found[i]));
                moment -= axle.x * mass.wheel * GRAVITY;
            }
            for bar in robhaz_model::Bar::ALL {
                moment -= posture.cg_from_q(geometry, bar).x * mass.of(bar).0 * GRAVITY;
            }
            assert!(moment.abs() < 1e-9, "{moment}");
        }
    }
}

//! Equation (8) in the estimator, and the needed friction in closed form.

#[path = "../../../../estimator/tests/full_system/derivation.rs"]
#[expect(dead_code, reason = "the least squares are the estimator's")]
mod derivation;
mod vertex;

use self::derivation::{BlockForm, FullSystem, ReducedSystem};
use self::vertex::vertex;
use super::*;
use proptest::prelude::*;
use robhaz_model::Robot;

/// A posture of robot A with one contact a wheel at given angles, and no limit of the torque.
fn balance(theta: [f64; 2], angles: &[f64; 3]) -> (Balance, ReducedSystem) {
    let robot = Robot::default_a();
    let (geometry, masses) = (&robot.geometry, robot.mass.true_points());
    let posture = Posture::close(geometry, theta[0], theta[1]).expect("inside the stops");
    let contact = |wheel: usize| {
        let tangent = Vec2::new(angles[wheel].cos(), angles[wheel].sin());
        let normal = Vec2::new(-tangent.y, tangent.x);
        GroundContact {
            wheel,
            point: posture.axle_from_q(geometry, wheel) - normal * geometry.wheel_radius,
            tangent,
            mu: 0.8,
        }
    };
    let contacts = [0, 1, 2].map(contact).to_vec();
    let q = Vec2::zeros();
    let limits = Tractions {
        braking: 1e4,
        driving: 1e4,
    };
    let balance = Balance::new(&robot, &posture, q, contacts, limits).expect("inside the stops");
    let block = BlockForm::new(&FullSystem::new(geometry, &masses, &posture, angles));
    let x_u = block.pin_forces().expect("regular");
    (balance, ReducedSystem::new(&block, &x_u))
}

/// The needed friction in closed form, where that is proven.
fn at_vertex(balance: &Balance) -> Option<Distribution> {
    let columns: &[[Vector4<f64>; 2]; 3] = balance.columns.as_slice().try_into().ok()?;
    let signs = [
        [1.0; 3],
        [-1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, -1.0],
    ];
    let mut tries = signs
        .iter()
        .filter_map(|s| vertex(columns, &balance.right, *s, 0.5));
    let found = tries.next()?;
    Some(balance.distribution(found.m, &found.normal, &found.traction))
}

proptest! {
    /// Equivalence: with one contact a wheel, columns and right side are those of eq. (8) in the
    /// estimator, to rounding.
    #[test]
    fn columns_are_those_of_eq_8(
        t1 in -0.3_f64..0.3, t2 in -0.3_f64..0.3, a in -0.6_f64..0.6, b in -0.6_f64..0.6, c in -0.6_f64..0.6,
    ) {
        let (balance, reduced) = balance([t1, t2], &[a, b, c]);
        for wheel in 0..3 {
            for (kind, column) in [2 * wheel + 1, 2 * wheel].into_iter().enumerate() {
                for row in 0..4 {
                    let scale = if row < 2 { 1.0 } else { 0.1 };
                    let found = scale * balance.columns[wheel][kind][row];
                    prop_assert!((found - reduced.h[(row, column)]).abs() < 1e-12);
                }
            }
        }
        prop_assert!((balance.right[0] - reduced.f[0]).abs() < 1e-12);
        prop_assert!((balance.right[1] - reduced.f[1]).abs() < 1e-9);
    }

    /// Equivalence: the closed form and the linear programs give the same needed friction; 1e-6 is
    /// the tolerance of the solver, 1e-7 N, over a load of 0.1 N. Its forces meet the condition and
    /// eq. (8).
    #[test]
    fn closed_form_and_programs_agree(
        t1 in -0.3_f64..0.3, t2 in -0.3_f64..0.3, a in -0.6_f64..0.6, b in -0.6_f64..0.6, c in -0.6_f64..0.6,
    ) {
        let (balance, _) = balance([t1, t2], &[a, b, c]);
        let programs = balance.least_excess(false, 0.5);
        if let Some(found) = at_vertex(&balance) {
            let programs = programs.expect("the closed form has a solution");
            prop_assert!((found.excess - programs.excess).abs() < 1e-6, "{found:?} {programs:?}");
            let mut sum = -balance.right;
            for i in 0..3 {
                let (n, t) = (found.normal_force[i], found.traction[i]);
                prop_assert!(t.abs() <= found.excess * n * (1.0 + 1e-9));
                sum += balance.columns[i][0] * n + balance.columns[i][1] * t;
            }
            prop_assert!(sum.amax() < 1e-8);
        }
    }
}

/// Sensitivity: the closed form is found in most postures, so the test above compares something.
#[test]
fn the_closed_form_is_the_usual_case() {
    let mut found = 0;
    for k in 0..100 {
        let angle = |j: f64| (f64::from(k) * 0.37 + j).sin() * 0.4;
        let (balance, _) = balance(
            [angle(1.0) * 0.5, angle(2.0) * 0.5],
            &[angle(3.0), angle(4.0), angle(5.0)],
        );
        found += u32::from(at_vertex(&balance).is_some());
    }
    assert!(found > 70, "{found}");
}

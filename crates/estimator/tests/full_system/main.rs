//! The paper's equations one after the other: eq. (1), its blocks (4) to (7), eq. (8), and least
//! squares; and the same eq. (8) as the estimators write it.
#![expect(clippy::expect_used, reason = "tests may stop at the first surprise")]

mod derivation;

use derivation::{BlockForm, FullSystem, ReducedSystem, Singular};
use nalgebra::{SMatrix, SVector, Vector4};
use proptest::prelude::*;
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::{GRAVITY, Geometry, MassSet, PointMasses, Posture, Robot, Vec2};

const NOMINAL: Posture = Posture {
    body: 0.0,
    links: [0.0; 3],
};

fn geometry(is_b: bool) -> Geometry {
    if is_b { Geometry::b() } else { Geometry::a() }
}

fn posture(geometry: &Geometry, theta1: f64, theta2: f64) -> Posture {
    Posture::close(geometry, theta1, theta2).expect("inside the stops the four-bar closes")
}

fn systems(
    geometry: &Geometry,
    masses: &PointMasses,
    posture: &Posture,
    contact_angle: &[f64; 3],
) -> (FullSystem, BlockForm, ReducedSystem) {
    let full = FullSystem::new(geometry, masses, posture, contact_angle);
    let block = BlockForm::new(&full);
    let x_u = block.pin_forces().expect("C is regular inside the stops");
    let reduced = ReducedSystem::new(&block, &x_u);
    (full, block, reduced)
}

/// Eq. (8) as the estimators write it, moments in N m as in the paper.
fn direct(
    geometry: &Geometry,
    posture: &Posture,
    loads: &Loads,
    contact_angle: &[f64; 3],
) -> Equilibrium {
    let [theta1, theta2, _] = posture.links;
    let arms = Arms::new(geometry, theta1, theta2).expect("inside the stops");
    let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
    Equilibrium::new(&arms, carriers, radius, loads, contact_angle, 1.0)
        .expect("C is regular inside the stops")
}

/// Links inside the stops, as `[theta1, theta2]`, rad.
fn angles() -> impl Strategy<Value = [f64; 2]> {
    (-0.4_f64..0.4, -0.6_f64..0.5).prop_map(|(theta2, opening)| [theta2 + opening, theta2])
}

fn masses() -> impl Strategy<Value = PointMasses> {
    let sets = [
        MassSet::caption().true_points(),
        MassSet::text().lumped_to_wheels(),
        MassSet::caption().lumped_to_body(),
    ];
    (0..3_usize).prop_map(move |i| sets[i])
}

/// The worked posture: all steps in their order, printed; the least squares of both forms of eq.
/// (8) agree to rounding.
///
/// `cargo test --release -p robhaz-estimator --test full_system worked -- --nocapture`
#[test]
fn worked_posture() {
    let robot = Robot::default_a();
    let (geometry, masses) = (&robot.geometry, robot.mass.true_points());
    let posture = NOMINAL;
    // The front wheel stands on a slope of 0.1 rad; tractions in N.
    let (contact_angle, traction) = ([0.1, 0.0, 0.0], [4.0, 1.0, 1.0]);

    let full = FullSystem::new(geometry, &masses, &posture, &contact_angle);
    let (rows, columns) = full.g.shape();
    println!("eq. (1): {rows} equations for {columns} forces");

    let block = BlockForm::new(&full);
    let pins = block.pin_forces().expect("regular");
    for (i, pin) in ["P", "R", "S"].iter().enumerate() {
        println!(
            "eq. (6): {pin} = ({:.2}, {:.2}) N",
            pins[2 * i],
            pins[2 * i + 1]
        );
    }

    let reduced = ReducedSystem::new(&block, &pins);
    let solution = reduced.normal_forces(&traction).expect("regular");
    let [n1, n2, n3] = solution.normal_force;
    println!("eq. (8): N = {n1:.2}, {n2:.2}, {n3:.2} N");
    let [x, y, m1, m2] = solution.residual;
    println!("residual: {x:.2} N, {y:.2} N, {m1:.3} N m, {m2:.3} N m");

    let loads = Loads::at_rest(&masses);
    let direct = direct(geometry, &posture, &loads, &contact_angle);
    let inverse = direct.least_squares().expect("regular");
    let normal = inverse.solve(&direct.right_side(&traction));
    for (i, (n, expected)) in normal.iter().zip(solution.normal_force).enumerate() {
        println!(
            "wheel {}: N differs by {:.0e} N",
            i + 1,
            (n - expected).abs()
        );
        assert!((n - expected).abs() < 1e-9);
    }
}

/// Closed form: static wheel loads on level ground without traction (derived by hand for both
/// geometries).
#[test]
fn static_loads_on_level_ground() {
    for (geometry, expected) in [
        (Geometry::a(), [43.58, 48.05, 45.71]),
        (Geometry::b(), [46.21, 45.65, 45.48]),
    ] {
        let masses = MassSet::caption().true_points();
        let (_, _, reduced) = systems(&geometry, &masses, &NOMINAL, &[0.0; 3]);
        let found = reduced.normal_forces(&[0.0; 3]).expect("regular");
        for (n, e) in found.normal_force.iter().zip(expected) {
            // Expected values are stated to 0.01 N.
            assert!((n - e).abs() < 0.006, "{:?}", found.normal_force);
        }
        // No horizontal force: the redundant row is met exactly.
        assert!(found.residual.iter().all(|r| r.abs() < 1e-12));
    }
}

/// The block of zeros that eq. (4) rests on.
#[test]
fn wheels_and_q_do_not_touch_link3_and_body() {
    let robot = Robot::default_a();
    let (full, _, _) = systems(
        &robot.geometry,
        &robot.mass.true_points(),
        &posture(&robot.geometry, 0.2, -0.1),
        &[0.3, -0.2, 0.1],
    );
    assert!(full.g.fixed_view::<6, 8>(6, 0).norm() == 0.0);
}

proptest! {
    /// Equivalence of two formulations: eq. (8) written directly is the one that eqs. (1) and
    /// (4) to (7) derive; H, F', pin forces, N, residual and Q. 1e-10 of the forces: a hundred
    /// times the rounding of the 6x6 solve of eq. (6).
    #[test]
    fn direct_and_derived_equations_agree(
        theta in angles(), slopes in prop::array::uniform3(-0.5_f64..0.5), masses in masses(), t in prop::array::uniform3(-20.0_f64..20.0), is_b in any::<bool>(),
    ) {
        let geometry = geometry(is_b);
        let posture = posture(&geometry, theta[0], theta[1]);
        let (_, block, reduced) = systems(&geometry, &masses, &posture, &slopes);
        let x_u = block.pin_forces().expect("regular");
        let loads = Loads::at_rest(&masses);
        let found = direct(&geometry, &posture, &loads, &slopes);

        for i in 0..3 {
            prop_assert!((found.h_t[i] - reduced.h.column(2 * i)).norm() < 1e-12);
            prop_assert!((found.h_n[i] - reduced.h.column(2 * i + 1)).norm() < 1e-12);
            let pin = Vec2::new(x_u[2 * i], x_u[2 * i + 1]);
            prop_assert!((found.pins[i] - pin).norm() < 1e-10 * (1.0 + x_u.norm()), "pin {i}");
        }
        prop_assert!((found.f - reduced.f).norm() < 1e-10 * reduced.f.norm());

        let expected = reduced.normal_forces(&t).expect("regular");
        let right = found.right_side(&t);
        let normal = found.least_squares().expect("regular").solve(&right);
        let mut residual = right;
        for i in 0..3 {
            residual -= found.h_n[i] * normal[i];
            prop_assert!((normal[i] - expected.normal_force[i]).abs() < 1e-9, "{normal:?} {expected:?}");
        }
        prop_assert!((residual - Vector4::from(expected.residual)).norm() < 1e-9);

        // Q from the force rows of link 1 in eq. (7).
        let mut q = Vec2::new(block.right_side(&x_u)[0], block.right_side(&x_u)[1]);
        for i in 0..3 {
            let x = Vec2::new(block.a[(0, 2 * i)], block.a[(1, 2 * i)]) * t[i];
            let y = Vec2::new(block.a[(0, 2 * i + 1)], block.a[(1, 2 * i + 1)]) * normal[i];
            q -= x + y;
        }
        prop_assert!((found.force_in_q(&loads, &geometry.carriers, &normal, &t) - q).norm() < 1e-9);
    }

    /// Equivalence of the three forms: with two tractions given, eq. (1), eqs. (5) to (7) and
    /// eq. (8) are square systems, and must give the same forces. 1e-9 relative to the load: a
    /// hundred times the rounding of a 12x12 solve at a condition of 1e3.
    #[test]
    fn full_block_and_reduced_systems_agree(
        theta1 in -0.3_f64..0.3, theta2 in -0.3_f64..0.3,
        g1 in -0.5_f64..0.5, g2 in -0.5_f64..0.5, g3 in -0.5_f64..0.5,
        t1 in -30.0_f64..30.0, t2 in -30.0_f64..30.0, is_b in any::<bool>(),
    ) {
        let geometry = geometry(is_b);
        let masses = MassSet::caption().true_points();
        let posture = posture(&geometry, theta1, theta2);
        let (full, block, reduced) = systems(&geometry, &masses, &posture, &[g1, g2, g3]);
        // The third traction is an unknown beside the three N.
        let given = [(0_usize, t1), (2, t2)];

        let mut right = full.f;
        let mut square = SMatrix::<f64, 12, 12>::zeros();
        for (column, value) in given { right -= full.g.column(column) * value; }
        for (to, from) in [1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13].into_iter().enumerate() {
            square.set_column(to, &full.g.column(from));
        }
        let Some(by_full) = square.lu().solve(&right) else { return Ok(()) };

        let x_u = block.pin_forces().expect("regular");
        let mut right = block.right_side(&x_u);
        let mut square = SMatrix::<f64, 6, 6>::zeros();
        for (column, value) in given { right -= block.a.column(column) * value; }
        for (to, from) in [1, 3, 4, 5, 6, 7].into_iter().enumerate() {
            square.set_column(to, &block.a.column(from));
        }
        let by_block = square.lu().solve(&right).expect("as regular as the full one");

        let mut right = reduced.f;
        let mut square = SMatrix::<f64, 4, 4>::zeros();
        for (column, value) in given { right -= reduced.h.column(column) * value; }
        for (to, from) in [1, 3, 4, 5].into_iter().enumerate() {
            square.set_column(to, &reduced.h.column(from));
        }
        let by_reduced = square.lu().solve(&right).expect("as regular as the full one");

        let scale = 1.0 + by_full.norm();
        for i in 0..4 {
            prop_assert!((by_full[i] - by_reduced[i]).abs() < 1e-9 * scale);
        }
        for i in 0..6 {
            prop_assert!((by_full[i] - by_block[i]).abs() < 1e-9 * scale);
            prop_assert!((by_full[6 + i] - x_u[i]).abs() < 1e-9 * scale);
        }
    }

    /// Property: with consistent tractions (those of an exact equilibrium) least squares
    /// returns the exact N and leaves no residual, and the ground carries the whole weight.
    #[test]
    fn exact_equilibrium_is_recovered(
        theta1 in -0.3_f64..0.3, theta2 in -0.3_f64..0.3,
        g1 in -0.4_f64..0.4, g2 in -0.4_f64..0.4, g3 in -0.4_f64..0.4, t1 in -10.0_f64..10.0, t2 in -10.0_f64..10.0,
    ) {
        let robot = Robot::default_a();
        let posture = posture(&robot.geometry, theta1, theta2);
        let angles = [g1, g2, g3];
        let (_, _, reduced) = systems(&robot.geometry, &robot.mass.true_points(), &posture, &angles);
        let mut square = SMatrix::<f64, 4, 4>::zeros();
        for (to, from) in [1, 3, 5, 4].into_iter().enumerate() {
            square.set_column(to, &reduced.h.column(from));
        }
        let right = reduced.f - reduced.h.column(0) * t1 - reduced.h.column(2) * t2;
        let Some(exact) = square.lu().solve(&right) else { return Ok(()) };
        let tractions = [t1, t2, exact[3]];
        let found = reduced.normal_forces(&tractions).expect("regular");
        let scale = 1.0 + exact.norm();
        let mut ground = Vec2::zeros();
        for i in 0..3 {
            prop_assert!((found.normal_force[i] - exact[i]).abs() < 1e-9 * scale);
            let (sin, cos) = libm::sincos(angles[i]);
            ground += Vec2::new(cos, sin) * tractions[i] + Vec2::new(-sin, cos) * exact[i];
        }
        prop_assert!(found.residual.iter().all(|r| r.abs() < 1e-9 * scale));
        prop_assert!((ground - Vec2::new(0.0, 14.0 * GRAVITY)).norm() < 1e-9 * scale);
    }

    /// Fig. 7, Fig. 8 and the true masses weigh the same: on level ground the sum of N is the
    /// weight for each.
    #[test]
    fn lumping_keeps_the_weight(theta1 in -0.2_f64..0.2, theta2 in -0.2_f64..0.2) {
        let robot = Robot::default_a();
        let posture = posture(&robot.geometry, theta1, theta2);
        for masses in [robot.mass.true_points(), robot.mass.lumped_to_body(), robot.mass.lumped_to_wheels()] {
            let (_, _, reduced) = systems(&robot.geometry, &masses, &posture, &[0.0; 3]);
            let found = reduced.normal_forces(&[0.0; 3]).expect("regular");
            prop_assert!((found.normal_force.iter().sum::<f64>() - 14.0 * GRAVITY).abs() < 1e-9);
        }
    }
}

#[test]
fn a_straight_line_through_p_r_s_is_refused() {
    let mut geometry = Geometry::a();
    geometry.pins.p = Vec2::new(geometry.pins.s.x, 0.5);
    let full = FullSystem::new(
        &geometry,
        &MassSet::caption().true_points(),
        &NOMINAL,
        &[0.0; 3],
    );
    assert_eq!(
        BlockForm::new(&full).pin_forces(),
        Err::<SVector<f64, 6>, _>(Singular { matrix: "C" })
    );
}

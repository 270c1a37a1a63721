//! Statics of a whole rover: closed forms, symmetry, the planar statics, and the truth of another
//! simulator.

#![allow(
    clippy::expect_used,
    clippy::needless_range_loop,
    reason = "a test stops at the first surprise; one index for several arrays"
)]

mod drives;
mod properties;
mod recorded;
mod rolling;
mod rover;
mod truth;

use nalgebra::{Rotation3, SMatrix, SVector, Vector4};
use proptest::prelude::*;
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::statics::{Arms, Equilibrium, LinkageMotion, Loads};
use robhaz_estimator::whole::{
    JointMotion, Joints, Link, Rows, Vec3, WholeEquilibrium, WholeError, WholeEstimate,
    WholeEstimator, WholeMotion, WholePosture,
};
use robhaz_model::{Carrier, Coupling, GRAVITY, Robot, Vec2, WholeRover};
use rover::{equilibrium, level_frame, on_a_plane, open_source_rover, triple_bogie, typical};

/// Shares of a unit load at the rocker's pivot among the wheels of a side, by moments about Q and
/// about the rear axle.
fn shares(rover: &WholeRover) -> [f64; 3] {
    let [x1, x2, x3] = rover.side.geometry.axles.map(|axle| axle.x);
    let x_q = rover.side.geometry.pins.q.x;
    let at_q = (rover.pivot.x - x3) / (x_q - x3);
    [
        at_q * (x_q - x2) / (x1 - x2),
        at_q * (x1 - x_q) / (x1 - x2),
        1.0 - at_q,
    ]
}

/// Mass of the rover, kg, and height of its centre of mass above the ground, m, in the nominal pose.
fn mass_and_height(rover: &WholeRover) -> (f64, f64) {
    let (g, m) = (&rover.side.geometry, &rover.side.mass);
    let parts = [
        (m.body, g.body_cg.y),
        (m.links[0], g.link_cg[0].y),
        (m.links[1], g.link_cg[1].y),
        (3.0 * m.wheel, g.wheel_radius),
    ];
    let mass: f64 = parts.iter().map(|p| p.0).sum();
    (
        2.0 * mass,
        parts.iter().map(|p| p.0 * p.1).sum::<f64>() / mass,
    )
}

/// Equivalence: the inclination along a steered wheel is that of its heading, turned by the body's roll and then by
/// its pitch.
#[test]
fn a_steered_wheel_climbs_a_cross_slope() {
    let (inclination, roll) = (0.2_f64, 0.15_f64);
    let steering = [0.4_f64, 0.0, -0.4, 0.3, 1.2, -0.3];
    let joints = Joints {
        steering,
        ..Joints::default()
    };
    let turned = Rotation3::from_axis_angle(&Vec3::y_axis(), -inclination)
        * Rotation3::from_axis_angle(&Vec3::x_axis(), roll);
    let found = joints.inclinations([inclination, roll]);
    for (found, angle) in found.into_iter().zip(steering) {
        let heading = turned * Vec3::new(angle.cos(), angle.sin(), 0.0);
        // Rounding.
        assert!((found - heading.z.asin()).abs() < 1e-12, "{found}");
    }
}

/// Closed form: what is stated for a payload is what it does, at rest on level ground: its part of the covariance
/// of N is `d d'`, `d` the difference of N to a rover whose body is heavier by it. Rounding.
#[test]
fn a_payload_is_stated() {
    const PAYLOAD: f64 = 1.5;
    for rover in [open_source_rover(), triple_bogie(0.2)] {
        let at_rest = |rover: &WholeRover, payload: f64| {
            let mut settings = EstimatorSettings::kalman();
            settings.budget.payload = payload;
            let mut estimator = WholeEstimator::new(rover, settings, [1e-3; 2]).expect("a rover");
            estimator.update(&level_frame(0.0)).expect("an estimate")
        };
        let mut heavier = rover.clone();
        heavier.side.mass.body += 0.5 * PAYLOAD;
        let (nominal, stated) = (at_rest(&rover, 0.0), at_rest(&rover, PAYLOAD));
        let found = at_rest(&heavier, 0.0).normal_force;
        let moved = SVector::from(found) - SVector::from(nominal.normal_force);
        let covariance =
            |of: &WholeEstimate| SMatrix::<f64, 6, 6>::from_fn(|i, j| of.covariance[i][j]);
        let added = covariance(&stated) - covariance(&nominal);
        let error = (added - moved * moved.transpose()).amax();
        assert!(error < 1e-6 * added.amax(), "{error} {added}");
        assert!((moved.sum() - PAYLOAD * GRAVITY).abs() < 0.01, "{moved}");
    }
}

/// Closed form: on level ground no other row tells how the wheels of a bogie share their load, nor what a coupling does, so
/// that what is stated of N for the torque of an end stop is what such a torque does. Within a thousandth: the rows weigh differently.
#[test]
fn what_an_end_stop_holds_is_stated() {
    const TORQUE: f64 = 5.0;
    let rovers = [open_source_rover(), triple_bogie(0.2)];
    for (rover, joint) in rovers.iter().flat_map(|rover| [(rover, 0), (rover, 1)]) {
        let level = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
        let solved = |held: f64, stated: f64| {
            let mut rows = equilibrium(rover, &Joints::default(), &level, &[0.0; 6]);
            rows.stop_torque[joint] = stated;
            rows.f[WholeEquilibrium::COUPLING + joint] += held / rows.lever;
            rows.solve(&[0.0; 6], &typical()).expect("determined")
        };
        let (free, stated) = (solved(0.0, 0.0), solved(0.0, TORQUE));
        let moved = SVector::from(solved(TORQUE, TORQUE).normal) - SVector::from(stated.normal);
        let added = stated.covariance - free.covariance;
        let error = (added - moved * moved.transpose()).amax();
        assert!(moved.amax() > 1.0 && error < 1e-3 * added.amax(), "{error}");
    }
}

/// Closed form: what an error of a rear bogie's rate does to the axial forces is their change by that rate. It is stated: of
/// the rear wheels more than of the others. A rover with a differential has none. Cubic terms of a difference.
#[test]
fn an_error_of_a_rear_bogies_rate_is_stated() {
    const ERROR: f64 = 1e-4;
    let slid = |rover: &WholeRover, rate: f64, error: f64| {
        let mut motion = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
        motion.coupling.rate = rate;
        let mut rows = equilibrium(rover, &Joints::default(), &motion, &[0.0; 6]);
        rows.slide(&motion, 0.2, &[0.012; 6], error);
        rows
    };
    let rover = triple_bogie(0.2);
    for rate in [0.0, 0.03, -0.05] {
        let [more, less] = [ERROR, -ERROR].map(|error| slid(&rover, rate + error, 0.0).sliding);
        let stated = slid(&rover, rate, ERROR).sliding_error;
        for i in 0..6 {
            let expected = 0.5 * (more[i] - less[i]);
            assert!((stated[i] - expected).abs() < 1e-8, "{rate} {i}");
        }
        let sigmas = |error: f64| {
            let found = slid(&rover, rate, error).solve(&[0.0; 6], &typical());
            let found = found.expect("determined");
            [0, 2].map(|i| found.sigma_normal(i))
        };
        let ([front, rear], [front_more, rear_more]) = (sigmas(0.0), sigmas(0.02));
        assert!(rear_more - rear > front_more - front && front_more > front);
    }
    let without = slid(&open_source_rover(), 0.03, 0.02).sliding_error;
    assert!(without.iter().all(|error| error.abs() <= 0.0));
}

/// Equivalence: the part of a side's weight that moves on a cross slope, and by a body whose centre of mass is aside,
/// is that of the nine rows, for a rover whose tracks are one. The axial forces of wheels in one line are in the planes of the tracks. Rounding.
#[test]
fn the_weight_that_a_cross_slope_moves_is_that_of_the_rows() {
    for (height, roll) in [(0.0, 0.05_f64), (0.2, -0.1)] {
        let mut rover = open_source_rover();
        rover.half_tracks = [0.2; 3];
        rover.side.geometry.body_cg.y += height;
        let found = on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, roll)).normal;
        let [left, right] = [0, 3].map(|k| found[k..k + 3].iter().sum::<f64>());
        let weight = 3.0 * rover.mean_wheel_load() * roll.cos();
        let moved = rover.load_shift().height_over_half_track * roll.tan() * weight;
        assert!(
            (right - left - 2.0 * moved).abs() < 1e-9,
            "{left} {right} {moved}"
        );
        rover.body_place = 0.03;
        let found = on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, 0.0)).normal;
        let [left, right] = [0, 3].map(|k| found[k..k + 3].iter().sum::<f64>());
        let moved = rover.load_shift().off_centre * 3.0 * rover.mean_wheel_load();
        assert!(
            (left - right - 2.0 * moved).abs() < 1e-9,
            "{left} {right} {moved}"
        );
    }
}

/// What a cross slope moves of a triple bogie acts where the rows of both sides have it: between pin Q and the rear wheel.
/// Within a tenth of the wheelbase: how the axial forces share, the rows say by their weights.
#[test]
fn a_cross_slope_moves_load_of_a_triple_bogie_between_q_and_the_rear_wheel() {
    let rover = triple_bogie(0.2);
    let geometry = &rover.side.geometry;
    let normal = |roll: f64| on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, roll)).normal;
    let (level, inclined) = (normal(0.0), normal(0.1));
    let moved = [0, 1, 2].map(|i| level[i] * 0.1_f64.cos() - inclined[i]);
    let moment = (moved.iter().zip(&geometry.axles)).map(|(n, axle)| n * axle.x);
    let place = moment.sum::<f64>() / moved.iter().sum::<f64>();
    let expected = rover.load_shift().share_at.expect("of a rover").x;
    let wheelbase = geometry.axles[0].x - geometry.axles[2].x;
    assert!(expected < geometry.pins.q.x - 0.05 * wheelbase);
    assert!(
        (place - expected).abs() < 0.1 * wheelbase,
        "{place} {expected}"
    );
}

fn largest_difference(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// Closed form at rest on a cross slope phi with the left side up and the centre of mass y_c to the
/// left: `N_i = N_i0 cos phi -+ nu_i D` with `D = W (h sin phi - y_c cos phi)/(2 sum nu_i |y_i|)`.
/// A lateral acceleration is a turned gravity: `phi = atan(a_y/g)`, `W = m sqrt(g^2 + a_y^2)`. N is
/// 10 to 40 N: 1e-9 N leaves four digits for rounding in a solution of condition 1e4.
#[test]
fn loads_on_a_cross_slope_are_the_closed_form() {
    let level = open_source_rover();
    let level_loads = level.side.static_loads().expect("determined");
    let nu = shares(&level);
    let (mass, height) = mass_and_height(&level);
    let base: f64 = (0..3).map(|i| 2.0 * nu[i] * level.half_tracks[i]).sum();
    let expected = |phi: f64, y_c: f64, weight: f64| {
        let d = weight * (height * phi.sin() - y_c * phi.cos()) / base;
        core::array::from_fn::<f64, 6, _>(|i| {
            let side = if i < 3 { -1.0 } else { 1.0 };
            let straight = level_loads[i % 3] * phi.cos() * weight / (mass * GRAVITY);
            straight + side * nu[i % 3] * d
        })
    };
    for (degrees, y_c) in [
        (0.0, 0.0),
        (0.0, 0.01),
        (5.0, 0.0),
        (10.0, 0.0),
        (15.0, 0.005),
        (-12.0, 0.02),
    ] {
        let phi = f64::to_radians(degrees);
        let mut rover = level.clone();
        rover.body_place = y_c * mass / (2.0 * rover.side.mass.body);
        let found = on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, phi));
        let error = largest_difference(&found.normal, &expected(phi, y_c, mass * GRAVITY));
        assert!(error < 1e-9, "{degrees} deg, y_c {y_c} m: {error:e} N");
        assert!((found.axial - phi.tan()).abs() < 1e-9, "{}", found.axial);
        assert!(found.misfit < 1e-12, "{}", found.misfit);
    }
    let turning = WholeMotion {
        specific_force: Vec3::new(0.0, 1.7, GRAVITY),
        ..WholeMotion::default()
    };
    let weight = mass * f64::hypot(1.7, GRAVITY);
    let expected_turning = expected(f64::atan2(1.7, GRAVITY), 0.0, weight);
    let found = on_a_plane(&level, &turning);
    assert!(largest_difference(&found.normal, &expected_turning) < 1e-9);

    // Figures worked out apart from this code, to their digits.
    let at_ten = on_a_plane(
        &level,
        &WholeMotion::at_rest(GRAVITY, 0.0, 10_f64.to_radians()),
    );
    let known = [15.8275, 20.8107, 16.2938, 20.0988, 28.7239, 20.9395];
    assert!(
        largest_difference(&at_ten.normal, &known) < 6e-5,
        "{:?}",
        at_ten.normal
    );
    assert!((base - 0.43533).abs() < 6e-6 && (height - 0.16933).abs() < 6e-6);
}

/// Closed form of a triple bogie at rest on a cross slope: the rear pair balances about its hinge
/// alone, and the other wheels share by their arms about Q what is left of the roll moment. With
/// the hinge at ground height the rear wheels shift by the weight of the rear bogie and its wheels
/// alone: where these weigh nothing, not at all.
#[test]
fn a_rear_bogie_shifts_by_its_own_moment_alone() {
    let phi = 5_f64.to_radians();
    for (hinge, own_weight) in [(0.0, 1.0), (0.0, 0.0), (0.11, 1.0)] {
        let mut rover = triple_bogie(hinge);
        rover.side.mass.links[1] *= own_weight;
        rover.side.mass.wheel *= own_weight;
        let (g, m) = (rover.side.geometry.clone(), rover.side.mass.clone());
        let (mass, height) = mass_and_height(&rover);
        let b = rover.half_tracks[0];
        let level = on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, 0.0));
        let found = on_a_plane(&rover, &WholeMotion::at_rest(GRAVITY, 0.0, phi));
        // Axial forces are N tan phi, at ground level.
        let own = 2.0
            * GRAVITY
            * (m.links[1] * (g.link_cg[1].y - hinge) + m.wheel * (g.wheel_radius - hinge));
        let rear_axial = 2.0 * level.normal[2] * phi.sin();
        let rear = (own * phi.sin() + rear_axial * hinge) / (2.0 * b);
        let all = mass * GRAVITY * height * phi.sin() / (2.0 * b);
        let [front_arm, middle_arm] = [g.axles[0].x - g.pins.q.x, g.pins.q.x - g.axles[1].x];
        let front = (all - rear) * middle_arm / (front_arm + middle_arm);
        let middle = (all - rear) * front_arm / (front_arm + middle_arm);
        for (wheel, shift) in [front, middle, rear].into_iter().enumerate() {
            let straight = level.normal[wheel] * phi.cos();
            let [left, right] = [found.normal[wheel], found.normal[wheel + 3]];
            assert!(
                (left - (straight - shift)).abs() < 1e-9,
                "hinge {hinge}, wheel {wheel}: {left} {straight} {shift}"
            );
            assert!(
                (right - (straight + shift)).abs() < 1e-9,
                "hinge {hinge}, wheel {wheel}: {right}"
            );
        }
        if own_weight == 0.0 {
            assert!((found.normal[2] - found.normal[5]).abs() < 1e-9);
            assert!((found.normal[3] - found.normal[0]) / level.normal[0] > 0.1);
        }
    }
}

/// All nine rows have rank 6 for N on level ground; without the coupling's row N is undetermined.
#[test]
fn the_coupling_makes_the_forces_determined() {
    for rover in [open_source_rover(), triple_bogie(0.1)] {
        let level = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
        let found = equilibrium(&rover, &Joints::default(), &level, &[0.0; 6]);
        let least = |matrix: SMatrix<f64, 9, 6>| matrix.svd(false, false).singular_values.min();
        let h = SMatrix::<f64, 9, 6>::from_columns(&found.h_n);
        let mut without = h;
        without.row_mut(WholeEquilibrium::COUPLING).fill(0.0);
        assert!(least(h) > 0.1, "{}", least(h));
        assert!(least(without) < 1e-12, "{}", least(without));
    }
}

/// Closed form: a body's inertia adds the moment of Euler's equations, `I alpha + w x I w`, to the
/// rows of the moments and to no other. Moments reach 10 N m: 1e-9 N of the rows is rounding.
#[test]
fn the_inertia_of_the_body_is_eulers() {
    let with = WholeRover {
        body_inertia: [0.2, 0.9],
        ..open_source_rover()
    };
    let mut without = with.clone();
    without.body_inertia = [0.0; 2];
    without.side.mass.body_inertia = 0.0;
    let motion = WholeMotion {
        rate: Vec3::new(2.0, -3.0, 1.5),
        acceleration: Vec3::new(-1.0, 4.0, 2.0),
        ..WholeMotion::at_rest(GRAVITY, 0.1, 0.2)
    };
    let loads = |rover| equilibrium(rover, &Joints::default(), &motion, &[0.0; 6]);
    let (found, lever) = (loads(&with).f - loads(&without).f, loads(&with).lever);
    let [w, a] = [motion.rate, motion.acceleration];
    let (roll, pitch, yaw) = (0.2, 2.0 * with.side.mass.body_inertia, 0.9);
    let expected = [
        roll * a.x + (yaw - pitch) * w.y * w.z,
        pitch * a.y + (roll - yaw) * w.z * w.x,
        yaw * a.z + (pitch - roll) * w.x * w.y,
    ];
    for row in 0..9 {
        let moment = if (3..6).contains(&row) {
            expected[row - 3]
        } else {
            0.0
        };
        assert!(
            (found[row] - moment / lever).abs() < 1e-9,
            "row {row}: {}",
            found[row]
        );
    }
}

/// A four-bar and readings that are not numbers give an error, not forces.
#[test]
fn what_is_undetermined_is_refused() {
    let rover = open_source_rover();
    let level = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
    let four_bar = WholeRover {
        side: Robot::default_a(),
        ..rover.clone()
    };
    assert_eq!(
        WholePosture::new(&four_bar, &Joints::default()).err(),
        Some(WholeError::FourBar)
    );
    let sound = equilibrium(&rover, &Joints::default(), &level, &[0.0; 6]);
    for t in [f64::NAN, f64::INFINITY] {
        let found = sound.solve(&[t, 0.0, 0.0, 0.0, 0.0, 0.0], &typical());
        assert_eq!(found.err(), Some(WholeError::Singular));
    }
    // A bogie's wheels in one place share their load in no way that statics know.
    let mut tandem = rover.clone();
    tandem.side.geometry.axles[0] = tandem.side.geometry.axles[1];
    tandem.half_tracks[1] = tandem.half_tracks[0];
    let found = equilibrium(&tandem, &Joints::default(), &level, &[0.0; 6]);
    assert_eq!(
        found.solve(&[0.0; 6], &typical()).err(),
        Some(WholeError::Singular)
    );
    // Free fall carries nothing, and no share of the axial forces is known.
    let falling = equilibrium(
        &rover,
        &Joints::default(),
        &WholeMotion::default(),
        &[0.0; 6],
    );
    assert_eq!(
        falling.solve(&[0.0; 6], &typical()).err(),
        Some(WholeError::Singular)
    );
}

//! Statics of a whole rover: closed forms, symmetry, the planar statics, and the truth of another
//! simulator.

#![allow(
    clippy::expect_used,
    clippy::needless_range_loop,
    reason = "a test stops at the first surprise; one index for several arrays"
)]

mod drives;
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
    let (level, tilted) = (normal(0.0), normal(0.1));
    let moved = [0, 1, 2].map(|i| level[i] * 0.1_f64.cos() - tilted[i]);
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

/// Any posture inside the stops, with any motion of a driving rover.
#[derive(Clone, Debug)]
struct Any {
    joints: Joints,
    motion: WholeMotion,
    contact_angle: [f64; 6],
    traction: [f64; 6],
    body_place: f64,
    is_differential: bool,
}

fn case() -> impl Strategy<Value = Any> {
    let numbers = |size: f64| prop::array::uniform6(-size..size);
    let pairs = || prop::collection::vec((-1.0..1.0_f64, -3.0..3.0_f64), 9);
    (
        (-0.3..0.3_f64, numbers(0.4), numbers(0.5), numbers(0.5)),
        (numbers(1.0), numbers(2.0), pairs()),
        (numbers(8.0), -0.03..0.03_f64, any::<bool>()),
    )
        .prop_map(
            |(
                (coupling, pins, steering, contact_angle),
                (force, turning, pairs),
                (traction, body_place, is_differential),
            )| {
                let joint = |k: usize| JointMotion {
                    rate: pairs[k].0,
                    acceleration: pairs[k].1,
                };
                Any {
                    joints: Joints {
                        coupling,
                        pins: [pins[0], pins[1]],
                        steering,
                    },
                    motion: WholeMotion {
                        specific_force: Vec3::new(force[0], 2.0 * force[1], GRAVITY + force[2]),
                        rate: Vec3::new(turning[0], turning[1], turning[2]),
                        acceleration: Vec3::new(turning[3], turning[4], turning[5]),
                        coupling: joint(0),
                        pins: [joint(1), joint(2)],
                        spin: [3, 4, 5, 6, 7, 8].map(joint),
                    },
                    contact_angle,
                    traction,
                    body_place,
                    is_differential,
                }
            },
        )
}

impl Any {
    fn rover(&self) -> WholeRover {
        WholeRover {
            body_place: self.body_place,
            ..if self.is_differential {
                open_source_rover()
            } else {
                triple_bogie(0.12)
            }
        }
    }

    /// Left and right exchanged.
    fn mirrored(&self) -> Self {
        let swapped = |[a, b, c, d, e, f]: [f64; 6]| [d, e, f, a, b, c];
        let [a, b, c, d, e, f] = self.motion.spin;
        let mirror = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
        let turned = |v: Vec3| Vec3::new(-v.x, v.y, -v.z);
        Self {
            joints: Joints {
                coupling: -self.joints.coupling,
                pins: [self.joints.pins[1], self.joints.pins[0]],
                steering: swapped(self.joints.steering).map(|angle| -angle),
            },
            motion: WholeMotion {
                specific_force: mirror(self.motion.specific_force),
                rate: turned(self.motion.rate),
                acceleration: turned(self.motion.acceleration),
                coupling: JointMotion {
                    rate: -self.motion.coupling.rate,
                    acceleration: -self.motion.coupling.acceleration,
                },
                pins: [self.motion.pins[1], self.motion.pins[0]],
                spin: [d, e, f, a, b, c],
            },
            contact_angle: swapped(self.contact_angle),
            traction: swapped(self.traction),
            body_place: -self.body_place,
            is_differential: self.is_differential,
        }
    }

    fn equilibrium(&self) -> WholeEquilibrium {
        equilibrium(
            &self.rover(),
            &self.joints,
            &self.motion,
            &self.contact_angle,
        )
    }
}

proptest! {
    /// Symmetry: left and right exchanged, the forces are exchanged. Forces reach 200 N in a
    /// solution of condition 1e4.
    #[test]
    fn left_and_right_are_mirrored(case in case()) {
        let found = case.equilibrium().solve(&case.traction, &typical()).expect("determined");
        let mirrored = case.mirrored();
        let other = mirrored.equilibrium().solve(&mirrored.traction, &typical()).expect("determined");
        for i in 0..6 {
            let k = (i + 3) % 6;
            prop_assert!((found.normal[i] - other.normal[k]).abs() < 1e-9, "{found:?} {other:?}");
            prop_assert!((found.sigma_normal(i) - other.sigma_normal(k)).abs() < 1e-9);
        }
        prop_assert!((found.axial + other.axial).abs() < 1e-9);
    }

    /// Derivatives: the effects of contact angles and specific force are those of the rows, by
    /// central differences, which err by 1e-10 of the forces' 20 N.
    #[test]
    fn effects_of_inputs_are_derivatives(case in case(), normal in prop::array::uniform6(1.0..40.0_f64)) {
        let step = 1e-5;
        let carried = |case: &Any| {
            let e = case.equilibrium();
            (0..6).fold(Rows::zeros(), |sum, i| sum + e.h_n[i] * normal[i] + e.h_t[i] * case.traction[i])
        };
        let e = case.equilibrium();
        for i in 0..6 {
            let [mut ahead, mut behind] = [case.clone(), case.clone()];
            ahead.contact_angle[i] += step;
            behind.contact_angle[i] -= step;
            let expected = (carried(&ahead) - carried(&behind)) / (2.0 * step);
            let found = e.by_contact_angle(i, normal[i], case.traction[i]);
            prop_assert!((found - expected).norm() < 1e-7, "{found} {expected}");
        }
        for axis in 0..3 {
            let mut more = case.clone();
            more.motion.specific_force[axis] += 1.0;
            let expected = more.equilibrium().f - e.f;
            prop_assert!((e.by_specific_force[axis] - expected).norm() < 1e-10);
        }
    }

    /// The stated covariance of N with the inputs is the effect of an input's error on N, and that
    /// of N contains it. On a plane, where the rows are consistent and the weights do not matter to
    /// first order. 1 % of the largest effect: the share of the axial forces, which the statement
    /// takes as given, follows N.
    #[test]
    fn covariances_are_effects_of_errors(index in 3_usize..15, phi in -0.2..0.2_f64) {
        let (rover, step) = (open_source_rover(), 1e-5);
        let motion = WholeMotion::at_rest(GRAVITY, 0.05, phi);
        let solve = |error: f64| {
            let (mut angles, mut tractions) = ([0.0; 6], [0.4; 6]);
            // Tractions that carry the slope, so that the rows are consistent.
            let weight = mass_and_height(&rover).0 * GRAVITY * 0.05_f64.sin();
            tractions.fill(weight / 6.0);
            if index < 9 { angles[index - 3] += error } else { tractions[index - 9] += error }
            let e = equilibrium(&rover, &Joints::default(), &motion, &angles);
            e.solve(&tractions, &typical()).expect("determined")
        };
        let (at, moved) = (solve(0.0), solve(step));
        let variance = typical()[(index, index)];
        for i in 0..6 {
            let expected = (moved.normal[i] - at.normal[i]) / step * variance;
            let found = at.with_inputs[(i, index)];
            let scale = at.with_inputs.column(index).amax();
            prop_assert!((found - expected).abs() < 0.01 * scale, "{i}: {found} {expected}");
            prop_assert!(at.covariance[(i, i)] * variance >= found * found);
        }
    }

    /// What is stated for stiff pins contains what they do: a moment between the left bogie and its
    /// parent moves N of a level rover by less than a deviation and a half, and by more than three of
    /// those without stiff pins. The rows weigh less that a pin is in, so that N moves less.
    #[test]
    fn stiff_pins_are_stated(moment in 0.5..2.0_f64, rear in proptest::bool::ANY) {
        let rover = if rear { triple_bogie(0.2) } else { open_source_rover() };
        let motion = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
        let solve = |stated: f64, acting: f64| {
            let mut e = equilibrium(&rover, &Joints::default(), &motion, &[0.0; 6]);
            e.pin_moment = stated;
            for (link, sign) in [(Link::Bogie(0), 1.0), (Link::Rocker(0), -1.0)] {
                e.f += e.of_load(link, Vec3::zeros(), Vec3::zeros(), Vec3::y() * (sign * acting));
            }
            e.solve(&[0.0; 6], &typical()).expect("determined")
        };
        let (free, stiff, turned) = (solve(0.0, 0.0), solve(moment, 0.0), solve(moment, moment));
        let mut largest = 0.0_f64;
        for i in 0..6 {
            let moved = (turned.normal[i] - stiff.normal[i]).abs();
            prop_assert!(moved < 1.5 * stiff.sigma_normal(i), "{i}: {moved} {}", stiff.sigma_normal(i));
            largest = largest.max(moved / free.sigma_normal(i));
        }
        prop_assert!(largest > 3.0, "{largest}");
    }

    /// Equivalence: a rover whose sides move alike has the forces of the planar statics on each
    /// side, with inertia and on any ground along the way: where the planar rows are consistent,
    /// which the last traction makes them. Forces reach 100 N: 1e-9 N is rounding.
    #[test]
    fn sides_alike_are_the_planar_statics(
        pitch in -0.3..0.3_f64, pin in -0.4..0.4_f64, slopes in prop::array::uniform3(-0.4..0.4_f64),
        traction in prop::array::uniform2(-8.0..8.0_f64), q in prop::array::uniform2(-1.0..1.0_f64),
        rates in prop::array::uniform2(-1.0..1.0_f64), accelerations in prop::array::uniform2(-3.0..3.0_f64),
        spin in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let rover = open_source_rover();
        let (geometry, mass) = (&rover.side.geometry, &rover.side.mass);
        // Link 1 is the bogie, link 2 the rocker with the body.
        let arms = Arms::new(geometry, pitch + pin, pitch).expect("a bogie closes");
        let turning = arms.turning([rates[0] + rates[1], rates[0]], [accelerations[0] + accelerations[1], accelerations[0]]);
        let linkage = LinkageMotion { q: Vec2::from(q), turning, spin };
        let carriers: &[Carrier; 3] = &geometry.carriers;
        let loads = Loads::moving(mass, &mass.true_points(), &arms, carriers, &linkage, GRAVITY);
        let planar = Equilibrium::new(&arms, carriers, geometry.wheel_radius, &loads, &slopes, 0.15).expect("regular");
        let w: Vector4<f64> = planar.parity_direction().expect("defined");
        let mut t = [traction[0], traction[1], 0.0];
        t[2] = w.dot(&planar.right_side(&t)) / w.dot(&planar.h_t[2]);
        prop_assume!(t[2].abs() < 100.0);
        let expected = planar.least_squares().expect("determined").solve(&planar.right_side(&t));

        // The same motion of O, in the body's axes.
        let to_q = geometry.pins.q - rover.pivot;
        let in_world = |v: Vec2| robhaz_model::rotate(v, pitch);
        let to_o = -in_world(to_q);
        let a_o = linkage.q + robhaz_model::perp(to_o) * accelerations[0] - to_o * (rates[0] * rates[0]);
        let f = robhaz_model::rotate(a_o + Vec2::new(0.0, GRAVITY), -pitch);
        let joint = |rate, acceleration| JointMotion { rate, acceleration };
        let of_pin = joint(rates[1], accelerations[1]);
        let of_spin = spin.map(|acceleration| joint(2.0, acceleration));
        let motion = WholeMotion {
            specific_force: Vec3::new(f.x, 0.0, f.y),
            rate: Vec3::new(0.0, -rates[0], 0.0),
            acceleration: Vec3::new(0.0, -accelerations[0], 0.0),
            coupling: JointMotion::default(),
            pins: [of_pin; 2],
            spin: [of_spin[0], of_spin[1], of_spin[2], of_spin[0], of_spin[1], of_spin[2]],
        };
        let joints = Joints { coupling: 0.0, pins: [pin; 2], steering: [0.0; 6] };
        let both = |[a, b, c]: [f64; 3]| [a, b, c, a, b, c];
        let e = equilibrium(&rover, &joints, &motion, &both(slopes.map(|s| s - pitch)));
        let found = e.solve(&both(t), &typical()).expect("determined");
        let error = largest_difference(&found.normal, &both(expected));
        prop_assert!(error < 1e-9, "{error:e}: {:?} {expected:?}", found.normal);
        prop_assert!(found.misfit < 1e-12, "{}", found.misfit);
        prop_assert!(rover.coupling == Coupling::Differential);
    }
}

//! Properties of the statics in any posture: symmetry, derivatives, covariances, the planar statics.

use super::*;

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

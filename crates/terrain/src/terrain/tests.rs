use super::*;
use proptest::prelude::*;

fn contacts(terrain: &Terrain, x: f64, y: f64, radius: f64) -> Vec<Contact> {
    let mut out = Vec::new();
    terrain.contacts(Vec2::new(x, y), radius, &mut out);
    out
}

#[test]
fn the_contact_with_level_ground_is_below_the_centre() {
    let terrain = Terrain::new(Profile::Flat);
    let found = contacts(&terrain, 0.7, 0.0994, 0.1);
    assert_eq!(found.len(), 1);
    assert!((found[0].distance - 0.0994).abs() < 1e-15);
    assert!(found[0].angle().abs() < 1e-15);
    assert!(contacts(&terrain, 0.7, 0.1001, 0.1).is_empty());
}

#[test]
fn below_the_ground_the_distance_is_negative() {
    let profile = Profile::smooth();
    let y = profile.eval(1.0)[0];
    let terrain = Terrain::new(profile);
    let found = contacts(&terrain, 1.0, y - 0.01, 0.1);
    assert!(found.iter().any(|c| c.distance < 0.0));
}

#[test]
fn a_narrow_hollow_is_bridged_at_two_points() {
    let terrain = Terrain::new(Profile::CosBump(crate::CosBump {
        height: -0.08,
        centre: 0.0,
        half_width: 0.08,
    }));
    let found = contacts(&terrain, 0.0, 0.055, 0.1);
    assert_eq!(found.len(), 2);
    assert!((found[0].distance - found[1].distance).abs() < 1e-12);
    assert!((found[0].angle() + found[1].angle()).abs() < 1e-9);
    assert!(found[0].angle() < 0.0);
}

#[test]
fn a_wheel_against_a_riser_touches_riser_and_tread() {
    let terrain = Terrain::new(Profile::Stairs(crate::Stairs::step()));
    let found = contacts(&terrain, 0.7 - 0.085, 0.0995, 0.1);
    assert_eq!(found.len(), 2);
    // From rear to front: the tread below the centre, then the riser's upper corner at a height of
    // 50 mm.
    assert!((found[0].distance - 0.0995).abs() < 1e-15 && found[0].angle().abs() < 1e-15);
    let corner = Vec2::new(0.7, 0.05);
    assert!((found[1].point - corner).norm() < 1e-15);
    let found = contacts(&terrain, 0.7 - 0.099, 0.04, 0.1);
    assert!(
        found
            .iter()
            .any(|c| (c.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12)
    );
}

#[test]
fn a_wheel_rests_on_both_corners_of_a_narrow_ditch_but_on_the_bottom_of_a_wide_one() {
    let terrain = Terrain::new(Profile::Ditch(crate::Ditch::default()));
    let hanging = 0.0999_f64.powi(2) - 0.06_f64.powi(2);
    let found = contacts(&terrain, 0.76, hanging.sqrt(), 0.1);
    assert_eq!(found.len(), 2);
    for (contact, x) in found.iter().zip([0.7, 0.82]) {
        assert!((contact.point - Vec2::new(x, 0.0)).norm() < 1e-15);
        assert!((contact.distance - 0.0999).abs() < 1e-12);
    }
    // In a wide ditch the wheel touches the bottom, and here the front wall as well.
    let terrain = Terrain::new(Profile::Ditch(crate::Ditch {
        depth: 0.2,
        width: 0.5,
        start: 0.7,
    }));
    let found = contacts(&terrain, 1.1005, -0.1005, 0.1);
    assert_eq!(found.len(), 2);
    assert!((found[0].angle().abs()) < 1e-12 && (found[0].point.y + 0.2).abs() < 1e-12);
    assert!((found[1].angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn a_concave_corner_has_two_contacts_a_convex_one_has_one() {
    let terrain = Terrain::new(Profile::Ramp(Default::default()));
    // On the bisector of the corner both distances are equal.
    let half = 7.5_f64.to_radians();
    let found = contacts(&terrain, 0.7 - 0.0995 * half.tan(), 0.0995, 0.1);
    assert_eq!(found.len(), 2);
    assert!((found[0].distance - found[1].distance).abs() < 1e-12);
    assert!((found[1].angle() - 15.0_f64.to_radians()).abs() < 1e-12);
    let top = Vec2::new(0.7, 0.0) + Vec2::new((2.0 * half).cos(), (2.0 * half).sin()) * 0.8;
    let up = Vec2::new(-half.sin(), half.cos());
    let centre = top + up * 0.0995;
    let found = contacts(&terrain, centre.x, centre.y, 0.1);
    assert_eq!(found.len(), 1);
    assert!((found[0].point - top).norm() < 1e-12);
    assert!((found[0].angle() - half).abs() < 1e-12);
}

#[test]
fn smooth_joints_are_not_corners() {
    for (profile, has) in [
        (Profile::Flat, false),
        (Profile::smooth(), false),
        (Profile::CosBump(Default::default()), false),
        (Profile::Ramp(Default::default()), true),
        (Profile::Stairs(crate::Stairs::step()), true),
    ] {
        assert_eq!(
            Terrain::new(profile.clone()).has_corners(),
            has,
            "{profile:?}"
        );
    }
}

#[test]
fn measured_points_carry_a_wheel_as_spline_or_corners() {
    let points = [
        (0.5, 3.0),
        (0.7, 3.0),
        (0.9, 3.02),
        (1.2, 3.01),
        (1.3, 3.01),
    ];
    let points = points.map(|(x, y)| Vec2::new(x, y)).to_vec();
    for interpolation in crate::Interpolation::ALL {
        let heights = crate::Heights::new(points.clone(), interpolation);
        let profile = Profile::Heights(heights);
        let terrain = Terrain::new(profile.clone());
        for i in 0..100 {
            let x = 0.4 + 0.01 * f64::from(i);
            let [y, slope, _] = profile.eval(x);
            let centre = Vec2::new(x, y) + Vec2::new(-slope, 1.0).normalize() * 0.0995;
            let found = contacts(&terrain, centre.x, centre.y, 0.1);
            // A concave corner is touched on both sides.
            let most = match interpolation {
                crate::Interpolation::Monotone | crate::Interpolation::Spline => 1,
                crate::Interpolation::Corners => 2,
            };
            assert!(
                (1..=most).contains(&found.len()),
                "{interpolation:?} at {x}"
            );
            assert!(found[0].distance <= 0.0995 + 1e-12);
        }
        let end = terrain.outline(2.0, 3.0, 0.1)[0];
        assert!((end - Vec2::new(2.0, 0.01)).norm() < 1e-12);
    }
}

/// Equivalence: a course of one part has the contacts of that part, bit for bit. A wheel on a
/// smooth joint of a course has one contact.
#[test]
fn parts_join_without_double_contacts() {
    let one = |p: &Profile| Terrain::new(Profile::Course(crate::Course::new(vec![p.clone()])));
    let waves = |start| {
        Profile::Sine(crate::Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start,
            periods: 2,
        })
    };
    let course = crate::Course::new(vec![
        Profile::Ramp(Default::default()),
        waves(1.6),
        waves(2.6),
    ]);
    let profile = Profile::Course(course);
    let course = Terrain::new(profile.clone());
    let smooth = Terrain::new(Profile::smooth());
    let alone = one(&Profile::smooth());
    for i in 0..500 {
        let x = 0.01 * f64::from(i);
        let same = contacts(&alone, x, 0.09, 0.1);
        assert_eq!(same, contacts(&smooth, x, 0.09, 0.1));
        if i > 155 {
            let [y, slope, _] = profile.eval(x);
            let centre = Vec2::new(x, y) + Vec2::new(-slope, 1.0).normalize() * 0.0995;
            let found = contacts(&course, centre.x, centre.y, 0.1);
            assert_eq!(found.len(), 1, "at {x}");
            assert!((found[0].distance - 0.0995).abs() < 1e-9);
        }
    }
}

#[test]
fn the_outline_has_every_corner() {
    let terrain = Terrain::new(Profile::Stairs(Default::default()));
    let points = terrain.outline(0.0, 3.0, 0.01);
    // Start, four risers of two points each, end.
    assert_eq!(points.len(), 10);
    assert!((points[9] - Vec2::new(3.0, 0.32)).norm() < 1e-12);
}

/// Edges follow the profile's curve between the knots, within bounds of height (m) and slope (-)
/// that grow with the sixth derivative. An error of 1e-9 m in height changes N by 0.2 mN; one of
/// 1e-6 in slope turns N by 0.05 mN.
#[test]
fn edges_follow_their_curves() {
    let rough = |class, shortest| {
        Profile::Rough(crate::Rough::new(crate::RoughSettings {
            class,
            shortest,
            longest: 10.0,
            start: 0.7,
            extent: 10.0,
            fade: 1.0,
            seed: 1,
        }))
    };
    for (name, profile, height, slope) in [
        ("smooth", Profile::smooth(), 5e-12, 5e-9),
        (
            "cosbump",
            Profile::CosBump(Default::default()),
            1e-12,
            5e-10,
        ),
        ("sine", Profile::Sine(crate::Sine::default()), 3e-12, 1e-9),
        (
            "rough C",
            Profile::Rough(crate::Rough::new(Default::default())),
            5e-11,
            2e-8,
        ),
        ("rough D", rough(crate::RoughClass::D, 0.2), 1e-10, 3e-8),
        ("rough H", rough(crate::RoughClass::H, 0.05), 1e-9, 1e-6),
    ] {
        let terrain = Terrain::new(profile.clone());
        let (mut height_error, mut slope_error) = (0.0_f64, 0.0_f64);
        for edge in terrain.0.edges.iter().filter(|e| !e.straight) {
            for i in 1..8 {
                let x = edge.from.x + (edge.to.x - edge.from.x) * f64::from(i) / 8.0;
                let [y, m, _] = profile.eval(x);
                height_error = height_error.max((edge.height(x) - y).abs());
                let h = 1e-5;
                let found = (edge.height(x + h) - edge.height(x - h)) / (2.0 * h);
                let expected = (profile.eval(x + h)[0] - profile.eval(x - h)[0]) / (2.0 * h);
                slope_error = slope_error.max((found - expected).abs());
                assert!((expected - m).abs() < 1e-4);
            }
        }
        println!("{name}: height {height_error:.1e} m, slope {slope_error:.1e}");
        assert!(
            height_error < height && slope_error < slope,
            "{name}: {height_error} {slope_error}"
        );
    }
}

/// Ground of every kind, from gentle shapes to shapes narrower than a wheel.
fn any_ground() -> impl Strategy<Value = Profile> {
    let height = -0.2..0.2_f64;
    let bump = (height.clone(), 0.5..2.0_f64, 0.02..0.3_f64).prop_map(|(height, centre, width)| {
        crate::Bump {
            height,
            centre,
            width,
        }
    });
    let points = proptest::collection::vec((0.002..0.15_f64, -0.1..0.1_f64), 2..30);
    let heights = (points, 0..2_usize).prop_map(|(steps, way)| {
        let mut x = 0.0;
        let mut next = |(dx, y): (f64, f64)| {
            x += dx;
            // |y| is at most the step in x, which bounds the slope.
            Vec2::new(x, y.clamp(-dx, dx))
        };
        let points = steps.into_iter().map(&mut next).collect();
        Profile::Heights(crate::Heights::new(points, crate::Interpolation::ALL[way]))
    });
    let one = prop_oneof![
        proptest::collection::vec(bump, 1..6).prop_map(Profile::Bumps),
        (height.clone(), 0.05..0.5_f64).prop_map(|(height, half_width)| {
            Profile::CosBump(crate::CosBump {
                height,
                centre: 1.0,
                half_width,
            })
        }),
        (-1.3..1.3_f64, 0.02..1.0_f64).prop_map(|(angle, length)| {
            Profile::Ramp(crate::Ramp {
                angle,
                start: 0.7,
                length,
            })
        }),
        (height.clone(), 0.02..0.2_f64, 1..6_u32).prop_map(|(rise, run, count)| {
            Profile::Stairs(crate::Stairs {
                rise,
                run,
                count,
                start: 0.7,
            })
        }),
        (height, 0.1..1.0_f64, 1..5_u32).prop_map(|(amplitude, wavelength, periods)| {
            Profile::Sine(crate::Sine {
                amplitude: 0.5 * amplitude,
                wavelength,
                start: 0.7,
                periods,
            })
        }),
        (0.01..0.3_f64, 0.02..0.5_f64).prop_map(|(depth, width)| {
            Profile::Ditch(crate::Ditch {
                depth,
                width,
                start: 0.7,
            })
        }),
        (0..8_usize, 0..1000_u64).prop_map(|(class, seed)| {
            Profile::Rough(crate::Rough::new(crate::RoughSettings {
                class: crate::RoughClass::ALL[class],
                shortest: 0.1,
                longest: 5.0,
                start: 0.5,
                extent: 3.0,
                fade: 0.5,
                seed,
            }))
        }),
        heights,
    ];
    let shifted = |one: Profile| {
        Profile::Course(crate::Course::new(vec![
            Profile::Ramp(crate::Ramp {
                angle: -0.1,
                start: -4.0,
                length: 0.5,
            }),
            one,
        ]))
    };
    prop_oneof![one.clone(), one.prop_map(shifted)]
}

/// Equivalence: the search with the grid finds the same contacts as a search of every edge.
#[test]
fn no_contact_is_missed() {
    let config = ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::with_cases(300)
    };
    let sunk = prop_oneof![-0.01..0.02_f64, 0.0..0.3_f64];
    let radius = prop_oneof![Just(0.1), 0.02..0.4_f64];
    // Number of places with 0, 1, 2 ... contacts.
    let counts = std::cell::RefCell::new([0; 20]);
    let one = |(profile, sunk, radius): (Profile, f64, f64)| {
        prop_assume!(profile.check().is_ok());
        let terrain = Terrain::new(profile);
        let Ground { edges, grid, .. } = &*terrain.0;
        for x in (0..70).map(|i| -0.2 + 0.041 * f64::from(i)) {
            // Height at which the wheel just touches the ground; the centre is then lowered or
            // raised.
            let over = |i: i32| {
                let dx = radius * f64::from(i) / 200.0;
                let ground = edges[grid.edge_at(edges, x + dx)].height(x + dx);
                ground + (radius * radius - dx * dx).sqrt()
            };
            let rest = (-200..=200).map(over).fold(f64::NEG_INFINITY, f64::max);
            let centre = Vec2::new(x, rest - sunk * radius);
            let found = contacts(&terrain, centre.x, centre.y, radius);
            let mut all = Vec::new();
            Found {
                centre,
                radius,
                out: &mut all,
                last_run: None,
            }
            .add_all_minima(edges);
            prop_assert_eq!(found.len(), all.len(), "{} {:?} {:?}", x, found, all);
            for (a, b) in found.iter().zip(&all) {
                // Newton's method starts at the same place on the same edge.
                prop_assert!((a.point - b.point).norm() < 1e-9);
                prop_assert!((a.distance - b.distance).abs() < 1e-12);
            }
            counts.borrow_mut()[found.len().min(19)] += 1;
        }
        Ok(())
    };
    let result =
        proptest::test_runner::TestRunner::new(config).run(&(any_ground(), sunk, radius), one);
    assert!(result.is_ok(), "{result:?}");
    let counts = counts.into_inner();
    println!("places with 0, 1, 2 ... contacts: {counts:?}");
    assert!(counts[0] > 1000 && counts[1] > 1000 && counts[2] > 100);
}

proptest! {
    /// Property: the contact is the nearest point of a dense sample of the curve, and the centre
    /// lies on its normal.
    #[test]
    fn nearest_is_nearest(x in -0.5_f64..4.5, gap in 0.09_f64..0.1, which in 0..4_usize) {
        let profile = [Profile::smooth(), Profile::CosBump(Default::default()), Profile::Sine(crate::Sine::default()), Profile::Rough(crate::Rough::new(Default::default()))][which].clone();
        let terrain = Terrain::new(profile.clone());
        let [y, slope, _] = profile.eval(x);
        let up = Vec2::new(-slope, 1.0).normalize();
        let centre = Vec2::new(x, y) + up * gap;
        let found = contacts(&terrain, centre.x, centre.y, 0.1);
        prop_assert_eq!(found.len(), 1);
        let contact = found[0];
        prop_assert!((contact.point + contact.normal() * contact.distance - centre).norm() < 1e-9);
        let dense = (-2000..=2000)
            .map(|i| {
                let u = centre.x + 1e-4 * f64::from(i);
                (Vec2::new(u, profile.eval(u)[0]) - centre).norm()
            })
            .fold(f64::INFINITY, f64::min);
        // Samples are 0.1 mm apart: the nearest one is farther than the curve by at most
        // (0.05 mm)^2/(2 r) = 1.3e-8 m. The edges of `rough` differ from the curve by 1e-11 m.
        prop_assert!(contact.distance <= dense + 1e-10 && contact.distance > dense - 5e-8);
    }
}

/// Equivalence: on a curve the survey is what the profile says, with the curvature of a plane
/// curve. Edges are polynomials through the profile's derivatives: 1e-9 m, 1e-7 and 1e-4 1/m
/// are ten times what was found.
#[test]
fn curves_are_surveyed_as_they_are() {
    let profile = Profile::smooth();
    let terrain = Terrain::new(profile.clone());
    let points = terrain.survey(0.0, 4.0, 0.005);
    assert!(points.len() >= 800);
    assert!(points.windows(2).all(|p| p[1].x - p[0].x <= 0.005 + 1e-12));
    for p in &points {
        let [height, slope, bend] = profile.eval(p.x);
        assert!((p.height - height).abs() < 1e-9);
        assert!(p.slope.is_some_and(|s| (s - slope).abs() < 1e-7));
        let curvature = bend / (1.0 + slope * slope).powf(1.5);
        assert!(p.curvature.is_some_and(|c| (c - curvature).abs() < 1e-4));
    }
}

#[test]
fn risers_have_no_slope_and_corners_two() {
    let points = Terrain::new(Profile::Stairs(crate::Stairs::step())).survey(-1.0, 2.0, 0.005);
    let rows: Vec<_> = points.iter().map(|p| (p.x, p.height, p.slope)).collect();
    let expected = [
        (-1.0, 0.0, Some(0.0)),
        (0.7, 0.0, Some(0.0)),
        (0.7, 0.0, None),
        (0.7, 0.05, None),
        (0.7, 0.05, Some(0.0)),
        (2.0, 0.05, Some(0.0)),
    ];
    assert_eq!(rows, expected);
    let ramp = Terrain::new(Profile::Ramp(Default::default())).survey(-1.0, 2.0, 0.005);
    let slopes: Vec<_> = ramp.iter().filter_map(|p| p.slope).collect();
    assert_eq!(slopes.len(), 6);
    let incline = 15.0_f64.to_radians().tan();
    assert!((slopes[2] - incline).abs() < 1e-12 && (slopes[3] - incline).abs() < 1e-12);
}

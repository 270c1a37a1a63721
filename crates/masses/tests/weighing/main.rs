//! What a weighing brings: robots that differ from their nominal values, weighed with scales of a
//! stated error.

mod robots;

use robhaz_estimator::statics::load_parameters;
use robhaz_masses::{
    Accuracy, Measurements, Reading, Tolerances, Weighed, lateral, plate_forces, simulate, weigh,
};
use robhaz_model::{Carrier, Coupling, Geometry, MassSet, Robot, Vec2, WholeRover};
use robots::{POSTURES, Random, plan_of, real_robot, squared_errors, weighed};

/// Acceptance: forty robots, both geometries, differ from their nominal values by 10 mm, 10 % and 2
/// mm (half of them also in the masses of body and wheels and the links' centres of mass). After
/// six postures on scales good to 0.2 N, forces at rest err by at most 0.5 % (RMS), and the stated
/// deviation is right: NEES of the seven load parameters within the 99.9 % bounds of chi-squared or
/// below.
#[test]
fn weighed_robots_have_the_forces_of_the_real_ones() {
    let mut random = Random(7);
    let mut shown = [0.0; 7];
    let (mut before, mut after, mut stated, mut nees, mut worst) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    const ROBOTS: u32 = 40;
    for k in 0..ROBOTS {
        let geometry = if k % 2 == 0 {
            Geometry::a()
        } else {
            Geometry::b()
        };
        let nominal = Robot {
            geometry,
            mass: MassSet::caption(),
            ..Robot::default_a()
        };
        let (others, centres) = if k % 4 < 2 { (0.0, 0.0) } else { (0.1, 0.01) };
        let real = real_robot(&nominal, &mut random, others, centres);
        let found = weighed(&nominal, &real, &mut random).unwrap();
        let [drawn, now] = squared_errors(&real, &nominal, &found.robot).unwrap();
        before += drawn / f64::from(ROBOTS);
        after += now / f64::from(ROBOTS);
        worst = worst.max(now);
        stated += found.forces.after.powi(2) / f64::from(ROBOTS);
        nees += nees_of(&real, &found) / f64::from(ROBOTS);
        for (i, real) in load_parameters(&real).into_iter().enumerate() {
            let value = &found.loads[i];
            shown[i] += ((value.found - real) / value.deviation).powi(2) / f64::from(ROBOTS);
        }
    }
    println!("squares of the values shown: {shown:.2?}");
    // chi-squared of 40 over 40: three standard deviations of 0.22.
    assert!(shown.iter().all(|square| *square < 1.67), "{shown:?}");
    let percent = |square: f64| 100.0 * square.sqrt() / (14.0 * 9.81 / 3.0);
    println!(
        "N: nominal values {:.2} %, weighed {:.3} % (stated {:.3} %, worst robot {:.3} %); NEES {nees:.2} of 7",
        percent(before),
        percent(after),
        percent(stated),
        percent(worst)
    );
    assert!(percent(before) > 1.5);
    assert!(percent(after) < 0.5);
    // chi-squared of 280: mean 7 a robot, standard deviation 0.59. The prior is wider than these
    // robots, so it may be below.
    assert!(nees < 7.0 + 3.3 * 0.59 && nees > 2.0, "{nees}");
}

/// Acceptance: the same of ten robots with a bogie, the body on either link; half of the load
/// parameters of body and link are seen together only.
#[test]
fn a_weighed_bogie_has_the_forces_of_the_real_one() {
    let mut random = Random(11);
    let (mut before, mut after, mut stated) = (0.0, 0.0, 0.0);
    for k in 0..10 {
        let mut nominal = Robot {
            geometry: Geometry::b(),
            mass: MassSet::caption(),
            ..Robot::default_a()
        };
        let body = [Carrier::Link1, Carrier::Link2][k % 2];
        nominal.geometry.make_bogie(body);
        (nominal.mass.links[2], nominal.mass.link_inertias[2]) = (0.0, 0.0);
        let mut real = real_robot(&nominal, &mut random, 0.1, 0.01);
        real.geometry.make_bogie(body);
        let found = weighed(&nominal, &real, &mut random).unwrap();
        assert!(!found.values.iter().any(|v| v.name.contains("link3")));
        let [drawn, now] = squared_errors(&real, &nominal, &found.robot).unwrap();
        before += 0.1 * drawn;
        after += 0.1 * now;
        stated += 0.1 * found.forces.after.powi(2);
    }
    let percent = |square: f64| 100.0 * square.sqrt() / (14.0 * 9.81 / 3.0);
    let [before, after, stated] = [before, after, stated].map(percent);
    println!("N: nominal values {before:.2} %, weighed {after:.3} % (stated {stated:.3} %)");
    assert!(before > 1.0 && after < 0.5 && after < 1.5 * stated);
}

/// Squared error of the load parameters by their stated covariance: 7 on average if it is right.
/// Their error is the change that balances the weighed robot with the real forces, least squares
/// over postures.
fn nees_of(real: &Robot, weighed: &Weighed) -> f64 {
    use nalgebra::{SMatrix, SVector, Vector4};
    use robhaz_estimator::statics::{Arms, Equilibrium, Loads, by_load_parameters};
    let missing = |robot: &Robot, angles: [f64; 2]| {
        let forces = plate_forces(real, angles, [0.0; 3]).ok()?;
        let (geometry, carriers) = (&robot.geometry, &robot.geometry.carriers);
        let arms = Arms::new(geometry, angles[0], angles[1]).ok()?;
        let loads = Loads::at_rest(&robot.mass.true_points());
        let e = Equilibrium::new(&arms, carriers, 0.1, &loads, &[0.0; 3], 0.2)?;
        let carried: Vector4<f64> = e.h_n.iter().zip(forces).map(|(h, n)| h * n).sum();
        Some((arms, carried - e.f))
    };
    let mut normal = SMatrix::<f64, 7, 7>::zeros();
    let mut right = SVector::<f64, 7>::zeros();
    for i in -2..=2 {
        for j in -2..=2 {
            let angles = [0.1 * f64::from(i + j), 0.1 * f64::from(i)];
            let Some((arms, missing)) = missing(&weighed.robot, angles) else {
                return f64::NAN;
            };
            let by = SMatrix::<f64, 4, 7>::from_columns(&by_load_parameters(&arms, 0.2));
            normal += by.transpose() * by;
            right += by.transpose() * missing;
        }
    }
    let covariance = SMatrix::<f64, 7, 7>::from_fn(|i, j| weighed.covariance.rows()[i][j]);
    match (normal.cholesky(), covariance.cholesky()) {
        (Some(normal), Some(covariance)) => {
            let error = normal.solve(&right);
            error.dot(&covariance.solve(&error))
        }
        _ => f64::NAN,
    }
}

/// Closed form: exact scales in many postures give the load parameters of a robot whose pins are
/// those of the nominal values.
#[test]
fn exact_scales_give_the_load_parameters() {
    let nominal = Robot::default_a();
    let mut real = nominal.clone();
    real.mass.body *= 1.07;
    real.mass.links = [1.6, 2.4, 0.55];
    real.geometry.body_cg += Vec2::new(0.008, -0.006);
    let mut measurements = Measurements::default();
    for i in -2..=2 {
        for j in -2..=2 {
            let inclinations = [0.08 * f64::from(i), 0.08 * f64::from(j)];
            let forces = plate_forces(&real, inclinations, [0.0; 3])
                .unwrap()
                .map(Some);
            measurements.readings.push(Reading {
                line: 0,
                inclinations,
                forces,
            });
        }
    }
    let accuracy = Accuracy {
        scale: 1e-5,
        inclination_offset: 0.0,
        inclination: 0.0,
        horizontal_force: 0.0,
        ..Accuracy::TYPICAL
    };
    let tolerances = Tolerances {
        pin: 1e-9,
        ..Tolerances::NOMINAL
    };
    let found = weigh(&nominal, &measurements, &tolerances, &accuracy).unwrap();
    let (is, should) = (load_parameters(&found.robot), load_parameters(&real));
    for (is, should) in is.iter().zip(should) {
        // The prior pulls by (1e-5 N over its deviation)^2: below 1e-7.
        assert!((is - should).abs() < 1e-6, "{is} {should}");
    }
}

/// A scale that reads 3 N too much contradicts the others: an error names its line and wheel. Order
/// of wheels reversed: an error as well. Of newtons that are taken for kilograms, and a weight of both sides, it says how
/// many times those of the robot they are.
#[test]
fn readings_that_do_not_fit_are_refused() {
    let nominal = Robot::default_a();
    let accuracy = Accuracy::TYPICAL;
    let plan = plan_of(&nominal).unwrap();
    let blocks: Vec<_> = plan.postures.iter().map(|p| p.blocks).collect();
    let sound = simulate(&nominal, &blocks, &accuracy, || 0.0).unwrap();
    let fit = |m: &Measurements| weigh(&nominal, m, &Tolerances::NOMINAL, &accuracy);
    assert!(fit(&sound).is_ok());
    let mut faulty = sound.clone();
    faulty.readings[3].forces[1] = faulty.readings[3].forces[1].map(|n| n + 3.0);
    let error = fit(&faulty).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("do not fit a robot"), "{text}");
    assert!(text.contains("wheel2 in line 5"), "{text}");
    let mut swapped = sound.clone();
    for reading in &mut swapped.readings {
        reading.forces.reverse();
    }
    let error = fit(&swapped).unwrap_err().to_string();
    assert!(error.contains("check the order of the wheels"), "{error}");
    let mut heavy = sound.clone();
    for force in heavy.readings.iter_mut().flat_map(|r| &mut r.forces) {
        *force = force.map(|n| 9.81 * n);
    }
    let error = fit(&heavy).unwrap_err().to_string();
    assert!(error.contains("9.81 times the"), "{error}");
    assert!(error.contains("check the unit of the forces"), "{error}");
    let mut of_both = sound.clone();
    of_both.weight = Some(2.0 * 9.81 * nominal.mass.total());
    let error = fit(&of_both).unwrap_err().to_string();
    assert!(
        error.contains("the worst reading is that of weight"),
        "{error}"
    );
    assert!(error.contains("2.00 times the"), "{error}");
    let mut steep = sound.clone();
    steep.readings[0].inclinations = [0.9, -0.5];
    let error = fit(&steep).unwrap_err().to_string();
    assert!(error.contains("line 2: theta_1 - theta_2 is"), "{error}");
    let error = fit(&Measurements::default()).unwrap_err().to_string();
    assert!(error.contains("there is no reading"), "{error}");
}

/// What scales do not measure stays at the nominal values: with the total weight alone the total
/// mass is known, all else keeps its deviation to a few percent; two scales of three leave larger
/// deviations than three.
#[test]
fn what_is_not_seen_keeps_its_prior() {
    let nominal = Robot::default_a();
    let fit =
        |m: &Measurements| weigh(&nominal, m, &Tolerances::NOMINAL, &Accuracy::TYPICAL).unwrap();
    let weight = nominal.mass.total() * 9.81;
    let alone = fit(&Measurements {
        readings: Vec::new(),
        weight: Some(weight),
        ..Measurements::default()
    });
    assert!((alone.loads[0].deviation * 9.81 - 0.2).abs() < 0.001);
    for value in &alone.values[5..] {
        let share = value.deviation / value.prior;
        assert!((share - 1.0).abs() < 1e-9, "{value:?}");
    }
    let plan = plan_of(&nominal).unwrap();
    let blocks: Vec<_> = plan.postures.iter().map(|p| p.blocks).collect();
    let three = simulate(&nominal, &blocks, &Accuracy::TYPICAL, || 0.0).unwrap();
    let mut two = three.clone();
    two.readings.iter_mut().for_each(|r| r.forces[2] = None);
    let (three, two) = (fit(&three), fit(&two));
    assert!(three.forces.after < two.forces.after && two.forces.after < two.forces.before);
}

/// A scale that reads 5 % high: with that stated, forces err within three stated deviations, where
/// calibrated scales would be ten off; and a constant error of 1 N as well. The same posture with
/// the scales exchanged does not fit.
#[test]
fn a_scale_that_reads_high_is_stated_or_found() {
    let nominal = Robot::default_a();
    let plan = plan_of(&nominal).unwrap();
    let blocks: Vec<_> = plan.postures.iter().map(|p| p.blocks).collect();
    let sound = simulate(&nominal, &blocks, &Accuracy::TYPICAL, || 0.0).unwrap();
    let stated = [
        Accuracy {
            scale_gain: 0.03,
            ..Accuracy::TYPICAL
        },
        Accuracy {
            scale_zero: 1.0,
            ..Accuracy::TYPICAL
        },
    ];
    let errors: [fn(f64) -> f64; 2] = [|n| 1.05 * n, |n| n + 1.0];
    for (accuracy, error) in stated.iter().zip(errors) {
        let mut faulty = sound.clone();
        for reading in &mut faulty.readings {
            reading.forces[0] = reading.forces[0].map(error);
        }
        let off = |accuracy: &Accuracy| {
            let found = weigh(&nominal, &faulty, &Tolerances::NOMINAL, accuracy).unwrap();
            let [_, now] = squared_errors(&nominal, &nominal, &found.robot).unwrap();
            now.sqrt() / found.forces.after
        };
        let (silent, said) = (off(&Accuracy::TYPICAL), off(accuracy));
        println!("{silent:.1} deviations, stated {said:.1}");
        assert!(silent > 4.0 && said < 2.0, "{silent} {said}");
        // The first posture again, its scales moved round by one wheel.
        let mut moved = sound.readings[0];
        moved.forces[1] = moved.forces[1].map(error);
        faulty.readings.push(moved);
        let found = weigh(&nominal, &faulty, &Tolerances::NOMINAL, &Accuracy::TYPICAL);
        let is_gain = accuracy.scale_gain > 0.0;
        assert_eq!(found.is_err(), is_gain, "{accuracy:?}");
    }
}

/// On Mars the error of N is that of a drive there: the same share of the load.
#[test]
fn the_error_of_the_forces_is_that_of_the_drive() {
    let shares = [9.81, 3.71].map(|gravity| {
        let nominal = Robot {
            gravity,
            ..Robot::default_a()
        };
        let found = weighed(&nominal, &nominal, &mut Random(3)).unwrap();
        let (plan, mean) = (plan_of(&nominal).unwrap(), nominal.mean_wheel_load());
        [found.forces.before, found.forces.after, plan.before].map(|n| n / mean)
    });
    for (earth, mars) in shares[0].iter().zip(shares[1]) {
        assert!((earth / mars - 1.0).abs() < 1e-9, "{shares:?}");
    }
}

/// Closed form: beside a load parameter stands its own deviation, also of errors of the pins, which
/// the budget's covariance states together with what else they change: by differences of the
/// parameters.
#[test]
fn the_deviation_beside_a_value_is_its_own() {
    let nominal = Robot::default_a();
    let measurements = Measurements {
        weight: Some(nominal.mass.total() * 9.81),
        ..Measurements::default()
    };
    let tolerances = Tolerances {
        mass: 1e-9,
        centre: 1e-9,
        pin: 0.002,
    };
    let found = weigh(&nominal, &measurements, &tolerances, &Accuracy::TYPICAL).unwrap();
    let mut squares = [0.0; 7];
    for pin in 0..4 {
        for axis in 0..2 {
            let mut moved = nominal.clone();
            let pins = &mut moved.geometry.pins;
            let pin = [&mut pins.p, &mut pins.q, &mut pins.r, &mut pins.s]
                .into_iter()
                .nth(pin);
            pin.unwrap()[axis] += 0.002 * std::f64::consts::FRAC_1_SQRT_2;
            let change = load_parameters(&moved)
                .into_iter()
                .zip(load_parameters(&nominal));
            for (square, (there, here)) in squares.iter_mut().zip(change) {
                *square += (there - here).powi(2);
            }
        }
    }
    for (value, square) in found.loads.iter().zip(squares).skip(1) {
        // The parameters are nearly linear in 2 mm.
        let (prior, expected) = (value.prior, square.sqrt());
        assert!(
            (prior / expected - 1.0).abs() < 0.05,
            "{value:?} {expected}"
        );
    }
}

/// The plan: each posture lowers the stated error of N, and six leave less than a fifth of it.
#[test]
fn planned_postures_tell_most() {
    let nominal = Robot::default_a();
    let plan = plan_of(&nominal).unwrap();
    let mut last = plan.before;
    for posture in &plan.postures {
        println!("{:?} {:.3} N", posture.blocks, posture.after);
        assert!(posture.after < last);
        last = posture.after;
    }
    println!(
        "{} candidates, before {:.3} N",
        plan.candidates, plan.before
    );
    assert!(plan.candidates > 15 && last < 0.2 * plan.before);
}

/// Equivalence: the budget's covariance gives the same deviation of the normal forces on plates as
/// masses, centres of mass and pins themselves, in the postures of a drive; and on slopes not much
/// more.
#[test]
fn the_budget_states_what_the_weighing_left() {
    use nalgebra::Matrix4;
    use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
    let nominal = Robot::default_a();
    let found = weighed(&nominal, &nominal, &mut Random(3)).unwrap();
    let geometry = &found.robot.geometry;
    let mut sums = [0.0; 2];
    for (sum, slope) in sums.iter_mut().zip([0.0, 0.3]) {
        for angles in POSTURES {
            let arms = Arms::new(geometry, angles[0], angles[1]).unwrap();
            let loads = Loads::at_rest(&found.robot.mass.true_points());
            let slopes = [slope, 0.0, -slope];
            let e = Equilibrium::new(&arms, &geometry.carriers, 0.1, &loads, &slopes, 0.2).unwrap();
            let of_loads: Matrix4<f64> = found.covariance.of_loads(&arms, 0.2);
            for row in e.least_squares().unwrap().rows {
                *sum += row.dot(&(of_loads * row)) / 15.0;
            }
        }
    }
    let [level, sloped] = sums.map(|s: f64| s.sqrt());
    println!(
        "level {level:.3} N, slopes {sloped:.3} N; stated {:.3} N",
        found.forces.after
    );
    assert!((level / found.forces.after - 1.0).abs() < 0.2);
    assert!(sloped < 1.5 * level);
}

/// The Open Source Rover, of its file's numbers.
fn open_source_rover() -> WholeRover {
    let mut side = Robot::default_a();
    let geometry = &mut side.geometry;
    geometry.make_bogie(Carrier::Link2);
    geometry.wheel_radius = 0.075;
    geometry.axles = [271.0, 0.0, -318.0].map(|mm| Vec2::new(1e-3 * mm, 0.075));
    geometry.carriers = [Carrier::Link1, Carrier::Link1, Carrier::Link2];
    geometry.pins.q = Vec2::new(0.095, 0.169);
    geometry.body_cg = Vec2::new(-0.02, 0.265);
    (geometry.link_cg[0], geometry.link_cg[1]) = (Vec2::new(0.122, 0.106), Vec2::new(-0.105, 0.19));
    let mass = &mut side.mass;
    (mass.body, mass.links, mass.wheel) = (2.9, [0.25, 0.35, 0.0], 0.95);
    WholeRover {
        side,
        coupling: Coupling::Differential,
        pivot: Vec2::new(-0.019, 0.261),
        half_tracks: [0.184, 0.2556, 0.184],
        link_places: [0.181; 2],
        body_place: 0.0,
        coupling_stop: WholeRover::NO_STOP,
        body_inertia: [0.041, 0.083],
        link_inertias: [[0.0; 2]; 2],
        wheel_inertia: 0.0,
    }
}

/// Closed form: a centre of mass y_c to the left loads the wheels by nu_i D = nu_i W y_c/b_P, with
/// the Open Source Rover's nu and b_P; scales that read so give y_c back. Six at 0.2 N state it to
/// 0.8 mm, and four postures to half of that.
#[test]
fn six_scales_give_the_lateral_centre_of_mass() {
    const NU: [f64; 3] = [0.25379, 0.47018, 0.27603];
    let (weight, b_p, y_c) = (124.587, 0.43533, 0.006);
    let rover = open_source_rover();
    let reading = |line| Reading {
        line,
        inclinations: [0.0; 2],
        forces: NU.map(|nu| Some(2.0 * nu * weight * y_c / b_p)),
    };
    let accuracy = Accuracy {
        horizontal_force: 0.0,
        ..Accuracy::TYPICAL
    };
    let found = lateral(&rover, &[reading(2)], &accuracy).unwrap();
    // The closed form has five digits.
    assert!((found.rover_place.0 - y_c).abs() < 1e-6, "{found:?}");
    assert!((found.rover_place.1 - 0.0008).abs() < 5e-5, "{found:?}");
    let body = y_c * rover.side.mass.total() / rover.side.mass.body;
    assert!((found.body_place.0 - body).abs() < 2e-6, "{found:?}");
    let four = lateral(&rover, &[2, 3, 4, 5].map(reading), &accuracy).unwrap();
    assert!((four.rover_place.1 / found.rover_place.1 - 0.5).abs() < 1e-9);
    // A gain keeps its error in all postures: the deviation of one posture, by hand, stays that of
    // four. The Open Source Rover bears 18.2, 25.1 and 18.9 N.
    let gains = Accuracy {
        scale_gain: 0.02,
        ..accuracy
    };
    let by = NU.map(|nu| 2.0 * nu * weight / b_p);
    let square = by.iter().map(|b| b * b).sum::<f64>();
    let loads = [18.2425, 25.1458, 18.9088];
    let constant = by.iter().zip(loads).map(|(b, n)| (b * 0.02 * n).powi(2));
    let constant = (2.0 * constant.sum::<f64>()).sqrt() / square;
    for lines in [1, 4] {
        let readings: Vec<_> = (0..lines).map(reading).collect();
        let found = lateral(&rover, &readings, &gains).unwrap();
        let random = 0.2 * (2.0 / (square * lines as f64)).sqrt();
        let expected = random.hypot(constant);
        assert!(
            (found.rover_place.1 / expected - 1.0).abs() < 1e-3,
            "{found:?} {expected}"
        );
    }
    // A robot of Mars is weighed here.
    let mut mars = rover.clone();
    mars.side.gravity = 3.71;
    let there = lateral(&mars, &[reading(2)], &accuracy).unwrap();
    assert!((there.body_place.0 / found.body_place.0 - 1.0).abs() < 1e-9);
    // A scale that reads 3 N too much is named.
    let mut faulty = reading(2);
    faulty.forces[1] = faulty.forces[1].map(|n| n + 3.0);
    let error = lateral(&rover, &[faulty], &accuracy)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("left less right: ") && error.contains("wheel2 in line 2"),
        "{error}"
    );
    let error = lateral(&rover, &[], &accuracy).unwrap_err().to_string();
    assert!(
        error.contains("no posture has readings of six scales"),
        "{error}"
    );
}

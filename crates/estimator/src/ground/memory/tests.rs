//! Tests of the memory: exact motion, constant errors, arbitrary input, sections.

extern crate std;

use super::super::cells::FrictionBounds;
use super::super::motion::GroundMotion;
use super::*;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

const DT: f64 = 1e-3;
const SPEED: f64 = 0.2;
/// Standard deviation of the inclinometers' bias, rad.
const LINK_BIAS: f64 = 1e-3;

/// A wave: height (m) and slope dy/dx at a place (m).
fn wave(x: f64) -> (f64, f64) {
    let (amplitude, number) = (0.03, 6.0);
    (
        amplitude * libm::sin(number * x),
        amplitude * number * libm::cos(number * x),
    )
}

/// Centre of a wheel that touches the wave at `x`, and the contact angle.
fn centre(radius: f64, x: f64) -> (Vec2, f64) {
    let (height, slope) = wave(x);
    let angle = libm::atan(slope);
    let (sin, cos) = libm::sincos(angle);
    (Vec2::new(x - radius * sin, height + radius * cos), angle)
}

/// A robot whose contacts are at `x` and 0.3 m ahead and behind. Q is the middle axle. The velocity
/// is exact for the trapezoidal rule up to the third power of the step. `bias`: angles (rad) by
/// which links 1 and 2 are read too high; `direction`: error of the velocity's direction, rad.
fn motion(geometry: &Geometry, x: f64, speed: f64, bias: [f64; 2], direction: f64) -> GroundMotion {
    let radius = geometry.wheel_radius;
    let h = 1e-5;
    let at = |x: f64| centre(radius, x).0;
    let tangent = (at(x + h) - at(x - h)) / (2.0 * h);
    let velocity = tangent * speed;
    let wheels = [0.3, 0.0, -0.3].map(|offset| centre(radius, x + offset));
    let axle = |i: usize| {
        let arm = wheels[i].0 - wheels[1].0;
        let link = geometry.carriers[i].index();
        arm + robhaz_model::perp(arm) * bias[link]
    };
    let sigma = 0.005;
    let variance = sigma * sigma * velocity.norm_squared();
    GroundMotion {
        dt: DT,
        velocity: velocity + robhaz_model::perp(velocity) * direction,
        velocity_covariance: [variance, 0.0, variance],
        axles: [axle(0), axle(1), axle(2)],
        contact_angle: wheels.map(|(_, angle)| (angle + direction, sigma)),
        touches: [true; 3],
    }
}

/// Drives on to a place x, m, at a speed, m/s.
fn drive_to(memory: &mut GroundMemory, geometry: &Geometry, x: f64, speed: f64) {
    memory.drop_left();
    let sample = motion(geometry, x, speed, [0.0; 2], 0.0);
    memory.update(geometry, LINK_BIAS, &sample);
}

/// Drives from 0 to `length` (m) and returns all points, those in memory last.
fn drive(length: f64, bias: [f64; 2], direction: f64) -> Vec<GroundPoint> {
    let geometry = Geometry::a();
    let mut memory = GroundMemory::new(&geometry);
    let mut points = Vec::new();
    let steps = (length / (SPEED * DT)) as u32;
    for k in 0..=steps {
        memory.drop_left();
        let x = SPEED * DT * f64::from(k);
        let sample = motion(&geometry, x, SPEED, bias, direction);
        memory.update(&geometry, LINK_BIAS, &sample);
        points.extend(memory.completed());
    }
    points.extend(memory.points());
    points
}

/// Largest error of height (m) and angle (rad) over the points.
fn errors(points: &[GroundPoint]) -> (f64, f64) {
    // The origin is the middle axle's place, at the height of its contact.
    let radius = Geometry::a().wheel_radius;
    let (axle, _) = centre(radius, 0.0);
    let mut worst = (0.0_f64, 0.0_f64);
    for point in points {
        let (height, slope) = wave(point.x + axle.x);
        worst.0 = worst.0.max((point.height - (height - wave(0.0).0)).abs());
        worst.1 = worst.1.max((point.slope - libm::atan(slope)).abs());
    }
    worst
}

/// Closed form: a velocity that points 0.5 deg too high does not close. The error is found to a
/// tenth after 2 m, once in each 0.3 m; an exact motion has none; and one that is corrected by what
/// was found has none left.
#[test]
fn an_error_of_the_direction_shows() {
    let geometry = Geometry::a();
    for (direction, corrects) in [(0.0, false), (0.0087, false), (0.0087, true)] {
        let mut memory = GroundMemory::new(&geometry);
        let (mut corrected, mut found) = (0.0, Vec::new());
        for k in 0..=10_000 {
            memory.drop_left();
            let x = SPEED * DT * f64::from(k);
            let sample = motion(&geometry, x, SPEED, [0.0; 2], direction + corrected);
            memory.update(&geometry, LINK_BIAS, &sample);
            if let Some((error, variance)) = memory.take_direction_error(LINK_BIAS) {
                // What the biases of the links leave: 1 mrad each, over 3 m.
                assert!(variance > 1e-6, "{variance}");
                found.push(error);
                if corrects {
                    corrected -= error;
                    memory.drift.direction_corrected(-error);
                }
            }
        }
        assert!(found.len() >= 5 && found.len() <= 6, "{found:?}");
        let expected = if corrects { 0.0 } else { direction };
        let last = found.last().copied().unwrap_or(f64::NAN);
        assert!((last - expected).abs() < 1e-3, "{found:?}");
        assert!((direction + corrected - expected).abs() < 1e-3 || !corrects);
    }
}

/// Closed form: with an exact motion the memory is the wave. The chord between two samples, 0.2 mm
/// apart, errs by h^2/8 times the curvature: 5e-9 m. The integral of the velocity errs by h^2/12
/// times the difference of its derivative at both ends, below 1e-8 m. The ground has every point
/// from the first contact of the rear wheel to the last one of the front wheel, but for up to six
/// where the middle wheel came to the front wheel's first point, and the rear wheel to the middle
/// wheel's.
#[test]
fn exact_motion_gives_the_ground() {
    let points = drive(2.0, [0.0; 2], 0.0);
    let (height, slope) = errors(&points);
    assert!(height < 1e-7 && slope < 1e-6, "{height} {slope}");
    let expected = (2.6 / 0.01) as usize;
    assert!(
        (expected - 12..=expected).contains(&points.len()),
        "{}",
        points.len()
    );
    let in_order = points.windows(2).all(|pair| pair[1].x > pair[0].x);
    assert!(in_order && points.iter().all(|p| p.section == 0));
}

/// A direction of the velocity that is 5 mrad too high would raise the profile by 5 mm a metre. The
/// link angles show that it does not rise: what remains is what their prior allows, 1 mrad.
#[test]
fn a_wrong_direction_does_not_turn_the_profile() {
    let points = drive(3.0, [0.0; 2], 5e-3);
    let (height, _) = errors(&points);
    assert!(height < 1e-3, "{height}");
    let last = points.last().expect("points");
    assert!(last.x > 3.2 && last.sigma_height > 2e-3, "{last:?}");
}

/// Opposite biases of the inclinometers contradict each other where the wheels pass the same place:
/// they are found. Equal biases turn the profile, and the stated deviation says so.
#[test]
fn only_the_mean_of_the_biases_turns_the_profile() {
    let (height, _) = errors(&drive(3.0, [1e-3, -1e-3], 0.0));
    // A chord of 0.3 m between two wheels errs by 0.3 mm.
    assert!(height < 0.3e-3, "{height}");
    let points = drive(3.0, [1e-3; 2], 0.0);
    let last = points.last().expect("points");
    let (axle, _) = centre(Geometry::a().wheel_radius, 0.0);
    let (true_height, _) = wave(last.x + axle.x);
    let error = last.height - true_height;
    // 1 mrad over 3.3 m.
    assert!((error - 3.3e-3).abs() < 0.3e-3, "{error}");
    assert!(error < 2.0 * last.sigma_height, "{error} {last:?}");
}

/// Property: three passes do not reduce the variance below that of the errors which the wheels have
/// in common. The mean of two biases of deviation s has s/sqrt(2); at the distance x from the
/// origin that is a height of x s/sqrt(2). A tenth less is left for the origin's extent, the
/// robot's length.
#[test]
fn passes_do_not_reduce_the_common_error() {
    for point in drive(3.0, [0.0; 2], 0.0) {
        let common = LINK_BIAS * core::f64::consts::FRAC_1_SQRT_2 * (point.x.abs() - 0.3).max(0.0);
        assert!(point.sigma_height > 0.9 * common, "{point:?} {common}");
        assert!(point.sigma_slope > 0.9 * LINK_BIAS * core::f64::consts::FRAC_1_SQRT_2);
    }
}

/// A robot that drives back gives the points that it left once more, with the same heights.
#[test]
fn a_robot_may_drive_back() {
    let geometry = Geometry::a();
    let mut memory = GroundMemory::new(&geometry);
    let (mut points, mut x) = (Vec::new(), 0.0);
    for k in 0..12_000 {
        let speed = if k < 7000 { SPEED } else { -SPEED };
        drive_to(&mut memory, &geometry, x, speed);
        points.extend(memory.completed());
        let next = if k + 1 < 7000 { SPEED } else { -SPEED };
        x += 0.5 * DT * (speed + next);
    }
    points.extend(memory.points());
    // As above, and one step of which the trapezoid's ends have opposite velocities.
    let (height, _) = errors(&points);
    assert!(height < 1e-6, "{height}");
    let count = |x: f64| {
        points
            .iter()
            .filter(|p| (p.axle_x - x).abs() < 1e-6)
            .count()
    };
    assert_eq!((count(0.1), count(0.8)), (1, 2));
}

/// Nothing is lost: a point that was in memory is there with the next sample, or has been completed
/// by it, also where the section ends. The next section starts at its own origin.
#[test]
fn every_point_is_completed() {
    let geometry = Geometry::a();
    let mut memory = GroundMemory::new(&geometry);
    let mut before: Vec<f64> = Vec::new();
    let mut completed = 0;
    for k in 0..8000_u32 {
        drive_to(&mut memory, &geometry, SPEED * DT * f64::from(k), SPEED);
        if k == 6000 {
            memory.end_section();
            assert_eq!(memory.wheel_places(), None);
        }
        let all: Vec<f64> = memory
            .completed()
            .chain(memory.points())
            .map(|p| p.axle_x)
            .collect();
        assert!(before.iter().all(|x| all.contains(x)), "sample {k}");
        completed += memory.completed().count();
        before = memory.points().map(|p| p.axle_x).collect();
    }
    assert_eq!(memory.section, 1);
    // 1.8 m and 0.4 m of travel, of which 0.88 m are in memory at most.
    assert!(completed > 150, "{completed}");
    let places = memory.wheel_places().expect("running");
    let [first, last] = [6001.0, 7999.0].map(|k| centre(geometry.wheel_radius, SPEED * DT * k).0);
    assert!((places[1] - (last.x - first.x)).abs() < 1e-6, "{places:?}");
}

/// The slope for the following wheels is that of the ground; its deviation grows with the way since
/// the first wheel.
#[test]
fn the_slope_at_a_place_is_known_before_the_next_wheel() {
    let geometry = Geometry::a();
    let mut memory = GroundMemory::new(&geometry);
    for k in 0..8000_u32 {
        drive_to(&mut memory, &geometry, SPEED * DT * f64::from(k), SPEED);
    }
    let [front, middle, _] = memory.wheel_places().expect("running");
    let (axle, _) = centre(geometry.wheel_radius, 0.0);
    for x in [middle, middle + 0.1, front - 0.015] {
        let (slope, sigma) = memory.slope_at(x).expect("known");
        // Linear between points 10 mm apart: h^2/8 times the third derivative of the height,
        // 6.5/m^2.
        let mut contact = x + axle.x;
        for _ in 0..50 {
            // The contact under the axle.
            contact += x + axle.x - centre(geometry.wheel_radius, contact).0.x;
        }
        let expected = libm::atan(wave(contact).1);
        assert!((slope - expected).abs() < 1e-4, "{slope} {expected}");
        assert!(sigma > 5e-4 && sigma < 6e-3, "{sigma}");
    }
    assert_eq!(memory.slope_at(front + 0.1), None);
    assert_eq!(memory.slope_at(f64::NAN), None);
}

/// mapped ground shows the slope to the wheels behind the first, within its stated deviation.
#[test]
fn mapped_terrain_shows_the_slope_of_the_wheels_behind() {
    let geometry = Geometry::a();
    let mut memory = GroundMemory::new(&geometry);
    let (mut passed, mut shown) = ([0; 3], 0);
    for k in 0..8000_u32 {
        memory.drop_left();
        let x = SPEED * DT * f64::from(k);
        let sample = motion(&geometry, x, SPEED, [0.0; 2], 0.0);
        let known = memory.update(&geometry, LINK_BIAS, &sample);
        for i in 0..3 {
            passed[i] += usize::from(known[i]);
            let Some((slope, variance)) = memory.mapped_slope(i).filter(|_| known[i]) else {
                continue;
            };
            shown += 1;
            let error = slope - sample.contact_angle[i].0;
            assert!(error * error < variance, "{i} {k} {error} {variance}");
        }
    }
    // 1.6 m of way; the first 0.3 m before the wheels behind come to mapped ground.
    assert_eq!(passed[0], 0);
    assert!(passed[1] > 100 && passed[2] > 100, "{passed:?}");
    assert!(shown > 200, "{shown}");
}

/// Property: the largest bound that was held at a place counts, a slip replaces both; places
/// outside of the window keep none.
#[test]
fn bounds_of_the_friction_are_the_largest_held_and_the_last_measured() {
    let mut memory = GroundMemory::new(&Geometry::a());
    for bound in [0.2, 0.5, 0.3] {
        memory.friction_held(0.1, bound);
    }
    let bounds = |at_least, at_most| FrictionBounds { at_least, at_most };
    assert_eq!(memory.friction_at(0.1), bounds(0.5, None));
    assert_eq!(memory.friction_at(0.2), FrictionBounds::default());
    memory.friction_measured(0.1, -0.1, 0.4);
    assert_eq!(memory.friction_at(0.1), bounds(0.0, Some(0.4)));
    memory.friction_held(100.0, 0.5);
    assert_eq!(memory.friction_at(100.0), FrictionBounds::default());
}

fn number() -> impl Strategy<Value = f64> {
    let odd = prop::sample::select(vec![
        0.0,
        1e-300,
        1e12,
        -1e12,
        1e300,
        f64::NAN,
        f64::INFINITY,
    ]);
    prop_oneof![8 => -1.0_f64..1.0, 1 => -100.0_f64..100.0, 1 => odd]
}

proptest! {
    /// Any input leaves finite points in order, with standard deviations that are not negative.
    #[test]
    fn arbitrary_input_leaves_finite_points(
        samples in prop::collection::vec((prop::array::uniform20(number()), any::<[bool; 3]>()), 1..60),
    ) {
        let geometry = Geometry::a();
        let mut memory = GroundMemory::new(&geometry);
        for (n, touches) in samples {
            memory.drop_left();
            let sample = GroundMotion {
                dt: n[0].abs(),
                velocity: Vec2::new(n[1], n[2]),
                velocity_covariance: [n[3], n[4], n[5]],
                axles: [Vec2::new(n[6], n[7]), Vec2::new(n[8], n[9]), Vec2::new(n[10], n[11])],
                contact_angle: [(n[12], n[13]), (n[14], n[15]), (n[16], n[17])],
                touches,
            };
            memory.update(&geometry, n[18].abs().min(1.0), &sample);
            if n[19] > 0.95 {
                memory.end_section();
            }
            let mut last = f64::NEG_INFINITY;
            for p in memory.completed().chain(memory.points()) {
                let sigmas = [p.sigma_x, p.sigma_height, p.sigma_slope];
                prop_assert!(sigmas.iter().all(|s| s.is_finite() && *s >= 0.0), "{p:?}");
                prop_assert!(p.x.is_finite() && p.height.is_finite() && p.slope.is_finite(), "{p:?}");
            }
            for p in memory.points() {
                prop_assert!(p.axle_x > last);
                last = p.axle_x;
            }
        }
    }
}

//! One side of a rover with two, JPL's Open Source Rover on level ground, against closed forms: a
//! cross slope moves the load from side to side, and the other side pushes through the body. No
//! reading of the side shows either.
#![allow(
    clippy::approx_constant,
    reason = "a rear axle at -0.318 m is not -1/pi"
)]
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use nalgebra::{Matrix3, Vector3};
use robhaz_estimator::{
    Channels, Estimator, EstimatorSettings, LinkReading, NoiseBudget, SensorFrame, Sides,
};
use robhaz_model::{Carrier, GRAVITY, Robot, Vec2};

/// Half of the track, m: corner and middle wheels.
const HALF_TRACK: [f64; 3] = [0.184, 0.2556, 0.184];
/// Slip speed over T/N, m/s: soft tyres.
const CREEP: f64 = 0.01;

/// The side, with the pivot of the rocker at the body's centre of mass.
fn rover() -> Robot {
    let mut robot = Robot::default_a();
    let geometry = &mut robot.geometry;
    geometry.wheel_radius = 0.075;
    geometry.axles = [0.271, 0.0, -0.318].map(|x| Vec2::new(x, 0.075));
    geometry.carriers = [Carrier::Link1, Carrier::Link1, Carrier::Link2];
    geometry.body_cg = Vec2::new(-0.02, 0.265);
    geometry.link_cg = [
        Vec2::new(0.122, 0.106),
        Vec2::new(-0.105, 0.19),
        Vec2::zeros(),
    ];
    geometry.pins.q = Vec2::new(0.095, 0.169);
    geometry.make_bogie(Carrier::Link2);
    let mass = &mut robot.mass;
    (mass.body, mass.links, mass.wheel) = (2.9, [0.25, 0.35, 0.0], 0.95);
    (mass.wheel_inertia, mass.rotor_inertia) = (0.0009, 0.0029);
    robot
}

fn budget(robot: &Robot) -> NoiseBudget {
    NoiseBudget::typical_for(robot)
}

/// N of the wheels with tractions T on level ground, N: forces of the side along the vertical,
/// moments of the bogie about Q, moments of the side about the pivot, where the other side pushes
/// and the vertical load `share` (N) of a cross slope acts.
fn normal_forces(robot: &Robot, traction: [f64; 3], share: f64) -> [f64; 3] {
    let (geometry, mass) = (&robot.geometry, &robot.mass);
    let (q, p) = (geometry.pins.q, geometry.body_cg);
    let [x1, x2, x3] = geometry.axles.map(|axle| axle.x);
    let [bogie, rocker, _] = geometry.link_cg.map(|cg| cg.x);
    let [of_bogie, of_rocker, _] = mass.links;
    let weight = 3.0 * mass.wheel + of_bogie + of_rocker + mass.body;
    let about_q = mass.wheel * (x1 + x2 - 2.0 * q.x) + of_bogie * (bogie - q.x);
    let about_p = mass.wheel * (x1 + x2 + x3 - 3.0 * p.x)
        + of_bogie * (bogie - p.x)
        + of_rocker * (rocker - p.x);
    let [t1, t2, t3] = traction;
    let rows = Matrix3::new(
        1.0,
        1.0,
        1.0,
        x1 - q.x,
        x2 - q.x,
        0.0,
        x1 - p.x,
        x2 - p.x,
        x3 - p.x,
    );
    let right = Vector3::new(
        GRAVITY * weight + share,
        GRAVITY * about_q - q.y * (t1 + t2),
        GRAVITY * about_p - p.y * (t1 + t2 + t3),
    );
    rows.lu().solve(&right).unwrap().into()
}

/// Loads of the left side at rest on a cross slope, rad, left side up: the weight along the normal
/// of the ground, less what the slope moves to the right, `W (h sin phi)/b`.
fn on_cross_slope(robot: &Robot, slope: f64) -> [f64; 3] {
    let (geometry, mass) = (&robot.geometry, &robot.mass);
    let unit = normal_forces(robot, [0.0; 3], 1.0);
    let level = normal_forces(robot, [0.0; 3], 0.0);
    let shares = [0, 1, 2].map(|i| unit[i] - level[i]);
    let track: f64 = (0..3).map(|i| 2.0 * shares[i] * HALF_TRACK[i]).sum();
    let moment = 3.0 * mass.wheel * geometry.wheel_radius
        + mass.links[0] * geometry.link_cg[0].y
        + mass.links[1] * geometry.link_cg[1].y
        + mass.body * geometry.body_cg.y;
    let moved = 2.0 * GRAVITY * moment * slope.sin() / track;
    [0, 1, 2].map(|i| level[i] * slope.cos() - shares[i] * moved)
}

/// Noise with the standard deviation 1: the sum of twelve uniform numbers less 6.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            // Knuth's generator, MMIX.
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
            self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// Speeds of wheels over their mean, less 1: straight on; and of the inner side in a turn of 0.8 m, of which the corner
/// wheels are steered.
const STRAIGHT: [f64; 3] = [0.0; 3];
const IN_A_TURN: [f64; 3] = [0.04, -0.10, 0.06];

/// What an estimator states of a drive against the truth.
struct Result {
    /// RMS error of N over the mean load.
    error: f64,
    /// RMS of the stated deviation over the mean load.
    stated: f64,
    /// Share of the errors within two stated deviations.
    within: f64,
    /// The same of T.
    traction_within: f64,
    /// Largest estimated torque offset over its deviation.
    offset: f64,
    faulty: Channels,
}

/// A drive of 10 s at 100 Hz: rest until 1 s, 0.2 m/s from 1.6 s on, and a push (N, forward) of the
/// other side that all wheels resist alike, in full from 3 s on; wheels run `apart`. Errors count from 4 s on.
fn drive(sides: Sides, push: f64, apart: [f64; 3], truth: impl Fn(f64) -> [f64; 3]) -> Result {
    let robot = rover();
    let budget = budget(&robot);
    let settings = EstimatorSettings {
        viscous_damping: 0.044,
        budget,
        sides,
        ..EstimatorSettings::kalman_without_angles()
    };
    let mut estimator = Estimator::new(&robot, settings);
    let mean_load = robot.mean_wheel_load();
    let (radius, mass) = (robot.geometry.wheel_radius, &robot.mass);
    let inertia = mass.wheel_inertia + mass.rotor_inertia + radius * radius * mass.total() / 3.0;
    let mut noise = Noise(7);
    let offsets = [0, 1, 2].map(|_| budget.torque_offset * noise.next());
    let biases = [0, 1].map(|_| budget.inclination_bias * noise.next());
    let smooth = |u: f64| {
        let u = u.clamp(0.0, 1.0);
        u * u * (3.0 - 2.0 * u)
    };
    let dt = 0.01;
    let (mut turned, mut speed_before) = (0.0, 0.0);
    let (mut squares, mut stated, mut within, mut count) = (0.0, 0.0, [0.0; 2], 0.0);
    let (mut offset, mut faulty) = (0.0_f64, Channels::default());
    for k in 0..=1000_u32 {
        let time = dt * f64::from(k);
        let speed = 0.2 * smooth((time - 1.0) / 0.6);
        let pushed = push * smooth((time - 2.5) / 0.5);
        let traction = -pushed / 3.0;
        let rim = (speed + CREEP * traction / mean_load) / radius;
        let acceleration = (speed - speed_before) / radius / dt;
        speed_before = speed;
        turned += rim * dt;
        let torque = inertia * acceleration + 0.044 * rim + radius * traction;
        let link = |i: usize, noise: &mut Noise| LinkReading {
            inclination: Some(biases[i] + budget.inclination_noise * noise.next()),
            rate: Some(budget.rate_noise * noise.next()),
            rate_error: 0.0,
        };
        let count_size = std::f64::consts::TAU / budget.encoder_counts;
        let frame = SensorFrame {
            time,
            wheel_angle: [(0.0, 0), (0.31, 1), (-0.47, 2)].map(|(start, i): (f64, usize)| {
                let angle = start + turned * (1.0 + apart[i]);
                Some((angle / count_size).floor() * count_size)
            }),
            motor_torque: offsets.map(|o| Some(torque + o + budget.torque_noise * noise.next())),
            link1: link(0, &mut noise),
            link2: link(1, &mut noise),
            contact_angle: [None; 3],
            ..SensorFrame::default()
        };
        let estimate = estimator.update(&frame).unwrap();
        faulty |= estimate.kalman.unwrap().health.faulty;
        if time < 4.0 {
            continue;
        }
        let covariance = estimate.kalman.unwrap().covariance;
        for (i, expected) in truth(traction).into_iter().enumerate() {
            let error = estimate.normal_force[i] - expected;
            let variance = covariance[2 * i + 1][2 * i + 1];
            squares += error * error;
            stated += variance;
            within[0] += f64::from(u8::from(error * error < 4.0 * variance));
            let error = estimate.traction[i] - traction;
            let variance = covariance[2 * i][2 * i];
            within[1] += f64::from(u8::from(error * error < 4.0 * variance));
            count += 1.0;
        }
        for (value, sigma) in estimate.kalman.unwrap().reading_errors.torque_offset {
            offset = offset.max((value / sigma).abs());
        }
    }
    Result {
        error: f64::sqrt(squares / count) / mean_load,
        stated: f64::sqrt(stated / count) / mean_load,
        within: within[0] / count,
        traction_within: within[1] / count,
        offset,
        faulty,
    }
}

/// The closed form has the numbers of the rover in three dimensions, at 10 deg: six wheels on a
/// plane, by the roll balance of the whole rover. Its pivot is 1 mm ahead of and 4 mm below the
/// body's centre of mass, which moves 0.2 % of the body's weight of 28 N.
#[test]
fn the_closed_form_is_that_of_the_whole_rover() {
    let robot = rover();
    for (sign, expected) in [
        (1.0, [15.8275, 20.8107, 16.2938]),
        (-1.0, [20.0988, 28.7239, 20.9395]),
    ] {
        let found = on_cross_slope(&robot, sign * 10.0_f64.to_radians());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 0.06, "{found} {expected}");
        }
    }
}

/// Up to twice the prior of the cross slope nearly all errors are within two stated deviations, to
/// either side, and what is stated is not more than twice the error at the prior's slope. A robot in
/// the plane would be sure of what it does not know.
#[test]
fn a_cross_slope_is_within_the_stated_deviation() {
    let robot = rover();
    for degrees in [-10, -5, 0, 5, 10] {
        let truth = on_cross_slope(&robot, f64::from(degrees).to_radians());
        let found = drive(Sides::OneOfTwo, 0.0, STRAIGHT, |_| truth);
        let (error, stated) = (found.error, found.stated);
        assert!(found.within > 0.95, "{degrees} deg: {error} +- {stated}");
        assert_eq!(found.faulty, Channels::default());
        if degrees == 5 {
            assert!(stated < 2.0 * error, "{error} +- {stated}");
            let plane = drive(Sides::Plane, 0.0, STRAIGHT, |_| truth);
            assert!(plane.within < 0.05, "{}", plane.within);
        }
    }
}

/// A push of a quarter of the side's weight, which wheels with speed controls of their own reach:
/// over both directions the error is less than half of what it is where the equations know of no push,
/// nearly all errors are within two stated deviations, and the push becomes neither an alarm nor an
/// offset of the torques.
#[test]
fn a_push_of_the_other_side_is_no_error_of_a_reading() {
    let robot = rover();
    let mut squares = [0.0; 2];
    for push in [-15.0, 15.0] {
        let truth = |traction: f64| normal_forces(&robot, [traction; 3], 0.0);
        let found = drive(Sides::OneOfTwo, push, STRAIGHT, truth);
        let plane = drive(Sides::Plane, push, STRAIGHT, truth);
        let (error, stated) = (found.error, found.stated);
        squares[0] += error * error;
        squares[1] += plane.error * plane.error;
        assert!(found.within > 0.9, "{error} +- {stated}");
        assert_eq!(found.faulty, Channels::default());
        // Two deviations: the offsets drawn are within them.
        assert!(found.offset < 2.0, "{}", found.offset);
    }
    let [known, unknown] = squares;
    assert!(known < 0.25 * unknown, "{known} {unknown}");
}

/// Wheels of one side that run apart in a turn, by more than any creep, are no torque: T = 0 is within two stated deviations.
/// In the plane nothing else explains them.
#[test]
fn a_turn_is_no_traction() {
    let robot = rover();
    let truth = |traction: f64| normal_forces(&robot, [traction; 3], 0.0);
    let [found, plane] =
        [Sides::OneOfTwo, Sides::Plane].map(|sides| drive(sides, 0.0, IN_A_TURN, truth));
    let (one, in_plane) = (found.traction_within, plane.traction_within);
    assert!(one > 0.95 && in_plane < 0.7, "{one} {in_plane}");
    assert_eq!(found.faulty, Channels::default());
}

/// Without push and slope little is lost: N is right to 2 % of the mean load, and to twice the error
/// in the plane and half a percent.
#[test]
fn level_ground_is_as_exact_as_before() {
    let robot = rover();
    let truth = |traction: f64| normal_forces(&robot, [traction; 3], 0.0);
    let [found, plane] =
        [Sides::OneOfTwo, Sides::Plane].map(|sides| drive(sides, 0.0, STRAIGHT, truth));
    assert!(found.error < 0.02, "{} {}", found.error, plane.error);
    assert!(
        found.error < 2.0 * plane.error + 0.005,
        "{} {}",
        found.error,
        plane.error
    );
}

/// Stated deviation of N of the front wheel over the mean load, of one side of robot A that drives at 0.2 m/s on
/// waves of the ground, 0.2 m long, on which link 1 turns to and fro by `turn`, rad.
fn stated_of_four_bar(turn: f64, cross_slope: f64) -> f64 {
    let robot = Robot::default_a();
    let budget = NoiseBudget {
        cross_slope,
        ..budget(&robot)
    };
    let settings = EstimatorSettings {
        budget,
        sides: Sides::OneOfTwo,
        ..EstimatorSettings::kalman_without_angles()
    };
    let mut estimator = Estimator::new(&robot, settings);
    let mut noise = Noise(5);
    let (speed, wave) = (0.2, std::f64::consts::TAU);
    let mut stated = 0.0;
    for k in 0..=1000_u32 {
        let time = 0.01 * f64::from(k);
        let drives = (time - 1.0).max(0.0);
        let link = |angle: f64, rate: f64, noise: &mut Noise| LinkReading {
            inclination: Some(angle + budget.inclination_noise * noise.next()),
            rate: Some(rate + budget.rate_noise * noise.next()),
            rate_error: 0.0,
        };
        let moves = f64::from(u8::from(drives > 0.0));
        let frame = SensorFrame {
            time,
            wheel_angle: [Some(speed * drives / robot.geometry.wheel_radius); 3],
            motor_torque: [Some(budget.torque_noise * noise.next()); 3],
            link1: link(
                turn * (wave * drives).sin(),
                moves * turn * wave * (wave * drives).cos(),
                &mut noise,
            ),
            link2: link(0.0, 0.0, &mut noise),
            ..SensorFrame::default()
        };
        let estimate = estimator.update(&frame).unwrap();
        stated = estimate.kalman.unwrap().covariance[1][1].sqrt();
    }
    stated / robot.mean_wheel_load()
}

/// A body that is fixed to two four-bars is lifted by ground that is uneven across, up to where a wheel is in the air:
/// a moment of weight times wheelbase over sqrt(12), as standard deviation, which moves N of the front wheel by some 0.7
/// of the mean load. It counts where the side finds the ground uneven by more than its wheels give way, and not on
/// floors, whose cross slope is stated as 0.
#[test]
fn uneven_ground_twists_a_body_on_two_four_bars() {
    let slope = NoiseBudget::typical().cross_slope;
    let [floor, even, uneven] = [(0.1, 0.0), (0.0, slope), (0.1, slope)]
        .map(|(turn, slope)| stated_of_four_bar(turn, slope));
    assert!((0.55..0.85).contains(&uneven), "{uneven}");
    assert!(even < 0.25 * uneven, "{even} {uneven}");
    assert!(floor < 0.25 * uneven, "{floor} {uneven}");
}

//! The closed forms that the fit of a start must meet.

use super::super::smoothing::WheelReadings;
use super::*;

const DT: f64 = 1e-3;
const ROBOT: RollingRobot = RollingRobot {
    inertia: 0.42,
    damping: 0.45,
};

/// Motion of wheels (angle, speed, acceleration) that start at 0.5 s to 2 rad/s within 0.6 s, the
/// quintic start of the drive.
fn motion(time: f64) -> [f64; 3] {
    const RAMP: f64 = 0.6;
    let (s, speed) = (((time - 0.5) / RAMP).clamp(0.0, 1.0), 2.0);
    let beyond = (time - 0.5 - RAMP).max(0.0);
    [
        speed * (RAMP * s.powi(4) * (2.5 - 3.0 * s + s * s) + beyond),
        speed * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
        speed / RAMP * 30.0 * s * s * (1.0 - s) * (1.0 - s),
    ]
}

/// Ground and readings of a start.
#[derive(Debug)]
struct Given {
    inertia: f64,
    /// N m/rad
    curvature: f64,
    /// Dry friction of all gears, N m.
    friction: f64,
    /// Delay of the torques, s.
    late: f64,
}

const GOOD: Given = Given {
    inertia: 0.42,
    curvature: 0.0,
    friction: 0.0,
    late: 0.0,
};

/// Feeds the readings from one time to another (s).
fn feed(start: &mut Start, from: f64, until: f64, given: &Given) {
    let mut smoothing = Smoothing::default();
    for k in 0..((until - from) / DT) as u32 {
        let time = from + f64::from(k) * DT;
        let [angle, speed, acceleration] = motion(time - given.late);
        let friction = given.friction * (speed / 0.01).tanh();
        let torque =
            given.inertia * acceleration + 0.45 * speed + given.curvature * angle + friction;
        let readings = WheelReadings {
            torque: [0.2, 0.3, 0.5].map(|share| share * torque + 0.1),
            angle: [motion(time)[0]; 3],
        };
        if let Some(step) = smoothing.update(&readings, DT) {
            start.update(&step, &ROBOT);
        }
    }
}

/// Closed form: the delay of torques that are the robot's own of some time before is found on even
/// and on curved ground when the robot has moved for 0.8 s. What the first order in the difference
/// of d and one step leaves out is 20 ms over the time in which the torques change, 0.15 s,
/// squared, at most: 1 % of it, 0.2 ms; the differences over 20 ms leave as much. Dry friction of
/// 1.5 N m, more than the torque of the acceleration, is still rising in the smoothed torques: 3
/// ms.
#[test]
fn the_delay_of_a_start_is_found() {
    for (friction, tolerance) in [(0.0, 4e-4), (1.5, 3e-3)] {
        for curvature in [-0.5, 0.0, 0.5] {
            for (late, expected) in [(0.0, false), (0.004, false), (0.020, true), (0.030, true)] {
                let mut start = Start::default();
                let given = Given {
                    curvature,
                    friction,
                    late,
                    ..GOOD
                };
                feed(&mut start, 0.0, 2.0, &given);
                let (delay, sigma) = start.delay(0.01, &ROBOT).expect("a rolling robot");
                assert!(
                    (delay - late).abs() < tolerance,
                    "{given:?}: {delay} {sigma}"
                );
                assert_eq!(start.late, expected, "{given:?}: {delay} {sigma}");
            }
        }
    }
}

/// What one start found, a gap keeps and the next start repairs.
#[test]
fn the_next_start_repairs() {
    let mut start = Start::default();
    feed(&mut start, 0.0, 2.0, &Given { late: 0.02, ..GOOD });
    assert!(start.late);
    start.interrupt();
    feed(&mut start, 0.7, 3.0, &GOOD);
    assert!(start.late, "not a start from rest");
    feed(&mut start, 0.0, 2.0, &GOOD);
    assert!(!start.late);
}

/// Wheels that spin have a third less inertia, a robot that pushes something more; a log may begin
/// in the middle of a drive. None of these says anything, however late the torques are.
#[test]
fn what_is_no_start_of_this_robot_says_nothing() {
    for (from, inertia) in [(0.0, 0.28), (0.0, 0.60), (0.7, 0.42)] {
        let mut start = Start::default();
        let given = Given {
            inertia,
            late: 0.02,
            ..GOOD
        };
        feed(&mut start, from, 3.0, &given);
        assert!(!start.late, "{from} {inertia}");
    }
}

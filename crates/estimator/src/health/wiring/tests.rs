//! The closed forms that the fit of torques to encoders must meet.

use super::*;
use crate::health::answer::Lateness;
use libm::{cos, sin};

const DT: f64 = 1e-3;
const ROBOT: RollingRobot = RollingRobot {
    inertia: 0.42,
    damping: 0.45,
};

/// Wheels that oscillate about a common angle with frequencies of their own, under a PI control whose torques are read in
/// an order. The control is that of the sampled angles: the fit is exact but for the smoothing of the speed.
fn run(wiring: &mut Wiring, order: [usize; 3], size: f64, time: f64) {
    feed(wiring, order, size, time, 0);
}

/// The same with torques that are late by a number of samples.
fn feed(wiring: &mut Wiring, order: [usize; 3], size: f64, time: f64, late: u32) {
    for k in 0..(time / DT) as u32 {
        let t = f64::from(k) * DT;
        let before = t - f64::from(late) * DT;
        let speeds = [3.0, 4.1, 5.3];
        let ahead = speeds.map(|w| size * sin(w * before));
        let rate = speeds.map(|w| size * w * cos(w * before));
        let torque = order.map(|i| 0.5 - 50.0 * ahead[i] - 5.0 * rate[i]);
        let readings = WheelReadings {
            torque,
            angle: speeds.map(|w| 2.0 * t + size * sin(w * t)),
            drives: true,
        };
        wiring.update(Some(&readings), || ROBOT, 0.0, DT);
    }
}

/// Each exchange is found within 5 s, with the torques concerned, and forgotten when it is repaired.
#[test]
fn exchanged_torques_are_found_and_forgotten() {
    let orders = [
        [0, 1, 2],
        [1, 0, 2],
        [0, 2, 1],
        [2, 1, 0],
        [1, 2, 0],
        [2, 0, 1],
    ];
    for order in orders {
        let mut wiring = Wiring::default();
        run(&mut wiring, order, 0.02, 5.0);
        let moved = [0, 1, 2].map(|i| order[i] != i);
        assert_eq!(wiring.exchanged(), moved, "{order:?}");
        wiring.update(None, || ROBOT, 0.0, DT);
        assert_eq!(wiring.exchanged(), moved, "a gap repairs nothing");
        run(&mut wiring, [0, 1, 2], 0.02, 5.0);
        assert_eq!(wiring.exchanged(), [false; 3], "{order:?}");
    }
}

/// Closed form: the residual of the right pairing is zero but for the step of the sums.
#[test]
fn the_right_pairing_explains_all() {
    let mut wiring = Wiring::default();
    run(&mut wiring, [0, 2, 1], 0.02, 20.0);
    let explained = wiring.answer.shares()[2];
    assert!(explained > 0.99 && explained < 1.0 + 1e-9, "{explained}");
}

/// Closed form: sampled torques that are the control's of 20 ms before. The third order in d that the fit leaves out is
/// (5.3 rad/s 20 ms)^2/6 = 0.2 % of d, the sampling of speeds over 20 ms as much; exp(-30 s/2 s) of what was before remains,
/// and its sigma says so: 1 ms and 3 sigma are enough for all. 5 ms are a control's own.
#[test]
fn late_torques_are_found_and_forgotten() {
    let mut wiring = Wiring::default();
    for (late, expected) in [(20, true), (0, false), (5, false), (30, true)] {
        feed(&mut wiring, [0, 1, 2], 0.02, 30.0, late);
        let found = wiring.answer.lateness(0.0).expect("a fit");
        let error = found.delay - f64::from(late) * DT;
        assert!(error.abs() < 1e-3 + 3.0 * found.sigma, "{late}: {found:?}");
        assert_eq!(wiring.late(), expected, "{late}: {found:?}");
        assert_eq!(wiring.exchanged(), [false; 3], "{late}");
    }
    wiring.update(None, || ROBOT, 0.0, DT);
    assert!(wiring.late(), "a gap repairs nothing");
}

/// Closed form: torques of a common obstacle, of gains that differ, make differences that look like a delay. With the gains'
/// deviation the error is within three sigma at each instant; without it the fit is sure of a delay that is not there.
#[test]
fn gains_that_differ_are_no_delay() {
    const GAIN: f64 = 0.02;
    let (mut wiring, mut surely_wrong) = (Wiring::default(), 0);
    for k in 0..30_000 {
        let t = f64::from(k) * DT;
        let speeds = [3.0, 4.1, 5.3];
        let gains = [1.0 + GAIN, 1.0, 1.0 - GAIN];
        let common = 3.0 * sin(2.3 * t);
        let torque = [0, 1, 2].map(|i| {
            let w = speeds[i];
            gains[i] * (common - 0.005 * (50.0 * sin(w * t) + 5.0 * w * cos(w * t)))
        });
        let readings = WheelReadings {
            torque,
            angle: speeds.map(|w| 2.0 * t + 0.005 * sin(w * t)),
            drives: true,
        };
        wiring.update(Some(&readings), || ROBOT, GAIN, DT);
        if k > 5000 {
            let [found, without] = [GAIN, 0.0].map(|gain| wiring.answer.lateness(gain));
            let is_off = |found: Lateness| found.delay.abs() > 3.0 * found.sigma;
            assert!(!found.is_some_and(is_off), "{t}: {found:?}");
            surely_wrong += u32::from(without.is_some_and(is_off));
        }
    }
    assert!(!wiring.late() && surely_wrong > 1000, "{surely_wrong}");
}

/// Torques whose differences are 0.1 N m say nothing, nor do a robot at rest and torques that drive a wheel that is ahead.
#[test]
fn small_differences_say_nothing() {
    let mut wiring = Wiring::default();
    run(&mut wiring, [0, 2, 1], 0.002, 20.0);
    assert_eq!(wiring.exchanged(), [false; 3]);
    let mut wiring = Wiring::default();
    for k in 0..20_000 {
        let t = f64::from(k) * DT;
        let speeds = [3.0, 4.1, 5.3];
        let ahead = speeds.map(|w| 0.02 * sin(w * t));
        let [a, b, c] = speeds.map(|w| 0.02 * (50.0 * sin(w * t) + 5.0 * w * cos(w * t)));
        let readings = WheelReadings {
            torque: [a, c, b],
            angle: ahead,
            drives: true,
        };
        wiring.update(Some(&readings), || ROBOT, 0.0, DT);
    }
    assert_eq!(wiring.exchanged(), [false; 3]);
}

//! The closed forms that the fit of torques to encoders must meet.

use super::*;
use libm::{cos, sin};

const DT: f64 = 1e-3;
const ROBOT: RollingRobot = RollingRobot {
    inertia: 0.42,
    damping: 0.45,
};

/// Wheels that oscillate about a common angle with frequencies of their own, under a PI control
/// whose torques are read in an order. The control is that of the sampled angles: the fit is exact
/// but for the smoothing of the speed.
fn run(wiring: &mut Wiring, order: [usize; 3], size: f64, time: f64) {
    for k in 0..(time / DT) as u32 {
        let t = f64::from(k) * DT;
        let speeds = [3.0, 4.1, 5.3];
        let ahead = speeds.map(|w| size * sin(w * t));
        let rate = speeds.map(|w| size * w * cos(w * t));
        let torque = order.map(|i| 0.5 - 50.0 * ahead[i] - 5.0 * rate[i]);
        let readings = WheelReadings {
            torque,
            angle: speeds.map(|w| 2.0 * t + size * sin(w * t)),
        };
        wiring.update(Some(&readings), true, &ROBOT, DT);
    }
}

/// Each exchange is found within 5 s, with the torques concerned, and cleared when it is
/// repaired.
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
        assert_eq!(wiring.exchanged, moved, "{order:?}");
        wiring.update(None, true, &ROBOT, DT);
        assert_eq!(wiring.exchanged, moved, "a gap repairs nothing");
        run(&mut wiring, [0, 1, 2], 0.02, 5.0);
        assert_eq!(wiring.exchanged, [false; 3], "{order:?}");
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

/// Torques whose differences are 0.1 N m say nothing, nor do a robot at rest and torques that drive
/// a wheel that is ahead.
#[test]
fn small_differences_say_nothing() {
    let mut wiring = Wiring::default();
    run(&mut wiring, [0, 2, 1], 0.002, 20.0);
    assert_eq!(wiring.exchanged, [false; 3]);
    let mut wiring = Wiring::default();
    for k in 0..20_000 {
        let t = f64::from(k) * DT;
        let speeds = [3.0, 4.1, 5.3];
        let ahead = speeds.map(|w| 0.02 * sin(w * t));
        let [a, b, c] = speeds.map(|w| 0.02 * (50.0 * sin(w * t) + 5.0 * w * cos(w * t)));
        let readings = WheelReadings {
            torque: [a, c, b],
            angle: ahead,
        };
        wiring.update(Some(&readings), true, &ROBOT, DT);
    }
    assert_eq!(wiring.exchanged, [false; 3]);
}

/// Torques commanded apart on purpose, whose wheels creep ahead in proportion, are none of another
/// wheel: another pairing would fit them as a stable control.
#[test]
fn wheels_commanded_apart_are_not_exchanged() {
    let mut wiring = Wiring::default();
    for k in 0..20_000 {
        let t = f64::from(k) * DT;
        // Wheel 1 takes over from wheel 2, the third one rolls.
        let (pull, crept) = (sin(2.0 * t), (1.0 - cos(2.0 * t)) / 2.0);
        let ahead = |share: f64| 2.0 * t + 0.02 * share * crept;
        let readings = WheelReadings {
            torque: [0.5 + pull, 0.5 - pull, 0.5],
            angle: [ahead(1.0), ahead(-1.0), ahead(0.0)],
        };
        wiring.update(Some(&readings), true, &ROBOT, DT);
        assert_eq!(wiring.exchanged, [false; 3], "{t}");
    }
    assert!(wiring.answer.shares()[0] > 0.9);
}

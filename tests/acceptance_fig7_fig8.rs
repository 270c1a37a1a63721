//! Figs. 7 and 8: estimates of N with the linkage's mass lumped to the body or to the wheels.

use crate::support::{Kept, keep, scene};

/// NRMSE of `paper-body`, `paper-wheels`, `true-mass` from 2 s on, %.
fn errors(kept: &Kept) -> [f64; 3] {
    [0, 1, 2].map(|i| 100.0 * kept.nrmse(i, 2.0))
}

/// Tolerance, %: half of the last digit of the independent implementation's figures, and an
/// allowance for the discretisation of eq. (3).
const TOLERANCE: f64 = 0.1;

fn assert_close(found: [f64; 3], expected: [f64; 3]) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(
            (found - expected).abs() < TOLERANCE,
            "{found:.3} %, expected {expected} %"
        );
    }
}

/// Acceptance of the paper's claim "better performance is observed with the second case that the
/// mass of linkages is lumped in the wheels evenly", for the PI drive. The expected figures are
/// those of an independent implementation.
#[test]
fn lumped_to_wheels_beats_lumped_to_body() {
    wheels_beat_body(&[], [10.9, 7.6, 2.5]);
}

/// The same claim with the low-gain drive.
#[test]
fn lumped_to_wheels_beats_lumped_to_body_with_the_soft_drive() {
    wheels_beat_body(&["drive.kp=2", "drive.ki=0"], [11.1, 7.5, 1.7]);
}

fn wheels_beat_body(drive: &[&str], expected: [f64; 3]) {
    let found = errors(&keep(&scene("smooth", drive)));
    let [body, wheels, true_mass] = found;
    println!("paper-body {body:.2} %, paper-wheels {wheels:.2} %, true-mass {true_mass:.2} %");
    assert!(wheels < body);
    assert_close(found, expected);
}

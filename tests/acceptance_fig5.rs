//! Fig. 5: "the position analysis of 4-bar linkage in the robot properly performed", from two inclinometers and gyros.

use crate::support::{keep, scene};
use robhaz_model::Pin;

/// Claim: the linkage's position follows from the sensors on links 1 and 2 alone. With ideal sensors the estimate of every
/// pin, seen from Q, is within 0.1 mm of the simulation's; what is left is the trapezoidal rule on the gyro's rate.
#[test]
fn pins_are_found_from_two_links() {
    let kept = keep(&scene("smooth", &["record.duration=12"]));
    let mut greatest = 0.0_f64;
    for (truth, estimate) in kept.truth.iter().zip(&kept.estimates[0]) {
        let estimate = estimate.as_ref().unwrap();
        let q = truth.pin(Pin::Q).position;
        for (i, pin) in Pin::ALL.into_iter().enumerate() {
            let error = (truth.pin(pin).position - q - estimate.pin_from_q[i]).norm();
            greatest = greatest.max(error);
        }
    }
    println!("greatest error of a pin's position: {greatest:.2e} m");
    assert!(greatest < 1e-4, "{greatest}");
    // The test would be empty if the linkage stood still.
    let turn = kept
        .truth
        .iter()
        .map(|t| (t.links[0].angle - t.links[1].angle).abs())
        .fold(0.0, f64::max);
    assert!(turn > 0.2, "{turn}");
}

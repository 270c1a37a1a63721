//! Fig. 5: "the position analysis of 4-bar linkage in the robot properly performed", from two
//! inclinometers and gyros.

use crate::support::{keep, scene};
use robhaz_model::Pin;

/// Acceptance: the sensors on links 1 and 2 determine the position of the linkage. With ideal
/// sensors the estimated position of every pin relative to Q is within 0.1 mm of the truth; the
/// rest is the error of the trapezoidal rule on the gyro's rate.
#[test]
fn the_sensors_of_two_links_give_the_pin_positions() {
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
    // The linkage must move, or the test proves nothing.
    let turn = kept
        .truth
        .iter()
        .map(|t| (t.links[0].angle - t.links[1].angle).abs())
        .fold(0.0, f64::max);
    assert!(turn > 0.2, "{turn}");
}

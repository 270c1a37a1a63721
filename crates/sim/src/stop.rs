//! End stops of pin Q: the paper's "limited pin joint".

use robhaz_model::PinStop;

/// Torque of the stops on link 1, N m counter-clockwise (its opposite acts on link 2).
///
/// `angle` is theta_1 - theta_2 (rad), `rate` its rate (rad/s). Zero between the limits; beyond one,
/// `-(k (angle - limit) + c rate)`, and never pulling back towards the limit.
pub fn stop_torque(stop: &PinStop, angle: f64, rate: f64) -> f64 {
    if angle > stop.upper {
        (-(stop.stiffness * (angle - stop.upper) + stop.damping * rate)).min(0.0)
    } else if angle < stop.lower {
        (-(stop.stiffness * (angle - stop.lower) + stop.damping * rate)).max(0.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pushes_back_and_never_pulls() {
        let stop = PinStop::standard();
        assert!(stop_torque(&stop, 0.0, 5.0) == 0.0);
        assert!((stop_torque(&stop, stop.upper + 0.01, 0.0) + 20.0).abs() < 1e-9);
        assert!((stop_torque(&stop, stop.lower - 0.01, 0.0) - 20.0).abs() < 1e-9);
        assert!(stop_torque(&stop, stop.upper + 0.001, -1.0) == 0.0);
        assert!(stop_torque(&stop, stop.lower - 0.001, 1.0) == 0.0);
    }
}

//! End stops of pin Q: the paper's "limited pin joint".

use robhaz_model::PinStop;

/// Torque of the stops on link 1, N m counter-clockwise (its opposite acts on link 2).
///
/// `angle` is theta_1 - theta_2 (rad), `rate` its rate (rad/s). The torque is zero between the
/// limits and `-(k (angle - limit) + c rate)` beyond a limit. It never acts away from the free
/// range: a stop cannot hold the bars back.
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
    fn stops_push_towards_the_free_range_and_never_away_from_it() {
        let stop = PinStop::standard();
        assert!(stop_torque(&stop, 0.0, 5.0) == 0.0);
        assert!((stop_torque(&stop, stop.upper + 0.01, 0.0) + 20.0).abs() < 1e-9);
        assert!((stop_torque(&stop, stop.lower - 0.01, 0.0) - 20.0).abs() < 1e-9);
        assert!(stop_torque(&stop, stop.upper + 0.001, -1.0) == 0.0);
        assert!(stop_torque(&stop, stop.lower - 0.001, 1.0) == 0.0);
    }
}

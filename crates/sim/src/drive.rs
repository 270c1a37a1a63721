//! The drive in the wheel: eq. (2) with its inertias told apart, and the speed control.

/// Speed control and losses of the three drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Set speed of travel, m/s; the wheels' set speed is this over the wheel radius.
    pub speed: f64,
    /// Proportional gain Kp, N m s.
    pub kp: f64,
    /// Integral gain Ki, N m.
    pub ki: f64,
    /// Greatest motor torque at the wheel, N m.
    pub torque_limit: f64,
    /// Viscous damping B in the wheel module, N m s.
    pub viscous_damping: f64,
    /// Time of rest before the start, s.
    pub start_time: f64,
    /// Duration of the smooth start from rest to the set speed, s.
    pub ramp_time: f64,
}

impl Default for Drive {
    /// The PI drive: 0.20 m/s, Kp = 5 N m s, Ki = 50 N m, 10 N m, B = 0.15 N m s, start at 0.8 s over 0.6 s.
    fn default() -> Self {
        Self {
            speed: 0.20,
            kp: 5.0,
            ki: 50.0,
            torque_limit: 10.0,
            viscous_damping: 0.15,
            start_time: 0.8,
            ramp_time: 0.6,
        }
    }
}

impl Drive {
    /// Set wheel speed at time `t`, rad/s: rest until the start, then a quintic ramp (no jump in acceleration).
    pub fn set_speed(&self, t: f64, wheel_radius: f64) -> f64 {
        let u = if self.ramp_time > 0.0 {
            ((t - self.start_time) / self.ramp_time).clamp(0.0, 1.0)
        } else {
            f64::from(t >= self.start_time)
        };
        self.speed / wheel_radius * u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
    }

    /// Motor torque at the wheel, N m, for a speed error `e` (rad/s) and its integral (rad), within the limit.
    pub fn torque(&self, error: f64, integral: f64) -> f64 {
        (self.kp * error + self.ki * integral).clamp(-self.torque_limit, self.torque_limit)
    }

    /// Rate of the integral of the error, rad/s: the error, or 0 while it would drive a saturated motor further.
    pub fn integral_rate(&self, error: f64, integral: f64) -> f64 {
        let wanted = self.kp * error + self.ki * integral;
        if wanted.abs() > self.torque_limit && wanted * error > 0.0 {
            0.0
        } else {
            error
        }
    }
}

/// Angular acceleration of a wheel relative to its link, rad/s^2: eq. (2) with the inertias told apart,
/// `J_wheel (domega/dt - alpha_link) + J_rotor domega/dt = tau - B omega - d T`.
///
/// `drive_torque` is `tau - B omega` (N m), `ground_torque` is `d T` (N m), `alpha_link` is counter-clockwise (rad/s^2).
pub fn wheel_acceleration(
    drive_torque: f64,
    ground_torque: f64,
    alpha_link: f64,
    wheel_inertia: f64,
    rotor_inertia: f64,
) -> f64 {
    (drive_torque - ground_torque + wheel_inertia * alpha_link) / (wheel_inertia + rotor_inertia)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_smoothly_and_reaches_the_set_speed() {
        let drive = Drive::default();
        assert!(drive.set_speed(0.8, 0.1) == 0.0);
        assert!((drive.set_speed(1.1, 0.1) - 1.0).abs() < 1e-14);
        assert!((drive.set_speed(1.4, 0.1) - 2.0).abs() < 1e-14);
        assert!((drive.set_speed(9.0, 0.1) - 2.0).abs() < 1e-14);
    }

    #[test]
    fn integral_stands_still_in_saturation_and_leaves_it() {
        let drive = Drive::default();
        assert!((drive.torque(3.0, 0.0) - 10.0).abs() < 1e-15);
        assert!(drive.integral_rate(3.0, 0.0) == 0.0);
        assert!((drive.integral_rate(-0.1, 0.5) + 0.1).abs() < 1e-15);
    }
}

//! Speed of a wheel from its encoder.

/// Differences of encoder readings through a low-pass filter of first order.
///
/// Quantisation of 160 000 counts a turn gives 1 mrad/s RMS at 1 kHz, 5 mN m at Kp = 5 N m s.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelSpeed {
    /// Last angle (rad) and its time (s).
    last: Option<(f64, f64)>,
    /// rad/s
    speed: f64,
}

impl WheelSpeed {
    /// Time constant of the filter, s. A wheel in the air follows its set speed with the time
    /// constant J/Kp = 19 ms for the default robot and gains.
    pub const TIME_CONSTANT: f64 = 5e-3;
    /// Largest plausible speed, rad/s: 20 m/s at the rim. An encoder that jumps farther was reset.
    const LARGEST: f64 = 200.0;

    /// Takes a reading (rad) at a time (s). Returns the speed, rad/s; without a reading the last
    /// one.
    pub fn update(&mut self, time: f64, angle: Option<f64>) -> f64 {
        let Some(angle) = angle.filter(|angle| angle.is_finite()) else {
            return self.speed;
        };
        if let Some((last_angle, last_time)) = self.last.replace((angle, time)) {
            let dt = time - last_time;
            let speed = (angle - last_angle) / dt;
            // Written so that a NaN fails.
            if dt > 0.0 && speed.abs() <= Self::LARGEST {
                self.speed += (speed - self.speed) * dt / (dt + Self::TIME_CONSTANT);
            }
        }
        self.speed
    }
}

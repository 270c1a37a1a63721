//! Link angle of the paper: a complementary filter of gyroscope and inclinometer (Fig. 5).

/// One link's angle from its rate gyroscope and its inclinometer: a complementary filter.
///
/// `d theta/dt = rate + (inclination - theta)/T`: the gyroscope counts over times shorter than the
/// crossover time T, the inclinometer over longer times. With exact readings the filter is exact up
/// to the integration of the rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ComplementaryFilter {
    /// T, s, above 0.
    pub crossover_time: f64,
    /// Last angle, rad, and rate, rad/s; `None` before the first reading.
    pub last: Option<(f64, f64)>,
}

impl ComplementaryFilter {
    /// Angle of the link, rad, after a reading `dt` seconds after the last one: `rate` in rad/s,
    /// `inclination` in rad.
    ///
    /// The first reading starts the filter at the inclinometer.
    pub fn update(&mut self, dt: f64, rate: f64, inclination: f64) -> f64 {
        let mut angle = inclination;
        if let Some((last_angle, last_rate)) = self.last {
            let predicted = last_angle + 0.5 * (rate + last_rate) * dt;
            angle = predicted + (inclination - predicted) * dt / (self.crossover_time + dt);
        }
        self.last = Some((angle, rate));
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a biased gyroscope leaves an offset of bias times crossover time.
    #[test]
    fn a_gyro_bias_leaves_bias_times_crossover_time() {
        let mut filter = ComplementaryFilter {
            crossover_time: 0.5,
            last: None,
        };
        let mut angle = 0.0;
        for _ in 0..20_000 {
            angle = filter.update(1e-3, 0.02, 0.1);
        }
        assert!((angle - (0.1 + 0.02 * 0.5)).abs() < 1e-9, "{angle}");
    }

    /// Exact readings of a swinging link: the error is that of the trapezoidal rule, (w dt)^2/12 of
    /// the amplitude, at most.
    #[test]
    fn exact_readings_give_the_exact_angle() {
        let mut filter = ComplementaryFilter {
            crossover_time: 0.5,
            last: None,
        };
        let (dt, w, a) = (1e-3, 6.0, 0.3);
        for k in 0..5000 {
            let t = dt * f64::from(k);
            let truth = a * libm::sin(w * t);
            let angle = filter.update(dt, a * w * libm::cos(w * t), truth);
            assert!((angle - truth).abs() < a * (w * dt) * (w * dt) / 6.0);
        }
    }
}

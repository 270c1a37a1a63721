//! The paper's filters: a complementary filter of gyroscope and inclinometer for the link angle
//! (Fig. 5), and the traction of a wheel from motor torque and wheel speed (eq. (3)).

/// One link's angle from its rate gyroscope and its inclinometer: a complementary filter.
///
/// `d theta/dt = rate + (inclination - theta)/T`: the gyroscope counts over times shorter than the
/// crossover time T, the inclinometer over longer times. With exact readings the filter is exact up
/// to the integration of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The paper's disturbance observer, `T = omega_c/(r (s + omega_c)) [tau - (J s + B) omega]`, eq.
/// (3).
///
/// The derivative is never formed: with `L` the low-pass `omega_c/(s + omega_c)`,
/// `r T = L[tau - B omega + J omega_c omega] - J omega_c omega`. `L` is discretised by the
/// trapezoidal rule.
///
/// It starts with its first reading, as if that reading had lasted for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TractionObserver {
    /// Pole of the observer omega_c, rad/s.
    pub pole: f64,
    /// Inertia J of wheel and rotor together, kg m^2.
    pub inertia: f64,
    /// Internal damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Arm of the traction: the wheel radius r, m.
    pub wheel_radius: f64,
    /// Last input and output of `L`, N m; `None` before the first reading.
    pub last: Option<(f64, f64)>,
}

impl TractionObserver {
    /// Traction T, N, from motor torque `tau` (N m) and wheel speed `omega` (rad/s), `dt` seconds
    /// after the last reading.
    pub fn update(&mut self, dt: f64, tau: f64, omega: f64) -> f64 {
        let momentum = self.inertia * self.pole * omega;
        let input = tau - self.viscous_damping * omega + momentum;
        let mut output = input;
        if let Some((last_input, last_output)) = self.last {
            let half = 0.5 * self.pole * dt;
            output = ((1.0 - half) * last_output + half * (input + last_input)) / (1.0 + half);
        }
        self.last = Some((input, output));
        (output - momentum) / self.wheel_radius
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

    const OBSERVER: TractionObserver = TractionObserver {
        pole: 50.0,
        inertia: 0.0939,
        viscous_damping: 0.15,
        wheel_radius: 0.1,
        last: None,
    };

    /// Closed form: at constant speed `r T = tau - B omega`.
    #[test]
    fn steady_rolling() {
        let mut observer = OBSERVER;
        let mut traction = 0.0;
        for _ in 0..1000 {
            traction = observer.update(1e-3, 0.8, 2.0);
        }
        assert!((traction - 5.0).abs() < 1e-12);
    }

    /// Closed form: a step of T shows as `1 - exp(-omega_c t)`, whatever the torque and speed that
    /// it causes.
    #[test]
    fn a_step_of_traction_shows_with_the_lag_of_the_pole() {
        let mut observer = OBSERVER;
        let (dt, inertia) = (1e-4, OBSERVER.inertia);
        observer.update(dt, 0.0, 0.0);
        let mut omega = 0.0;
        for k in 1..=2000 {
            // Wheel without drive under T = 10 N: J domega/dt = -r T - B omega, integrated exactly.
            let decay = libm::exp(-OBSERVER.viscous_damping / inertia * dt);
            let rest = -1.0 / OBSERVER.viscous_damping;
            omega = rest + (omega - rest) * decay;
            let traction = observer.update(dt, 0.0, omega);
            let expected = 10.0 * (1.0 - libm::exp(-50.0 * dt * f64::from(k)));
            // The trapezoidal rule errs by (omega_c dt)^2/12 = 2e-6 of the step.
            assert!(
                (traction - expected).abs() < 1e-4,
                "{k}: {traction} {expected}"
            );
        }
    }
}

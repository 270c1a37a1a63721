//! Traction of a wheel from motor torque and wheel speed: eq. (3).

/// The paper's disturbance observer, `T = omega_c/(r (s + omega_c)) [tau - (J s + B) omega]`, eq.
/// (3).
///
/// The derivative is never formed: with `L` the low-pass `omega_c/(s + omega_c)`,
/// `r T = L[tau - B omega + J omega_c omega] - J omega_c omega`. `L` is discretised by the
/// trapezoidal rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TractionObserver {
    parameters: ObserverParameters,
    /// Last input and output of `L`, N m.
    input: f64,
    output: f64,
    started: bool,
}

/// Parameters of eq. (3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserverParameters {
    /// Pole of the observer omega_c, rad/s.
    pub pole: f64,
    /// Inertia J of wheel and rotor together, kg m^2.
    pub inertia: f64,
    /// Internal damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Arm of the traction: the wheel radius r, m.
    pub wheel_radius: f64,
}

impl TractionObserver {
    /// An observer that starts with its first reading, as if that reading had lasted for ever.
    pub fn new(parameters: ObserverParameters) -> Self {
        Self {
            parameters,
            input: 0.0,
            output: 0.0,
            started: false,
        }
    }

    /// Traction T, N, from motor torque `tau` (N m) and wheel speed `omega` (rad/s), `dt` seconds
    /// after the last reading.
    pub fn update(&mut self, dt: f64, tau: f64, omega: f64) -> f64 {
        let p = &self.parameters;
        let momentum = p.inertia * p.pole * omega;
        let input = tau - p.viscous_damping * omega + momentum;
        let mut output = input;
        if self.started {
            let half = 0.5 * p.pole * dt;
            output = ((1.0 - half) * self.output + half * (input + self.input)) / (1.0 + half);
        }
        (self.input, self.output, self.started) = (input, output, true);
        (output - momentum) / p.wheel_radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMETERS: ObserverParameters = ObserverParameters {
        pole: 50.0,
        inertia: 0.0939,
        viscous_damping: 0.15,
        wheel_radius: 0.1,
    };

    /// Closed form: at constant speed `r T = tau - B omega`.
    #[test]
    fn steady_rolling() {
        let mut observer = TractionObserver::new(PARAMETERS);
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
        let mut observer = TractionObserver::new(PARAMETERS);
        let (dt, inertia) = (1e-4, PARAMETERS.inertia);
        observer.update(dt, 0.0, 0.0);
        let mut omega = 0.0;
        for k in 1..=2000 {
            // Wheel without drive under T = 10 N: J domega/dt = -r T - B omega, integrated exactly.
            let decay = libm::exp(-PARAMETERS.viscous_damping / inertia * dt);
            let rest = -1.0 / PARAMETERS.viscous_damping;
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

//! Normal force between wheel and ground, eq. (10).

use robhaz_model::Robot;

/// The law `N = max(0, k g^n + c(g) dg/dt)` for a penetration `g > 0`, eq. (10).
///
/// `c(g)` is constant, or rises from 0 to `damping` in a cubic step over `0 < g < damping_ramp`
/// (ADAMS's function IMPACT). Neither that rise nor the clamp at zero is in the paper: its c is
/// constant, and N of eq. (10) as printed can be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Stiffness k, N/m^n.
    pub stiffness: f64,
    /// Exponent n, -.
    pub exponent: f64,
    /// Damping c, N s/m.
    pub damping: f64,
    /// Penetration over which the damping rises from 0 to c, m; 0 for a constant c.
    pub damping_ramp: f64,
}

impl Default for ContactLaw {
    /// k = 150 N/mm^2.1, n = 2.1, c = 20 N s/mm; c rises over 0.1 mm.
    fn default() -> Self {
        let exponent = 2.1;
        Self {
            stiffness: 150.0 * 1000.0_f64.powf(exponent),
            exponent,
            damping: 2.0e4,
            damping_ramp: 1.0e-4,
        }
    }
}

impl ContactLaw {
    /// Normal force N >= 0, N, at penetration `g` (m) and its rate `g_rate` (m/s). Zero for
    /// `g <= 0`.
    pub fn normal_force(&self, g: f64, g_rate: f64) -> f64 {
        self.at(g, g_rate, |g| g.powf(self.exponent)).force()
    }

    /// The law at penetration `g` (m) and its rate `g_rate` (m/s). Everything is zero for `g <= 0`.
    /// `power` is the n-th power of a positive number.
    #[inline]
    pub(crate) fn at(&self, g: f64, g_rate: f64, power: impl Fn(f64) -> f64) -> NormalForce {
        if g <= 0.0 {
            return NormalForce::default();
        }
        let damping = self.damping * cubic_step(g, 0.0, 0.0, self.damping_ramp, 1.0);
        let spring = self.stiffness * power(g);
        NormalForce {
            stiffness: self.exponent * spring / g,
            damping,
            unclamped: spring + damping * g_rate,
            energy: spring * g / (self.exponent + 1.0),
        }
    }

    /// Penetration of a wheel at rest under the mean wheel load of a robot, m.
    pub fn mean_penetration(&self, robot: &Robot) -> f64 {
        self.static_penetration(robot.mean_wheel_load())
    }

    /// Penetration of a wheel at rest under `load` (N), m: the inverse of eq. (10) with dg/dt = 0.
    pub fn static_penetration(&self, load: f64) -> f64 {
        (load / self.stiffness).powf(1.0 / self.exponent)
    }
}

/// The parts of eq. (10) at one penetration and rate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NormalForce {
    /// Tangent stiffness of the spring, `k n g^(n - 1)`, N/m.
    pub stiffness: f64,
    /// c(g), N s/m.
    pub damping: f64,
    /// `k g^n + c(g) dg/dt`, N: negative where eq. (10) as printed would pull.
    pub unclamped: f64,
    /// Elastic energy, `k g^(n + 1)/(n + 1)`, J.
    pub energy: f64,
}

impl NormalForce {
    /// N >= 0, N.
    pub fn force(&self) -> f64 {
        self.unclamped.max(0.0)
    }
}

/// Cubic step from `y0` at `x <= x0` to `y1` at `x >= x1`, with slope zero at both ends (ADAMS's
/// function STEP). It jumps if `x0 == x1`.
#[inline]
pub(crate) fn cubic_step(x: f64, x0: f64, y0: f64, x1: f64, y1: f64) -> f64 {
    if x >= x1 {
        y1
    } else if x <= x0 {
        y0
    } else {
        let u = (x - x0) / (x1 - x0);
        y0 + (y1 - y0) * u * u * (3.0 - 2.0 * u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: at the mean load of 45.78 N the penetration is 0.568 mm and the tangent
    /// stiffness 169 N/mm.
    #[test]
    fn static_penetration_and_stiffness_at_the_mean_load() {
        let law = ContactLaw::default();
        let g = law.static_penetration(45.78);
        assert!((g - 0.568_282_211e-3).abs() < 1e-12, "{g}");
        assert!((law.normal_force(g, 0.0) - 45.78).abs() < 1e-10);
        let tangent = (law.normal_force(g + 1e-9, 0.0) - law.normal_force(g - 1e-9, 0.0)) / 2e-9;
        assert!((tangent - 169.0e3).abs() < 0.5e3, "{tangent}");
    }

    /// Closed form: eq. (10) evaluated in mm over a grid of penetrations and rates, with constant
    /// and with rising c.
    #[test]
    fn law_equals_eq_10_in_millimetres() {
        for ramp in [0.0, 1e-4] {
            let law = ContactLaw {
                damping_ramp: ramp,
                ..ContactLaw::default()
            };
            for i in 1..200 {
                for j in -10..=10 {
                    let (g_mm, rate_mm) = (f64::from(i) * 0.01, f64::from(j) * 0.7);
                    let u = if ramp > 0.0 {
                        (g_mm / 0.1).min(1.0)
                    } else {
                        1.0
                    };
                    let c = 20.0 * (3.0 * u.powi(2) - 2.0 * u.powi(3));
                    let expected = (150.0 * g_mm.powf(2.1) + c * rate_mm).max(0.0);
                    let found = law.normal_force(g_mm * 1e-3, rate_mm * 1e-3);
                    // The two evaluations round differently: 1e-13 of the largest force (790 N).
                    assert!(
                        (found - expected).abs() < 1e-10,
                        "g {g_mm} rate {rate_mm}: {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_normal_force_is_zero_in_the_air_and_never_negative() {
        let law = ContactLaw::default();
        assert!(law.normal_force(-1e-6, 1.0) == 0.0);
        assert!(law.normal_force(1e-5, -1.0) == 0.0);
    }
}

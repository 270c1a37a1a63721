//! Traction of a sliding wheel: eq. (11), `T = mu(v) N`.

use crate::contact::cubic_step;

/// Friction coefficient over the slip speed, in ADAMS's form.
///
/// A cubic from `-mu_s` to `+mu_s` inside `|v| <= v_s`, a cubic from `mu_s` to `mu_d` between `v_s` and `v_d`, `mu_d`
/// beyond. The paper's eq. (11) says `T = mu N`, which holds in sliding only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
    /// Slip speed of the static coefficient, m/s.
    pub v_s: f64,
    /// Slip speed from which the dynamic coefficient holds, m/s.
    pub v_d: f64,
}

impl Default for FrictionLaw {
    /// mu_s = 0.8, mu_d = 0.7, v_s = 0.02 m/s, v_d = 0.10 m/s.
    fn default() -> Self {
        Self {
            mu_s: 0.8,
            mu_d: 0.7,
            v_s: 0.02,
            v_d: 0.10,
        }
    }
}

impl FrictionLaw {
    /// Coefficient mu(v), with the sign of the slip speed `v` (m/s, positive when the rim outruns the ground).
    pub fn coefficient(&self, v: f64) -> f64 {
        if v.abs() <= self.v_s {
            cubic_step(v, -self.v_s, -self.mu_s, self.v_s, self.mu_s)
        } else {
            cubic_step(v.abs(), self.v_s, self.mu_s, self.v_d, self.mu_d).copysign(v)
        }
    }
}

/// A stretch of the ground with friction coefficients of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// x at which it starts, m.
    pub from: f64,
    /// x at which it ends, m; the end itself is not part of it.
    pub to: f64,
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
}

impl FrictionLaw {
    /// The law at x (m): the slip speeds stay, a stretch brings its coefficients.
    pub fn at(&self, stretches: &[Stretch], x: f64) -> Self {
        match stretches.iter().find(|s| s.from <= x && x < s.to) {
            Some(stretch) => Self {
                mu_s: stretch.mu_s,
                mu_d: stretch.mu_d,
                ..*self
            },
            None => *self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_through_the_stated_points_and_is_odd() {
        let law = FrictionLaw::default();
        for (v, mu) in [
            (0.0, 0.0),
            (0.02, 0.8),
            (0.06, 0.75),
            (0.10, 0.7),
            (2.0, 0.7),
        ] {
            assert!((law.coefficient(v) - mu).abs() < 1e-15, "mu({v})");
            assert!((law.coefficient(-v) + mu).abs() < 1e-15, "mu(-{v})");
        }
        // Slope at rest of the cubic: 3 mu_s / (2 v_s) = 60 s/m.
        assert!((law.coefficient(1e-8) / 1e-8 - 60.0).abs() < 1e-6);
    }
}

//! Traction of a sliding wheel: eq. (11), `T = mu(v) N`.

use crate::contact::cubic_step;

/// Friction coefficient as a function of the slip speed v, in ADAMS's form.
///
/// A cubic from `-mu_s` to `+mu_s` for `|v| <= v_s`, a cubic from `mu_s` to `mu_d` for `v_s < |v| < v_d`, and `mu_d`
/// beyond. A constant mu in the paper's eq. (11), `T = mu N`, holds for a sliding wheel only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
    /// Slip speed at which the coefficient reaches mu_s, m/s.
    pub v_s: f64,
    /// Slip speed from which the coefficient is mu_d, m/s.
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
    /// Coefficient mu(v), -, with the sign of the slip speed `v` (m/s), which is positive when the rim moves faster
    /// than the wheel's centre.
    pub fn coefficient(&self, v: f64) -> f64 {
        if v.abs() <= self.v_s {
            cubic_step(v, -self.v_s, -self.mu_s, self.v_s, self.mu_s)
        } else {
            cubic_step(v.abs(), self.v_s, self.mu_s, self.v_d, self.mu_d).copysign(v)
        }
    }

    /// Whether a contact slides at the slip speed `v` (m/s): its slip is beyond the peak of the law, where T/N = mu_s.
    /// Up to there the wheel grips, with a creep that grows with T/N.
    pub fn slides(&self, v: f64) -> bool {
        v.abs() > self.v_s
    }
}

/// A stretch of the terrain with its own friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// x at which it starts, m.
    pub from: f64,
    /// x at which it ends, m. The end does not belong to it.
    pub to: f64,
    /// Static coefficient mu_s, -.
    pub mu_s: f64,
    /// Dynamic coefficient mu_d, -.
    pub mu_d: f64,
}

impl FrictionLaw {
    /// The law at x (m). The first stretch that contains x replaces the coefficients; the slip speeds stay.
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
    fn the_law_passes_through_its_parameters_and_is_odd() {
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
        // Slope of the cubic at v = 0: 3 mu_s/(2 v_s) = 60 s/m.
        assert!((law.coefficient(1e-8) / 1e-8 - 60.0).abs() < 1e-6);
    }

    /// Definition: a contact slides where T/N falls with the slip speed, not before.
    #[test]
    fn a_contact_slides_beyond_the_peak_of_the_law() {
        let law = FrictionLaw::default();
        for v in [0.005, 0.019, 0.021, 0.05, 0.09] {
            let falls = law.coefficient(v + 1e-6) < law.coefficient(v);
            assert_eq!(law.slides(v), falls, "{v}");
            assert_eq!(law.slides(-v), falls, "-{v}");
        }
    }
}

//! Rolling resistance of a wheel on its ground.

use crate::drive::coulomb_sign;

/// A moment `f_r r N` against the rolling of a wheel with radius r (m) under the normal force N
/// (N).
///
/// It acts from the ground on the wheel's absolute spin, at each contact. The traction T is not
/// part of it: a wheel that rolls freely has T = 0 and is braked by this moment alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollingResistance {
    /// Coefficient f_r, -: 0.01 to 0.05 on firm ground, 0 for none.
    pub coefficient: f64,
}

impl RollingResistance {
    /// Moment that resists the forward spin, N m, for a normal force (N), wheel radius (m) and
    /// absolute spin (rad/s). At standstill its sign is smoothed like that of the gear friction:
    /// [`coulomb_sign`].
    pub fn moment(&self, normal_force: f64, wheel_radius: f64, spin: f64) -> f64 {
        self.coefficient * wheel_radius * normal_force * coulomb_sign(spin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::FRICTION_SPEED;

    /// Closed form: `f_r r N` beyond the smoothing (tanh(10) = 1 - 4e-9), zero at standstill, odd,
    /// with the slope `f_r r N/FRICTION_SPEED` there.
    #[test]
    fn the_moment_opposes_the_rolling() {
        let law = RollingResistance { coefficient: 0.03 };
        let moment = |spin| law.moment(46.0, 0.1, spin);
        for spin in [0.1, 2.0, 50.0] {
            assert!((moment(spin) - 0.138).abs() < 1e-9, "{spin}");
            assert!((moment(-spin) + moment(spin)).abs() < 1e-15);
        }
        assert!(moment(0.0) == 0.0);
        assert!((moment(1e-6) / 1e-6 - 0.138 / FRICTION_SPEED).abs() < 1e-6);
        assert!(RollingResistance::default().moment(46.0, 0.1, 2.0) == 0.0);
    }
}

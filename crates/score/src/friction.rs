//! The friction coefficient that a wheel needs, section 5 of the paper.

/// Normal force below which T/N has no meaning, N: 2 % of the mean wheel load, the scale of the estimates' errors.
pub const LEAST_LOAD: f64 = 1.0;

/// Needed friction mu_n = T/N, -, of a traction and a normal force in N; `None` where N is below [`LEAST_LOAD`].
pub fn needed_friction(traction: f64, normal_force: f64) -> Option<f64> {
    (normal_force >= LEAST_LOAD).then(|| traction / normal_force)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_without_load_has_no_friction_coefficient() {
        assert_eq!(needed_friction(-10.0, 40.0), Some(-0.25));
        assert_eq!(needed_friction(10.0, 0.9), None);
        assert_eq!(needed_friction(10.0, f64::NAN), None);
    }
}

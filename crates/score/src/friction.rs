//! The friction coefficient that a wheel needs, section 5 of the paper.

use robhaz_estimator::Estimate;

/// Normal force below which T/N has no meaning, N: 2 % of the mean wheel load, the scale of the
/// estimates' errors.
pub const LEAST_LOAD: f64 = 1.0;

/// Needed friction mu_n = T/N, -, of a traction and a normal force in N; `None` where N is below
/// [`LEAST_LOAD`].
pub fn needed_friction(traction: f64, normal_force: f64) -> Option<f64> {
    (normal_force >= LEAST_LOAD).then(|| traction / normal_force)
}

/// Needed friction mu_n of wheel `i` (0 to 2) of an estimate, -, and its standard deviation. An
/// estimator that states it knows more than its forces at this instant: the direction in which the
/// robot moves. T/N of the others, without a deviation.
pub fn estimated_needed_friction(estimate: &Estimate, i: usize) -> Option<(f64, Option<f64>)> {
    let of_forces = needed_friction(estimate.traction[i], estimate.normal_force[i])?;
    match estimate.kalman.as_ref().map(|k| &k.friction) {
        Some(wheels) => wheels[i].needed.map(|n| (n.value, Some(n.sigma))),
        None => Some((of_forces, None)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_without_load_needs_no_friction() {
        assert_eq!(needed_friction(-10.0, 40.0), Some(-0.25));
        assert_eq!(needed_friction(10.0, 0.9), None);
        assert_eq!(needed_friction(10.0, f64::NAN), None);
    }
}

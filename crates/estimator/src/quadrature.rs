//! Sums in quadrature.

/// `sqrt(a^2 + b^2)`: the standard deviation of a sum of independent errors. For quantities of a robot, whose squares neither
/// overflow nor vanish, it needs fewer instructions than `libm::hypot`.
#[inline]
pub(crate) fn root_sum_square(a: f64, b: f64) -> f64 {
    robhaz_model::sqrt(a * a + b * b)
}

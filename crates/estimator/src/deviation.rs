//! Standard deviations: gates, and sums in quadrature.

/// Standard deviations beyond which an innovation is an outlier: white ones are once in 1.7 million
/// samples. A false alarm of 5.7e-7 for a Gaussian; correlated samples have fewer.
pub(crate) const GATE: f64 = 5.0;

/// The same for the direction of a wheel's velocity against an estimated contact angle: beyond it
/// the wheel has met an edge. The angle follows what leaves it, so that the deviation is small: on
/// rolling ground it is beyond once in a thousand samples at most. A false alarm of 2.7e-3 for a
/// Gaussian: it costs little, since only a variance grows.
pub(crate) const EDGE_GATE: f64 = 3.0;

/// `sqrt(a^2 + b^2)`: the standard deviation of a sum of independent errors. For quantities of a
/// robot, whose squares neither overflow nor vanish, it needs fewer instructions than
/// `libm::hypot`.
#[inline]
pub(crate) fn root_sum_square(a: f64, b: f64) -> f64 {
    robhaz_model::sqrt(a * a + b * b)
}

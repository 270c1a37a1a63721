//! Standard deviations: the three levels at which anything is decided, and sums in quadrature.

/// Standard deviations beyond which an innovation is an outlier: white ones are once in 1.7 million
/// samples. A false alarm of 5.7e-7 for a Gaussian; correlated samples have fewer.
pub(crate) const GATE: f64 = 5.0;

/// Standard deviations beyond which something is there, where a false alarm costs little. A false
/// alarm of 2.7e-3 for a Gaussian.
///
/// Beyond it the direction of a wheel's velocity shows that the wheel has met an edge, where the
/// contact angle is estimated: the angle follows what leaves it, so that the deviation is small,
/// and a false alarm only makes a variance grow.
pub(crate) const SIGNIFICANT: f64 = 3.0;

/// Standard deviations within which nothing is there: 95 % of a Gaussian.
pub(crate) const WITHIN: f64 = 2.0;

/// Standard deviation of a uniform error over its width, 1/sqrt(12).
/// Definition.
pub(crate) const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// `sqrt(a^2 + b^2)`: the standard deviation of a sum of independent errors. For quantities of a
/// robot, whose squares neither overflow nor vanish, it needs fewer instructions than
/// `libm::hypot`.
#[inline]
pub(crate) fn root_sum_square(a: f64, b: f64) -> f64 {
    robhaz_model::sqrt(a * a + b * b)
}

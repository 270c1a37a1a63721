//! Low passes on rates: as slow as the noise of the readings asks for.

use crate::common::SMOOTHING;

/// Least time constant of a low pass, s.
/// Guard.
const SHORTEST: f64 = 0.001;

/// Time constant of a low pass on a rate, s, for readings whose noise is `noise` times that of
/// typical sensors: the finer, the shorter.
pub(crate) fn smoothing_time(noise: f64) -> f64 {
    (SMOOTHING * noise).clamp(SHORTEST, SMOOTHING)
}

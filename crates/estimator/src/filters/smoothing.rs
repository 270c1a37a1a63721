//! Low passes on rates: as slow as the noise of the readings asks for.

use crate::settings::NoiseBudget;

/// Sensors to which the time constants of low passes and observers refer.
pub(crate) const TYPICAL: NoiseBudget = NoiseBudget::typical();

/// Time constant of a low pass on a rate of typical sensors, s; and of what filters of that speed
/// leave for some samples: load that no reading shows, the end of a second contact.
/// Chosen; sensitive.
pub(crate) const SMOOTHING: f64 = 0.02;

/// Least time constant of a low pass, s.
/// Guard.
const SHORTEST: f64 = 0.001;

/// Time constant of a low pass on a rate, s, for readings whose noise is `noise` times that of
/// typical sensors: the finer, the shorter.
pub(crate) fn smoothing_time(noise: f64) -> f64 {
    (SMOOTHING * noise).clamp(SHORTEST, SMOOTHING)
}

//! Speeds and times that mean the same in several places.

use crate::settings::NoiseBudget;

/// Least speed of a robot that drives, m/s: health and the push of the other side count from it on.
/// Chosen; held by the faults and honest logs of `tests/check`.
pub const DRIVING_SPEED: f64 = 0.005;

/// Least speed of a wheel that rolls, m/s, of a robot whose speed is steady. Below it a velocity has no
/// direction, and a wheel may bear its traction without slip.
/// Chosen: with 0.001 a robot that creeps to a halt in its gears' friction, with 0.004 one that
/// drives at 0.005 m/s errs by more than it states (`crates/study/tests/study/no_angles.rs`).
pub(crate) const ROLLING_SPEED: f64 = 0.002;

/// Sensors to which the time constants of low passes and observers refer.
pub(crate) const TYPICAL: NoiseBudget = NoiseBudget::typical();

/// Time constant of a low pass on a rate of typical sensors, s; and of what filters of that speed
/// leave for some samples: load that no reading shows, the end of a second contact.
/// Chosen; sensitive.
pub(crate) const SMOOTHING: f64 = 0.02;

/// Correlation time of errors that observers and low passes leave, s: in the slip by the torques'
/// observers, in the parity residual but for these, in what an inclinometer shows of a link that
/// turns, and in the acceleration after an impact. What the readings show for as long is no noise of
/// theirs.
/// Chosen; sensitive.
pub(crate) const FILTER_TIME: f64 = 0.03;

/// Time that covers some obstacles or a turn, s: 1 m at 0.2 m/s. What the ground and the other side do is
/// averaged over it.
/// Chosen; insensitive.
pub(crate) const OBSTACLES: f64 = 5.0;

/// Time for which an impact shakes a wheel, s: hard wheels on hard ground. For as long a condition has
/// to hold before a contact state changes; it is the time constant of the slip's low pass, too.
/// Chosen; held by `tests/acceptance_contacts.rs`.
pub(crate) const IMPACT_LASTS: f64 = 0.005;

/// Time for which all measurements of a kind may be outliers before what contradicts them is discarded, s:
/// longer than any impact. What was estimated from false readings would otherwise make the gate reject correct
/// ones for ever.
/// Guard.
pub(crate) const LONGEST_BEYOND_GATE: f64 = 1.0;

//! Wheels driven apart: set speeds that differ from wheel to wheel for a time.

use robhaz_model::quintic;

/// A time in which chosen wheels have their set speed times a factor.
///
/// The factor changes smoothly, like the set speed at the start: from 1 beginning at `from`, and
/// back to 1 beginning at `to`, each over the ramp time of the drive. In a time shorter than the
/// ramp time the factor is not reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedScaling {
    /// Whether it acts on the front, middle and rear wheel.
    pub wheels: [bool; 3],
    /// Time at which the factor begins to change from 1, s.
    pub from: f64,
    /// Time at which it begins to change back, s.
    pub to: f64,
    /// Factor, -. Zero stops the wheels, a negative one reverses them.
    pub factor: f64,
}

impl SpeedScaling {
    /// What it adds to the factor 1 at time `t` (s), -.
    pub(crate) fn change(&self, t: f64, ramp_time: f64) -> f64 {
        let share = |start: f64| quintic(1.0, ramp(t, start, ramp_time));
        (self.factor - 1.0) * (share(self.from) - share(self.to))
    }

    /// The times at which a change begins or ends, s.
    pub(crate) fn changes(&self, ramp_time: f64) -> impl Iterator<Item = f64> {
        let ends = [self.from, self.to].into_iter();
        ends.flat_map(move |end| [end, end + ramp_time])
    }
}

/// Share of a ramp of `duration` (s) that has passed at time `t` (s), 0 to 1. Without duration it
/// jumps at `start` (s).
pub(crate) fn ramp(t: f64, start: f64, duration: f64) -> f64 {
    if duration > 0.0 {
        ((t - start) / duration).clamp(0.0, 1.0)
    } else {
        f64::from(t >= start)
    }
}

//! A log may begin, or go on after a gap, while the rover drives.

use crate::common::DRIVING_SPEED;
use crate::deviation::root_sum_square;
use crate::frame::LONGEST_GAP;
use crate::whole::readings::WholeFrame;
use robhaz_model::Units;

/// Time over which the first frames show whether the wheels turn, s: more than a period of most logs.
/// Chosen.
const SHOWS: f64 = 0.015;
/// Rim speed from which on they do, of the least one of a drive: a rover that starts to move is slow.
/// Chosen.
const SLOW: f64 = 0.1;
/// Standard deviation of an inclination before, rad: that of an acceleration of 3 m/s^2.
/// Guard.
const UNKNOWN: f64 = 0.3;

/// What is known of the motion at the start. An inclination that is read while the rover gathers
/// speed is not that of gravity: taken for it, all that follow would contradict it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// Stated noise of the inclinations, rad.
    noise: f64,
    /// Time (s) and turn of all wheels (rad) of the first frame, until it is known whether they turn.
    first: Option<(f64, f64)>,
    /// Whether there has been a frame with all wheels.
    seen: bool,
    /// Time until which the acceleration is not known, s: a rover gathers its speed within the same time
    /// as it loses it.
    until: f64,
}

impl Start {
    pub fn new(noise: f64) -> Self {
        Self {
            noise,
            first: None,
            seen: false,
            until: f64::NEG_INFINITY,
        }
    }

    /// Takes the wheel angles of a frame of a rover with this wheel radius (m). `interrupted`: there is a
    /// gap before it. Returns the standard deviation of its inclinations, rad, and whether it shows that
    /// the rover drives though it counted as standing.
    pub fn take(
        &mut self,
        frame: &WholeFrame,
        interrupted: bool,
        radius: f64,
        units: &Units,
    ) -> (f64, bool) {
        let now = frame.time;
        let turned = frame.wheel_angle.iter().copied().sum::<Option<f64>>();
        let mut moves = false;
        if let Some(turned) = turned.filter(|turned| turned.is_finite()) {
            let shows = |(time, _): &(f64, f64)| now - time > SHOWS * units.time;
            if let Some((time, before)) = self.first.filter(shows) {
                let speed = radius * (turned - before) / 6.0;
                let least = SLOW * DRIVING_SPEED * units.speed();
                moves = libm::fabs(speed) > least * (now - time);
                self.first = None;
            } else if !self.seen {
                (self.first, self.seen) = (Some((now, turned)), true);
            }
        }
        if moves || interrupted {
            self.until = now + LONGEST_GAP * units.time;
        }
        let unknown = if now < self.until { UNKNOWN } else { 0.0 };
        (root_sum_square(self.noise, unknown), moves)
    }
}

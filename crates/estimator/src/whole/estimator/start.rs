//! A log may begin, or go on after a gap, while the rover drives.

use super::{WholeEstimator, WholeFrame};
use crate::deviation::root_sum_square;
use crate::filters::LinkAngleKalman;
use crate::frame::LONGEST_GAP;
use crate::health::DRIVING_SPEED;

/// Time over which the first frames show whether the wheels turn, s: more than a period of most logs.
/// Chosen; insensitive.
const SHOWS: f64 = 0.015;
/// Rim speed from which on they do, of the least one of a drive: a rover that starts to move is slow.
/// Chosen; insensitive.
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
}

impl WholeEstimator {
    /// The filters of roll and of both sides start anew where the first frames show that the rover
    /// drives. `interrupted`: there is a gap before this frame.
    pub(super) fn begin(&mut self, frame: &WholeFrame, interrupted: bool) {
        let (now, unit) = (frame.time, self.units.time);
        let turned = frame.wheel_angle.iter().copied().sum::<Option<f64>>();
        let start = &mut self.start;
        let mut moves = false;
        if let Some(turned) = turned.filter(|turned| turned.is_finite()) {
            if let Some((time, before)) = start.first.filter(|(time, _)| now - time > SHOWS * unit)
            {
                let speed = self.rover.side.geometry.wheel_radius * (turned - before) / 6.0;
                let least = SLOW * DRIVING_SPEED * self.units.speed();
                moves = libm::fabs(speed) > least * (now - time);
                start.first = None;
            } else if !start.seen {
                (start.first, start.seen) = (Some((now, turned)), true);
            }
        }
        if moves || interrupted {
            start.until = now + LONGEST_GAP * unit;
        }
        let unknown = if now < start.until { UNKNOWN } else { 0.0 };
        let noise = root_sum_square(start.noise, unknown);
        self.settings.budget.inclination_noise = noise;
        for side in &mut self.sides {
            side.set_inclination_noise(noise);
            if moves {
                side.start_moving();
            }
        }
        if moves || interrupted {
            self.roll = LinkAngleKalman::new(&self.settings.budget);
        }
    }
}

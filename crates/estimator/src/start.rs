//! A log may begin, or go on after a gap, while the robot drives, or is carried and put down.

use crate::common::ROLLING_SPEED;
use crate::deviation::root_sum_square;
use crate::frame::LONGEST_GAP;
use robhaz_model::Units;

/// Time over which the first frames show whether the wheels turn, s: more than a period of most logs.
/// Chosen.
const SHOWS: f64 = 0.015;
/// Standard deviation of an inclination before, rad: that of an acceleration of 3 m/s^2.
/// Guard.
const UNKNOWN: f64 = 0.3;

/// What is known of the motion at the start. An inclination that is read while the robot gathers
/// speed is not that of gravity: taken for it, all that follow would contradict it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// Stated noise of the inclinations, rad.
    noise: f64,
    /// Time (s) and turn of all wheels (rad) of the first frame, until it is known whether they turn.
    first: Option<(f64, f64)>,
    /// Whether there has been a frame with all wheels.
    seen: bool,
    /// Time until which the acceleration is not known, s: a robot gathers its speed within the same time
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

    /// As before its first frame: another reading is still missing, without which nothing starts.
    pub fn wait(&mut self) {
        *self = Self::new(self.noise);
    }

    /// Takes the angles of the wheels (rad) in a frame at the time `now` (s), both in the filters' units.
    /// `interrupted`: there is a gap before it. Returns the standard deviation of its inclinations, rad,
    /// and the speed of the rims, m/s, if it shows that the robot drives though it counted as standing.
    pub fn take(
        &mut self,
        now: f64,
        wheels: &[Option<f64>],
        interrupted: bool,
    ) -> (f64, Option<f64>) {
        let turned = wheels.iter().copied().sum::<Option<f64>>();
        let mut moves = None;
        if let Some(turned) = turned.filter(|turned| turned.is_finite()) {
            if let Some((time, before)) = self.first.filter(|(time, _)| now - time > SHOWS) {
                // A count of wheels.
                let way = Units::RADIUS * (turned - before) / wheels.len() as f64;
                let speed = way / (now - time);
                moves = Some(speed).filter(|v| libm::fabs(*v) > ROLLING_SPEED);
                self.first = None;
            } else if !self.seen {
                (self.first, self.seen) = (Some((now, turned)), true);
            }
        }
        if moves.is_some() || interrupted {
            self.until = now + LONGEST_GAP;
        }
        let unknown = if now < self.until { UNKNOWN } else { 0.0 };
        (root_sum_square(self.noise, unknown), moves)
    }
}

/// Whether a robot is carried or inclined by hand: its links turn while no wheel does. Then it does not stand on the
/// ground by which the filters would learn errors of the torques.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Carried {
    /// Turn of each wheel and angle of each link when a wheel last turned, rad.
    since: Option<([f64; 3], [f64; 2])>,
}

impl Carried {
    /// Angle by which a link turns as no robot that stands does, rad: 3 deg.
    /// Chosen; held by `tests/check/trusted.rs`.
    const TURNED: f64 = 0.05;
    /// Turn of a wheel that rolls, rad.
    /// Chosen; held by `tests/check/trusted.rs`.
    const ROLLED: f64 = 0.02;

    /// Takes the angles of wheels and links, rad.
    pub fn take(&mut self, wheels: [f64; 3], links: [f64; 2]) -> bool {
        let (stood, level) = *self.since.get_or_insert((wheels, links));
        let beyond = |a: &[f64], b: &[f64], limit: f64| {
            let mut changes = a.iter().zip(b).map(|(a, b)| libm::fabs(a - b));
            changes.any(|change| change > limit)
        };
        if beyond(&wheels, &stood, Self::ROLLED) {
            self.since = Some((wheels, links));
            return false;
        }
        beyond(&links, &level, Self::TURNED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Links that turn by 3 deg with the wheels at rest, and not as they roll.
    #[test]
    fn a_robot_that_turns_without_its_wheels_is_carried() {
        for (rolls, expected) in [(0.0, true), (1.0, false)] {
            let mut carried = Carried::default();
            let turned = (0..10).any(|k| {
                let k = f64::from(k);
                carried.take([0.1 * rolls * k; 3], [0.0, 0.01 * k])
            });
            assert_eq!(turned, expected);
        }
    }
}

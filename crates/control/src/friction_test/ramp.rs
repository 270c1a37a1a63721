//! A torque ramp on one wheel: approach, linear rise, back-off.

use super::result::FrictionTestEnd;
use super::test::{FrictionTest, FrictionTestPhase};
use crate::input::ControlInput;
use robhaz_model::quintic;

/// Time over which the torque of robot A is taken back, s.
const BACK_OFF: f64 = 0.3;
/// Duration of the approach of robot A, s.
const APPROACH: f64 = 1.0;

/// A ramp of the torque of one wheel. It goes smoothly to its first torque, grows linearly until
/// the test ends, and goes back smoothly to the torque that turns the wheel without traction.
#[derive(Clone, Debug)]
pub(crate) struct Ramp {
    pub test: FrictionTest,
    /// Torque at the start and after the approach, N m. Without an approach both are the same.
    torque: [f64; 2],
    /// Rate with its direction, N m/s.
    rate: f64,
    /// Unit of time of the robot, s.
    unit: f64,
    /// The torque at the end of the rise (N m), and that time (s).
    back_off: Option<(f64, f64)>,
}

impl Ramp {
    /// A ramp of wheel `wheel` (0 to 2) from `time` (s) on: from one torque to another in the
    /// approach (N m), then with `rate` (N m/s), negative to brake. `unit`: that of time of the
    /// robot, s.
    pub fn new(wheel: usize, time: f64, torque: [f64; 2], rate: f64, unit: f64) -> Self {
        Self {
            test: FrictionTest::new(wheel, time),
            torque,
            rate,
            unit,
            back_off: None,
        }
    }

    /// The torque at the time of the input; `idle` turns the wheel without traction, `limit` is the
    /// largest torque, N m. `None` when the ramp is over. A wheel that still slips then stays at
    /// `idle`.
    pub fn update(&mut self, input: &ControlInput<'_>, idle: f64, limit: f64) -> Option<f64> {
        let now = input.frame.time;
        let wanted = self.wanted(now);
        let mut phase = self.test.update(now, input.estimate);
        if wanted.abs() >= limit && wanted * self.rate > 0.0 {
            phase = self.test.end(FrictionTestEnd::TorqueLimit);
        }
        if phase == FrictionTestPhase::Rising {
            return Some(wanted);
        }
        let limited = wanted.max(-limit).min(limit);
        let (torque, since) = *self.back_off.get_or_insert((limited, now));
        let passed = ((now - since) / (BACK_OFF * self.unit)).min(1.0);
        let over = passed >= 1.0 && phase == FrictionTestPhase::Done;
        (!over).then(|| torque + (idle - torque) * quintic(1.0, passed))
    }

    fn wanted(&self, now: f64) -> f64 {
        let [first, second] = self.torque;
        let passed = now - self.test.start;
        let duration = APPROACH * self.unit;
        let approached = quintic(1.0, (passed / duration).max(0.0).min(1.0));
        let approach = match (first - second).abs() > 0.0 {
            true => duration,
            false => 0.0,
        };
        first + (second - first) * approached + self.rate * (passed - approach).max(0.0)
    }
}

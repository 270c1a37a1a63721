//! The friction test of section 5 of the paper: torque ramps on one wheel after the other.
//!
//! The torque of the tested wheel changes linearly from its present value, while the drives of the other wheels hold their
//! set speeds. They bear the reaction. Front and middle wheel are driven, the rear wheel is braked ([`DIRECTION`]). When the wheel slips ([`robhaz_estimator::FrictionTest`]), its torque goes back
//! smoothly to what turns it without traction, and its drive holds the set speed again. The next wheel follows after a
//! pause. A robot at rest is tested in the same way.

use crate::input::{ControlInput, ControlSettings, FrictionTestPlan};
use robhaz_estimator::{FrictionTest, FrictionTestEnd, FrictionTestPhase, FrictionTestResult};
use robhaz_model::WheelCommand;

/// Time over which the torque is taken back, s.
const BACK_OFF: f64 = 0.3;
/// Pause between two wheels, s: the drives share the load again.
const PAUSE: f64 = 2.0;
/// Time constant of the low pass on the torque from which a ramp starts, s.
const TORQUE_SMOOTHING: f64 = 0.1;
/// Longest time between samples that is integrated over, s.
const LONGEST_STEP: f64 = 0.1;

/// Direction of each wheel's torque.
///
/// A wheel is tested in the direction in which its own traction relieves it: forces of the ground act below the body, so driving
/// raises the load of the rear wheel and braking lowers it. With mu = 0.9 on level ground, a driven rear wheel would need so much
/// reaction that the middle wheel lifts off before it slips. A relieved wheel slips at half the torque.
const DIRECTION: [f64; 3] = [1.0, 1.0, -1.0];

/// The tests with their state from sample to sample.
#[derive(Clone, Debug)]
pub struct FrictionTests {
    plan: FrictionTestPlan,
    torque_limit: f64,
    viscous_damping: f64,
    /// Time of the last sample, s.
    time: Option<f64>,
    /// Low-pass filtered torques, N m.
    torques: [f64; 3],
    stage: Stage,
    /// Results in the order of the plan.
    results: [Option<FrictionTestResult>; 3],
}

#[derive(Clone, Debug)]
enum Stage {
    /// Test number `next` of the plan starts at `from` (s).
    Waiting {
        next: usize,
        from: f64,
    },
    /// A ramp from a torque (N m) at a time (s).
    Testing {
        number: usize,
        test: FrictionTest,
        torque: f64,
        from: f64,
        /// The torque when the wheel slipped (N m), and that time (s).
        back_off: Option<(f64, f64)>,
    },
    Over,
}

impl FrictionTests {
    /// Before the first sample.
    pub fn new(settings: &ControlSettings, plan: &FrictionTestPlan) -> Self {
        Self {
            plan: *plan,
            torque_limit: settings.torque_limit,
            viscous_damping: settings.viscous_damping,
            time: None,
            torques: [0.0; 3],
            stage: Stage::Waiting {
                next: 0,
                from: plan.start,
            },
            results: [None; 3],
        }
    }

    /// The results so far, in the order of the plan. A test that has not ended counts as unfinished.
    pub fn results(&self) -> [Option<FrictionTestResult>; 3] {
        let mut results = self.results;
        if let Stage::Testing { number, test, .. } = &self.stage
            && let Some(result) = results.get_mut(*number)
        {
            *result = Some(test.result());
        }
        results
    }

    /// The commands of the wheels.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        let now = input.frame.time;
        let dt = self
            .time
            .map_or(0.0, |last| (now - last).max(0.0).min(LONGEST_STEP));
        for (smooth, found) in self.torques.iter_mut().zip(&input.frame.motor_torque) {
            if let Some(found) = found {
                let weight = if self.time.is_some() {
                    dt / (TORQUE_SMOOTHING + dt)
                } else {
                    1.0
                };
                *smooth += weight * (found - *smooth);
            }
        }
        self.time = Some(now);
        if let Stage::Waiting { next, from } = self.stage
            && now >= from
        {
            self.start(next, now);
        }
        let mut commands = [WheelCommand::Planned; 3];
        if let Some((wheel, torque)) = self.advance(input)
            && let Some(command) = commands.get_mut(wheel)
        {
            *command = WheelCommand::Torque(torque);
        }
        commands
    }

    fn start(&mut self, number: usize, now: f64) {
        self.stage = match self.plan.wheels.get(number).copied().flatten() {
            Some(wheel) => Stage::Testing {
                number,
                test: FrictionTest::new(wheel, now),
                torque: self.torques.get(wheel).copied().unwrap_or(0.0),
                from: now,
                back_off: None,
            },
            None => Stage::Over,
        };
    }

    /// The wheel under test and its torque, N m.
    fn advance(&mut self, input: &ControlInput<'_>) -> Option<(usize, f64)> {
        let now = input.frame.time;
        // A wheel that rolls without traction.
        let idle = self.viscous_damping * input.set_speed;
        let limit = self.torque_limit;
        let Stage::Testing {
            number,
            test,
            torque,
            from,
            back_off,
        } = &mut self.stage
        else {
            return None;
        };
        let wheel = test.result().wheel;
        let direction = DIRECTION.get(wheel).copied().unwrap_or(1.0);
        let wanted = *torque + direction * self.plan.rate * (now - *from);
        let mut phase = test.update(now, input.estimate);
        if direction * wanted >= limit {
            phase = test.end(FrictionTestEnd::TorqueLimit);
        }
        if phase == FrictionTestPhase::Rising {
            return Some((wheel, wanted));
        }
        let (from_torque, since) = *back_off.get_or_insert((wanted.max(-limit).min(limit), now));
        let passed = (now - since) / BACK_OFF;
        if passed < 1.0 {
            return Some((
                wheel,
                from_torque + (idle - from_torque) * smooth_step(passed),
            ));
        }
        if phase == FrictionTestPhase::Done {
            let (number, result) = (*number, test.result());
            if let Some(place) = self.results.get_mut(number) {
                *place = Some(result);
            }
            self.stage = Stage::Waiting {
                next: number + 1,
                from: now + PAUSE,
            };
        }
        // The drive brakes a wheel that still slips.
        None
    }
}

/// The quintic from 0 to 1 whose first two derivatives are zero at both ends.
fn smooth_step(u: f64) -> f64 {
    u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
}

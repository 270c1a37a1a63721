//! Torque ramps on one wheel after the other.
//!
//! The torque of the tested wheel grows linearly from its present value, while the drives of the
//! other wheels hold their set speeds. They bear the reaction. When the wheel slips
//! ([`FrictionTest`](super::FrictionTest)), its torque goes back smoothly to what turns it without
//! traction. Then the same the other way, from three quarters of the torque found on: the offset of
//! the torque's reading and the friction in the gear add to one and subtract from the other
//! ([`FrictionTestResult::combined`]). The next wheel follows after a pause. A robot at rest is
//! tested in the same way.

use super::ramp::Ramp;
use super::result::{FrictionTestEnd, FrictionTestResult};
use super::together::together;
use crate::input::{ControlInput, ControlSettings};
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::{Robot, Units, WheelCommand};

/// Pause between two wheels, s: the drives share the load again.
const PAUSE: f64 = 2.0;
/// Time constant of the low pass on the torque from which a ramp starts, s.
const TORQUE_SMOOTHING: f64 = 0.1;
/// Longest time between samples that is integrated over, s.
const LONGEST_STEP: f64 = 0.1;
/// Part of the torque that the first ramp and the load between the ramps let expect, from which the
/// second ramp of a wheel starts, -. The load grows under the second ramp, and the wheel slips
/// later.
const SECOND_START: f64 = 0.75;
/// Standard deviations of the torque's offset by which it starts below the expected torque at
/// least. The offset adds to what one ramp finds and subtracts from the torque of the other: two
/// deviations, twice.
const OFFSETS: f64 = 4.0;
/// Both ramps of a wheel together last at most as long as a rise by this torque takes, N m of robot
/// A: 18.6 s at 0.35 N m/s.
const LONGEST: f64 = 6.5;
/// Direction of the first ramp of each wheel: that in which the wheel's own traction relieves it,
/// by the statics of the nominal pose, eq. (8), where the others share the reaction.
///
/// Driving raises the load of the rear wheel and braking lowers it; of the middle wheel it depends
/// on the link that carries it. With mu = 0.9 on level ground, a driven rear wheel would need so
/// much reaction that the middle wheel lifts off before it slips. A relieved wheel slips at half
/// the torque.
fn relieving(robot: &Robot) -> Option<[f64; 3]> {
    let geometry = &robot.geometry;
    let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
    let arms = Arms::new(geometry, 0.0, 0.0).ok()?;
    let (loads, angles) = (Loads::default(), [0.0; 3]);
    let equations = Equilibrium::new(&arms, carriers, radius, &loads, &angles, radius)?;
    let inverse = equations.least_squares()?;
    let mut found = [1.0; 3];
    for (wheel, direction) in found.iter_mut().enumerate() {
        let traction = [0, 1, 2].map(|i| if i == wheel { 1.0 } else { -0.5 });
        let load = inverse.solve(&equations.right_side(&traction));
        if *load.get(wheel)? > 0.0 {
            *direction = -1.0;
        }
    }
    Some(found)
}

/// The tests with their state from sample to sample.
#[derive(Clone, Debug)]
pub struct FrictionTests {
    settings: ControlSettings,
    /// Unit of time of the robot, s.
    unit: f64,
    /// See [`relieving`].
    directions: [f64; 3],
    /// Rise of the torque over which both ramps of a wheel last at most, N m.
    longest: f64,
    /// Time of the last sample, s.
    time: Option<f64>,
    /// The last finite set speed, rad/s.
    set_speed: f64,
    /// Low-pass filtered torques, N m.
    torques: [f64; 3],
    stage: Stage,
    /// Number of the present or next test in the plan.
    number: usize,
    /// Results in the order of the plan.
    results: [Option<FrictionTestResult>; 3],
}

#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one test at a time: nothing is boxed without an allocator"
)]
enum Stage {
    /// The next wheel follows at this time, s.
    Waiting(f64),
    /// The first ramp of a wheel.
    First(Ramp),
    /// The second one, the other way; the result of the first.
    Second(Ramp, FrictionTestResult),
}

impl FrictionTests {
    /// Before the first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        Self {
            settings: settings.clone(),
            unit: Units::of(&settings.robot).time,
            directions: relieving(&settings.robot).unwrap_or([1.0; 3]),
            longest: LONGEST * Units::of(&settings.robot).torque(),
            time: None,
            set_speed: 0.0,
            torques: [0.0; 3],
            stage: Stage::Waiting(settings.friction_test.start),
            number: 0,
            results: [None; 3],
        }
    }

    /// The results so far, in the order of the plan. A test that has not ended counts as
    /// unfinished. A later test can change an earlier result: it shows more of the torque offsets
    /// ([`together`]).
    pub fn results(&self) -> [Option<FrictionTestResult>; 3] {
        let mut results = self.results;
        let present = match &self.stage {
            Stage::Waiting(_) => None,
            Stage::First(ramp) => Some(ramp.test.result),
            Stage::Second(ramp, first) => Some(first.combined(&ramp.test.result)),
        };
        if let (Some(place), Some(_)) = (results.get_mut(self.number), present) {
            *place = present;
        }
        together(&results)
    }

    /// The commands of the wheels.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        let input = &input.holding(&mut self.set_speed);
        let now = input.frame.time;
        self.follow_torques(input);
        if let Stage::Waiting(from) = self.stage
            && now >= from
            && let Some(wheel) = self.wheel()
        {
            let present = self.torques.get(wheel).copied().unwrap_or(0.0);
            let rate = self.direction(wheel) * self.settings.friction_test.rate;
            let idle = self.settings.viscous_damping * input.set_speed;
            // A wheel that is to be braked does not drive first, and the other way round.
            let ahead = (present - idle) * rate < 0.0;
            let torque = [present, if ahead { idle } else { present }];
            self.stage = Stage::First(Ramp::new(wheel, now, torque, rate, self.unit));
        }
        let mut commands = [WheelCommand::Planned; 3];
        let torque = self.advance(input);
        if let (Some(wheel), Some(torque)) = (self.wheel(), torque)
            && let Some(command) = commands.get_mut(wheel)
        {
            *command = WheelCommand::Torque(torque);
        }
        commands
    }

    /// The wheel of the present or next test.
    fn wheel(&self) -> Option<usize> {
        self.settings
            .friction_test
            .wheels
            .get(self.number)
            .copied()
            .flatten()
    }

    /// Direction of the first ramp of a wheel.
    fn direction(&self, wheel: usize) -> f64 {
        self.directions.get(wheel).copied().unwrap_or(1.0)
    }

    /// Torque up to which the wheel of `result` is expected to grip under its second ramp, N m.
    fn least_expected(&self, result: &FrictionTestResult, input: &ControlInput<'_>) -> f64 {
        let wheel = result.wheel;
        let load = input.estimate.and_then(|e| e.normal_force.get(wheel));
        let friction = input
            .estimate
            .and_then(|e| e.kalman.as_ref()?.friction.get(wheel).copied());
        let offset = friction.map_or(0.0, |friction| friction.offset.sigma);
        let part = (SECOND_START * result.mu).min(result.mu - OFFSETS * offset);
        part.max(0.0) * load.copied().unwrap_or(0.0) * self.settings.robot.geometry.wheel_radius
    }

    fn follow_torques(&mut self, input: &ControlInput<'_>) {
        let now = input.frame.time;
        let weight = self.time.map_or(1.0, |last| {
            let dt = (now - last).max(0.0).min(LONGEST_STEP);
            robhaz_model::low_pass_share(dt, TORQUE_SMOOTHING * self.unit)
        });
        for (smooth, found) in self.torques.iter_mut().zip(input.torques()) {
            if let Some(found) = found {
                *smooth += weight * (found - *smooth);
            }
        }
        self.time = Some(now);
    }

    /// The torque of the tested wheel, N m. `None` between the tests.
    fn advance(&mut self, input: &ControlInput<'_>) -> Option<f64> {
        let now = input.frame.time;
        let idle = self.settings.viscous_damping * input.set_speed;
        let longest = self.longest / self.settings.friction_test.rate;
        let ramp = match &mut self.stage {
            Stage::Waiting(_) => return None,
            Stage::First(ramp) => ramp,
            Stage::Second(ramp, first) => {
                if first.duration + ramp.test.result.duration > longest {
                    ramp.test.end(FrictionTestEnd::TimeLimit);
                }
                ramp
            }
        };
        if let Some(torque) = ramp.update(input, idle, self.settings.torque_limit) {
            return Some(torque);
        }
        let result = ramp.test.result;
        if self.settings.friction_test.both_ways && matches!(self.stage, Stage::First(_)) {
            let back = -self.direction(result.wheel);
            // Where no wheel slipped nothing is expected.
            let [limit, _] = result.limits;
            let expected = limit.map_or(0.0, |_| self.least_expected(&result, input));
            let torque = [idle, idle + back * expected];
            let ramp = Ramp::new(
                result.wheel,
                now,
                torque,
                back * self.settings.friction_test.rate,
                self.unit,
            );
            self.stage = Stage::Second(ramp, result);
            return Some(idle);
        }
        let result = match &self.stage {
            Stage::Second(_, first) => first.combined(&result),
            _ => result,
        };
        if let Some(place) = self.results.get_mut(self.number) {
            *place = Some(result);
        }
        self.number += 1;
        self.stage = Stage::Waiting(now + PAUSE * self.unit);
        None
    }
}

#[cfg(test)]
#[path = "sequence_tests.rs"]
mod tests;

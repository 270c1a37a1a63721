//! The zero that all inclinometers have in common, by the work of the torques: on the way the torques lift the
//! robot by as much as the inclinometers say.
//!
//! Over the way s in one direction, with the weight W, the work A of the torques less that of the damping, and
//! the inclination theta of the line through the axles,
//!
//! ```text
//! A/W = sum(sin(theta - e) ds) + f s
//! ```
//!
//! where e is the error of theta, and f what the gears and the ground take: at least 0, and not more than the
//! budget allows. What the inclinometers show beyond the torques is then an error of theta; what the torques do
//! beyond it may be friction. On the way back friction changes its sign and e does not. An inclinometer shows the
//! acceleration of the robot, too, so that work which speeds it up is no error.

use crate::check::recording::{LARGEST_FROUDE, slope_of};
use crate::check::{Finding, rest};
use robhaz_estimator::whole::WholeFrame;
use robhaz_estimator::{EstimatorSettings, SensorFrame, Sides};
use robhaz_model::{Robot, WholeRover};
use robhaz_score::signals::mean;
use std::fmt;

/// Standard deviations that are a fault: a false alarm in 16 000.
const GATE: f64 = 4.0;
/// Shortest way that shows something, in distances from the front to the rear axle.
const SHORTEST: f64 = 1.0;
/// Time over which turns, torques and slopes are averaged, s: counts of an encoder are no speed.
const SMOOTHING: f64 = 0.1;
/// Longest step that counts, s: the estimators start anew after it.
const LONGEST_STEP: f64 = 0.5;
/// Relative error of the mass of a robot as people build it, -.
const MASS: f64 = 0.01;
/// Difference of a wheel's turn from the mean of all within [`SMOOTHING`] that is none of a drive, rad.
const LARGEST_DIFFERENCE: f64 = 1.5;
/// Sideways over forward speed of the front and rear wheels, by the wheels of both sides, from which on a rover turns: its
/// wheels work against friction across, which lifts nothing. As the estimator has it of wheels that are dragged.
const TURNS: f64 = 0.1;
/// Push of the other side over the weight of a side that no ground holds, -: torques have another unit.
const LARGEST_PUSH: f64 = 1.0;
/// Slope on which no robot stands, rad.
const STEEPEST: f64 = 1.0;
/// Turn of the wheels within which a robot has not moved, rad.
const STILL: f64 = 0.02;
/// Time before the wheels have turned by [`STILL`] in which the robot gathers speed, which an inclinometer shows as a
/// slope, s.
const STARTS: f64 = 0.5;

pub const TEST: &str = "zero by the torques";

/// What the torques allow as an error that all inclinometers have in common, and what these show at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Least and largest error, rad; `None` of a log that shows none.
    allowed: Option<[f64; 2]>,
    /// What the torques do beyond the rise, over weight and way, -: gear friction, rolling resistance, or
    /// the error.
    resisted: f64,
    /// Largest such part that gears and ground have, by two deviations of the budget.
    usual: f64,
    /// Push by the torques that the slope does not need, over the side's weight, -: the other side holds it, as in a skid
    /// turn; `None` within budget and four deviations.
    pub pushed: Option<f64>,
    /// Slope of the ground before the first motion, as the inclinometers show it, rad; `None` without a rest.
    at_rest: Option<f64>,
    /// The same of the roll of a body; of one side of how much more link 1 is inclined than link 2, 0 on level ground.
    beside: Option<f64>,
    /// Whether one inclinometer, that of a body, shows the slope.
    is_of_body: bool,
    /// Largest slope that is none, rad.
    even: f64,
}

/// What is read in a frame: time, s; angles (rad) and torques (N m) of the wheels; slope of the robot, and what stands beside
/// it ([`Level::beside`]), rad.
type Read<const N: usize> = (f64, [Option<f64>; N], [Option<f64>; N], [Option<f64>; 2]);

/// The same with the last readings where there are none.
struct Moment<const N: usize> {
    time: f64,
    angle: [f64; N],
    torque: [f64; N],
    slope: f64,
    /// Where it is read.
    beside: Option<f64>,
}

impl<const N: usize> Moment<N> {
    /// The frames from the first on before which each reading was there.
    fn all(frames: impl Iterator<Item = Read<N>>) -> Vec<Self> {
        let (mut slopes, mut angles, mut torques) = ([None], [None; N], [None; N]);
        let of = |(time, angle, torque, [slope, beside]): Read<N>| {
            let slope = hold(&mut slopes, [slope]);
            let (angle, torque) = (hold(&mut angles, angle), hold(&mut torques, torque));
            let [slope] = slope?;
            Some(Self {
                time,
                angle: angle?,
                torque: torque?,
                slope,
                beside: beside.filter(|angle| angle.is_finite()),
            })
        };
        frames.filter_map(of).collect()
    }
}

/// The ways forward and back.
#[derive(Clone, Copy, Debug, Default)]
struct Ways {
    /// Way, m.
    way: [f64; 2],
    /// Rise by the inclinometers, m.
    rise: [f64; 2],
    /// Work of the torques over the weight, m.
    work: [f64; 2],
    /// Largest speed, m/s.
    speed: f64,
    /// Slopes at the start and the end of the way, rad.
    ends: [f64; 2],
    /// Means and number of the slopes and of the rolls before the first motion.
    rest: [(f64, f64); 2],
}

impl Level {
    /// Of the frames of one side; one side of two does not carry its weight alone.
    pub fn of_side(frames: &[SensorFrame], robot: &Robot, settings: &EstimatorSettings) -> Self {
        let slope = |frame: &SensorFrame| {
            let links = [frame.link1.inclination?, frame.link2.inclination?];
            Some(slope_of(&robot.geometry, links))
        };
        let apart = |f: &SensorFrame| Some(f.link1.inclination? - f.link2.inclination?);
        let read = |f: &SensorFrame| (f.time, f.wheel_angle, f.motor_torque, [slope(f), apart(f)]);
        // One side shows no turn.
        let found = Self::of(frames.iter().map(read), robot, settings, None);
        Self {
            allowed: found.allowed.filter(|_| settings.sides == Sides::Plane),
            ..found
        }
    }

    /// Of the frames of both sides.
    pub fn of_both(
        frames: &[WholeFrame],
        rover: &WholeRover,
        settings: &EstimatorSettings,
    ) -> Self {
        let side = &rover.side;
        // Difference of the speeds of both sides from their mean, over it.
        let turns_from = TURNS * rover.mean_half_track() / (0.5 * side.geometry.wheelbase());
        let read = |f: &WholeFrame| {
            let attitude = [f.inclination, f.roll];
            (f.time, f.wheel_angle, f.motor_torque, attitude)
        };
        Self {
            is_of_body: true,
            ..Self::of(frames.iter().map(read), side, settings, Some(turns_from))
        }
    }

    /// Roll before the first motion, rad, and whether it is one of the ground; `None` without a rest.
    pub fn roll_at_rest(&self) -> Option<(f64, bool)> {
        let known = self.roll().filter(|roll| roll.abs() <= STEEPEST);
        known.map(|roll| (roll, self.is_slope(roll)))
    }

    fn roll(&self) -> Option<f64> {
        self.beside.filter(|_| self.is_of_body)
    }

    /// Of a robot with one such side, or of a rover with two, which turns from this difference of their speeds on.
    fn of<const N: usize>(
        frames: impl Iterator<Item = Read<N>>,
        side: &Robot,
        settings: &EstimatorSettings,
        turns_from: Option<f64>,
    ) -> Self {
        let Some(ways) = Ways::of(&Moment::<N>::all(frames), side, settings, turns_from) else {
            return Self::default();
        };
        let geometry = &side.geometry;
        let footprint = geometry.wheelbase();
        let (budget, wheels) = (&settings.budget, N as f64);
        let over = 1.0 / (geometry.wheel_radius * wheels * side.mean_wheel_load());
        let offset = wheels.sqrt() * budget.torque_offset * over;
        let friction = (wheels * budget.gear_friction * over).hypot(budget.rolling_resistance);
        let [first, last] = ways.ends;
        let [at_rest, beside] = (ways.rest).map(|(mean, count)| (count > 0.0).then_some(mean));
        let noise = budget.inclination_noise / ways.rest[0].1.sqrt().max(1.0);
        let mut found = Self {
            usual: 2.0 * friction,
            at_rest,
            beside,
            even: 3.0 * budget.inclination_bias + GATE * noise,
            ..Self::default()
        };
        let mut allowed = [f64::NEG_INFINITY, f64::INFINITY];
        for (back, sign) in [1.0, -1.0].into_iter().enumerate() {
            let way = ways.way[back];
            // On curved ground a fast robot shows slopes that are none.
            let froude = ways.speed * ways.speed / (side.gravity * geometry.wheel_radius);
            if way < SHORTEST * footprint || froude > LARGEST_FROUDE {
                continue;
            }
            // The middle of the robot rises by another way than its line where the slope changes.
            let at_ends = 0.25 * footprint * (last - first) / way;
            let size = ways.work[back] / way * budget.torque_gain.hypot(MASS);
            let sigma = [offset, at_ends, size, budget.inclination_bias];
            let sigma = sigma.into_iter().fold(0.0, f64::hypot);
            let beyond = (ways.rise[back] - ways.work[back]) / way;
            let more = GATE * sigma.hypot(friction);
            found.resisted = found.resisted.max(-beyond);
            let is_push = beyond.abs() > found.usual + GATE * sigma && beyond.abs() < LARGEST_PUSH;
            found.pushed = found.pushed.or(is_push.then_some(-beyond));
            let [from, to] = match sign > 0.0 {
                true => [beyond - GATE * sigma, beyond + more],
                false => [-beyond - more, -beyond + GATE * sigma],
            };
            allowed = [allowed[0].max(from), allowed[1].min(to)];
        }
        // Where both ways contradict each other it is no zero.
        let is_zero = allowed[0].is_finite() && allowed[0] <= allowed[1];
        found.allowed = is_zero.then_some(allowed);
        found
    }

    /// Whether no error at all is not allowed: then the readings contradict each other.
    pub fn contradicts(&self) -> bool {
        self.allowed
            .is_some_and(|[from, to]| from > 0.0 || to < 0.0)
    }

    /// Whether they err nose down, as far as the torques show: loose ground does the same.
    fn nose_down(&self) -> bool {
        self.allowed.is_some_and(|[_, to]| to < 0.0)
    }

    /// What an estimate says before its forces, if the zero of the inclinometers is not known to be right.
    pub fn warning(&self) -> Option<String> {
        if self.contradicts() {
            return Some(format!(
                "READINGS CONTRADICT EACH OTHER: {self}. {PER_DEGREE}. `robhaz check` says what to do"
            ));
        }
        let roll = self.roll().filter(|roll| self.is_slope(*roll));
        let roll = roll.map(|roll| format!(
            "at rest body_roll shows {:.1} deg: if the ground was level across, it errs by that, and offset = {roll:.4} (rad) belongs to it; no other reading shows it, and it moves load from one side to the other",
            roll.to_degrees()
        ));
        let slope = match self.at_rest {
            Some(slope) if !self.is_slope(slope) => None,
            Some(slope) => Some(match self.is_of_body {
                true => format!(
                    "at rest body_inclination shows {:.1} deg: if the ground was level along, it errs by that, and offset = {slope:.4} (rad) belongs to it",
                    slope.to_degrees()
                ),
                false if self.beside.is_some_and(|apart| self.is_slope(apart)) => format!(
                    "at rest the inclinometers show a slope of {:.1} deg, and that of link 1 {:+.1} deg more than that of link 2: if the ground was level there, they err, each by its own; `robhaz check` names the offsets",
                    slope.to_degrees(),
                    self.beside.unwrap_or_default().to_degrees()
                ),
                false => format!(
                    "at rest all inclinometers together show a slope of {:.1} deg: if the ground was level there, they err by that, and offset = {slope:.4} (rad) belongs to each",
                    slope.to_degrees()
                ),
            }),
            None => Some("the log has no rest on level ground, which would show whether all inclinometers err alike".to_owned()),
        };
        let unknown = match self.allowed {
            Some(_) => format!("{self}"),
            None => "the torques do not show it".to_owned(),
        };
        let along = slope.map(|slope| format!("{slope}; {unknown}. {PER_DEGREE}"));
        let all = [along, roll, self.resistance()].into_iter().flatten();
        let all = all.collect::<Vec<_>>().join("; ");
        (!all.is_empty()).then_some(all)
    }

    /// Gears that are stiffer, or ground that is softer, than stated: no reading says which.
    fn resistance(&self) -> Option<String> {
        let Self {
            resisted, usual, ..
        } = *self;
        (self.allowed.is_some() && resisted > usual).then(|| format!(
            "the torques turn the wheels against {resisted:.2} of the weight, and the budget allows gears and ground {usual:.2}: measure gear_friction with lifted wheels, and on loose soil state rolling_resistance; N depends on which of them it is"
        ))
    }

    /// Whether a robot at rest may stand on this slope (rad), and it is one.
    fn is_slope(&self, slope: f64) -> bool {
        slope.abs() > self.even && slope.abs() <= STEEPEST
    }

    /// The finding of a check.
    pub fn finding(&self, channel: &str) -> Finding {
        let Some(_) = self.allowed else {
            let figure = "the torques do not show an error that all inclinometers have in common";
            let remedy =
                "stand on level ground at the start of the log: all inclinations must be 0";
            return Finding::ok(TEST, channel, figure).cannot_tell(remedy);
        };
        let finding = Finding::ok(TEST, channel, self.to_string());
        if !self.contradicts() {
            return match self.resistance() {
                Some(resistance) => finding.cannot_tell(resistance),
                None => finding,
            };
        }
        let remedy = "the sensors are mounted at an angle (that of a body: or turned about its vertical axis), or the torques have an offset or another scale: stand on level ground and state the mean of each as its offset; a way forth and back tells friction from both";
        if self.nose_down() {
            let resisted = self.resisted;
            return finding.fault(format!(
                "on loose soil measure budget.gear_friction and state budget.rolling_resistance = {resisted:.2}; on firm ground {remedy}"
            ));
        }
        finding.fault(remedy)
    }
}

/// How much a common error costs.
const PER_DEGREE: &str = "Each degree is 1.7 % of the weight in the sum of T, and moves about as much of N from wheel to wheel";

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.allowed.unwrap_or_default().map(f64::to_degrees);
        write!(
            f,
            "by the work of the torques all inclinometers err by {from:.1} to {to:.1} deg, nose up positive"
        )?;
        if self.nose_down() {
            return write!(
                f,
                ", or the ground resists the wheels by {:.2} of the weight",
                self.resisted
            );
        }
        Ok(())
    }
}

/// The readings with the last ones where there are none; `None` before there is one of each.
fn hold<const N: usize>(held: &mut [Option<f64>; N], read: [Option<f64>; N]) -> Option<[f64; N]> {
    for (held, value) in held.iter_mut().zip(read) {
        *held = value.filter(|value| value.is_finite()).or(*held);
    }
    let known = held.iter().all(Option::is_some);
    known.then(|| held.map(Option::unwrap_or_default))
}

/// Mean and count of the slope, and of what stands beside it, while the robot stands, up to `until`, s; of all samples if none is earlier.
fn at_rest<const N: usize>(stood: &[Moment<N>], until: f64) -> [(f64, f64); 2] {
    let before = stood.partition_point(|moment| moment.time < until);
    let stood = if before > 0 { &stood[..before] } else { stood };
    let slopes = stood.iter().map(|moment| moment.slope).collect();
    let beside = stood.iter().filter_map(|moment| moment.beside).collect();
    // Counts of frames.
    [slopes, beside].map(|x: Vec<f64>| (mean(&x).unwrap_or(0.0), x.len() as f64))
}

impl Ways {
    /// `None` of angles that jump: that of a turn, say.
    fn of<const N: usize>(
        moments: &[Moment<N>],
        side: &Robot,
        settings: &EstimatorSettings,
        turns_from: Option<f64>,
    ) -> Option<Self> {
        let mut found = Self::default();
        let stands = |now: &&Moment<N>| {
            let turns = moments[0].angle.iter().zip(&now.angle);
            turns.map(|(a, b)| b - a).all(|turn| turn.abs() < STILL)
        };
        let (stood, driven) = moments.split_at(moments.iter().take_while(stands).count());
        if let [first, ..] = driven {
            if first.time - moments[0].time >= rest::SHORTEST {
                found.rest = at_rest(stood, first.time - STARTS);
            }
            found.ends = [first.slope, driven[driven.len() - 1].slope];
        } else {
            found.rest = at_rest(stood, f64::INFINITY);
        }
        // Each part begins with the frame at which the one before ends.
        let mut start = 0;
        for (end, moment) in moments.iter().enumerate() {
            if moment.time - moments[start].time >= SMOOTHING {
                found.add(&moments[start..=end], side, settings, turns_from)?;
                start = end;
            }
        }
        Some(found)
    }

    /// Adds a part of the way, but for one in a turn with this difference of both sides' speeds or more; `None` of angles
    /// that jump.
    fn add<const N: usize>(
        &mut self,
        part: &[Moment<N>],
        side: &Robot,
        settings: &EstimatorSettings,
        turns_from: Option<f64>,
    ) -> Option<()> {
        let [first, .., last] = part else {
            return Some(());
        };
        let turns: [f64; N] = std::array::from_fn(|i| last.angle[i] - first.angle[i]);
        let mean = turns.iter().sum::<f64>() / N as f64;
        let is_far = |turn: &f64| (turn - mean).abs() > LARGEST_DIFFERENCE;
        if turns.iter().any(is_far) {
            return None;
        }
        let (step, count) = (last.time - first.time, part.len() as f64);
        let work = turns.iter().enumerate().map(|(i, turn)| {
            let torque = part.iter().map(|moment| moment.torque[i]).sum::<f64>() / count;
            turn * (torque - settings.viscous_damping * turn / step)
        });
        let slope = part.iter().map(|moment| moment.slope).sum::<f64>() / count;
        let way = side.geometry.wheel_radius * mean;
        let back = usize::from(way < 0.0);
        // Of one side no reading shows a turn.
        let beside = match turns.split_at(N / 2) {
            (left, right) if N == 6 => {
                (right.iter().sum::<f64>() - left.iter().sum::<f64>()) / N as f64
            }
            _ => 0.0,
        };
        if step < LONGEST_STEP && turns_from.is_none_or(|least| beside.abs() < least * mean.abs()) {
            self.speed = self.speed.max(way.abs() / step);
            self.way[back] += way.abs();
            self.rise[back] += way * slope.sin();
            self.work[back] += work.sum::<f64>() / (N as f64 * side.mean_wheel_load());
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::both::testing::rover;

    /// Closed form: at rest an inclinometer of link 1 that shows -0.94 deg and one of link 2 with -0.04 deg have no offset in
    /// common; two with -0.6 deg have.
    #[test]
    fn an_offset_of_one_link_is_not_called_that_of_each() {
        let side = Robot::default_a();
        let said = |angles: [f64; 2]| {
            let frame = |k: u32| {
                let mut frame = SensorFrame {
                    time: 0.01 * f64::from(k),
                    wheel_angle: [Some(0.0); 3],
                    motor_torque: [Some(0.0); 3],
                    ..SensorFrame::default()
                };
                let [first, second] = angles.map(|angle| Some(angle.to_radians()));
                (frame.link1.inclination, frame.link2.inclination) = (first, second);
                frame
            };
            let frames: Vec<SensorFrame> = (0..300).map(frame).collect();
            let level = Level::of_side(&frames, &side, &EstimatorSettings::kalman());
            level.warning().unwrap_or_default()
        };
        assert!(said([-0.94, -0.04]).contains("-0.9 deg more than that of link 2"));
        assert!(
            said([-0.6; 2]).contains("belongs to each"),
            "{}",
            said([-0.6; 2])
        );
    }

    /// A rover that turns for 8 s, on the spot with its wheels against friction across of half of the weight, or with its
    /// wheels dragged a little, against a tenth of it, and drives on for 8 s on level ground: the work of the turn lifts
    /// nothing. Without it the zero is that of the drive, 0.
    #[test]
    fn the_work_of_a_turn_lifts_nothing() {
        let rover = rover();
        let side = &rover.side;
        let settings = EstimatorSettings {
            viscous_damping: 0.0,
            ..EstimatorSettings::kalman()
        };
        let weight = 2.0 * side.mass.total() * side.gravity * side.geometry.wheel_radius / 6.0;
        for (ways, torques) in [([-1.0, 1.05], [-0.5, 0.5]), ([0.85, 1.15], [0.1, 0.1])] {
            let frame = |k: u32| {
                let time = 0.02 * f64::from(k);
                let (turned, driven) = (time.min(8.0), (time - 8.0).max(0.0));
                let turns = driven <= 0.0;
                let turn = |i: usize| 2.0 * (ways[i / 3] * turned + driven);
                let torque = |i: usize| if turns { torques[i / 3] * weight } else { 0.0 };
                WholeFrame {
                    time,
                    wheel_angle: std::array::from_fn(|i| Some(turn(i))),
                    motor_torque: std::array::from_fn(|i| Some(torque(i))),
                    inclination: Some(0.0),
                    roll: Some(0.0),
                    ..WholeFrame::default()
                }
            };
            let frames: Vec<WholeFrame> = (0..800).map(frame).collect();
            let level = Level::of_both(&frames, &rover, &settings);
            assert!(level.allowed.is_some() && !level.contradicts(), "{level:?}");
            assert!(level.resisted.abs() < 0.01, "{level:?}");
        }
    }
}

//! Which wiring of left and right the estimator of both sides agrees with.

use super::across::{coupling_angle, pace, turned};
use super::steering;
use crate::check::report::Finding;
use crate::check::stated::StatedBoth;
use robhaz_estimator::whole::{WholeEstimate, WholeEstimator, WholeFrame};
use robhaz_estimator::{DRIVING_SPEED, Estimate};
use robhaz_model::{Coupling, Units, WholeRover};

const TEST: &str = "left and right";
/// Sum over that of the log as wired below which another wiring is a fault. Of honest drives, straight
/// on and in turns, the least is 0.96; one exchanged wheel on uneven ground has 0.83.
const BETTER: f64 = 0.87;
/// The same of pins, coupling and the axes of the body's sensor, with the misfit's.
const BETTER_OF_JOINTS: f64 = 0.97;
/// Misfit over that of the log as wired of such a case.
const BETTER_MISFIT: f64 = 0.75;
/// Sum over the least one up to which a case fits as well.
const AS_WELL: f64 = 1.05;
/// Share of the frames from which on wheels are mostly dragged across.
const MOSTLY: f64 = 0.3;
/// Correlation that shows a sign.
const CORRELATED: f64 = 0.5;
/// Sum of a frame without an estimate: far above that of any contradiction.
const REFUSED: f64 = 1e3;
/// Longest part of a log for which the cases are tried, s of an ordinary drive: some metres.
const LONGEST: f64 = 16.0;

/// What to do about the axes of the body's sensor.
const AXES: &str =
    "exchange the columns of body_inclination and body_roll, and of body_rate and body_roll_rate";

/// A change of the wiring; wheels 0 to 2 of both sides.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Change {
    /// Encoders of left and right are exchanged.
    Angle(usize),
    /// Torques are.
    Torque(usize),
    /// Pins are.
    Pins,
    /// Differential or rear bogie counts the other way.
    Coupling,
    /// Roll and its rate do.
    Roll,
    /// Roll and inclination are exchanged, and their rates.
    Axes,
    /// The same of a sensor that is turned about its vertical axis: by a right angle to the left, or to the right.
    Turned(f64),
    /// All torques are so many times as large.
    Torques(f64),
    /// The coupling's angle is so many times as large.
    CouplingSize(f64),
    /// The angles of both pins are so many times as large.
    PinsSize(f64),
    /// The gears have this efficiency: a setting, which changes no frame.
    Gears(f64),
}

use Change::{Angle, Axes, Pins, Roll, Torque, Turned};

/// As wired, then all others that are tried, those with fewer changes first.
pub(super) fn wirings() -> Vec<Vec<Change>> {
    type Of = fn(usize) -> Change;
    let of = |wheels: &[usize], changes: &[Of]| -> Vec<Change> {
        let each = |change: &Of| wheels.iter().map(|i| change(*i)).collect::<Vec<_>>();
        changes.iter().flat_map(each).collect()
    };
    let kinds: [&[Of]; 3] = [&[Torque], &[Angle], &[Angle, Torque]];
    let [.., both] = kinds;
    let mut all = vec![Vec::new()];
    for i in 0..3 {
        all.extend(kinds.map(|changes| of(&[i], changes)));
    }
    let of_body = [Roll, Axes, Turned(1.0), Turned(-1.0)];
    all.extend([Pins, Change::Coupling].map(|change| vec![change]));
    all.extend(of_body.map(|change| vec![change]));
    // The wheels of a bogie, in front or behind.
    all.extend([of(&[0, 1], both), of(&[1, 2], both)]);
    all.extend(kinds.map(|changes| of(&[0, 1, 2], changes)));
    all.push([of(&[0, 1, 2], both), vec![Pins]].concat());
    all
}

impl Change {
    fn apply(self, frame: &mut WholeFrame) {
        match self {
            Angle(i) => frame.wheel_angle.swap(i, i + 3),
            Torque(i) => frame.motor_torque.swap(i, i + 3),
            Pins => frame.pins.swap(0, 1),
            Self::Torques(size) => {
                frame.motor_torque = frame.motor_torque.map(|torque| torque.map(|x| size * x));
            }
            Self::CouplingSize(size) => frame.coupling = frame.coupling.map(|angle| size * angle),
            Self::PinsSize(size) => {
                frame.pins = frame.pins.map(|pin| pin.map(|angle| size * angle))
            }
            Self::Gears(_) => {}
            Self::Coupling => frame.coupling = frame.coupling.map(|angle| -angle),
            Axes => {
                std::mem::swap(&mut frame.roll, &mut frame.inclination);
                frame.rates.swap(0, 1);
            }
            Turned(way) => {
                Axes.apply(frame);
                frame.roll = frame.roll.map(|roll| way * roll);
                frame.inclination = frame.inclination.map(|angle| -way * angle);
                let [roll, pitch, yaw] = frame.rates;
                let (roll, pitch) = (roll.map(|x| way * x), pitch.map(|x| -way * x));
                frame.rates = [roll, pitch, yaw];
            }
            Roll => {
                frame.roll = frame.roll.map(|roll| -roll);
                frame.rates[0] = frame.rates[0].map(|rate| -rate);
            }
        }
    }

    /// What to do, in words.
    pub(super) fn words(self, coupling: Coupling) -> String {
        let exchange = |part: &str| format!("exchange the columns of left_{part} and right_{part}");
        match self {
            Angle(i) => exchange(&format!("wheel{}_angle", i + 1)),
            Torque(i) => exchange(&format!("wheel{}_motor_torque", i + 1)),
            Pins => exchange("pin_angle"),
            Self::Coupling => format!("turn the sign of {}", coupling_angle(coupling)),
            Axes => AXES.to_owned(),
            Turned(way) => {
                let of = match way > 0.0 {
                    true => "body_inclination and body_rate",
                    false => "body_roll and body_roll_rate",
                };
                format!("{AXES}; then turn the signs of {of}: the sensor is mounted across")
            }
            Roll => "turn the signs of body_roll and body_roll_rate".to_owned(),
            Self::Torques(size) => format!("take {size:.2} of all torques"),
            Self::CouplingSize(size) => format!("take {size:.2} of {}", coupling_angle(coupling)),
            Self::Gears(efficiency) => format!("state drive.gear_efficiency = {efficiency:.1}"),
            Self::PinsSize(size) => format!("take {size:.2} of both pin angles"),
        }
    }
}

/// A frame that is wired so.
pub(super) fn wired(frame: &WholeFrame, wiring: &[Change]) -> WholeFrame {
    let mut wired = *frame;
    wiring.iter().for_each(|change| change.apply(&mut wired));
    wired
}

/// Whether each torque then answers its own encoder.
fn fits(wiring: &[Change], follows: [Option<bool>; 3]) -> bool {
    let is_one = |i: usize| wiring.contains(&Angle(i)) != wiring.contains(&Torque(i));
    (0..3).all(|i| follows[i].is_none_or(|follows| follows != is_one(i)))
}

/// Whether it is of pins and coupling, of everything, or of the axes of the body's sensor: what the misfit shows.
fn is_of_joints(wiring: &[Change]) -> bool {
    let is_of_joints = |c: &Change| matches!(c, Pins | Change::Coupling | Axes | Turned(_));
    wiring.iter().any(is_of_joints)
}

fn words(wiring: &[Change], coupling: Coupling) -> String {
    let words: Vec<String> = wiring.iter().map(|change| change.words(coupling)).collect();
    words.join("; ")
}

/// The part of a log from a second before the wheels turn.
fn part<'a>(frames: &'a [WholeFrame], rover: &WholeRover) -> &'a [WholeFrame] {
    let least = DRIVING_SPEED * Units::of(&rover.side).speed() / rover.side.geometry.wheel_radius;
    let start = frames.first().map_or([None; 6], |f| f.wheel_angle);
    let moves = |f: &WholeFrame| {
        let turns = f.wheel_angle.iter().zip(start);
        let mut turns = turns.filter_map(|(a, b)| Some((*a)? - b?));
        turns.any(|turn| turn.abs() > 0.1_f64.max(least))
    };
    let moved = frames.iter().find(|f| moves(f));
    let from = moved.map_or(0.0, |f| f.time - 1.0);
    let begin = frames.partition_point(|f| f.time < from);
    let longest = LONGEST * pace(frames, rover);
    let end = frames.partition_point(|f| f.time < from + longest);
    &frames[begin..end.max(begin)]
}

/// What the estimator of both sides says of a log that is wired in a way.
#[derive(Clone, Copy, Debug, Default)]
struct Judgement {
    /// Mean over the frames of the sum of all mean NIS of both sides and a third of the misfit.
    sum: f64,
    /// The misfit's part of it.
    misfit: f64,
    /// Share of the frames in which wheels are dragged across.
    dragged: f64,
    roll: RollOnGround,
}

/// Sums over the frames of the squares of the roll rate and of that which the ground under both sides
/// asks for, and of their product, rad^2/s^2.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RollOnGround([f64; 3]);

impl RollOnGround {
    /// Adds a frame of a rover at `speed` (m/s), whose body rolls at `rate` (rad/s).
    pub fn add(&mut self, rover: &WholeRover, estimate: &WholeEstimate, speed: f64, rate: f64) {
        let track: f64 = rover.half_tracks.iter().sum::<f64>() / 3.0;
        let slope = |side: &Estimate| side.contact_angle.iter().sum::<f64>() / 3.0;
        let [left, right] = estimate.sides.each_ref().map(slope);
        let asked = speed * (left - right) / (2.0 * track);
        let of_frame = [rate * rate, asked * asked, rate * asked];
        for (sum, x) in self.0.iter_mut().zip(of_frame) {
            *sum += x;
        }
    }

    /// How the roll follows the ground: where the left wheels climb, the left side rises.
    pub fn correlation(&self) -> f64 {
        let [rates, asked, product] = self.0;
        product / (rates * asked).sqrt()
    }
}

impl Judgement {
    fn of(frames: &[WholeFrame], stated: &StatedBoth<'_>, wiring: &[Change]) -> Self {
        let refused = Self {
            sum: REFUSED,
            ..Self::default()
        };
        let estimator = WholeEstimator::new(stated.rover, stated.settings, stated.joint);
        let (Ok(mut estimator), false) = (estimator, frames.is_empty()) else {
            return refused;
        };
        let side = &stated.rover.side;
        let mut found = Self::default();
        let mut last: Option<(f64, f64)> = None;
        for frame in frames {
            let wired = wired(frame, wiring);
            let Ok(estimate) = estimator.update(&wired) else {
                found.sum += REFUSED;
                continue;
            };
            let misfit = (estimate.misfit / 3.0).min(REFUSED);
            found.misfit += misfit;
            found.sum += misfit;
            found.dragged += f64::from(u8::from(estimate.dragged));
            for health in estimate.sides.iter().filter_map(|s| Some(s.kalman?.health)) {
                let tests: [&[f64]; 4] = [
                    &health.encoder,
                    &health.slip,
                    &health.direction,
                    &health.inclination,
                ];
                found.sum += tests.into_iter().flatten().sum::<f64>();
            }
            if let (Some(turned), [Some(rate), ..]) = (turned(frame), wired.rates)
                && let Some((time, before)) = last.replace((frame.time, turned))
            {
                let way = side.geometry.wheel_radius * (turned - before) / 6.0;
                let speed = way / (frame.time - time).max(f64::MIN_POSITIVE);
                found.roll.add(stated.rover, &estimate, speed, rate);
            }
        }
        // A count of frames.
        let count = frames.len() as f64;
        for mean in [&mut found.sum, &mut found.misfit, &mut found.dragged] {
            *mean /= count;
        }
        found
    }

    /// Whether it fits better than the log as wired: by all innovations, or, of joints, by these and
    /// the misfit. On drives of `examples/mujoco` without a skid turn no other case of a log that is
    /// wired right has less than 0.96 of its sum (`joints`: less than 0.99).
    fn is_better(&self, own: &Self, joints: bool) -> bool {
        let [by_all, by_misfit] = [self.sum / own.sum, self.misfit / own.misfit];
        // The roll follows the ground with it, and not as wired.
        let turns_roll = own.roll.correlation() < 0.0 && self.roll.correlation() > CORRELATED;
        let of_joints = by_all < BETTER_OF_JOINTS || turns_roll && by_all < 1.0;
        by_all < BETTER || joints && of_joints && by_misfit < BETTER_MISFIT
    }
}

/// The sign of the roll against the ground, with what was found corrected.
fn roll_on_ground(found: &Judgement) -> Finding {
    let correlation = found.roll.correlation();
    let figure = format!(
        "the roll follows the ground under both sides with a correlation of {correlation:.2}"
    );
    let finding = Finding::ok("roll and ground", "body_roll_rate", figure);
    let finding = finding.with("correlation", correlation, "-");
    if correlation > CORRELATED {
        finding
    } else if correlation < -CORRELATED {
        finding.fault("turn the signs of body_roll and body_roll_rate: lift the left side by hand, then both must grow; or left and right are exchanged")
    } else {
        finding.cannot_tell("drive over bumps under one side")
    }
}

/// Which exchange or sign the estimator of both sides agrees with, the roll then, and the frames with
/// it. `is_upset`: another test has found a fault, with which no exchange is to be seen; `zeroed`:
/// none has found a joint's zero that is off.
pub fn findings(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    follows: [Option<bool>; 3],
    [is_upset, zeroed]: [bool; 2],
) -> ([Finding; 2], Vec<WholeFrame>) {
    let part = part(frames, stated.rover);
    let of = |wiring: Vec<Change>| {
        let found = Judgement::of(part, stated, &wiring);
        (wiring, found)
    };
    let all: Vec<_> = wirings().into_iter().map(of).collect();
    let own = all[0].1;
    let least = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
    let best = least(&mut all.iter().map(|(_, f)| f.sum));
    let figure = format!(
        "{} exchanges and signs tried; contradiction (sum of the mean NIS of both sides, and the misfit) {:.1} as wired, {best:.1} at best",
        all.len() - 1,
        own.sum
    );
    let finding = Finding::ok(TEST, "all", figure)
        .with("as wired", own.sum, "-")
        .with("at best", best, "-");
    let others = || all.iter().skip(1);
    let mut better: Vec<_> = others()
        .filter(|(wiring, f)| f.is_better(&own, zeroed && is_of_joints(wiring)))
        .collect();
    let best = least(&mut better.iter().map(|(_, f)| f.sum));
    better.retain(|(_, f)| f.sum <= AS_WELL * best);
    // What the torques answer excludes some.
    if better.iter().any(|(wiring, _)| fits(wiring, follows)) {
        better.retain(|(wiring, _)| fits(wiring, follows));
    }
    // With all of one side exchanged for the other the differential's sign fits as well, and the roll
    // does not.
    let follows_ground = |found: &Judgement| found.roll.correlation() > CORRELATED;
    if better.iter().any(|(_, f)| follows_ground(f)) {
        better.retain(|(_, f)| follows_ground(f));
    }
    let words = |wiring: &[Change]| words(wiring, stated.rover.coupling);
    let (mut wiring, mut corrected): (&[Change], _) = (&[], own);
    let finding = if own.dragged > MOSTLY || steering::skids(frames) {
        finding.cannot_tell("wheels are dragged across, which no innovation allows for: drive straight on, over bumps")
    } else if is_upset && !better.is_empty() {
        finding.cannot_tell(
            "correct the faults of the sides first: with them no exchange is to be seen",
        )
    } else if let [(first, judged), rest @ ..] = &better[..] {
        (wiring, corrected) = (first, *judged);
        let mut remedy = words(first);
        for (other, _) in rest {
            remedy += &format!("\nfits as well: {}", words(other));
        }
        finding.fault(remedy)
    } else if others().any(|(_, f)| f.sum < own.sum * AS_WELL) {
        finding.cannot_tell("some exchanges of left and right fit as well: drive over bumps under one side; turn one wheel after the other by hand: its encoder and torque must change")
    } else {
        finding
    };
    let roll = roll_on_ground(&corrected);
    let wired = frames.iter().map(|frame| wired(frame, wiring));
    ([roll, finding], wired.collect())
}

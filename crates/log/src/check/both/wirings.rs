//! Which wiring of left and right the estimator of both sides agrees with.

use super::frames::{Correlation, wheel_turns};
use super::steering;
use super::wiring::Change::Roll;
use super::wiring::{Change, fits, is_of_axes, is_of_joints, wired, wirings, words};
use crate::check::recording::{add, driving_spin, part_of_drive};
use crate::check::{Finding, StatedBoth, rewire};
use rayon::prelude::*;
use robhaz_estimator::Estimate;
use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_model::WholeRover;

const TEST: &str = "left and right";
/// Sum over that of the log as wired below which another wiring is a fault. Of honest drives, straight
/// on and in turns, the least is 0.96; one exchanged wheel on uneven ground has 0.83.
const BETTER: f64 = 0.87;
/// The same of pins, coupling and the axes of the body's sensor, with the misfit's.
const BETTER_OF_JOINTS: f64 = 0.97;
/// Misfit over that of the log as wired of such a case.
const BETTER_MISFIT: f64 = 0.75;
/// The likelihood's sum, of misfit, slip and directions, over that of the log as wired, each wheel radius of the way
/// alike: where it says less, stops and impacts decide. Of 170 honest drives of thirteen rovers none with [`BETTER`] has
/// less than 0.57; of exchanged wheels and pins in these the middle one has 0.3.
const BETTER_LIKELY: f64 = 0.5;
/// Deviations by which a case wins over the wheel radii of the way: once in 700 of correct logs.
const BEYOND: f64 = 3.0;
/// Least number of wheel radii of the way: of fewer a mean difference is beyond that more often.
const LEAST_PARTS: usize = 10;
/// Largest mean NIS that counts, as of a misfit.
const LARGEST_NIS: f64 = 25.0;
/// Sum over the least one up to which a case fits as well.
const AS_WELL: f64 = 1.05;
/// Sum over that of the log as wired of an exchange that the torques ask for: other faults may be in both.
const LARGEST_SUM: f64 = 1.2;
/// So many of those are named.
pub(super) const LISTED: usize = 3;
/// Share of the frames from which on wheels are mostly dragged across.
const MOSTLY: f64 = 0.3;
/// Correlation that shows a sign.
const CORRELATED: f64 = 0.5;
/// Sum of a frame without an estimate: far above that of any contradiction.
const REFUSED: f64 = 1e3;
/// Longest part of a log for which the cases are tried, s of an ordinary drive: some metres.
const LONGEST: f64 = 16.0;

/// What the estimator of both sides says of a log that is wired in a way.
#[derive(Clone, Debug, Default)]
struct Judgement {
    /// Mean over the frames of the sum of all mean NIS of both sides and a third of the misfit.
    sum: f64,
    /// The misfit's part of it.
    misfit: f64,
    /// Share of the frames in which wheels are dragged across.
    dragged: f64,
    /// Of the roll rate with that which the ground asks for.
    roll: Correlation,
    /// Each wheel radius of the way.
    parts: Vec<Part>,
}

/// A part of the way: the sum and the likelihood's sum, no impact counted, and the number of the frames.
type Part = [f64; 3];

/// The roll rate, rad/s, that the ground under both sides asks for of a rover at `speed`, m/s: where the left wheels
/// climb, the left side rises.
pub(super) fn roll_on_ground(rover: &WholeRover, estimate: &WholeEstimate, speed: f64) -> f64 {
    let slope = |side: &Estimate| side.contact_angle.iter().sum::<f64>() / 3.0;
    let [left, right] = estimate.sides.each_ref().map(slope);
    speed * (left - right) / (2.0 * rover.mean_half_track())
}

impl Judgement {
    /// Ends where `is_out` of its sums so far: such a case counts no more.
    fn of(
        frames: &[WholeFrame],
        stated: &StatedBoth<'_>,
        wiring: &[Change],
        is_out: impl Fn(&Self) -> bool,
    ) -> Self {
        let refused = Self {
            sum: REFUSED,
            ..Self::default()
        };
        let (Some(mut estimator), false) = (stated.estimator(), frames.is_empty()) else {
            return refused;
        };
        let side = &stated.rover.side;
        let mut found = Self::default();
        // A count of frames.
        let count = frames.len() as f64;
        let (mut last, mut way): (Option<(f64, f64)>, f64) = (None, 0.0);
        for frame in frames {
            if is_out(&found) {
                // What has no mean is not the best.
                found.sum = f64::INFINITY;
                break;
            }
            let wired = wired(frame, wiring);
            let Ok(estimate) = estimator.update(&wired) else {
                found.sum += REFUSED;
                continue;
            };
            let misfit = (estimate.misfit / 3.0).min(REFUSED);
            found.misfit += misfit;
            found.sum += misfit;
            found.dragged += f64::from(u8::from(estimate.dragged));
            let misfit = estimate.misfit.min(WholeEstimate::LARGEST_MISFIT);
            let (mut all, mut likely) = (misfit / 3.0, misfit);
            for health in estimate.sides.iter().filter_map(|s| Some(s.kalman?.health)) {
                let tests: [&[f64]; 4] = [
                    &health.encoder,
                    &health.slip,
                    &health.direction,
                    &health.inclination,
                ];
                found.sum += tests.into_iter().flatten().sum::<f64>();
                all += capped(&tests);
                likely += capped(&tests[1..3]);
            }
            if let (Some(turned), [Some(rate), ..]) = (wheel_turns(frame), wired.rates)
                && let Some((time, before)) = last.replace((frame.time, turned))
            {
                let step = side.geometry.wheel_radius * (turned - before) / 6.0;
                let speed = step / (frame.time - time).max(f64::MIN_POSITIVE);
                way += step.abs() / side.geometry.wheel_radius;
                let asked = roll_on_ground(stated.rover, &estimate, speed);
                found.roll.add(rate, asked);
            }
            if !estimate.dragged {
                let count = found.parts.len().max(way as usize + 1);
                found.parts.resize(count, Part::default());
                add(&mut found.parts[way as usize], [all, likely, 1.0]);
            }
        }
        for mean in [&mut found.sum, &mut found.misfit, &mut found.dragged] {
            *mean /= count;
        }
        found
    }

    /// Correlation of the roll with the ground over the deviation of none: Fisher's transform of that of independent
    /// samples, the wheel radii of the way.
    fn of_roll(&self) -> f64 {
        // A count of parts.
        let samples = self.parts.len() as f64 - 3.0;
        self.roll.value().atanh() * samples.max(0.0).sqrt()
    }

    /// Whether its sums so far exclude that it is better than `own` over `count` frames, as [`Self::is_better`] says.
    fn is_worse(&self, own: &Self, count: f64) -> bool {
        let [by_all, by_misfit] =
            [self.sum / own.sum, self.misfit / own.misfit].map(|share| share / count);
        // The parts that are over.
        let over = &self.parts[..self.parts.len().saturating_sub(1)];
        let likely = |[_, likely, count]: &Part| likely / count;
        let all = own.parts.iter().map(likely).filter(|of| of.is_finite());
        let found = over.iter().zip(&own.parts);
        let found = found.map(|(other, own)| [likely(other), likely(own)]);
        let found = found.filter(|of| of.iter().all(|of| of.is_finite()));
        let by_likely = found.map(|[other, _]| other).sum::<f64>() / all.sum::<f64>();
        (by_all > BETTER || by_likely > BETTER_LIKELY)
            && (by_all > 1.0 || by_misfit > BETTER_MISFIT || by_likely > 1.0)
    }

    /// Whether it fits better than the log as wired: by all innovations, or, of joints, by these and
    /// the misfit; and over all of the way. On drives of `examples/mujoco` without a skid turn no other case of a log
    /// that is wired right has less than 0.96 of its sum (`joints`: less than 0.99).
    fn is_better(&self, own: &Self, joints: bool) -> bool {
        let [by_all, by_misfit] = [self.sum / own.sum, self.misfit / own.misfit];
        let Some([likely, beyond]) = self.over_way(own) else {
            return false;
        };
        // The roll follows the ground with it, and not as wired.
        let turns_roll =
            own.roll.value() < 0.0 && self.roll.value() > CORRELATED && self.of_roll() > BEYOND;
        let of_joints = by_all < BETTER_OF_JOINTS || turns_roll && by_all < 1.0;
        let of_joints = of_joints && by_misfit < BETTER_MISFIT;
        by_all < BETTER && likely < BETTER_LIKELY
            || joints && of_joints && likely < 1.0 && (turns_roll || beyond > BEYOND)
    }

    /// Against the log as wired, each wheel radius of the way alike: its sum of the likelihood over that of the log, and
    /// the mean difference of the sums over its own deviation; `None` of too short a way.
    fn over_way(&self, own: &Self) -> Option<[f64; 2]> {
        let mean = |[all, likely, count]: &Part| [all / count, likely / count];
        let pairs = own.parts.iter().zip(&self.parts);
        let pairs = pairs.map(|(own, other)| (mean(own), mean(other)));
        // Parts in which wheels are dragged across have no mean.
        let pairs: Vec<_> = pairs.filter(|(a, b)| (a[0] + b[0]).is_finite()).collect();
        let sum = |of: &dyn Fn([f64; 2], [f64; 2]) -> f64| {
            pairs.iter().map(|(a, b)| of(*a, *b)).sum::<f64>()
        };
        // A count of parts.
        let count = pairs.len() as f64;
        let gain = sum(&|own, other| own[0] - other[0]) / count;
        let square = sum(&|own, other| (own[0] - other[0] - gain).powi(2));
        let likely = sum(&|_, other| other[1]) / sum(&|own, _| own[1]);
        let beyond = gain / (square / (count * (count - 1.0))).sqrt();
        (pairs.len() >= LEAST_PARTS).then_some([likely, beyond])
    }
}

/// Sum of mean NIS, none beyond [`LARGEST_NIS`].
fn capped(tests: &[&[f64]]) -> f64 {
    let all = tests.iter().copied().flatten();
    all.map(|nis| nis.min(LARGEST_NIS)).sum()
}

/// The sign of the roll against the ground, with what was found corrected.
fn roll_finding(found: &Judgement) -> Finding {
    let correlation = found.roll.value();
    let figure = format!(
        "the roll follows the ground under both sides with a correlation of {correlation:.2}"
    );
    let finding = Finding::ok("roll and ground", "body_roll_rate", figure);
    let finding = finding.with("correlation", correlation, "-");
    if correlation > CORRELATED {
        finding
    } else if correlation < -CORRELATED && found.of_roll() < -BEYOND {
        finding.fault("turn the signs of body_roll and body_roll_rate: lift the left side by hand, then both must grow; or left and right are exchanged")
    } else {
        finding.cannot_tell("drive over bumps under one side")
    }
}

/// A wiring, and what the estimator says of it.
type Judged = (Vec<Change>, Judgement);

/// The least of the sums.
fn least<'a>(all: impl IntoIterator<Item = &'a Judged>) -> f64 {
    let sums = all.into_iter().map(|(_, found)| found.sum);
    sums.fold(f64::INFINITY, f64::min)
}

/// The wirings that fit better than that of the log, `own`, and as well as the best of them. `None`: none fits better. Empty:
/// one does, but the torques exclude it, and no other one fits. `follows`, `zeroed`, `pitched`: see [`findings`].
fn better<'a>(
    others: &'a [Judged],
    own: &Judgement,
    follows: [Option<bool>; 3],
    [zeroed, pitched]: [bool; 2],
) -> Option<Vec<&'a Judged>> {
    let is_better = |(wiring, found): &&Judged| {
        let joints = zeroed && is_of_joints(wiring);
        let is_excluded = pitched && is_of_axes(wiring);
        found.is_better(own, joints) && !is_excluded
    };
    let is_found = |judged: &&Judged| fits(&judged.0, follows) && is_better(judged);
    let mut better: Vec<&Judged> = others.iter().filter(is_found).collect();
    if better.is_empty() {
        others.iter().find(is_better)?;
        // An encoder alone changes the innovations most, so that it wins where encoder and torque are exchanged.
        let may_be = |(wiring, found): &&Judged| {
            let is_of_wheels = !is_of_joints(wiring) && !wiring.contains(&Roll);
            fits(wiring, follows) && is_of_wheels && found.sum < BETTER * own.sum
        };
        better = others.iter().filter(may_be).collect();
    }
    let best = least(better.iter().copied());
    better.retain(|(_, found)| found.sum <= AS_WELL * best);
    // With all of one side exchanged for the other the differential's sign fits as well, and the roll
    // does not.
    let follows_ground = |found: &Judgement| found.roll.value() > CORRELATED;
    if better.iter().any(|(_, found)| follows_ground(found)) {
        better.retain(|(_, found)| follows_ground(found));
    }
    Some(better)
}

/// Of the exchanges that make each torque answer its own encoder the one that the estimator agrees with, where it agrees
/// with no other one.
fn of_torques<'a>(
    others: &'a [Judged],
    own: &Judgement,
    follows: [Option<bool>; 3],
) -> Option<&'a [Change]> {
    let answers = |judged: &&Judged| fits(&judged.0, follows);
    let mut fitting: Vec<&Judged> = others.iter().filter(answers).collect();
    fitting.sort_by(|a, b| a.1.sum.total_cmp(&b.1.sum));
    let (wiring, best) = fitting.first()?;
    if best.sum > LARGEST_SUM * own.sum {
        return None;
    }
    let next = fitting.get(1).map_or(REFUSED, |(_, found)| found.sum);
    (next > AS_WELL * best.sum).then_some(wiring)
}

/// What to state of inclinations of the acceleration alone.
const FORCE: &str = "state budget.inclination_measures = \"specific-force\": the inclination is that of the acceleration alone, as of an orientation that is made of it";

/// Whether inclinations that are stated to measure gravity fit better as those of the specific force than the log as
/// wired, `own`, and as well as the `best` sum of an exchange: with the axes of the body's sensor exchanged its
/// acceleration is lost, too. On three drives of `examples/mujoco` they have 0.76 of the sum then, and 1.02 and more where
/// gravity is right. (A sensor of gravity that is stated as one of the force has 0.94 with gravity, which shows nothing.)
fn measures_force(
    part: &[WholeFrame],
    stated: &StatedBoth<'_>,
    own: &Judgement,
    best: f64,
) -> bool {
    if stated.settings.budget.specific_force {
        return false;
    }
    let mut stated = *stated;
    stated.settings.budget.specific_force = true;
    // A count of frames.
    let most = AS_WELL * best * part.len() as f64;
    let found = Judgement::of(part, &stated, &[], |found| found.sum > most);
    let beyond = found.over_way(own).map_or(0.0, |[_, beyond]| beyond);
    found.sum < BETTER * own.sum && beyond > BEYOND
}

/// What [`findings`] has found.
pub struct Found {
    /// The roll on the ground, and left and right.
    pub findings: [Finding; 2],
    /// The frames with what was found corrected.
    pub frames: Vec<WholeFrame>,
    /// What to do about a torque that answers the encoder of the other side.
    pub of_torques: Option<String>,
}

/// Which exchange or sign the estimator of both sides agrees with, the roll then, and the frames with
/// it. `follows`: see [`super::torques::follows`]; `is_upset`: another test has found a fault, with which no
/// exchange is to be seen; `zeroed`: none has found a joint's zero that is off; `pitched`: the ground shows that the
/// inclination of the body is none across. `is_compared`: the evidence of the
/// innovations for another case is known to be none; then only those of the joints are tried, whose misfit may show
/// them, and only for a fault.
pub fn findings(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    pace: f64,
    follows: [Option<bool>; 3],
    [is_upset, zeroed, pitched]: [bool; 3],
    is_compared: bool,
) -> Found {
    let turned = driving_spin(&stated.rover.side).max(0.1);
    let wheels = |f: &WholeFrame| (f.time, f.wheel_angle);
    let part = part_of_drive(frames, wheels, turned, LONGEST * pace);
    let own = &Judgement::of(part, stated, &[], |_| false);
    let is_dragged = own.dragged > MOSTLY || steering::skids(frames);
    // A count of frames.
    let count = part.len() as f64;
    let is_out = |found: &Judgement| match is_compared {
        true => found.is_worse(own, count),
        false => found.sum > AS_WELL * own.sum * count,
    };
    // One of those that the torques ask for is right, however it fits.
    let is_asked = |wiring: &[Change]| follows.contains(&Some(false)) && fits(wiring, follows);
    let of = |wiring: Vec<Change>| {
        let asked = is_asked(&wiring);
        let found = Judgement::of(part, stated, &wiring, |found| !asked && is_out(found));
        (wiring, found)
    };
    // As wired is the first.
    let mut others = wirings().split_off(1);
    others.retain(|wiring| !is_compared || is_of_joints(wiring) && !is_dragged && !is_upset);
    let others: Vec<Judged> = others.into_par_iter().map(of).collect();
    let best = least(&others).min(own.sum);
    let figure = format!(
        "{} exchanges and signs tried; contradiction (sum of the mean NIS of both sides, and the misfit) {:.1} as wired, {best:.1} at best",
        others.len(),
        own.sum
    );
    let finding = Finding::ok(TEST, "all", figure)
        .with("as wired", own.sum, "-")
        .with("at best", best, "-");
    let better = better(&others, own, follows, [zeroed, pitched]);
    let better = better.as_deref();
    let words = |wiring: &[Change]| words(wiring, stated.rover.coupling);
    let fits_as_well = |(wiring, found): &&Judged| {
        let is_excluded = !fits(wiring, follows) || pitched && is_of_axes(wiring);
        found.sum < own.sum * AS_WELL && !is_excluded
    };
    let mut as_well: Vec<&Judged> = others.iter().filter(fits_as_well).collect();
    as_well.sort_by(|a, b| a.1.sum.total_cmp(&b.1.sum));
    let (mut wiring, mut corrected): (&[Change], _) = (&[], own);
    let finding = if own.sum >= REFUSED {
        let figure = "the estimator has no force in this part of the log";
        Finding::ok(TEST, "all", figure).cannot_tell("correct what is missing or wrong first")
    } else if is_dragged {
        finding.cannot_tell("wheels are dragged across, which no innovation allows for: drive straight on, over bumps")
    } else if is_upset && better.is_some() {
        finding.cannot_tell(
            "correct the faults of the sides first: with them no exchange is to be seen",
        )
    } else if !is_upset && measures_force(part, stated, own, best) {
        let others = better.unwrap_or_default().iter();
        let others = others.take(LISTED).map(|(wiring, _)| words(wiring));
        finding.fault(FORCE.to_owned() + &rewire::as_well(others))
    } else if let Some([]) = better {
        finding.fault("some channels of left and right are exchanged, and the log does not show which: turn each wheel by hand; its own encoder and torque must change")
    } else if let Some([(first, judged), rest @ ..]) = better {
        (wiring, corrected) = (first, judged);
        let others = rest.iter().map(|(wiring, _)| words(wiring));
        finding.fault(words(first) + &rewire::as_well(others))
    } else if let [_, ..] = &as_well[..] {
        let remedy = "drive over bumps under one side, or turn one wheel after the other by hand: its encoder and torque must change";
        let others = as_well.iter().take(LISTED).map(|(wiring, _)| words(wiring));
        finding.cannot_tell(remedy.to_owned() + &rewire::as_well(others))
    } else {
        finding
    };
    let roll = roll_finding(corrected);
    let wired = frames.iter().map(|frame| wired(frame, wiring));
    let asked = follows
        .contains(&Some(false))
        .then(|| of_torques(&others, own, follows));
    Found {
        findings: [roll, finding],
        frames: wired.collect(),
        of_torques: asked.flatten().map(words),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of ten wheel radii of the way, each with these sums, all and likely, and a misfit.
    fn judged(misfit: f64, sums: impl Fn(u8) -> [f64; 2]) -> Judgement {
        let sums: Vec<[f64; 2]> = (0..10).map(sums).collect();
        Judgement {
            sum: sums.iter().map(|[all, _]| all).sum::<f64>() / 10.0,
            misfit,
            parts: sums
                .iter()
                .map(|[all, likely]| [*all, *likely, 1.0])
                .collect(),
            ..Judgement::default()
        }
    }

    /// Other axes that fit better at two stops, and exchanged wheels of a rover whose misfit and slip hardly show
    /// them, are no better case; one that wins all along the way is, and so are joints that win in the misfit.
    #[test]
    fn a_case_wins_over_the_way_and_not_in_a_few_instants() {
        let own = judged(1.0, |k| if k < 2 { [30.0, 2.0] } else { [4.0, 1.5] });
        let at_stops = judged(2.5, |k| if k < 2 { [10.0, 4.0] } else { [4.2, 2.0] });
        assert!(at_stops.sum < BETTER * own.sum);
        assert!(!at_stops.is_better(&own, true));
        let steady = judged(1.0, |_| [6.0, 1.7]);
        let hardly = judged(1.0, |k| [5.0 + 0.01 * f64::from(k), 1.0]);
        assert!(!hardly.is_better(&steady, false));
        let exchanged = judged(1.0, |k| [4.0 + 0.01 * f64::from(k), 0.5]);
        assert!(exchanged.is_better(&steady, false));
        let [once, always] = [5.0, 0.1].map(|by| {
            judged(0.6, move |k| match k {
                0 => [6.0 - by, 1.0],
                _ => [6.0 - if by < 1.0 { 0.4 } else { 0.0 }, 1.6],
            })
        });
        assert!(!once.is_better(&steady, true) && always.is_better(&steady, true));
    }

    /// Axes of the body's sensor that would fit better are none where all wheels of a side pass the same ground by its
    /// inclination; another case that fits as well is one.
    #[test]
    fn the_ground_excludes_other_axes() {
        let own = judged(1.0, |k| [4.0 + 0.01 * f64::from(k), 1.5]);
        let case = |change: Change| {
            let fits = judged(0.5, |k| [2.0 + 0.02 * f64::from(k), 0.5]);
            (vec![change], fits)
        };
        let others = [case(Change::Axes), case(Change::Turned(1.0))];
        let found = |others: &[Judged], pitched: bool| {
            let found = better(others, &own, [None; 3], [true, pitched]);
            found.map(|found| found.len())
        };
        assert_eq!(
            (found(&others, false), found(&others, true)),
            (Some(2), None)
        );
        assert_eq!(found(&[case(Change::Pins)], true), Some(1));
    }

    /// Encoder and torque of a wheel are exchanged: the encoder alone fits better by the likelihood, and both together by the sum
    /// alone. Where the torques follow their encoders it is both; where that is not known, the encoder; without a case
    /// that the torques allow, it is not known which.
    #[test]
    fn no_exchange_is_named_that_the_torques_exclude() {
        let own = judged(1.0, |k| [10.0 + 0.01 * f64::from(k), 2.0]);
        let case = |wiring: Vec<Change>, likely: f64| {
            let fits = judged(1.0, move |k| [7.0 + 0.02 * f64::from(k), likely]);
            (wiring, fits)
        };
        let encoder = vec![Change::Angle(0)];
        let both = vec![Change::Angle(0), Change::Torque(0)];
        let others = [case(encoder.clone(), 0.5), case(both.clone(), 1.3)];
        let named = |others: &[Judged], follows: Option<bool>| {
            let found = better(others, &own, [follows; 3], [true, false]);
            found.map(|found| {
                let wirings = found.iter().map(|(wiring, _)| wiring.clone());
                wirings.collect::<Vec<_>>()
            })
        };
        assert!(named(&others, Some(true)) == Some(vec![both]));
        assert!(named(&others, None) == Some(vec![encoder]));
        assert!(named(&others[..1], Some(true)) == Some(Vec::new()));
        assert!(named(&others[1..], Some(true)).is_none());
    }

    /// Of the exchanges that a torque asks for one is named that fits clearly best, and none that fits worse than the log.
    #[test]
    fn the_torques_ask_for_the_exchange_that_fits() {
        let own = judged(1.0, |_| [10.0, 2.0]);
        let case = |change: Change, sum: f64| (vec![change], judged(1.0, move |_| [sum, 1.0]));
        let asked = |encoder: f64, torque: f64| {
            let others = [
                case(Change::Angle(0), encoder),
                case(Change::Torque(0), torque),
            ];
            let found = of_torques(&others, &own, [Some(false), None, None]);
            found.map(|wiring| wiring == [Change::Torque(0)])
        };
        assert_eq!(asked(14.0, 9.0), Some(true));
        assert_eq!(asked(9.1, 9.0), None);
        assert_eq!(asked(1e3, 20.0), None);
    }
}

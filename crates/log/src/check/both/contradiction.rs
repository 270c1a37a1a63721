//! Whether the readings of left and right contradict each other: what an estimate says before its
//! forces. What to correct, the tests of a check find.
//!
//! Of two wirings the readings are `exp(E)` times as likely with the other one, where `E` is half of
//! the difference of the sums of normalised innovations squared. With correct readings that happens in
//! at most `exp(-E)` of the logs (Markov's inequality: the likelihood of the other wiring has the mean 1
//! under the right one), for all others together in at most their number times as many. The sums are
//! those of one sample for each [`WholeEstimate::INDEPENDENT`] turn of the wheels, or of fewer where what the two
//! wirings differ by lasts longer. A wiring that fits better than what is stated lets readings fit gains nothing by
//! that: some errors are stated as larger than they are.
//!
//! The same evidence says whether the sizes of torques and of the joints' angles are confirmed, and
//! the sign of the roll: another one is not, if the readings allow it, too, and the forces would differ
//! by more than what is stated.

use super::frames::{Correlation, LONGEST_GAP, body_turn, pace, wheel_turns, without_yaw_bias};
use super::wiring::{Change, wired, wirings, words};
use super::wirings::{LISTED, roll_on_ground};
use super::{STRAIGHT, across, of_start, roll, steering, torques};
use crate::check::recording::{add, driving_speed, part_of_drive};
use crate::check::{Finding, StatedBoth, start, torque_spikes};
use rayon::prelude::*;
use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_estimator::{Confirmation, Flags};
use robhaz_model::WholeRover;
use robhaz_score::signals::{correlated, mean, subtract};

/// Share of the logs with correct readings that may be taken for others.
const CHANCE: f64 = 0.01;
/// Its quantile of a normal deviate.
const BEYOND: f64 = 2.33;
/// Longest part of a log that is compared, s, and least time between its frames, of an ordinary drive.
const LONGEST: f64 = 30.0;
const STEP: f64 = 0.0099;
/// Longest such time, s.
const LONGEST_STEP: f64 = 0.1;
/// Wheel radii of the way over which errors may last that make one wiring fit better than another: contact angles of
/// waves of the ground, some wheel radii long, and what wheels push each other.
const LONGEST_CORRELATION: usize = 10;
/// Mean misfit of readings that all that is stated holds for.
const FITS: f64 = 3.0;

use Change::{Axes, Coupling, Gears, PinsSize, Roll, Torques, TorquesOf};

/// What may be otherwise than stated, by what it changes. A size of torques shows in the work on slopes, too.
const TRIED: [(&str, Change); 14] = [
    ("size of the torques", Torques(2.0 / 3.0)),
    ("size of the torques", Torques(1.5)),
    ("size of the torques of a side", TorquesOf(0, 2.0 / 3.0)),
    ("size of the torques of a side", TorquesOf(0, 1.5)),
    ("size of the torques of a side", TorquesOf(1, 2.0 / 3.0)),
    ("size of the torques of a side", TorquesOf(1, 1.5)),
    ("size of the coupling's angle", Coupling(0.5)),
    ("size of the coupling's angle", Coupling(2.0)),
    ("size of the pins' angles", PinsSize(0.5)),
    ("size of the pins' angles", PinsSize(2.0)),
    ("gears that lose torque", Gears(0.8)),
    ("gears that lose torque", Gears(0.6)),
    ("sign of body_roll", Roll),
    ("axes of the body", Axes),
];

/// Logarithm of the likelihood of the best over that of another one up to which that may be as well: a twentieth.
const AS_WELL: f64 = 3.0;
/// Normal forces over their stated deviation from which on they differ.
const DIFFERENT: f64 = 2.0;

/// Something else than stated that fits better, in words, and how much speaks for it.
struct Better {
    words: String,
    evidence: f64,
}

/// What an estimate says of the readings of both sides.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Consistency {
    /// Why they contradict each other, in words; `None` where they do not.
    pub contradiction: Option<String>,
    /// What they do not confirm, though the forces depend on it.
    pub unconfirmed: Vec<String>,
}

impl Consistency {
    /// Of readings that contradict each other, as these words say.
    fn contradicting(words: String) -> Self {
        Self {
            contradiction: Some(words),
            ..Self::default()
        }
    }
}

/// What is gained by sums of another wiring in place of its own: misfit, and all else.
fn gain([own, own_others]: &[f64; 2], [misfit, others]: &[f64; 2]) -> f64 {
    let by_misfit = (own - misfit).min(own.max(FITS) - misfit.max(FITS));
    by_misfit + own_others - others
}

/// What the estimator of both sides says of a wiring.
#[derive(Default)]
struct Judged {
    /// Means of the normalised innovations squared: misfit; slip and directions of the wheels.
    sums: [f64; 2],
    /// The same of each wheel radius of the way, both together, and the number of the frames.
    parts: Vec<[f64; 2]>,
    /// Number of the frames that count: the rover drives, no wheel is dragged across, no reading has been
    /// missing for long.
    count: f64,
    /// How far the wheels turn in these, rad.
    rolled: f64,
    /// Of the roll rate with that which the ground under both sides asks for.
    roll: Correlation,
    /// Normal forces of all frames with an estimate, N, and the sum of their variances, N^2.
    normal: Vec<(f64, [f64; 6])>,
    variance: f64,
    /// The torques against the weight.
    weight: Option<Confirmation>,
}

impl Judged {
    /// `None` without an estimate, and where `is_out` of the least that its sums can be.
    fn of(
        frames: &[(WholeFrame, f64)],
        stated: &StatedBoth<'_>,
        wiring: &[Change],
        is_out: impl Fn(&[f64; 2]) -> bool,
    ) -> Option<Self> {
        let rover = stated.rover;
        let mut estimator = stated.estimator()?;
        let least = driving_speed(&rover.side);
        let mut found = Self::default();
        let mut last = frames.first().map_or(0.0, |(f, _)| f.time);
        for (frame, speed) in frames {
            let step = frame.time - std::mem::replace(&mut last, frame.time);
            let frame = wired(frame, wiring);
            let Ok(estimate) = estimator.update(&frame) else {
                continue;
            };
            found.normal.push((frame.time, estimate.normal_force));
            found.variance += (0..6).map(|i| estimate.covariance[i][i]).sum::<f64>();
            found.weight = Some(estimate.torque_scale.confirmation);
            let held = estimate.flags().contains(Flags::SENSOR_STALE);
            if estimate.dragged || held || speed.abs() < least {
                continue;
            }
            found.count += 1.0;
            let turned = speed.abs() / rover.side.geometry.wheel_radius;
            found.rolled += turned * step.clamp(0.0, LONGEST_GAP);
            let mut of_frame = [estimate.misfit.min(WholeEstimate::LARGEST_MISFIT), 0.0];
            for health in estimate.sides.iter().filter_map(|s| Some(s.kalman?.health)) {
                of_frame[1] += health.slip.iter().chain(&health.direction).sum::<f64>();
            }
            let (parts, part) = (&mut found.parts, found.rolled as usize);
            parts.resize(parts.len().max(part + 1), [0.0; 2]);
            add(&mut parts[part], [of_frame.iter().sum(), 1.0]);
            add(&mut found.sums, of_frame);
            // No more frames than all can count.
            if is_out(&found.sums.map(|sum| sum / frames.len() as f64)) {
                return None;
            }
            if let [Some(rate), ..] = frame.rates {
                let asked = roll_on_ground(rover, &estimate, *speed);
                found.roll.add(rate, asked);
            }
        }
        found.sums = found.sums.map(|sum| sum / found.count);
        Some(found)
    }

    /// Mean square of the differences of the normal forces of a side from those of `own`, N^2, and of these forces: of the
    /// side that differs more.
    fn differs(&self, own: &Self) -> [f64; 2] {
        let (mut sums, mut other) = ([[0.0; 2]; 2], self.normal.iter().peekable());
        for (time, forces) in &own.normal {
            while other.next_if(|(at, _)| at < time).is_some() {}
            let Some((_, found)) = other.next_if(|(at, _)| at <= time) else {
                continue;
            };
            for (i, (a, b)) in forces.iter().zip(found).enumerate() {
                add(&mut sums[i / 3], [(a - b) * (a - b), a * a]);
            }
        }
        let [left, right] = sums;
        let most = if right[0] > left[0] { right } else { left };
        most.map(|sum: f64| sum / (3 * own.normal.len()) as f64)
    }
}

/// Frames from a second before the wheels turn, some time apart, with the speed, m/s.
fn part(frames: &[WholeFrame], rover: &WholeRover, pace: f64) -> Vec<(WholeFrame, f64)> {
    let radius = rover.side.geometry.wheel_radius;
    let (longest, step) = (pace * LONGEST, (pace * STEP).min(LONGEST_STEP));
    let turns = |f: &WholeFrame| (f.time, [wheel_turns(f)]);
    let mut kept: Vec<(WholeFrame, f64)> = Vec::new();
    for frame in part_of_drive(frames, turns, 0.3, longest) {
        let speed = match kept.last() {
            Some((last, _)) if frame.time - last.time < step => continue,
            Some((last, speed)) => match wheel_turns(frame).zip(wheel_turns(last)) {
                Some((now, before)) => radius * (now - before) / (6.0 * (frame.time - last.time)),
                None => *speed,
            },
            None => 0.0,
        };
        kept.push((*frame, speed));
    }
    kept
}

/// Why the readings contradict each other without an estimate.
fn direct(frames: &[WholeFrame], stated: &StatedBoth<'_>, pace: f64) -> Option<String> {
    let (rover, budget) = (stated.rover, &stated.settings.budget);
    let frames = &without_yaw_bias(frames, budget);
    let words = |finding: Finding| format!("{}: {}", finding.channel, finding.figure);
    let mut direct = across::ranges(frames, rover);
    direct.extend(across::stuck(frames, stated));
    direct.push(roll::roll(frames, stated, pace));
    direct.push(across::yaw(frames, rover, budget));
    direct.extend(across::opposed(frames, rover));
    direct.extend(steering::steering(frames, rover));
    direct.extend(of_start(frames, stated));
    if let Some(finding) = direct.into_iter().find(Finding::is_fault) {
        return Some(words(finding));
    }
    // More than half of a difference over some ten independent samples is no chance: once in 10 000 logs.
    let wrong = |i: &usize| torques::follows(frames, rover, *i, pace) == Some(false);
    let wheel = (0..3).find(wrong)? + 1;
    (body_turn(frames) < STRAIGHT).then_some(())?;
    Some(format!(
        "the torques of left and right wheel {wheel} answer the encoders of the other side"
    ))
}

/// Whether the readings agree, for an estimate.
pub fn contradiction(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Consistency {
    let (side, noise) = (&stated.rover.side, stated.settings.budget.torque_noise);
    let (_, frames) = torque_spikes::of_both(frames, side, noise);
    let frames = &frames;
    let pace = pace(frames, stated.rover);
    if let Some(words) = direct(frames, stated, pace) {
        return Consistency::contradicting(words);
    }
    let Some(compared) = Compared::new(frames, stated, pace) else {
        return Consistency::default();
    };
    match compared.roll() {
        Some(words) => Consistency::contradicting(words),
        None => compared.consistency(compared.wirings()),
    }
}

/// The sizes, for a check: it names no size where a wiring fits better still.
pub fn sizes(frames: &[WholeFrame], stated: &StatedBoth<'_>, pace: f64) -> Finding {
    let compared = Compared::new(frames, stated, pace);
    let mut found = Consistency::default();
    if let Some(compared) = compared {
        found = compared.consistency(Vec::new());
        if found.contradiction.is_some() {
            found = compared.consistency(compared.wirings());
        }
    }
    let finding =
        |figure: String| Finding::ok("sizes and signs", "torques, coupling, roll", figure);
    match (found.contradiction, &found.unconfirmed[..]) {
        (Some(words), _) => finding(words).fault("do the first of these, and check again; where it is right as it is, the log has several faults"),
        (None, []) => finding("other ones agree less, or change the forces little".to_owned()),
        (None, all) => finding(all.join("; ")).cannot_tell(
            "roll: lift the left side by hand, then it must grow, or drive over bumps under one side; torques: drive over slopes with little torque of one wheel against another",
        ),
    }
}

/// A log as wired, with which others are compared.
struct Compared<'a> {
    stated: &'a StatedBoth<'a>,
    part: Vec<(WholeFrame, f64)>,
    own: Judged,
    /// Number of the independent samples.
    samples: f64,
    /// Whether the start shows the size of the torques.
    is_sized: bool,
}

impl<'a> Compared<'a> {
    fn new(frames: &[WholeFrame], stated: &'a StatedBoth<'a>, pace: f64) -> Option<Self> {
        let part = part(frames, stated.rover, pace);
        let own = Judged::of(&part, stated, &[], |_| false)?;
        Some(Self {
            samples: own.rolled / WholeEstimate::INDEPENDENT,
            is_sized: start::confirm(&of_start(frames, stated)),
            stated,
            part,
            own,
        })
    }

    /// What the evidence for another wiring with these sums, or with greater ones, is at most.
    fn most_evidence(&self, sums: &[f64; 2]) -> f64 {
        0.5 * self.samples * gain(&self.own.sums, sums)
    }

    /// Half of the difference of the sums of normalised innovations squared.
    fn evidence(&self, other: &Judged) -> f64 {
        let of_parts =
            |of: &Judged| -> Vec<f64> { of.parts.iter().map(|[sum, count]| sum / count).collect() };
        let gains = subtract(&of_parts(&self.own), &of_parts(other));
        let mean = mean(&gains).unwrap_or(0.0);
        let errors: Vec<f64> = gains.iter().map(|gain| gain - mean).collect();
        // A count of parts.
        let count = errors.iter().filter(|error| error.is_finite()).count() as f64;
        let length = correlated(&errors, LONGEST_CORRELATION);
        let samples = self.samples.min(count / length);
        let gain = gain(&self.own.sums, &other.sums);
        // What speaks against the other one is no alarm.
        0.5 * gain * if gain > 0.0 { samples } else { self.samples }
    }

    /// How far the roll follows the ground, in deviations of a correlation that is none: Fisher's
    /// transform of the correlation of independent samples.
    fn follows(&self) -> f64 {
        self.own.roll.value().atanh() * (self.samples - 3.0).max(0.0).sqrt()
    }

    /// The roll against the ground.
    fn roll(&self) -> Option<String> {
        let correlation = self.own.roll.value();
        (self.follows() < -BEYOND).then(|| {
            format!("body_roll_rate has a correlation of {correlation:.2} with the roll that the ground under both sides asks for")
        })
    }

    /// Exchanges and signs that fit better, with the evidence of so many others that were tried.
    fn wirings(&self) -> Vec<Better> {
        // As wired is the first.
        let wirings = wirings();
        let others = (wirings.len() - 1) as f64;
        let least = (others / CHANCE).ln();
        // No wiring has less than 0.
        let at_most = self.most_evidence(&[0.0; 2]);
        if at_most.is_nan() || at_most <= least {
            return Vec::new();
        }
        let is_out = |sums: &[f64; 2]| self.most_evidence(sums) <= least;
        let of = |wiring: &Vec<Change>| {
            let found = Judged::of(&self.part, self.stated, wiring, is_out)?;
            // One that is dragged across, or has no estimate, compares with nothing.
            let found = Some(found).filter(|found| found.count > 0.9 * self.own.count)?;
            let evidence = self.evidence(&found) - others.ln();
            let words = words(wiring, self.stated.rover.coupling);
            (evidence > -CHANCE.ln()).then_some(Better { words, evidence })
        };
        wirings[1..].par_iter().filter_map(of).collect()
    }

    /// Whether another wiring with this evidence is excluded.
    fn excludes(evidence: f64) -> bool {
        evidence <= -(1.0 / CHANCE).ln()
    }

    /// What is said of the log with something otherwise than stated; `None` of what is confirmed or excluded, or
    /// compares with nothing: wheels are dragged across, or it has no estimate.
    fn judged(&self, other: Change) -> Option<Judged> {
        let mut stated = *self.stated;
        let is_confirmed = match other {
            TorquesOf(..) => self.is_sized,
            Torques(_) => self.is_sized || self.own.weight == Some(Confirmation::Confirmed),
            Roll | Axes => self.follows() > BEYOND,
            _ => false,
        };
        if is_confirmed {
            return None;
        }
        if let Gears(efficiency) = other {
            stated.settings.gear_efficiency = efficiency;
        }
        let is_out = |sums: &[f64; 2]| Self::excludes(self.most_evidence(sums));
        Judged::of(&self.part, &stated, &[other], is_out)
            .filter(|found| found.count >= 0.9 * self.own.count)
    }

    /// What the readings say of sizes of torques and of the joints' angles, gears, and the sign of the roll, beside other
    /// things that fit `better`.
    fn consistency(&self, mut better: Vec<Better>) -> Consistency {
        let others = TRIED.len() as f64;
        let coupling = self.stated.rover.coupling;
        let mut consistency = Consistency::default();
        let mut noted = None;
        let judged = TRIED.par_iter().map(|(_, other)| self.judged(*other));
        let judged: Vec<Option<Judged>> = judged.collect();
        for ((what, other), found) in TRIED.into_iter().zip(judged) {
            let Some(found) = found else {
                continue;
            };
            // At rest there is none.
            let evidence = Some(self.evidence(&found)).filter(|e| e.is_finite());
            let evidence = evidence.unwrap_or(0.0);
            let beyond = evidence - others.ln();
            if beyond > -CHANCE.ln() {
                better.push(Better {
                    words: format!("{what}: {}", other.words(coupling)),
                    evidence: beyond,
                });
                continue;
            }
            let [square, all] = found.differs(&self.own);
            let variance = self.own.variance / (6 * self.own.normal.len()) as f64;
            let matters = square > DIFFERENT * DIFFERENT * variance;
            if matters && !Self::excludes(evidence) && noted != Some(what) {
                noted = Some(what);
                consistency.unconfirmed.push(format!(
                    "{what}: with another one the readings agree as well, and normal forces differ by {:.0} %: {}",
                    100.0 * (square / all).sqrt(),
                    other.words(coupling)
                ));
            }
        }
        better.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let Some((best, rest)) = better.split_first() else {
            return consistency;
        };
        let as_well = rest
            .iter()
            .take_while(|other| best.evidence - other.evidence < AS_WELL);
        let as_well: String = as_well
            .take(LISTED)
            .map(|other| format!(" (or {})", other.words))
            .collect();
        Consistency::contradicting(format!(
            "{}{as_well}, and they fit better: of correct readings that happens in less than {:.1e} of the logs",
            best.words,
            (-best.evidence).exp()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What fits better than what is stated lets readings fit gains nothing; a wiring without a contradiction where the
    /// log has one gains that, and a worse one loses all.
    #[test]
    fn a_fit_that_is_too_good_gains_nothing() {
        for (own, other, expected) in [
            ([3.5, 0.3], [0.7, 0.5], 0.3),
            ([8.0, 0.3], [3.5, 0.3], 4.5),
            ([1.0, 0.0], [2.0, 0.0], -1.0),
        ] {
            let found = gain(&own, &other);
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
    }
}

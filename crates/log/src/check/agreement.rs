//! The estimator's own judgement: [`robhaz_estimator::Health`] of `kalman` over the whole log, and
//! over the same log with its wheels and links wired otherwise.
//!
//! Which torque belongs to which encoder, the speed control shows ([`crate::check::drive`]). That
//! leaves the wheel to which both belong, and the link of gyroscope and inclinometer: 12 wirings,
//! 72 if the torques show nothing. `kalman` runs with each; the one with the least mean NIS fits
//! best.

use crate::check::limits::Limits;
use crate::check::readings::Readings;
use crate::check::report::{Finding, Verdict};
use crate::check::rest::has_quiet;
use crate::check::rewire::{Channel, moved, names};
use crate::check::stated::Stated;
use robhaz_estimator::{
    Confirmation, EstimateError, Estimator, EstimatorSettings, Flags, PAIRINGS, SensorFrame, Sides,
    TorqueScale,
};
use robhaz_score::{Agreement, tests};

pub const TEST: &str = "agreement of all";
pub const WIRING: &str = "wheels and links";
pub const TORQUE_SCALE: &str = "scale of torques, mass";
pub const GEARS: &str = "efficiency of the gears";
const CHANNEL: &str = "all";
/// Efficiencies that are tried.
const EFFICIENCIES: [f64; 5] = [1.0, 0.9, 0.8, 0.7, 0.6];
/// Share of the frames with a reading beyond what the robot can do, or without an estimate, that is
/// a fault.
const OFTEN: f64 = 0.01;
/// Number of such frames that is no fault in a short log, either.
const FEW: f64 = 3.0;
/// Compared sum over the least one of all wirings up to which a wiring fits as well.
const AS_WELL: f64 = 1.1;
/// Compared sum over that of the log's wiring below which another one is a fault.
const BETTER: f64 = 0.7;
/// Compared sum up to which the readings agree as wired: each of nine mean NIS is 1 for innovations as
/// stated.
const AGREE: f64 = 2.0;
/// Number of wirings that are named.
const MOST_SHOWN: usize = 3;
/// NIS of a frame without an estimate: far above that of any contradiction.
const REFUSED: f64 = 1e3;
/// Longest part of a log for which other wirings are tried, s: some metres.
const LONGEST: f64 = 16.0;

/// A wiring: the columns of the log that are encoders and torques of wheels 1 to 3, and whether the
/// links are exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Case {
    encoders: [usize; 3],
    torques: [usize; 3],
    links: bool,
}

/// The wiring of the log.
const OWN: Case = Case {
    encoders: PAIRINGS[0],
    torques: PAIRINGS[0],
    links: false,
};

impl Case {
    /// All wirings in which torque i belongs to encoder `order[i]`; without `order` in which it
    /// belongs to any.
    fn all(order: Option<[usize; 3]>) -> Vec<Self> {
        let mut all = Vec::new();
        for encoders in PAIRINGS {
            for torques in PAIRINGS {
                let of = |links| Self {
                    encoders,
                    torques,
                    links,
                };
                if order.is_none_or(|order| torques.map(|i| order[i]) == encoders) {
                    all.extend([false, true].map(of));
                }
            }
        }
        all.sort_by_key(Self::moved);
        all
    }

    /// Number of channels that are not where the log says.
    fn moved(&self) -> usize {
        let wheels = moved(self.encoders).count() + moved(self.torques).count();
        wheels + 4 * usize::from(self.links)
    }

    fn of(&self, frame: &SensorFrame) -> SensorFrame {
        let mut wired = *frame;
        wired.wheel_angle = self.encoders.map(|i| frame.wheel_angle[i]);
        wired.motor_torque = self.torques.map(|i| frame.motor_torque[i]);
        if self.links {
            std::mem::swap(&mut wired.link1, &mut wired.link2);
        }
        wired
    }

    /// The channels that it changes.
    fn channels(&self) -> String {
        let encoders = moved(self.encoders).map(Channel::Encoder);
        let mut names = names(encoders.chain(moved(self.torques).map(Channel::Torque)));
        if self.links {
            names.push("gyro 1, inclinometer 1, gyro 2, inclinometer 2".to_owned());
        }
        names.join(", ")
    }

    /// What to do, in words: which reading takes the column of which.
    fn words(&self) -> String {
        let mut parts = Vec::new();
        for (order, name) in [(self.torques, "motor_torque"), (self.encoders, "angle")] {
            let reading = |i: usize| format!("wheel{}_{name}", i + 1);
            match moved(order).collect::<Vec<usize>>()[..] {
                [] => {}
                [a, b] => {
                    let (a, b) = (reading(a), reading(b));
                    parts.push(format!("exchange the columns of {a} and {b}"));
                }
                _ => {
                    let takes = |i| format!("{} that of {}", reading(i), reading(order[i]));
                    let takes: Vec<String> = moved(order).map(takes).collect();
                    parts.push(format!("give other columns: {}", takes.join(", ")));
                }
            }
        }
        if self.links {
            parts.push("exchange the columns of links 1 and 2".to_owned());
        }
        parts.join("; ")
    }
}

/// What `kalman` says of a log.
struct Judgement {
    agreement: Agreement,
    /// What `kalman` has found of the torques' scale.
    scale: Option<TorqueScale>,
    /// Mean over the frames of the sum over the tests of their mean NIS.
    nis: f64,
    /// The encoders' part of it.
    of_encoders: f64,
    /// Shares of the frames with a reading beyond what the robot can do, and without an estimate; 0
    /// for a few frames.
    absurd: f64,
    refused: f64,
    /// Why the last of these have none.
    why: Option<EstimateError>,
    /// Normalised square of the parity residual of each frame; a NaN without one.
    parity: Vec<f64>,
}

impl Judgement {
    fn of(
        frames: &[SensorFrame],
        stated: &Stated<'_>,
        settings: &EstimatorSettings,
        case: &Case,
    ) -> Self {
        let mut estimator = Estimator::new(stated.robot, *settings);
        let start = frames.first().map_or(0.0, |frame| frame.time);
        let mut found = Self {
            agreement: Agreement::new(start + stated.compare_from),
            parity: Vec::with_capacity(frames.len()),
            scale: None,
            nis: 0.0,
            of_encoders: 0.0,
            absurd: 0.0,
            refused: 0.0,
            why: None,
        };
        for frame in frames {
            found.parity.push(f64::NAN);
            let estimate = match estimator.update(&case.of(frame)) {
                Ok(estimate) => estimate,
                Err(error) => {
                    found.refused += 1.0;
                    found.why = Some(error);
                    found.nis += REFUSED;
                    continue;
                }
            };
            found.agreement.add(frame.time, &estimate);
            found.scale = estimate.kalman.and_then(|k| k.torque_scale).or(found.scale);
            if estimate.flags.contains(Flags::SENSOR_ABSURD) {
                found.absurd += 1.0;
                found.nis += REFUSED;
            }
            let Some(kalman) = estimate.kalman else {
                continue;
            };
            if let (Some(parity), Some(square)) = (estimate.parity, found.parity.last_mut()) {
                *square = (parity.value / parity.sigma).powi(2);
            }
            found.of_encoders += kalman.health.encoder.iter().sum::<f64>();
            let tests = tests(&kalman.health).into_iter();
            found.nis += tests.flat_map(|(values, _)| values).sum::<f64>();
        }
        let count = frames.len().max(1) as f64;
        found.nis /= count;
        found.of_encoders /= count;
        for share in [&mut found.absurd, &mut found.refused] {
            *share = if *share > FEW { *share / count } else { 0.0 };
        }
        found
    }
}

/// The part of a log for which other wirings are tried.
fn part(frames: &[SensorFrame]) -> &[SensorFrame] {
    let start = frames.first().map_or([None; 3], |f| f.wheel_angle);
    let moves = |f: &SensorFrame| {
        let turn = |(a, b): (Option<f64>, Option<f64>)| Some((a? - b?).abs());
        let mut turns = f.wheel_angle.into_iter().zip(start).filter_map(turn);
        turns.any(|turn| turn > 0.1)
    };
    let moved = frames.iter().position(moves).unwrap_or(0);
    let from = frames[moved].time - 1.0;
    let begin = frames.partition_point(|f| f.time < from);
    let end = frames.partition_point(|f| f.time < from + LONGEST);
    &frames[begin..end.max(begin)]
}

/// `kalman` with what is stated; with contact angles if each wheel has some.
fn settings(stated: &Stated<'_>, frames: &[SensorFrame]) -> EstimatorSettings {
    let has_angle = |i: usize| frames.iter().any(|f| f.contact_angle[i].is_some());
    let best = match (0..3).all(has_angle) {
        true => EstimatorSettings::kalman(),
        false => EstimatorSettings::kalman_without_angles(),
    };
    EstimatorSettings {
        viscous_damping: stated.viscous_damping,
        gear_efficiency: stated.gear_efficiency,
        compression: stated.compression,
        budget: stated.budget,
        sides: stated.sides,
        ..best
    }
}

/// The sum of the mean NIS of each wiring, less the least one of the encoders: what no wiring
/// changes would only hide their differences.
fn compared(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    settings: &EstimatorSettings,
    cases: Vec<Case>,
) -> Vec<(Case, f64)> {
    let judge = |case: Case| (case, Judgement::of(frames, stated, settings, &case));
    let judged: Vec<(Case, Judgement)> = cases.into_iter().map(judge).collect();
    let of_encoders = judged.iter().map(|(_, found)| found.of_encoders);
    let common = of_encoders.fold(f64::INFINITY, f64::min);
    let compared = |(case, found): &(Case, Judgement)| (*case, found.nis - common);
    judged.iter().map(compared).collect()
}

fn least_of(judged: &[(Case, f64)]) -> f64 {
    let all = judged.iter().map(|(_, nis)| *nis);
    all.fold(f64::INFINITY, f64::min)
}

fn nis_of_own(judged: &[(Case, f64)]) -> f64 {
    let own = judged.iter().find(|(case, _)| *case == OWN);
    own.map_or(REFUSED, |(_, nis)| *nis)
}

/// Whether the readings agree, without a look at other wirings.
pub fn as_wired(log: &Readings<'_>, certain: f64) -> Finding {
    let settings = &settings(log.stated, &log.frames);
    let own = Judgement::of(&log.frames, log.stated, settings, &OWN);
    contradiction(&own, certain)
}

/// All findings. `order`: the encoders to which the torques belong, if these show it. `certain`: the mean NIS from
/// which on a contradiction is one, 0 where the readings follow each other closely enough for the filters.
pub fn findings(log: &Readings<'_>, order: Option<[usize; 3]>, certain: f64) -> Vec<Finding> {
    let (frames, stated) = (&*log.frames, log.stated);
    let settings = &settings(stated, frames);
    let own = Judgement::of(frames, stated, settings, &OWN);
    if own.absurd > OFTEN {
        return vec![torque_scale(&own, log.stated), contradiction(&own, certain)];
    }
    let part = part(frames);
    let is_other = order.is_some_and(|o| o != PAIRINGS[0]);
    let is_right = own.agreement.first().is_none() && own.refused <= OFTEN && !is_other;
    let judged_of = |order: Option<[usize; 3]>, few: bool| {
        let mut cases = Case::all(order);
        if !cases.contains(&OWN) {
            cases.insert(0, OWN);
        }
        // One sensor of the body gives the readings of both links.
        cases.retain(|case| !(log.stated.body.is_some() && case.links));
        // Three wheels that moved on by one, and exchanged links, are left out where all agrees.
        cases.retain(|case| !few || case.moved() <= 4 && !case.links);
        compared(part, stated, settings, cases)
    };
    let mut judged = judged_of(if is_right { Some(PAIRINGS[0]) } else { order }, is_right);
    // Where another wiring fits better, the torques may belong to other encoders, too.
    if is_right && least_of(&judged) < BETTER * nis_of_own(&judged) {
        judged = judged_of(order, false);
    }
    let nis_of_own = nis_of_own(&judged);
    // Where the torques belong to other encoders, the wiring of the log is none to choose.
    judged.retain(|(case, _)| !is_other || *case != OWN);
    let least = least_of(&judged);
    // The first that fits as well as the best: the fewest changes.
    let fits = |(_, nis): &&(Case, f64)| *nis <= AS_WELL * least;
    let best = judged.iter().find(fits).map_or(OWN, |(case, _)| *case);
    // The log's own wiring excludes another one as far as the other one would have to exclude it.
    let margin = if best == OWN { 1.0 / BETTER } else { AS_WELL };
    let as_well = judged.iter().filter(|(_, nis)| *nis <= margin * least);
    let mut as_well: Vec<Case> = as_well.map(|(case, _)| *case).collect();
    as_well.retain(|case| *case != best && *case != OWN);
    // Where the readings agree far better than stated, or too few of them show it, another wiring
    // that fits better than that of the log is none to choose, but it fits as well.
    let better = (best != OWN && nis_of_own > AGREE).then_some(best);
    let others: Vec<Case> = better.into_iter().chain(as_well.iter().copied()).collect();
    let figure = format!(
        "{} wirings tried; contradiction (sum of the mean NIS, less that of the encoders at best) {nis_of_own:.1} as wired, {least:.1} at best",
        judged.len()
    );
    let is_better =
        certain <= 0.0 && best != OWN && nis_of_own > AGREE && least < BETTER * nis_of_own;
    // Torques that may be in another unit show no wiring.
    let finding = if has_quiet(&log.findings, "torque") {
        let remedy = "correct the unit of the torques, or state their noise, first";
        Finding::ok(WIRING, CHANNEL, figure).cannot_tell(remedy)
    } else if is_better || best != OWN && is_other {
        let remedy = format!("{}{}", best.words(), also(&as_well));
        Finding::ok(WIRING, best.channels(), figure).fault(remedy)
    } else if let [other, ..] = others[..] {
        let remedy = format!(
            "turn one wheel after the other by hand: its encoder and torque must change{}",
            also(&others)
        );
        Finding::ok(WIRING, other.channels(), figure).cannot_tell(remedy)
    } else {
        Finding::ok(WIRING, CHANNEL, figure)
    };
    let finding = finding
        .with("as wired", nis_of_own, "-")
        .with("at best", least, "-");
    let finding_is_ok = finding.verdict != Verdict::Fault;
    let rewired = match finding.verdict {
        Verdict::Fault => Judgement::of(frames, stated, settings, &best),
        _ => own,
    };
    let contradiction = contradiction(&rewired, certain);
    let mut findings = vec![torque_scale(&rewired, log.stated), finding, contradiction];
    if finding_is_ok {
        findings.splice(0..0, at_limit(frames, &rewired.parity));
        // Fast drives and rare readings leave the filters behind, as such gears do.
        if certain <= 0.0 {
            findings.splice(0..0, gears(part, stated, settings));
        }
    }
    findings
}

/// Torques that are read before gears which lose a part of them: with another efficiency than that stated they agree,
/// and fit far better.
fn gears(
    part: &[SensorFrame],
    stated: &Stated<'_>,
    settings: &EstimatorSettings,
) -> Option<Finding> {
    let of = |gear_efficiency: f64| {
        let settings = EstimatorSettings {
            gear_efficiency,
            ..*settings
        };
        let found = Judgement::of(part, stated, &settings, &OWN);
        (gear_efficiency, found.nis - found.of_encoders)
    };
    let (own, as_stated) = of(settings.gear_efficiency);
    if as_stated <= AGREE {
        return None;
    }
    let tried = EFFICIENCIES.into_iter().map(of);
    let (best, least) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least < BETTER * as_stated && least < AGREE).then(|| {
        let figure = format!(
            "driving and braking torques fit gears of an efficiency of {best:.1}; stated is {own:.2} (contradiction {least:.1} in place of {as_stated:.1})"
        );
        let remedy = format!("state drive.gear_efficiency = {best:.1}, for torques before the gears: currents times torque_constant and gear_ratio");
        Finding::ok(GEARS, "torques 1 to 3", figure)
            .with("efficiency", best, "-")
            .fault(remedy)
    })
}

/// Median of a normalised square if all that is stated holds: of chi-square with one degree of freedom.
const MIDDLE: f64 = 0.455;

/// Torques that stay at a limit.
fn at_limit(frames: &[SensorFrame], parity: &[f64]) -> Option<Finding> {
    let torque = |channel: Channel| {
        let value = |frame: &SensorFrame| channel.value(frame).unwrap_or(f64::NAN);
        (channel.to_string(), frames.iter().map(value).collect())
    };
    let mut limits = Limits::of([0, 1, 2].map(Channel::Torque).map(torque).into_iter());
    let known = parity.iter().enumerate().filter(|(_, x)| x.is_finite());
    known.for_each(|(frame, square)| limits.add(frame, *square));
    limits.finding(MIDDLE)
}

/// The torques against the weight, as `kalman` has found them.
fn torque_scale(own: &Judgement, stated: &Stated<'_>) -> Finding {
    const CHANNEL: &str = "torques 1 to 3";
    if stated.sides == Sides::OneOfTwo {
        let figure = "the torques of one side of two do not carry its weight alone";
        let remedy =
            "hold a wheel by a spring scale: its pull times the wheel radius is the torque";
        return Finding::ok(TORQUE_SCALE, CHANNEL, figure).cannot_tell(remedy);
    }
    let robot = stated.robot;
    let Some(scale) = own.scale else {
        return Finding::ok(TORQUE_SCALE, CHANNEL, "no estimate")
            .cannot_tell("see the faults above");
    };
    let figure = scale.in_words(robot.mass.total()).to_string();
    let finding = Finding::ok(TORQUE_SCALE, CHANNEL, figure)
        .with("ratio", scale.ratio, "-")
        .with("sigma", scale.sigma, "-");
    match scale.confirmation {
        Confirmation::Contradicts => finding.fault(format!(
            "weigh the robot as it drives; if its mass is right, multiply `scale` of the three torques by {:.2}",
            1.0 / scale.ratio
        )),
        Confirmation::Confirmed => finding,
        Confirmation::Unconfirmed => {
            let remedy = "drive gently over a slope of some degrees that is longer than the robot";
            finding.cannot_tell(remedy)
        }
    }
}

/// Wirings that fit as well as the best, in words, a line each.
fn also(cases: &[Case]) -> String {
    let line = |case: &Case| format!("\nfits as well: {}", case.words());
    let mut lines: String = cases.iter().take(MOST_SHOWN).map(line).collect();
    if let more @ 1.. = cases.len().saturating_sub(MOST_SHOWN) {
        lines += &format!("\nand {more} more");
    }
    lines
}

/// What is left with all changes that other tests ask for.
fn contradiction(own: &Judgement, certain: f64) -> Finding {
    let of_frames = |share: f64, channel: &str, what: &str| {
        let figure = format!("{:.1} % of the frames have {what}", 100.0 * share);
        Finding::ok(TEST, channel, figure).with("share", 100.0 * share, "%")
    };
    if own.absurd > OFTEN {
        let what = "a reading beyond what the robot can do";
        return of_frames(own.absurd, CHANNEL, what).fault("check units and gear ratios");
    }
    if let Some(excuse) = own.agreement.wrong(certain) {
        let what = "forces that neither weight nor impacts explain: `estimate` says so, too";
        let names: Vec<&str> = match own.agreement.contradiction(0.0) {
            Some(found) => found.faulty.names().collect(),
            None => vec![CHANNEL],
        };
        let finding = of_frames(own.agreement.out_of_range(), &names.join(", "), what);
        return match excuse {
            Some(excuse) => finding.cannot_tell(excuse.in_words()),
            None => finding.fault("see the faults above and correct them first; without any, check signs, zeros, dimensions, masses and noise budget"),
        };
    }
    let (largest, of) = own.agreement.largest();
    let contradiction = own.agreement.contradiction(certain);
    if let Some((found, first)) = contradiction.zip(own.agreement.first()) {
        let names: Vec<&str> = found.faulty.names().collect();
        let figure = format!(
            "readings contradict each other from {first:.1} s on (largest mean NIS {largest:.1}; from 4 on it is a contradiction, below it a sign, a pairing or a delay does not fit)"
        );
        if let Some(excuse) = found.excuse {
            return Finding::ok(TEST, CHANNEL, figure).cannot_tell(excuse.in_words());
        }
        let remedy = "see the faults above and correct them first; without any, check dimensions, masses and noise budget";
        let finding = Finding::ok(TEST, names.join(", "), figure).fault(remedy);
        return finding
            .with("from", first, "s")
            .with("largest", largest, "-");
    }
    if own.refused > OFTEN {
        let (channel, remedy) = match own.why {
            Some(EstimateError::Missing { field }) => (
                CHANNEL,
                format!("no frame has the reading {field}: map its column, or look into it"),
            ),
            Some(EstimateError::Linkage(_)) => (
                "inclinometer 1, inclinometer 2",
                "check the inclinometers: the four-bar cannot close at such angles".to_owned(),
            ),
            Some(error) => (CHANNEL, format!("the estimator refuses them: {error}")),
            None => (CHANNEL, "see the faults above".to_owned()),
        };
        return of_frames(own.refused, channel, "no estimate").fault(remedy);
    }
    let figure =
        format!("largest mean NIS {largest:.1} ({of}; 1 is right, a contradiction from 4 on)");
    Finding::ok(TEST, CHANNEL, figure).with("largest", largest, "-")
}

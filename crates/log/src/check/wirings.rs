//! Which wiring of wheels and links fits: `kalman` over a part of the log with each of them.
//!
//! Which torque belongs to which encoder, the speed control shows ([`crate::check::drive`]). That
//! leaves the wheel to which both belong, and the link of gyroscope and inclinometer: 12 wirings,
//! 72 if the torques show nothing. The one with the least mean NIS fits best.

use crate::check::judgement::{AGREE, BETTER, Judgement, REFUSED};
use crate::check::recording::part_of_drive;
use crate::check::rest::has_quiet;
use crate::check::rewire::as_well;
use crate::check::wiring::Wiring;
use crate::check::{Finding, Readings, Stated};
use robhaz_estimator::{PAIRINGS, SensorFrame};

pub const TEST: &str = "wheels and links";
const CHANNEL: &str = "all";
/// Contradiction over the least one of all wirings up to which a wiring fits as well.
const AS_WELL: f64 = 1.1;
/// Contradiction of the log's own wiring over the least one from which on another one is the better fit also where
/// readings are too far apart for the filters, whose own errors all wirings have: of honest logs there up to 2.5.
const FAR_BETTER: f64 = 3.0;
/// Number of wirings that are named.
const MOST_SHOWN: usize = 3;
/// Longest part of a log for which other wirings are tried, s: some metres.
const LONGEST: f64 = 16.0;

/// The part of a log for which other wirings are tried.
pub fn part(frames: &[SensorFrame]) -> &[SensorFrame] {
    part_of_drive(frames, |f| (f.time, f.wheel_angle), 0.1, LONGEST)
}

/// A wiring with its contradiction: the sum of the mean NIS, less the least one of the encoders of all that are tried,
/// since what no wiring changes would only hide their differences.
type Tried = (Wiring, f64);

/// The least contradiction, and that of the log's own wiring.
fn least_and_own(tried: &[Tried]) -> [f64; 2] {
    let all = tried.iter().map(|(_, contradiction)| *contradiction);
    let own = tried.iter().find(|(wiring, _)| *wiring == Wiring::OF_LOG);
    let own = own.map_or(REFUSED, |(_, contradiction)| *contradiction);
    [all.fold(f64::INFINITY, f64::min), own]
}

/// The wirings in which the torques belong to the encoders of `order`, if these show it, and that of the log, the fewest
/// changes first. Few where all agrees as wired (`agrees`).
fn tried(
    part: &[SensorFrame],
    stated: &Stated<'_>,
    order: Option<[usize; 3]>,
    agrees: bool,
) -> Vec<Tried> {
    let tried = |order: Option<[usize; 3]>, few: bool| {
        let mut wirings = Wiring::all(order);
        if !wirings.contains(&Wiring::OF_LOG) {
            wirings.insert(0, Wiring::OF_LOG);
        }
        // One sensor of the body gives the readings of both links.
        wirings.retain(|wiring| !(stated.body.is_some() && wiring.links));
        // Three wheels that moved on by one, and exchanged links, are left out where all agrees.
        wirings.retain(|wiring| !few || wiring.moved() <= 4 && !wiring.links);
        let judge = |wiring: &Wiring| Judgement::of(part, stated, wiring);
        let judged: Vec<Judgement> = wirings.iter().map(judge).collect();
        let of_encoders = judged.iter().map(|found| found.of_encoders);
        let common = of_encoders.fold(f64::INFINITY, f64::min);
        let compared = judged.iter().map(|found| found.nis - common);
        wirings.into_iter().zip(compared).collect::<Vec<Tried>>()
    };
    if !agrees {
        return tried(order, false);
    }
    let few = tried(Some(PAIRINGS[0]), true);
    // Where another wiring fits better, the torques may belong to other encoders, too.
    let [least, own] = least_and_own(&few);
    match least < BETTER * own {
        true => tried(order, false),
        false => few,
    }
}

/// The finding, and the wiring that the log should have, if another one is certain. `order`: see
/// [`crate::check::agreement::findings`]; `agrees`: the readings do as wired.
pub fn finding(
    log: &Readings<'_>,
    part: &[SensorFrame],
    order: Option<[usize; 3]>,
    agrees: bool,
) -> (Finding, Option<Wiring>) {
    let is_other = order.is_some_and(|order| order != PAIRINGS[0]);
    let certain = log.certain();
    let mut tried = tried(part, log.stated, order, agrees && !is_other);
    let [_, of_log] = least_and_own(&tried);
    // Where the torques belong to other encoders, the wiring of the log is none to choose.
    tried.retain(|(wiring, _)| !is_other || *wiring != Wiring::OF_LOG);
    let [least, _] = least_and_own(&tried);
    let up_to = |most: f64| {
        let fits = tried.iter().filter(move |(_, found)| *found <= most);
        fits.map(|(wiring, _)| *wiring)
    };
    // The first that fits as well as the best: the fewest changes.
    let best = up_to(AS_WELL * least).next().unwrap_or(Wiring::OF_LOG);
    // The log's own wiring excludes another one as far as the other one would have to exclude it.
    let margin = match best == Wiring::OF_LOG {
        true => 1.0 / BETTER,
        false => AS_WELL,
    };
    let mut alike: Vec<Wiring> = up_to(margin * least).collect();
    alike.retain(|wiring| ![best, Wiring::OF_LOG].contains(wiring));
    // Where the readings agree far better than stated, or too few of them show it, another wiring
    // that fits better than that of the log is none to choose, but it fits as well.
    let better = Some(best).filter(|best| *best != Wiring::OF_LOG && of_log > AGREE);
    let others: Vec<Wiring> = better.into_iter().chain(alike.iter().copied()).collect();
    let share = match certain {
        certain if certain <= 0.0 => BETTER,
        _ => 1.0 / FAR_BETTER,
    };
    let is_certain = certain.is_finite() && better.is_some() && least < share * of_log;
    let figure = format!(
        "{} wirings tried; contradiction (sum of the mean NIS, less that of the encoders at best) {of_log:.1} as wired, {least:.1} at best",
        tried.len()
    );
    let finding = |channel: String| {
        Finding::ok(TEST, channel, figure)
            .with("as wired", of_log, "-")
            .with("at best", least, "-")
    };
    // Torques that may be in another unit show no wiring.
    if has_quiet(&log.findings, "torque") {
        let remedy = "correct the unit of the torques, or state their noise, first";
        (finding(CHANNEL.to_owned()).cannot_tell(remedy), None)
    } else if is_certain || best != Wiring::OF_LOG && is_other {
        let remedy = format!("{}{}", best.words(), also(&alike));
        (finding(best.channels()).fault(remedy), Some(best))
    } else if let [other, ..] = others[..] {
        let remedy = format!(
            "turn one wheel after the other by hand: its encoder and torque must change{}",
            also(&others)
        );
        (finding(other.channels()).cannot_tell(remedy), None)
    } else {
        (finding(CHANNEL.to_owned()), None)
    }
}

/// Wirings that fit as well as the best, in words, a line each.
fn also(wirings: &[Wiring]) -> String {
    let mut lines = as_well(wirings.iter().take(MOST_SHOWN).map(Wiring::words));
    if let more @ 1.. = wirings.len().saturating_sub(MOST_SHOWN) {
        lines += &format!("\nand {more} more");
    }
    lines
}

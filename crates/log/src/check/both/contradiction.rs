//! Whether the readings of left and right contradict each other: what an estimate says before its
//! forces. What to correct, the tests of a check find.
//!
//! Of two wirings the readings are `exp(E)` times as likely with the other one, where `E` is half of
//! the difference of the sums of normalised innovations squared. With correct readings that happens in
//! at most `exp(-E)` of the logs (Markov's inequality: the likelihood of the other wiring has the mean 1
//! under the right one), for all others together in at most their number times as many. The sums are
//! those of one sample in [`LASTS`], for which the errors of the filters' equations last.

use super::wirings::{Change, RollOnGround, wired, wirings};
use super::{STRAIGHT, across};
use crate::check::report::{Finding, Verdict};
use crate::check::stated::StatedBoth;
use robhaz_estimator::DRIVING_SPEED;
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
use robhaz_model::Units;

/// Share of the logs with correct readings that may be taken for others.
const CHANCE: f64 = 0.01;
/// Its quantile of a normal deviate.
const BEYOND: f64 = 2.33;
/// Time for which errors last, s: that of the axial forces in the filters of both sides.
const LASTS: f64 = 2.0;
/// Largest misfit that counts: three innovations of five deviations, as in the mean NIS of a side. An
/// impact is no wiring.
const LARGEST: f64 = 75.0;
/// Longest part of a log that is compared, s, and least time between its frames.
const LONGEST: f64 = 30.0;
const STEP: f64 = 0.0099;

/// What the estimator of both sides says of a wiring.
struct Judged {
    /// Mean of the normalised innovations squared: misfit, slip and directions of the wheels.
    sum: f64,
    /// Number of the frames that count: the rover drives, no wheel is dragged across.
    count: f64,
    /// Correlation of the roll rate with that which the ground under both sides asks for.
    correlation: f64,
}

fn judged(
    frames: &[(WholeFrame, f64)],
    stated: &StatedBoth<'_>,
    wiring: &[Change],
) -> Option<Judged> {
    let rover = stated.rover;
    let mut estimator = WholeEstimator::new(rover, stated.settings, stated.joint).ok()?;
    let least = DRIVING_SPEED * Units::of(&rover.side).speed();
    let (mut sum, mut count, mut roll) = (0.0, 0.0, RollOnGround::default());
    for (frame, speed) in frames {
        let frame = wired(frame, wiring);
        let Ok(estimate) = estimator.update(&frame) else {
            continue;
        };
        if estimate.dragged || speed.abs() < least {
            continue;
        }
        count += 1.0;
        sum += estimate.misfit.min(LARGEST);
        for health in estimate.sides.iter().filter_map(|s| Some(s.kalman?.health)) {
            sum += health.slip.iter().chain(&health.direction).sum::<f64>();
        }
        if let [Some(rate), ..] = frame.rates {
            roll.add(rover, &estimate, *speed, rate);
        }
    }
    Some(Judged {
        sum: sum / count,
        count,
        correlation: roll.correlation(),
    })
}

/// Frames at least [`STEP`] apart from a second before the wheels turn, with the speed, m/s.
fn part(frames: &[WholeFrame], radius: f64) -> Vec<(WholeFrame, f64)> {
    let turned = |f: &WholeFrame| f.wheel_angle.iter().copied().sum::<Option<f64>>();
    let start = frames.iter().find_map(turned).unwrap_or(0.0);
    let moves = |f: &&WholeFrame| turned(f).is_some_and(|turned| (turned - start).abs() > 0.3);
    let from = frames.iter().find(moves).map_or(0.0, |f| f.time - 1.0);
    let mut kept: Vec<(WholeFrame, f64)> = Vec::new();
    for frame in frames
        .iter()
        .filter(|f| f.time >= from && f.time < from + LONGEST)
    {
        let speed = match kept.last() {
            Some((last, _)) if frame.time - last.time < STEP => continue,
            Some((last, speed)) => match turned(frame).zip(turned(last)) {
                Some((now, before)) => radius * (now - before) / (6.0 * (frame.time - last.time)),
                None => *speed,
            },
            None => 0.0,
        };
        kept.push((*frame, speed));
    }
    kept
}

/// Why the readings contradict each other, in words; `None` where they do not.
pub fn contradiction(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Option<String> {
    let is_fault = |finding: &Finding| finding.verdict == Verdict::Fault;
    let direct = [across::roll(frames), across::yaw(frames, stated.rover)];
    let opposed = across::opposed(frames, stated.rover);
    let direct = direct.iter().chain(&opposed).find(|f| is_fault(f));
    if let Some(finding) = direct {
        return Some(format!("{}: {}", finding.channel, finding.figure));
    }
    // More than half of a difference over some ten independent samples is no chance: once in 10 000 logs.
    let wrong = |i: &usize| across::torque_follows(frames, *i) == Some(false);
    if across::turn(frames) < STRAIGHT
        && let Some(i) = (0..3).find(wrong)
    {
        let wheel = i + 1;
        return Some(format!(
            "the torques of left and right wheel {wheel} answer the encoders of the other side"
        ));
    }
    let part = part(frames, stated.rover.side.geometry.wheel_radius);
    let own = judged(&part, stated, &[])?;
    let period = robhaz_score::signals::median(
        part.windows(2).map(|w| w[1].0.time - w[0].0.time).collect(),
    )?;
    let samples = own.count * period / LASTS;
    // Fisher's transform of the correlation of independent samples.
    let deviate = -own.correlation.atanh() * (samples - 3.0).max(0.0).sqrt();
    if deviate > BEYOND {
        return Some(format!(
            "body_roll_rate has a correlation of {:.2} with the roll that the ground under both sides asks for",
            own.correlation
        ));
    }
    // As wired is the first.
    let wirings = wirings();
    let others = (wirings.len() - 1) as f64;
    let least = (others / CHANCE).ln();
    let evidence = |sum: f64| 0.5 * samples * (own.sum - sum);
    // No wiring has less than 0.
    let at_most = evidence(0.0);
    if at_most.is_nan() || at_most <= least {
        return None;
    }
    let all = wirings
        .iter()
        .skip(1)
        .filter_map(|wiring| judged(&part, stated, wiring));
    // One that is dragged across, or has no estimate, compares with nothing.
    let all = all.filter(|found| found.count > 0.9 * own.count);
    let best = all.map(|found| evidence(found.sum)).fold(0.0, f64::max);
    (best > least).then(|| {
        format!(
            "with left and right of some channels exchanged, or a sign turned, they fit better: of correct readings that happens in less than {:.1e} of the logs",
            others * (-best).exp()
        )
    })
}

//! Encoders against each other: signs and counts.

use crate::check::readings::Readings;
use crate::check::report::Finding;
use crate::check::rewire::{Change, Channel};
use robhaz_score::signals::median;

/// Difference of the turns of a wheel from those of the others that is a fault, -: more than slip
/// makes, less than any mistake in counts, gear ratios or edges.
const RATIO_ERROR: f64 = 0.08;
/// Difference in each part of the drive that creep and noise do not make, -: a wheel that differs as
/// much all the time slips, or has another radius.
const SLIP: f64 = 0.02;
/// Parts of the drive: a fault shows in each.
const PARTS: usize = 10;
/// Least number of samples of a part.
const LEAST_SAMPLES: usize = 50;

const TEST: &str = "sign and counts";

/// All findings.
pub fn findings(log: &Readings<'_>) -> [Finding; 3] {
    let recording = &log.recording;
    let ratios = |spin: &[f64]| {
        let ratio = spin.iter().zip(&recording.middle_spin).map(|(a, b)| a / b);
        let ratio: Vec<f64> = ratio.collect();
        parts(&recording.while_driving(&ratio))
    };
    let torque_turns = |j: &usize| {
        let spin = recording.derivative(&recording.torque[*j]);
        median(ratios(&spin)).is_some_and(is_right)
    };
    [0, 1, 2].map(|i| encoder(i, &ratios(&recording.spin[i]), || (0..3).find(torque_turns)))
}

/// Whether a wheel turns as fast as the others.
fn is_right(ratio: f64) -> bool {
    (ratio - 1.0).abs() < RATIO_ERROR
}

/// The finding of encoder `i`, for its ratios to the middle one; `torque` finds a torque that turns
/// as a wheel does.
fn encoder(i: usize, parts: &[f64], torque: impl Fn() -> Option<usize>) -> Finding {
    let channel = Channel::Encoder(i);
    let Some(ratio) = median(parts.to_vec()) else {
        let remedy = "record a drive of some metres";
        return Finding::ok(TEST, channel, "the robot does not drive").cannot_tell(remedy);
    };
    let figure = format!(
        "turns {ratio:.3} times as fast as the middle one of the three wheels ({:.2} to {:.2} is right)",
        1.0 - RATIO_ERROR,
        1.0 + RATIO_ERROR
    );
    let finding = Finding::ok(TEST, channel, figure).with("ratio", ratio, "-");
    let torque = if is_right(ratio) { None } else { torque() };
    if torque.is_none()
        && is_right(ratio)
        && parts.len() == PARTS
        && parts
            .iter()
            .all(|p| (p - 1.0) * (ratio - 1.0).signum() > SLIP)
    {
        let percent = 100.0 * (ratio - 1.0);
        return finding.cannot_tell(format!(
            "it turns {percent:+.1} % all the time: it slips, or its radius, counts or gear ratio differ; measure its circumference"
        ));
    }
    // A wheel that slips for some time, or a robot that is stuck, does not do so all the time.
    if torque.is_none() && parts.iter().copied().any(is_right) {
        return finding;
    }
    let is_steady = parts.iter().all(|p| (p / ratio - 1.0).abs() < RATIO_ERROR);
    let (remedy, change) = if let Some(j) = torque {
        let torque = Channel::Torque(j);
        let remedy = format!(
            "{torque} turns as a wheel does: exchange the columns of {channel} and {torque}"
        );
        (remedy, Some(Change::Exchange(channel, torque)))
    } else if is_right(-ratio) {
        let remedy = format!("wheel {} counts backwards: state sign = \"-\"", i + 1);
        (remedy, Some(Change::Factor(channel, -1.0)))
    } else {
        let remedy = format!(
            "check unit, counts a turn, gear ratio and radius of wheel {}: counts of the others times {ratio:.3}",
            i + 1
        );
        let factor = Change::Factor(channel, 1.0 / ratio);
        (remedy, is_steady.then_some(factor))
    };
    finding.fault(remedy).change(change)
}

/// Medians over the parts of the drive; none of a robot that does not drive.
fn parts(ratio: &[f64]) -> Vec<f64> {
    let driving: Vec<f64> = ratio.iter().copied().filter(|r| r.is_finite()).collect();
    let length = (driving.len() / PARTS).max(LEAST_SAMPLES);
    let parts = driving.chunks_exact(length);
    parts.filter_map(|part| median(part.to_vec())).collect()
}

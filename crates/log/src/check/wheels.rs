//! Encoders against each other: signs and counts.

use crate::check::readings::Readings;
use crate::check::report::Finding;
use crate::check::rewire::{Change, Channel, Tested};
use crate::check::signal::{median, zip};

/// Difference of the turns of a wheel from those of the others that is a fault, -: more than slip
/// makes, less than any mistake in counts, gear ratios or edges.
const RATIO_ERROR: f64 = 0.08;
/// Parts of the drive: a fault shows in each.
const PARTS: usize = 10;
/// Least number of samples of a part.
const LEAST_SAMPLES: usize = 50;

const TEST: &str = "sign and counts";

/// All findings, and what to change before further tests.
pub fn findings(log: &Readings<'_>) -> Tested {
    let (recording, motion, robot) = (&log.recording, &log.motion, log.robot);
    let mut all = Tested::default();
    for i in 0..3 {
        let ratios = |spin: &[f64]| {
            let ratio = zip(spin, &motion.middle_spin, |a, b| a / b);
            parts(&motion.while_driving(robot, &ratio))
        };
        let torque_turns = |j: &usize| {
            let spin = motion.derivative(recording, &recording.torque[*j]);
            let ratio = median(ratios(&spin));
            ratio.is_some_and(|ratio| (ratio - 1.0).abs() < RATIO_ERROR)
        };
        let (finding, change) = encoder(i, &ratios(&motion.spin[i]), || (0..3).find(torque_turns));
        all.add(finding, change);
    }
    all
}

/// Whether a wheel turns as fast as the others: in the middle, or in one part. A wheel that slips
/// for some time, or a robot that is stuck, does not do so all the time.
fn is_right(parts: &[f64]) -> bool {
    let right = |ratio: f64| (ratio - 1.0).abs() < RATIO_ERROR;
    parts.iter().any(|ratio| right(*ratio))
}

/// The finding of encoder `i`, for its ratios to the middle one; `torque` finds a torque that turns
/// as a wheel does.
fn encoder(
    i: usize,
    parts: &[f64],
    torque: impl Fn() -> Option<usize>,
) -> (Finding, Option<Change>) {
    let channel = Channel::Encoder(i);
    let Some(ratio) = median(parts.iter().copied()) else {
        let remedy = "record a drive of some metres";
        let finding = Finding::ok(TEST, channel, "the robot does not drive");
        return (finding.cannot_tell(remedy), None);
    };
    let figure = format!(
        "turns {ratio:.3} times as fast as the middle one of the three wheels ({:.2} to {:.2} is right)",
        1.0 - RATIO_ERROR,
        1.0 + RATIO_ERROR
    );
    let finding = Finding::ok(TEST, channel, figure).with("ratio", ratio, "-");
    let is_near = |value: f64| (ratio - value).abs() < RATIO_ERROR;
    let torque = if is_near(1.0) { None } else { torque() };
    if torque.is_none() && is_right(parts) {
        return (finding, None);
    }
    let is_steady = parts.iter().all(|p| (p / ratio - 1.0).abs() < RATIO_ERROR);
    let (remedy, change) = if let Some(j) = torque {
        let torque = Channel::Torque(j);
        let remedy = format!(
            "{torque} turns as a wheel does: exchange the columns of {channel} and {torque}"
        );
        (remedy, Some(Change::Exchange(channel, torque)))
    } else if is_near(-1.0) {
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
    (finding.fault(remedy), change)
}

/// Medians over the parts of the drive; none of a robot that does not drive.
fn parts(ratio: &[f64]) -> Vec<f64> {
    let driving: Vec<f64> = ratio.iter().copied().filter(|r| r.is_finite()).collect();
    let length = (driving.len() / PARTS).max(LEAST_SAMPLES);
    let parts = driving.chunks_exact(length);
    parts
        .filter_map(|part| median(part.iter().copied()))
        .collect()
}

//! Encoders against each other: signs and counts.
//!
//! Wheels on one ground go as far, but for their slip, which follows their traction. So the turn of
//! wheel i over that of all is `1 + e_i + c (tau_i - tau)/(N r)`, with the same c for all wheels,
//! where e_i is what radius, counts or gear ratio of the wheel differ by. Parts of the drive with
//! different torques tell e_i from slip.

use crate::check::recording::add;
use crate::check::{Change, Channel, Finding, Readings};
use robhaz_estimator::Sides;
use robhaz_score::signals::{mean, median};

/// Difference of the turns of a wheel from those of the others that is a fault, -: more than slip
/// makes, less than any mistake in counts, gear ratios or edges.
const RATIO_ERROR: f64 = 0.08;
/// Parts of the drive: a fault shows in each.
const PARTS: usize = 10;
/// Least number of samples of a part.
const LEAST_SAMPLES: usize = 50;

pub const TEST: &str = "sign and counts";

/// Speeds of a wheel over that of another in a turn: wheels that are steered, or in another track, of a rover that
/// turns about a point three times as far away as its wheels.
const OF_TURN: std::ops::Range<f64> = 0.7..1.4;

/// Relative difference of a wheel's radius from that of the others that is no fault, -: twice what
/// tyres and printed wheels err by.
const RADIUS: f64 = 0.02;
/// Its standard deviations beyond which it is one.
const GATE: f64 = 3.0;
/// Prior of the slip over T/N, -, and its deviation: hard wheels on rock have 0.005, soft ground 0.5
/// (Pacejka, Tyre and Vehicle Dynamics, ch. 3).
const SLIP: [f64; 2] = [0.15, 0.12];

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
    let sizes = sizes(log);
    let may_turn = log.stated.settings.sides == Sides::OneOfTwo && !log.is_of_both;
    [0, 1, 2].map(|i| {
        let size = sizes.map(|sizes| sizes[i]);
        let ratios = ratios(&recording.spin[i]);
        let found = encoder(i, &ratios, size, || (0..3).find(torque_turns));
        let is_of_turn = median(ratios).is_some_and(|ratio| OF_TURN.contains(&ratio));
        found.unless(
            is_of_turn && may_turn,
            "the rover turned, which one side does not show: record a drive straight on",
        )
    })
}

/// By how much each wheel turns more than the middle one of the three beyond its slip, -, and the standard deviation;
/// `None` of a robot that does not drive for long enough.
fn sizes(log: &Readings<'_>) -> Option<[(f64, f64); 3]> {
    let (recording, robot) = (&log.recording, log.stated.robot);
    let budget = &log.stated.settings.budget;
    let moment = robot.mean_wheel_load() * robot.geometry.wheel_radius;
    let driving = |x: &Vec<f64>| recording.while_driving(x);
    let spins = recording.spin.each_ref().map(driving);
    let torques = recording.torque.each_ref().map(driving);
    let known = |k: &usize| (0..3).all(|i| (spins[i][*k] + torques[i][*k]).is_finite());
    let samples: Vec<usize> = (0..recording.len()).filter(known).collect();
    let samples_of_part = (samples.len() / PARTS).max(LEAST_SAMPLES);
    let (mut more, mut pull): ([Vec<f64>; 3], [Vec<f64>; 3]) = Default::default();
    for part in samples.chunks_exact(samples_of_part) {
        let mean = |x: &Vec<f64>| part.iter().map(|k| x[*k]).sum::<f64>() / part.len() as f64;
        let (spin, torque) = (spins.each_ref().map(mean), torques.each_ref().map(mean));
        let [of_spin, of_torque] = [spin, torque].map(|x| x.iter().sum::<f64>() / 3.0);
        for i in 0..3 {
            more[i].push(spin[i] / of_spin - 1.0);
            pull[i].push((torque[i] - of_torque) * of_spin.signum() / moment);
        }
    }
    let parts = more[0].len();
    if parts < PARTS {
        return None;
    }
    let means = |x: &[Vec<f64>; 3]| x.each_ref().map(|x| mean(x).unwrap_or(f64::NAN));
    let (mean_more, mean_pull) = (means(&more), means(&pull));
    // Sums over wheels and parts of the products of the deviations from each wheel's mean.
    let mut sums = [0.0; 3];
    for i in 0..3 {
        for (more, pull) in more[i].iter().zip(&pull[i]) {
            let (more, pull) = (more - mean_more[i], pull - mean_pull[i]);
            add(&mut sums, [pull * pull, pull * more, more * more]);
        }
    }
    let [of_pull, both, of_more] = sums;
    // Three wheels whose sum is zero, less the estimated ones.
    let free = (2 * parts - 3) as f64;
    // What noise makes of the torques' differences shows no slip.
    let noise = budget.torque_noise / moment;
    let of_pull = (of_pull - free * noise * noise / samples_of_part as f64).max(0.0);
    let scatter = of_more / free;
    // Both in units of the scatter.
    let prior = scatter / (SLIP[1] * SLIP[1]);
    let slip = (both + prior * SLIP[0]) / (of_pull + prior);
    let of_slip = scatter / (of_pull + prior);
    let of_offset = budget.torque_offset / moment;
    let size = |i: usize| mean_more[i] - slip * mean_pull[i];
    let sigma = |i: usize| {
        let offset = (slip * slip + of_slip) * of_offset * of_offset;
        (scatter / parts as f64 + mean_pull[i] * mean_pull[i] * of_slip + offset).sqrt()
    };
    let sizes = [0, 1, 2].map(size);
    let middle = median(sizes.to_vec()).unwrap_or(f64::NAN);
    Some([0, 1, 2].map(|i| (sizes[i] - middle, std::f64::consts::SQRT_2 * sigma(i))))
}

/// Whether a wheel turns as fast as the others.
fn is_right(ratio: f64) -> bool {
    (ratio - 1.0).abs() < RATIO_ERROR
}

/// The finding of encoder `i`, for its ratios to the middle one and what it turns more beyond slip,
/// with its deviation; `torque` finds a torque that turns as a wheel does.
fn encoder(
    i: usize,
    parts: &[f64],
    size: Option<(f64, f64)>,
    torque: impl Fn() -> Option<usize>,
) -> Finding {
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
    if let Some((more, sigma)) = size.filter(|(more, _)| is_right(ratio) && more.abs() > RADIUS) {
        let [more, sigma] = [more, sigma].map(|x| 100.0 * x);
        let beyond = format!("it turns {more:+.1} +- {sigma:.1} % beyond its slip");
        let wheel = i + 1;
        return if more.abs() > GATE * sigma {
            let change = Change::Factor(channel, 1.0 / (1.0 + more / 100.0));
            finding.change([change]).fault(format!(
                "{beyond}: check radius of wheel {wheel}, its counts a turn and gear ratio"
            ))
        } else {
            finding.cannot_tell(format!(
                "{beyond}: measure the circumference of wheel {wheel}, or drive some metres more on even ground"
            ))
        };
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

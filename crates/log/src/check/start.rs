//! Torques against the motion of the robot that starts: their signs, and those of all encoders.
//!
//! When the robot starts, each motor accelerates rotor, wheel and its share of the robot: its
//! torque follows the wheels' acceleration with a positive coefficient, whatever the control is.
//! All three negative ones mean the torques, or the encoders: these, if the inclinometers show the
//! acceleration the other way round, too.

use crate::check::newton::{OTHER_SIZE, Start, inertia};
use crate::check::recording::SMOOTHING;
use crate::check::rest::rest;
use crate::check::{Change, Channel, Finding, Readings, Verdict};
use robhaz_score::signals::{fit, smooth};

/// Time from the first motion on that counts as the start, and as much rest before it as there is,
/// s.
const START: f64 = 1.0;
/// Share of a torque's change that the acceleration explains at a start on even ground.
const EXPLAINED: f64 = 0.5;
/// Time for which residuals are correlated, s.
const CORRELATED: f64 = 0.1;
/// Speed over the largest one of a start from which on the robot was driving before.
const AT_ONCE: f64 = 0.2;
/// Deviations of a coefficient that tell its sign.
const GATE: f64 = 5.0;

/// Torques of a start over those that the inertias ask for, from which on, and below one over which,
/// units are wrong: masses are known better, and the other side of a robot can do no more than all.
const OTHER_UNIT: f64 = 5.0;
/// Standard deviations by which they are beyond.
const CERTAIN: f64 = 2.0;

pub const TEST: &str = "sign at the start";
pub const SIZE: &str = "size at the start";

/// Torque over the acceleration of the wheels in a start, N m s^2, where it is known.
fn coefficients(log: &Readings<'_>) -> [Option<f64>; 3] {
    let recording = &log.recording;
    let end = rest(recording);
    let (before, after) = (recording.steps(0.3 * START), recording.steps(START));
    let range = end.saturating_sub(before)..(end + after).min(recording.len());
    let half = recording.steps(0.5 * SMOOTHING);
    let acceleration = recording.derivative(&recording.middle_spin);
    // A log that begins in a drive has no start.
    let spins = recording.middle_spin[range.clone()].iter();
    let mut speeds = spins.map(|spin| spin.abs());
    let first = speeds.find(|spin| spin.is_finite()).unwrap_or(0.0);
    let is_start = first < AT_ONCE * speeds.fold(0.0, f64::max);
    let (acceleration, constant) = (&acceleration[range.clone()], vec![1.0; range.len()]);
    let correlated = (recording.steps(CORRELATED) as f64).sqrt();
    [0, 1, 2].map(|i| {
        let torque = &smooth(&recording.torque[i], half)[range.clone()];
        // The mean of the torque explains nothing.
        let mean = fit(torque, &[&constant])?.coefficients[0];
        let torque: Vec<f64> = torque.iter().map(|t| t - mean).collect();
        let found = fit(&torque, &[acceleration, &constant])?;
        let value = found.coefficients[0];
        let known = value.abs() > GATE * correlated * found.deviations[0];
        (is_start && known && found.explained > EXPLAINED).then_some(value)
    })
}

/// What the inertias of rotor, wheel and a third of the robot ask for, N m s^2.
pub fn expected(log: &Readings<'_>) -> f64 {
    inertia(log.stated.robot) / 3.0
}

/// The channel of torques or encoders that are in another unit.
const OF_UNIT: &str = "encoders, torques";

/// Whether a start shows another unit of torques or encoders: nothing that follows from both is right.
pub fn is_of_unit(finding: &Finding) -> bool {
    finding.verdict == Verdict::Fault && finding.test == TEST && finding.channel.ends_with(OF_UNIT)
}

/// Units of encoders and torques, if those of a start do not fit.
pub fn unit(log: &Readings<'_>) -> Option<Finding> {
    let [a, b, c] = coefficients(log);
    let share = (a? + b? + c?) / (3.0 * expected(log));
    let is_other = share > 0.0 && !(1.0 / OTHER_UNIT..OTHER_UNIT).contains(&share);
    let figure =
        format!("the torques of the start are {share:.3} of what the robot's inertias ask for");
    let remedy = "the encoders or the torques have another unit (degrees 57.3; mN m, or mA for A, 1000), or are those of the motor's side: angles over the gear ratio, torques times it; or the masses are wrong";
    let finding = Finding::ok(TEST, OF_UNIT, figure).with("share", share, "-");
    is_other.then(|| finding.fault(remedy))
}

/// The size of all torques, of a start that shows it. Beyond that it is their unit.
pub fn size(start: Option<Start>) -> Option<Finding> {
    if start.is_none() {
        let figure = "no start from a rest on level ground";
        let finding = Finding::ok(SIZE, "torques 1 to 3", figure);
        return Some(finding.cannot_tell("stand for a second on level ground, and start there"));
    }
    let is_size = |start: &Start| (1.0 / OTHER_UNIT..OTHER_UNIT).contains(&start.size);
    let Start { size, sigma, .. } = start.filter(is_size)?;
    let figure = format!(
        "the torques are {size:.2} +- {sigma:.2} of what the inertias of the robot ask for ({:.2} to {OTHER_SIZE:.2} is right)",
        1.0 / OTHER_SIZE
    );
    let finding = Finding::ok(SIZE, "torques 1 to 3", figure)
        .with("size", size, "-")
        .with("deviation", sigma, "-");
    let is_other = size - CERTAIN * sigma > OTHER_SIZE || size + CERTAIN * sigma < 1.0 / OTHER_SIZE;
    let is_right = (1.0 / OTHER_SIZE..=OTHER_SIZE).contains(&size);
    let remedy = format!(
        "check torque_constant, gear_ratio and scale of all torques: scale times {:.2} would fit; or the masses and the rotors' inertia",
        1.0 / size
    );
    Some(match (is_other, is_right) {
        (true, _) => finding.fault(remedy),
        (_, true) => finding,
        _ => finding.cannot_tell(format!(
            "{remedy}; one start more, faster, on level ground shows it better"
        )),
    })
}

/// Whether the findings of a start exclude another size of the torques: one does, and none is a fault.
pub fn confirm(findings: &[Finding]) -> bool {
    findings.iter().any(confirms) && !findings.iter().any(Finding::is_fault)
}

/// Whether a finding of [`size`] excludes another size.
fn confirms(finding: &Finding) -> bool {
    let [size, sigma] = ["size", "deviation"].map(|name| finding.number(name));
    let is_within = |(size, sigma): (f64, f64)| {
        size + GATE * sigma < OTHER_SIZE && size - GATE * sigma > 1.0 / OTHER_SIZE
    };
    finding.test == SIZE && size.zip(sigma).is_some_and(is_within)
}

/// All findings, for encoders of one sign. `forward` is the sign of the acceleration by the
/// inclinometers over that by the encoders, 0 where it is not known.
pub fn findings(log: &Readings<'_>, forward: f64) -> Vec<Finding> {
    let coefficients = coefficients(log);
    let is_backwards = coefficients.iter().all(|c| c.is_some_and(|c| c < 0.0));
    if forward < 0.0 || is_backwards && forward > 0.0 {
        let mut finding = common(is_backwards, forward);
        if log.stated.body_link().is_some() && !is_backwards {
            // The sign of the body's readings alone.
            let remedy = "the signs of body_inclination and body_rate are wrong, nose up is positive; or, if the robot drove backwards, those of all encoders and torques";
            finding = finding
                .change([Change::Factor(Channel::Pin, -1.0)])
                .fault(remedy);
        }
        return vec![finding];
    }
    if let Some(finding) = unit(log) {
        return vec![finding];
    }
    let expected = expected(log);
    let of_torque = |i: usize| {
        let torque = Channel::Torque(i);
        let Some(coefficient) = coefficients[i] else {
            let figure = "the torque does not follow the acceleration of a start";
            let remedy = "start on even ground, after a rest, and accelerate harder: the torque must exceed its noise and the forces between the wheels";
            return Finding::ok(TEST, torque, figure).cannot_tell(remedy);
        };
        let figure = format!(
            "{coefficient:.2} N m for each rad/s^2 of the wheels; positive is right, the robot's inertias ask for {expected:.2}"
        );
        let finding = Finding::ok(TEST, torque, figure).with("coefficient", coefficient, "N m s^2");
        if coefficient > 0.0 {
            return finding;
        }
        let remedy = format!("change the sign of {torque}: driving forward is positive");
        finding.fault(remedy).change([Change::Factor(torque, -1.0)])
    };
    [0, 1, 2].map(of_torque).into()
}

/// Signs of a whole group: torques, encoders or the sensors of both links.
fn common(torques_are_backwards: bool, forward: f64) -> Finding {
    let turned = |channel: &Channel| Change::Factor(*channel, -1.0);
    let (names, figure, remedy, channels) = match (torques_are_backwards, forward < 0.0) {
        (true, true) => (
            "encoders 1 to 3",
            "the wheels turn against their torques and against the acceleration that the inclinometers show",
            "the signs of all encoders are wrong: forward is positive",
            0..3,
        ),
        (true, _) => (
            "torques 1 to 3",
            "the wheels turn against their torques and with the acceleration that the inclinometers show",
            "the signs of all torques are wrong: driving forward is positive",
            3..6,
        ),
        (false, _) => (
            "gyros 1 and 2, inclinometers 1 and 2",
            "the inclinometers show the acceleration of the wheels the other way round",
            "the signs of all gyros and inclinometers are wrong, nose up is positive; or those of all encoders and torques",
            6..10,
        ),
    };
    let finding = Finding::ok(TEST, names, figure).fault(remedy);
    finding.change(Channel::all()[channels].iter().map(turned))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A size near 1 is confirmed where the start knows it, and one that may as well be two thirds is not.
    #[test]
    fn a_start_confirms_the_size_that_it_shows() {
        let of = |sigma: f64| {
            let start = Start {
                lag: 0.0,
                size: 1.0,
                sigma,
                left: 0.1,
                left_in_time: 0.1,
            };
            let found = size(Some(start)).expect("a finding");
            (found.verdict, confirms(&found))
        };
        assert_eq!(of(0.04), (Verdict::Ok, true));
        assert_eq!(of(0.1), (Verdict::Ok, false));
    }
}

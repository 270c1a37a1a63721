//! Torques against encoders, wheel by wheel: exchanged wheels, signs and delays.
//!
//! A speed control answers each wheel's own speed: differences of the torques from their mean follow the differences of the
//! spin speeds and angles from theirs,
//!
//! ```text
//! dtau_i = a dphi_i + b domega_i
//! ```
//!
//! with the same a and b, not both positive, for all wheels, whatever the common set speed is. The pairing of torques and
//! encoders, and the signs, that this explains best are the true ones.

use crate::delay::{Allowed, delay};
use crate::fit::fit;
use crate::links::in_words;
use crate::motion::Motion;
use crate::recording::Recording;
use crate::report::{Finding, Verdict};
use crate::signal::{high_pass, rms, smooth, zip};

/// Time over which torques are averaged, s: as spin speeds.
const SMOOTHING: f64 = 0.05;
/// Differences are those within this time, s.
const SPAN: f64 = 2.0;
/// RMS of the differences between the torques of the log, N m, that shows something.
const LEAST_DIFFERENCE: f64 = 0.15;
/// Share of the differences that a speed control explains.
const EXPLAINED: f64 = 0.5;
/// Larger share of another pairing that is a fault.
const BETTER: f64 = 0.15;
/// Delay of a torque behind its encoder that a control itself may have, s.
const CONTROL_DELAY: f64 = 0.008;
/// Longest delay that is looked for, s.
const LONGEST_DELAY: f64 = 0.1;

const PAIRING: &str = "wiring of wheels";
const DELAY: &str = "delay";
const CHANNEL: &str = "torques and encoders";
const LATE: &str = "torques after encoders";

/// A wiring of the torques: the encoder to which torque i belongs, and the sign of torque i.
type Wiring = ([usize; 3], [f64; 3]);

/// Wirings that are looked for: exchanged wheels, wrong signs.
const WIRINGS: [Wiring; 13] = [
    ([0, 1, 2], [1.0, 1.0, 1.0]),
    ([1, 0, 2], [1.0, 1.0, 1.0]),
    ([0, 2, 1], [1.0, 1.0, 1.0]),
    ([2, 1, 0], [1.0, 1.0, 1.0]),
    ([1, 2, 0], [1.0, 1.0, 1.0]),
    ([2, 0, 1], [1.0, 1.0, 1.0]),
    ([0, 1, 2], [-1.0, 1.0, 1.0]),
    ([0, 1, 2], [1.0, -1.0, 1.0]),
    ([0, 1, 2], [1.0, 1.0, -1.0]),
    ([0, 1, 2], [-1.0, -1.0, 1.0]),
    ([0, 1, 2], [-1.0, 1.0, -1.0]),
    ([0, 1, 2], [1.0, -1.0, -1.0]),
    ([0, 1, 2], [-1.0, -1.0, -1.0]),
];

/// Differences of torques, spin angles and spin speeds from their means over the wheels: one wheel after the other, with
/// gaps that no delay bridges.
struct Differences {
    torque: Vec<f64>,
    angle: Vec<f64>,
    speed: Vec<f64>,
}

impl Differences {
    fn of(recording: &Recording, motion: &Motion, (order, signs): &Wiring) -> Self {
        let half = recording.steps(0.5 * SMOOTHING);
        let span = recording.steps(0.5 * SPAN);
        let gap = recording.steps(LONGEST_DELAY) + 2;
        let joined = |of: [Vec<f64>; 3]| {
            let mean: Vec<f64> = (0..of[0].len())
                .map(|k| (of[0][k] + of[1][k] + of[2][k]) / 3.0)
                .collect();
            let mut all = Vec::new();
            for x in &of {
                all.extend(high_pass(&zip(x, &mean, |x, m| x - m), span));
                all.extend(std::iter::repeat_n(f64::NAN, gap));
            }
            all
        };
        let torque = [0, 1, 2].map(|i| {
            let mut torque = smooth(&recording.torque[i], half);
            torque.iter_mut().for_each(|t| *t *= signs[i]);
            torque
        });
        Self {
            torque: joined(torque),
            angle: joined(order.map(|i| smooth(&recording.wheel_angle[i], half))),
            speed: joined(order.map(|i| motion.spin[i].clone())),
        }
    }

    /// Share of the torques that a stable speed control, the same for all wheels, explains: it brakes a wheel that is ahead.
    fn explained(&self) -> f64 {
        let found = fit(&self.torque, &[&self.angle, &self.speed]);
        let stable = found.filter(|f| f.coefficients[0] < 0.0 || f.coefficients[1] < 0.0);
        stable.map_or(0.0, |f| f.explained)
    }
}

/// All findings.
pub fn findings(recording: &Recording, motion: &Motion) -> Vec<Finding> {
    let differences = Differences::of(recording, motion, &WIRINGS[0]);
    let size = rms(&differences.torque);
    if size < LEAST_DIFFERENCE {
        let figure = format!("the torques differ by {size:.2} N m RMS only");
        let remedy = "drive over an obstacle, so that the wheels' torques differ";
        return vec![
            Finding::cannot_tell(PAIRING, CHANNEL, &figure, remedy),
            Finding::cannot_tell(DELAY, LATE, figure, remedy),
        ];
    }
    let shares = WIRINGS.map(|wiring| Differences::of(recording, motion, &wiring).explained());
    let own = shares[0];
    // The first of equal ones: exchanged wheels before wrong signs.
    let (mut best, mut most) = (0, own);
    for (k, share) in shares.iter().enumerate() {
        if *share > most + 1e-3 {
            (best, most) = (k, *share);
        }
    }
    let differences = Differences::of(recording, motion, &WIRINGS[best]);
    let figure = format!(
        "own encoders explain {:.0} % of the differences between the torques ({size:.2} N m RMS)",
        100.0 * own
    );
    let pairing = if most > EXPLAINED && most > own + BETTER {
        let figure = format!("{figure}, otherwise wired {:.0} %", 100.0 * most);
        Finding::fault(PAIRING, CHANNEL, figure, remedy(&WIRINGS[best]))
    } else if own > EXPLAINED {
        Finding::ok(PAIRING, CHANNEL, figure)
    } else {
        let remedy =
            "drive under speed control over an obstacle, so that the wheels' torques differ";
        Finding::cannot_tell(PAIRING, CHANNEL, figure, remedy)
    };
    vec![pairing, late(recording, &differences)]
}

/// What to do about a wiring, in words.
fn remedy((order, signs): &Wiring) -> String {
    let exchanged: Vec<String> = (0..3)
        .filter(|i| order[*i] != *i)
        .map(|i| format!("torque {} belongs to encoder {}", i + 1, order[i] + 1))
        .collect();
    if !exchanged.is_empty() {
        return format!(
            "{}: exchange the torques, or the encoders",
            exchanged.join(", ")
        );
    }
    let wrong: Vec<String> = (0..3)
        .filter(|i| signs[*i] < 0.0)
        .map(|i| format!("{}", i + 1))
        .collect();
    format!(
        "change the sign of torque {}, or of its encoder",
        wrong.join(" and ")
    )
}

/// Delay of the torques behind their encoders, of all wheels together.
fn late(recording: &Recording, differences: &Differences) -> Finding {
    let longest = recording.steps(LONGEST_DELAY);
    let memory = recording.steps(0.25);
    let Differences {
        torque,
        angle,
        speed,
    } = differences;
    let allowed = Allowed {
        early: CONTROL_DELAY,
        late: CONTROL_DELAY,
    };
    let allowed = allowed.at_period(recording.slowest);
    let found = delay(
        torque,
        &[angle, speed],
        longest,
        memory,
        recording.dt,
        allowed,
    );
    let channel = LATE;
    let remedy = "drive under speed control over an obstacle, so that the wheels' torques differ";
    let Some(found) = found.filter(|d| d.explained > EXPLAINED) else {
        return Finding::cannot_tell(DELAY, channel, "torques do not follow the encoders", remedy);
    };
    let figure = in_words(&found);
    match allowed.judge(&found) {
        Verdict::Ok => return Finding::ok(DELAY, channel, figure),
        Verdict::CannotTell => return Finding::cannot_tell(DELAY, channel, figure, remedy),
        Verdict::Fault => {}
    }
    let (what, offset) = if found.seconds > 0.0 {
        ("the torques'", -found.seconds)
    } else {
        ("the encoders'", found.seconds)
    };
    let remedy = format!(
        "{what} readings arrive late, unless the control itself is that slow: state offset = {offset:.4} of their channel"
    );
    Finding::fault(DELAY, channel, figure, remedy)
}

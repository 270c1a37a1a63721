//! Torques against encoders, wheel by wheel: exchanged wheels, signs and delays.
//!
//! A speed control answers each wheel's own speed: differences of the torques from their mean
//! follow the differences of the spin speeds and angles from theirs,
//!
//! ```text
//! dtau_i = a dphi_i + b domega_i
//! ```
//!
//! with the same a and b, not both positive, for all wheels, whatever the common set speed is. The
//! pairing of torques and encoders, and the signs, that this explains best are the true ones.

use crate::check::newton::Start;
use crate::check::recording::{SMOOTHING, slowness};
use crate::check::rewire::{moved, names};
use crate::check::{Change, Channel, Finding, Readings, Recording, Verdict, delay, start};
use nalgebra::{DMatrix, Matrix2, Matrix3, Vector2};
use robhaz_estimator::{LATE_TORQUE, PAIRINGS};
use robhaz_score::signals::{Allowed, delay, fit, high_pass, products, rms, smooth, subtract};
use std::f64::consts::TAU;

/// Differences are those within this time, s.
const SPAN: f64 = 2.0;
/// Differences between the torques over what noise and gains of the budget make that show
/// something.
const GATE: f64 = 2.0;
/// Share of the differences that a speed control explains.
const EXPLAINED: f64 = 0.5;
/// Residual share over that of the log's wiring below which another wiring is a fault.
const BETTER: f64 = 0.5;
/// Difference of two shares that counts as none.
const EQUAL: f64 = 1e-3;
/// A wiring fits as well as the best if it leaves a tenth more.
const AS_WELL: f64 = 0.1;
/// Share that the fit of one torque by another must explain to show its size.
const CERTAIN_SIZE: f64 = 0.95;
/// Share that a fit must explain to show a delay. Honest logs at 0.1 m/s whose fits explain 96 to
/// 98.6 % look late by up to 85 ms; a drive that answers its encoders explains 99.6 %.
const CERTAIN: f64 = 0.99;
/// Longest delay that is looked for, s.
const LONGEST_DELAY: f64 = 0.3;
/// Damping ratio of a wheel under its speed control below which no robot drives: it would swing on with a third of its
/// amplitude in each period. A low pass with the time constant of a PI control leaves its integral part alone, and none
/// of its damping.
const LEAST_DAMPED: f64 = 0.2;
/// Size of a torque over that of both others that is a fault, and up to which the others are alike.
const OTHER_SIZE: f64 = 1.4;
const ALIKE: f64 = 1.2;

pub const PAIRING: &str = "wiring of wheels";
/// Its faults make all that follows from the torques wrong.
pub const BY_DIRECTION: &str = "sign on the way back";
const CHANNEL: &str = "torques and encoders";
pub const LATE: &str = "torques after encoders";

/// A wiring of the torques: the encoder to which torque i belongs, and the sign of torque i.
type Wiring = ([usize; 3], [f64; 3]);

/// The wiring of the log.
const OWN: Wiring = ([0, 1, 2], [1.0; 3]);

/// All wirings, the fewest changes first.
fn wirings() -> Vec<Wiring> {
    let of = |bits: u32| [0, 1, 2].map(|i| if bits >> i & 1 == 1 { -1.0 } else { 1.0 });
    let all = (0..8).flat_map(|bits| PAIRINGS.map(|order| (order, of(bits))));
    let mut all: Vec<Wiring> = all.collect();
    all.sort_by_key(|(order, signs)| moved(*order).count() + turned(signs).count());
    all
}

/// The torques of the wrong sign.
fn turned(signs: &[f64; 3]) -> impl Iterator<Item = usize> {
    (0..3).filter(|i| signs[*i] < 0.0)
}

/// Torques, spin angles and spin speeds, averaged, less their means over [`SPAN`].
type Signals = [[Vec<f64>; 3]; 3];

/// `stretched`: over times that are so many times as long.
fn signals(recording: &Recording, torque: &[Vec<f64>; 3], stretched: f64) -> Signals {
    let half = recording.steps(0.5 * stretched * SMOOTHING);
    let span = recording.steps(0.5 * stretched * SPAN);
    let smoothed = |x: &[Vec<f64>; 3]| x.each_ref().map(|x| high_pass(&smooth(x, half), span));
    let [torque, angle] = [torque, &recording.wheel_angle].map(smoothed);
    let speed = match stretched > 1.0 {
        true => smoothed(&recording.spin),
        false => recording.spin.each_ref().map(|x| high_pass(x, span)),
    };
    [torque, angle, speed]
}

/// Differences between the torques.
struct Differences {
    signals: Signals,
    /// Sums of the products of all signals, torques 0 to 2, angles 3 to 5, speeds 6 to 8.
    sums: DMatrix<f64>,
    /// RMS, and what noise and gains of the budget make of it, N m.
    size: f64,
    least: f64,
}

impl Differences {
    /// Of torques at the samples of the recording, N m.
    fn of(log: &Readings<'_>, torque: &[Vec<f64>; 3], stretched: f64) -> Self {
        let (recording, budget) = (&log.recording, &log.stated.settings.budget);
        let signals = signals(recording, torque, stretched);
        let all: Vec<&[f64]> = signals.iter().flatten().map(Vec::as_slice).collect();
        let (sums, count) = products(&all);
        let count = count as f64;
        // Noise and different gains make differences, too: RMS of the mean of the torques, N m.
        let common = (sums.view((0, 0), (3, 3)).sum() / (9.0 * count)).sqrt();
        let noise = budget.torque_noise / (recording.steps(stretched * SMOOTHING) as f64).sqrt();
        let mut found = Self {
            signals,
            sums,
            size: f64::NAN,
            least: GATE * noise.hypot(budget.torque_gain * common),
        };
        let torques = [0, 1, 2].map(|i| (i, 1.0));
        found.size = (found.product(torques, torques) / (3.0 * count)).sqrt();
        found
    }

    fn show(&self) -> bool {
        self.size > self.least
    }

    /// The findings of wiring and delay that such ones do not show.
    fn too_small(&self) -> [Finding; 2] {
        let Self { size, least, .. } = *self;
        let figure = match size.is_nan() {
            true => "the wheels do not turn together long enough".to_owned(),
            false => {
                format!("the torques differ by {size:.2} N m RMS only, {least:.2} are needed")
            }
        };
        let remedy = "drive over an obstacle, so that the wheels' torques differ";
        let of = |test, channel| Finding::ok(test, channel, &figure).cannot_tell(remedy);
        let [mut pairing, delay] = [of(PAIRING, CHANNEL), of(delay::TEST, LATE)];
        if size.is_finite() {
            pairing = pairing.with("difference", size, "N m");
        }
        [pairing, delay]
    }

    /// Sum over the wheels of the products of two signals' differences from their means over the
    /// wheels.
    fn product(&self, a: [(usize, f64); 3], b: [(usize, f64); 3]) -> f64 {
        let of = |i: usize, j: usize| a[i].1 * b[j].1 * self.sums[(a[i].0, b[j].0)];
        let products = Matrix3::from_fn(of);
        products.trace() - products.sum() / 3.0
    }

    /// Share of the torques that a stable speed control, the same for all wheels, explains: it
    /// brakes a wheel that is ahead.
    fn explained(&self, (order, signs): &Wiring) -> f64 {
        let torques = [0, 1, 2].map(|i| (i, signs[i]));
        let angles = order.map(|i| (3 + i, 1.0));
        let speeds = order.map(|i| (6 + i, 1.0));
        let of = |a, b| self.product(a, b);
        let both = of(angles, speeds);
        let normal = Matrix2::new(of(angles, angles), both, both, of(speeds, speeds));
        let right = Vector2::new(of(angles, torques), of(speeds, torques));
        let found = normal.try_inverse().map(|inverse| inverse * right);
        let stable = found.filter(|c| c.iter().any(|c| *c < 0.0));
        stable.map_or(0.0, |c| c.dot(&right) / of(torques, torques))
    }
}

/// Differences from the mean over the wheels: one wheel after the other, with gaps that no delay
/// bridges.
fn joined([torque, angle, speed]: &Signals, gap: usize, (order, signs): &Wiring) -> [Vec<f64>; 3] {
    let joined = |x: [&Vec<f64>; 3], signs: [f64; 3]| {
        let mut all = Vec::new();
        for (i, sign) in signs.iter().enumerate() {
            let mean = |k: usize| (0..3).map(|i| signs[i] * x[i][k]).sum::<f64>() / 3.0;
            all.extend((0..x[i].len()).map(|k| sign * x[i][k] - mean(k)));
            all.extend(std::iter::repeat_n(f64::NAN, gap));
        }
        all
    };
    [
        joined(torque.each_ref(), *signs),
        joined(order.map(|i| &angle[i]), [1.0; 3]),
        joined(order.map(|i| &speed[i]), [1.0; 3]),
    ]
}

/// All findings, and the encoders to which the torques belong, if these show it.
pub fn findings(log: &Readings<'_>, start: Option<Start>) -> (Vec<Finding>, Option<[usize; 3]>) {
    let recording = &log.recording;
    let differences = |stretched| Differences::of(log, &recording.torque, stretched);
    let usual = differences(1.0);
    let stretched = slowness(recording.usual_spin(), log.stated.robot);
    let slow = (stretched > 1.0 && !usual.show()).then(|| differences(stretched));
    let slow = slow.filter(Differences::show);
    let is_slow = slow.is_some();
    let differences = slow.unwrap_or(usual);
    if !differences.show() {
        let [pairing, delay] = differences.too_small();
        let delay = late_at_start(start).unwrap_or(delay);
        return (vec![pairing, delay], None);
    }
    if let Some(finding) = by_direction(log, &differences, if is_slow { stretched } else { 1.0 }) {
        return (vec![finding], None);
    }
    let (pairing, best) = pairing(&differences);
    let known = pairing.verdict != Verdict::CannotTell;
    let mut delay = late_at_start(start).unwrap_or_else(|| match is_slow {
        true => {
            Finding::ok(delay::TEST, LATE, "a slow drive shows none").cannot_tell("drive faster")
        }
        false => {
            let gap = recording.steps(LONGEST_DELAY) + 2;
            late(log, &joined(&differences.signals, gap, &best))
        }
    });
    if start.is_some_and(|start| start.is_in_time()) && delay.is_fault() {
        let figure = delay.figure + ": the control's own, as the robot's start has no delay";
        delay = Finding::ok(delay.test, delay.channel, figure);
    }
    let mut findings = vec![pairing, delay];
    if known && best == OWN {
        findings.extend(size_of_one(&differences.signals));
    }
    let (order, _) = best;
    (findings, known.then_some(order))
}

/// Torques that count what drives as positive, forward and back, where the log has both: with the sign of the direction
/// they answer the encoders as those of a control do.
fn by_direction(log: &Readings<'_>, as_read: &Differences, stretched: f64) -> Option<Finding> {
    let spin = log.recording.while_driving(&log.recording.middle_spin);
    let is_both = [1.0, -1.0].map(|sign| spin.iter().any(|spin| sign * spin > 0.0));
    if is_both != [true; 2] {
        return None;
    }
    let directed = |torque: &Vec<f64>| {
        let all = torque.iter().zip(&log.recording.middle_spin);
        all.map(|(torque, spin)| torque * spin.signum()).collect()
    };
    let torque = log.recording.torque.each_ref().map(directed);
    let directed = Differences::of(log, &torque, stretched);
    let [own, other] = [as_read, &directed].map(|of| of.explained(&OWN));
    (other > EXPLAINED && 1.0 - other < BETTER * (1.0 - own)).then(|| {
        let figure = format!(
            "own encoders explain {:.0} % of the differences between the torques, {:.0} % with the sign of the direction of travel",
            100.0 * own,
            100.0 * other
        );
        Finding::ok(BY_DIRECTION, "torques 1 to 3", figure)
            .explained(own, other)
            .fault("the torques count what drives as positive, forward and back: log them with the direction of the wheel, positive where they drive it forward")
    })
}

/// The finding of the wiring, and the wiring that explains the torques best; without one that is certain, that
/// of the log or a guess.
fn pairing(differences: &Differences) -> (Finding, Wiring) {
    let size = differences.size;
    let explained = |wiring| (wiring, differences.explained(&wiring));
    let shares: Vec<(Wiring, f64)> = wirings().into_iter().map(explained).collect();
    let own = differences.explained(&OWN);
    // The first of equal ones: the fewest changes.
    let (mut best, mut most) = (OWN, own);
    for (wiring, share) in &shares {
        if *share > most + EQUAL {
            (best, most) = (*wiring, *share);
        }
    }
    let figure = format!(
        "own encoders explain {:.0} % of the differences between the torques ({size:.2} N m RMS)",
        100.0 * own
    );
    let finding = if most > EXPLAINED && 1.0 - most < BETTER * (1.0 - own) {
        let is_as_well = |share: f64| most - share < AS_WELL * (1.0 - most);
        let others = shares.iter().filter(|(wiring, _)| *wiring != best);
        let as_well = others.filter(|(_, share)| is_as_well(*share));
        let as_well: Vec<String> = as_well.map(|(wiring, _)| words(wiring)).collect();
        let mut remedy = words(&best);
        if !as_well.is_empty() {
            remedy = format!("{remedy}; these fit as well: {}", as_well.join("; "));
        }
        let figure = format!("{figure}, otherwise wired {:.0} %", 100.0 * most);
        let (_, signs) = best;
        let changes = turned(&signs).map(|i| Change::Factor(Channel::Torque(i), -1.0));
        Finding::ok(PAIRING, channels(&best), figure)
            .fault(remedy)
            .change(changes)
    } else if own > EXPLAINED {
        best = OWN;
        Finding::ok(PAIRING, CHANNEL, figure)
    } else {
        Finding::ok(PAIRING, CHANNEL, figure).cannot_tell(
            "drive under speed control over an obstacle, so that the wheels' torques differ",
        )
    };
    let finding = finding.with("difference", size, "N m");
    (finding.explained(own, most), best)
}

/// One torque of another size than both others: under the same control, `tau_i/s_i - tau_j/s_j = a (phi_i - phi_j) +
/// b (omega_i - omega_j)` for the sizes s, whatever both have in common.
fn size_of_one([torque, angle, speed]: &Signals) -> Option<Finding> {
    // Over that of wheel j. Errors of the torques and of the encoders make it too small, and its inverse as well.
    let fitted = |i: usize, j: usize| {
        let [angle, speed] = [angle, speed].map(|x| subtract(&x[i], &x[j]));
        let found = fit(&torque[i], &[&torque[j], &angle, &speed])?;
        (found.explained > CERTAIN_SIZE).then_some(found.coefficients[0])
    };
    let size = |i: usize, j: usize| Some([fitted(i, j)?, 1.0 / fitted(j, i)?]);
    let is_beyond = |sizes: &[f64], least: f64| {
        sizes.iter().all(|x| *x > least) || sizes.iter().all(|x| *x > 0.0 && *x < 1.0 / least)
    };
    (0..3).find_map(|i| {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        let [a, b, others] = [size(i, j)?, size(i, k)?, size(j, k)?];
        let sizes = [a, b].concat();
        let is_other = is_beyond(&sizes, OTHER_SIZE) && !is_beyond(&others, ALIKE);
        let size = sizes.iter().product::<f64>().powf(0.25);
        is_other.then(|| {
            let figure = format!("{size:.2} times as large as those of the others for the same answer to its encoder");
            Finding::ok("size of one", Channel::Torque(i), figure).with("size", size, "-").fault(format!(
                "check its torque_constant, gear_ratio and scale, unless its control has other gains: scale times {:.2} would fit",
                1.0 / size
            ))
        })
    })
}

/// The channels that a wiring changes.
fn channels((order, signs): &Wiring) -> String {
    let torques = (0..3).filter(|i| order[*i] != *i || signs[*i] < 0.0);
    let encoders = moved(*order).map(Channel::Encoder);
    names(torques.map(Channel::Torque).chain(encoders)).join(", ")
}

/// What to do about a wiring, in words.
fn words((order, signs): &Wiring) -> String {
    let (torque, encoder) = (Channel::Torque, |i: usize| Channel::Encoder(order[i]));
    let belongs = moved(*order).map(|i| format!("{} belongs to {}", torque(i), encoder(i)));
    let belongs = belongs.collect::<Vec<_>>().join(", ");
    let wrong = names(turned(signs).map(torque)).join(" and ");
    let signs = format!("change the sign of {wrong}, or of its encoder");
    match (belongs.is_empty(), wrong.is_empty()) {
        (true, _) => signs,
        (false, true) => belongs,
        (false, false) => format!("{belongs}; {signs}"),
    }
}

/// Share of the torques that encoders of this many counts a turn (0: exact) leave in the fit, and that of the
/// control's gain which they pass: errors of the speeds by counts. The fit answers them with a share `1 - N/V` of the control's gain, where `N` is
/// their variance and `V` that of the speeds which the angles leave, so that they leave `b^2 N/(1 - N/V)` for
/// the gain `b` of the fit.
fn share_of_counts(
    recording: &Recording,
    counts: f64,
    [torque, angle, speed]: &[Vec<f64>; 3],
) -> [f64; 2] {
    let fits = fit(torque, &[angle, speed]).zip(fit(speed, &[angle]));
    let Some((control, of_angle)) = fits.filter(|_| counts > 0.0) else {
        return [0.0, 1.0];
    };
    let half = recording.steps(0.5 * SMOOTHING) as f64;
    let (samples, apart) = (2.0 * half + 1.0, 2.0 * half * recording.dt);
    let count = TAU / counts;
    // Readings within a count err alike.
    let turned = recording.usual_spin().unwrap_or(0.0) * SMOOTHING;
    let independent = (turned / count).clamp(1.0, samples);
    // Of the means before and behind; of three wheels' differences from their mean.
    let noise = 2.0 / 3.0 * 2.0 * count * count / 12.0 / independent / (apart * apart);
    let left = (1.0 - of_angle.explained) * rms(speed).powi(2);
    let passed = 1.0 - noise / left;
    if passed.is_nan() || passed <= 0.0 {
        return [1.0, 0.0];
    }
    let by_noise = control.coefficients[1].powi(2) * noise / passed;
    [by_noise / rms(torque).powi(2), passed]
}

/// Torques that are late, as a start shows them.
fn late_at_start(start: Option<Start>) -> Option<Finding> {
    let start = start.filter(Start::is_late)?;
    let figure = format!(
        "{:.0} ms at the start of the robot, where its law of motion leaves {:.1} % of the torques, without a delay {:.1} %",
        1e3 * start.lag,
        100.0 * start.left,
        100.0 * start.left_in_time
    );
    let whose = match start.lag > 0.0 {
        true => "torques",
        false => "encoders",
    };
    let finding = Finding::ok(delay::TEST, LATE, figure).with("delay", start.lag, "s");
    Some(finding.fault(remedy(whose, -start.lag.abs())))
}

/// What to do about readings that are late by an offset, s.
fn remedy(whose: &str, offset: f64) -> String {
    format!(
        "the {whose} arrive late, by a filter or a delay in the driver, unless the control itself is that slow: log unfiltered ones, or state offset = {offset:.4} of a channel of theirs, [[channel]]"
    )
}

/// Delay of the torques behind their encoders, of all wheels together.
fn late(log: &Readings<'_>, joined: &[Vec<f64>; 3]) -> Finding {
    let (recording, [torque, angle, speed]) = (&log.recording, joined);
    // Errors of the encoders leave a share.
    let [errors, passed] =
        share_of_counts(recording, log.stated.settings.budget.encoder_counts, joined);
    let [longest, memory] = [LONGEST_DELAY, 0.25].map(|time| recording.steps(time));
    let allowed = Allowed {
        early: LATE_TORQUE + 0.5 * recording.slowest,
        late: LATE_TORQUE + 0.5 * recording.slowest,
        explained: CERTAIN,
        errors,
    };
    let by = [angle.as_slice(), speed];
    let found = delay(torque, &by, longest, memory, recording.dt, allowed);
    let mut found = found.filter(|d| d.explained > EXPLAINED);
    if let Some(delay) = &mut found {
        // The wheels are one behind the other in these signals, at the same times: only the time
        // counts.
        delay.length /= 3.0;
    }
    let is_of_counts = found.is_some_and(|d| d.gained > 0.0 && d.gained <= errors);
    let unknown = match is_of_counts {
        true => "counts of the encoders look like a delay: drive faster, over larger obstacles",
        false => "drive under speed control over an obstacle, so that the wheels' torques differ",
    };
    let unknown = ["torques do not follow the encoders", unknown];
    let whose = ["torques", "encoders"];
    let finding = delay::finding(LATE, found, &allowed, unknown, whose, remedy);
    if finding.is_fault() || passed <= 0.5 {
        return finding;
    }
    let Some(control) = fit(torque, &by).filter(|control| control.explained > CERTAIN) else {
        return finding;
    };
    let gains = [control.coefficients[0], control.coefficients[1] / passed];
    let damped = damping_ratio(log, gains);
    if damped.is_none_or(|ratio| ratio > LEAST_DAMPED) {
        return finding;
    }
    let figure = format!(
        "as they are read, their control would not damp the wheels (damping ratio {:.2}, {:.1} % explained)",
        damped.unwrap_or(0.0),
        100.0 * control.explained
    );
    Finding::ok(delay::TEST, LATE, figure).fault(
        "the torques are late, by a filter or a delay in the driver: log unfiltered ones, and start from a rest on level ground, which shows by how much",
    )
}

/// That of a wheel with its share of the robot under a control with these gains of its angle (N m) and its speed
/// (N m s), both negative where it brakes; `None` without one of the angle.
fn damping_ratio(log: &Readings<'_>, [of_angle, of_speed]: [f64; 2]) -> Option<f64> {
    let damping = log.stated.settings.viscous_damping - of_speed;
    (of_angle < 0.0).then(|| damping / (2.0 * (-of_angle * start::expected(log)).sqrt()))
}

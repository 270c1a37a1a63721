//! Noise and spikes of the links' sensors, or of those of the body, while the robot drives.
//!
//! Ground moves a link smoothly: in a step ds of the path an axle rises by at most ds. White noise
//! is what three readings in a row differ by from a straight line beyond that, and a spike is what
//! a reading or two differ by from those before and after.

use crate::check::changes::DEGREE;
use crate::check::rest::{OFFSET_GATE, SHORTEST, SHOWN, SMALL_RATE, rest};
use crate::check::{Channel, Finding, Readings, Recorded, Recording};
use robhaz_model::Robot;
use robhaz_score::signals::{deviation, high_pass, integral, median, rms, subtract, white_noise};

const NOISE: &str = "noise while driving";
const ZERO: &str = "zero while driving";
const WHITE: &str = "white noise while driving";
const SPIKES: &str = "spikes";

/// Half of the time of the mean that is taken from an inclination less the integral of its
/// gyroscope, s: vibration of links and wheels is faster, the errors of both are slower.
const HALF_TIME: f64 = 0.125;
/// Noise over that of the budget from which on the budget states too little.
const RATIO: f64 = 2.0;
/// Change of the slope of an axle's path between readings that is usual on uneven ground, rad: a
/// corner of 17 deg.
const CORNER: f64 = 0.3;
/// Standard deviations that a spike is beyond: none by chance.
const GATE: f64 = 10.0;
/// Standard deviations of an inclinometer beside the drift of its gyroscope that are none.
const CERTAIN: f64 = 3.0;
/// Angle (rad) or rate (rad/s) by ground and impacts from which a spike cannot be distinguished.
const MOST: f64 = 4.0;
/// Fewest readings in which spikes are looked for.
const LEAST: usize = 50;

/// All findings; nothing of a log that does not drive.
pub fn findings(log: &Readings<'_>) -> Vec<Finding> {
    let Some(ground) = Ground::of(log) else {
        return Vec::new();
    };
    let recording = &log.recording;
    let channels = Recorded::of_recording(recording, recording.len(), log.stated);
    let pairs = channels.windows(2);
    let pairs = pairs.filter(|pair| pair[1].channel.is_inclination());
    let mut findings = Vec::new();
    findings.extend((pairs.clone()).filter_map(|pair| beside_gyro(recording, &pair[0], &pair[1])));
    // At rest it shows better.
    if rest(recording) < recording.steps(SHORTEST) {
        findings.extend(pairs.filter_map(|pair| drift(log, &pair[0], &pair[1])));
    }
    for channel in &channels {
        if channel.channel == Channel::Pin {
            findings.extend(white(log, channel, &ground));
        }
        findings.extend(spikes(log, channel, &ground));
    }
    findings
}

/// What an inclinometer shows beside the integral of its gyroscope while the robot drives: noise,
/// accelerations, and vibration of the links. It is no fault, but with a budget that states much
/// less `kalman` names channels whose wiring is right.
fn beside_gyro(recording: &Recording, gyro: &Recorded, read: &Recorded) -> Option<Finding> {
    let drift = subtract(&read.values, &integral(&gyro.values, recording.dt));
    let error = recording.while_driving(&high_pass(&drift, recording.steps(HALF_TIME)));
    error.iter().find(|x| x.is_finite())?;
    let [noise, shown] = [rms(&error), read.noise].map(|x| x / DEGREE);
    let figure = format!("{noise:.3} deg, budget.inclination_noise {shown:.3} deg");
    let finding = Finding::ok(NOISE, read.channel, figure).with("noise", noise, "deg");
    if noise <= (RATIO * shown).max(SHOWN) {
        return Some(finding);
    }
    Some(finding.cannot_tell(format!(
        "accelerations, vibration or noise: where its sign, unit and noise at rest are right, state inclination_noise = {:.5} (rad)",
        noise * DEGREE
    )))
}

/// The zero of a gyroscope, by what its integral turns more than the inclinometer beside it: from the middle of the first
/// third of the log to that of the last one. What the inclinometer shows beside a steady drift is an error of it.
fn drift(log: &Readings<'_>, gyro: &Recorded, read: &Recorded) -> Option<Finding> {
    let (recording, budget) = (&log.recording, &log.stated.settings.budget);
    let drift = subtract(&integral(&gyro.values, recording.dt), &read.values);
    let third = drift.len() / 3;
    let [first, last] = [&drift[..third], &drift[2 * third..]].map(|part| median(part.to_vec()));
    // Numbers of samples.
    let time = 2.0 * third as f64 * recording.dt;
    let rate = (last? - first?) / time;
    let line = |k: usize| drift[k] - rate * recording.dt * k as f64;
    let beside = deviation(&(0..drift.len()).map(line).collect::<Vec<f64>>());
    let walk = budget.rate_walk * time.sqrt();
    let limit = OFFSET_GATE * budget.rate_bias.hypot(walk) + SMALL_RATE + CERTAIN * beside / time;
    let [shown, at_most] = [rate, limit].map(|x| x / DEGREE);
    let figure = format!(
        "its integral drifts by {shown:.3} deg/s from the inclinometer, at most {at_most:.3} deg/s"
    );
    let finding = Finding::ok(ZERO, gyro.channel, figure).with("drift", shown, "deg/s");
    (rate.abs() > limit).then(|| {
        finding.fault(format!(
            "subtract {rate:.4} rad/s from it: state that as its offset, of an IMU as rate_offset; stand for a second before the drive, which shows it better"
        ))
    })
}

/// How fast ground can move the links.
struct Ground {
    /// Usual and largest way between readings, over the arm on which a wheel turns its link, rad.
    usual: f64,
    largest: f64,
    /// Angle that an inclinometer shows at an impact at which the robot stops between readings, rad.
    impact: f64,
}

impl Ground {
    /// `None` of a robot that does not drive.
    fn of(log: &Readings<'_>) -> Option<Self> {
        let (recording, robot) = (&log.recording, log.stated.robot);
        let spin = recording.while_driving(&recording.middle_spin);
        // Missing ones do not count.
        let largest = spin.iter().map(|s| s.abs()).fold(0.0, f64::max);
        let turn = robot.geometry.wheel_radius / arm(robot) * recording.slowest;
        Some(Self {
            usual: turn * recording.usual_spin()?,
            largest: turn * largest,
            impact: largest * robot.geometry.wheel_radius / (recording.slowest * robot.gravity),
        })
    }
}

/// The shortest distance on which an axle turns its link, m: to the other axle of the link, or to Q.
fn arm(robot: &Robot) -> f64 {
    let geometry = &robot.geometry;
    let place = |i: usize| geometry.axles[i].x;
    let arm = |i: usize| {
        let other = (0..3).find(|j| *j != i && geometry.carriers[*j] == geometry.carriers[i]);
        (place(i) - other.map_or(geometry.pins.q.x, place)).abs()
    };
    (0..3).map(arm).fold(f64::INFINITY, f64::min)
}

/// The white noise of the angle of pin Q.
fn white(log: &Readings<'_>, channel: &Recorded, ground: &Ground) -> Option<Finding> {
    let values = log.recording.while_driving(&channel.values);
    let of_ground = CORNER * ground.usual;
    let noise = white_noise(&values)?;
    let [shown, stated] = [noise, channel.noise].map(|x| x / DEGREE);
    let figure = format!(
        "{shown:.3} deg, budget {stated:.3} deg and by the ground {:.3} deg",
        of_ground / DEGREE
    );
    let finding = Finding::ok(WHITE, channel.channel, figure).with("noise", shown, "deg");
    if noise <= RATIO * channel.noise + of_ground {
        return Some(finding);
    }
    Some(finding.fault("state the measured noise in the budget, or find its cause"))
}

/// Readings that differ from those before and after by more than noise and ground can explain.
fn spikes(log: &Readings<'_>, channel: &Recorded, ground: &Ground) -> Option<Finding> {
    let recording = &log.recording;
    let (unit, factor) = channel.shown_in();
    // An axle rises as far as the wheel rolls. A link that turns as fast does so for some readings.
    let by_ground = match channel.channel {
        Channel::Encoder(_) | Channel::Torque(_) => return None,
        Channel::Gyro(_) | Channel::BodyRate => 3.0 * ground.largest / recording.slowest,
        Channel::Pin => 2.0 * ground.largest,
        // An impact stops the robot within a reading.
        Channel::Inclinometer(_) | Channel::BodyInclination => 2.0 * ground.largest + ground.impact,
    };
    if by_ground > MOST {
        return None;
    }
    let gate = GATE * channel.noise + by_ground;
    let mut values = channel.values.clone();
    values.retain(|x| x.is_finite());
    if values.len() < LEAST || channel.noise <= 0.0 {
        return None;
    }
    let spike = |w: &[f64]| {
        let size = (w[2] - median(w.to_vec())?).abs();
        let (before, after) = (0.5 * (w[0] + w[1]), 0.5 * (w[3] + w[4]));
        (size > gate && (before - after).abs() < 0.5 * size).then_some(size)
    };
    let found: Vec<f64> = values.windows(5).filter_map(spike).collect();
    let largest = found.iter().copied().fold(0.0, f64::max);
    let share = 100.0 * found.len() as f64 / values.len() as f64;
    let (count, gate) = (found.len(), factor * gate);
    let figure = format!("{count} readings off by more than {gate:.2} {unit}");
    let finding = Finding::ok(SPIKES, channel.channel, figure).with("share", share, "%");
    if found.is_empty() {
        return Some(finding);
    }
    let remedy = format!(
        "up to {:.2} {unit}: a worn wiper, a loose plug, or a lost byte; mend it, or leave these readings out of the log",
        factor * largest
    );
    Some(finding.fault(remedy))
}

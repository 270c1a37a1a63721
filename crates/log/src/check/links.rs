//! Gyroscopes against inclinometers: sign, unit, exchange between the links.
//!
//! Over half a second an inclination changes by the integral of its link's rate, and by the
//! acceleration over g that an inclinometer measures when the robot starts or stops. The
//! coefficient of the first is 1; -1 shows a wrong sign, 57.3 degrees for radians, and a link that
//! follows the other link's gyroscope exchanged channels. That of the second is the scale of the
//! encoders: 1/57.3 if they are in degrees, negative if it is the inclinometer whose sign is wrong.

use crate::check::changes::{Changes, Coefficients, DEGREE, GATE, LEAST_CHANGE, SPAN};
use crate::check::fit::robust_fit;
use crate::check::ground::Signs;
use crate::check::readings::Readings;
use crate::check::report::Finding;
use crate::check::rewire::{Change, Channel, Tested};
use crate::check::signal::{high_pass, rms};
use std::f64::consts::TAU;

/// Share of the changes that the gyroscope must explain.
const EXPLAINED: f64 = 0.6;
/// Error of the slope that is a fault: ten times the scale error of a gyroscope, and more than
/// impacts make.
const SCALE_ERROR: f64 = 0.25;
/// Factor between the encoders' acceleration and that of the inclinometers which is a fault: more
/// than wheels slip that start a robot, less than a mistake in units, edges or gear ratios.
const ACCELERATION_ERROR: f64 = 2.0;

const ACCELERATION: &str = "acceleration";
const SIGN: &str = "sign and unit";
const NOISE: &str = "noise while driving";
/// Half of the time of the mean that is taken from an inclination less the integral of its
/// gyroscope, s: vibration of links and wheels is faster, the errors of both are slower.
const HALF_TIME: f64 = 0.125;

/// What inclinometers show beside the integral of their gyroscopes while the robot drives: noise,
/// accelerations, and vibration of the links. It is no fault, but with a budget that states much
/// less `best` names channels whose wiring is right. Nothing of a log that does not drive.
pub fn noise_while_driving(log: &Readings<'_>) -> Vec<Finding> {
    let half = log.recording.steps(HALF_TIME);
    let of_link = |k: usize| {
        let (_, drift) = log.recording.turned(k);
        let fast = high_pass(&drift, half);
        let error = log.motion.while_driving(log.robot, &fast);
        if !error.iter().any(|x| x.is_finite()) {
            return None;
        }
        let [noise, stated] = [rms(&error), log.budget.inclination_noise].map(|x| x / DEGREE);
        let figure = format!("{noise:.3} deg, budget.inclination_noise {stated:.3} deg");
        let finding = Finding::ok(NOISE, format!("inclinometer {}", k + 1), figure);
        Some(finding.with("noise", noise, "deg"))
    };
    [0, 1].into_iter().filter_map(of_link).collect()
}

/// Units of gyroscopes, inclinometers and encoders that are wrong, and what to change before
/// further tests.
pub fn units(log: &Readings<'_>) -> Tested {
    let changes = Changes::of_links(log);
    let mut all = Tested::default();
    for k in 0..2 {
        let channel = of_link(k);
        let Some(found) = changes.fit(k, k).filter(Coefficients::is_known) else {
            continue;
        };
        let figure = found.figure();
        let is = |value: f64| (found.rate.abs() / value - 1.0).abs() < SCALE_ERROR;
        let (remedy, change) = if is(1.0 / DEGREE) {
            let remedy = "the inclination is in degrees: state unit = \"deg\"";
            (remedy, Change::Factor(Channel::Inclinometer(k), DEGREE))
        } else if is(DEGREE) {
            let remedy = "the rate is in degrees a second: state unit = \"deg/s\"";
            (remedy, Change::Factor(Channel::Gyro(k), DEGREE))
        } else {
            continue;
        };
        let finding = Finding::ok(SIGN, channel, figure).fault(remedy);
        all.add(finding.with("coefficient", found.rate, "-"), [change]);
    }
    all
}

/// Sign of the acceleration that the inclinometers of both links show, over that of the encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    Positive,
    Negative,
    Unknown,
}

/// Scale of all encoders, by the acceleration that the inclinometers measure, and its sign; for
/// right units of the links.
pub fn acceleration(log: &Readings<'_>) -> (Tested, Sign) {
    let channel = "encoders 1 to 3";
    let changes = Changes::of_links(log);
    let fits = [0, 1].map(|k| changes.fit(k, k));
    let (mut sum, mut weight) = (0.0, 0.0);
    for (value, sigma) in fits.iter().flatten().filter_map(|f| f.forward) {
        sum += value.abs() / (sigma * sigma);
        weight += 1.0 / (sigma * sigma);
    }
    let (found, sigma) = (sum / weight, weight.sqrt().recip());
    let mut all = Tested::default();
    if !found.is_finite() || found < GATE * sigma {
        let remedy = "start and stop on even ground within the log";
        let figure = "the inclinometers do not show the acceleration of the wheels";
        let finding = Finding::ok(ACCELERATION, channel, figure).cannot_tell(remedy);
        all.add(finding, None);
        return (all, Sign::Unknown);
    }
    let scale = 1.0 / found;
    let figure = format!(
        "accelerations by the encoders are {scale:.3} times those by the inclinometers ({:.2} to {ACCELERATION_ERROR:.2} is right)",
        1.0 / ACCELERATION_ERROR
    );
    let is_right = |x: f64| (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&x);
    let margin = GATE * sigma;
    let finding = Finding::ok(ACCELERATION, channel, figure).with("scale", scale, "-");
    let within = [found, found + margin, found - margin];
    if within.iter().any(|found| is_right(1.0 / found)) {
        all.add(finding, None);
    } else {
        let (remedy, factor) = encoder_unit(scale);
        let changes = (0..3).map(|i| Change::Factor(Channel::Encoder(i), factor));
        all.add(finding.fault(remedy), changes);
    }
    // A link whose gyroscope and inclinometer disagree has a wrong sign of its own.
    let own = fits
        .iter()
        .flatten()
        .filter(|f| f.rate > -GATE * f.rate_sigma);
    let signs: Vec<f64> = own.map(Coefficients::of_acceleration).collect();
    let sign = match signs[..] {
        [a, b] if a > 0.0 && b > 0.0 => Sign::Positive,
        [a, b] if a < 0.0 && b < 0.0 => Sign::Negative,
        _ => Sign::Unknown,
    };
    (all, sign)
}

/// What to do about encoders whose angles are `scale` times the true ones, and the factor that
/// corrects them.
fn encoder_unit(scale: f64) -> (String, f64) {
    for (unit, name) in [(1.0 / DEGREE, "deg"), (1.0 / TAU, "turns")] {
        if (scale / unit - 1.0).abs() < SCALE_ERROR {
            return (
                format!("the angles are in another unit: state unit = \"{name}\""),
                1.0 / unit,
            );
        }
    }
    let remedy = format!(
        "check unit, counts a turn and gear ratio: angles are {scale:.3} times the true ones"
    );
    (remedy, 1.0 / scale)
}

/// All findings of the links, and what to change. `on_ground`: what the ground that the wheels pass
/// shows of the inclinometers; `body_link`: the link with the body whose readings those of both
/// links are made of.
pub fn findings(log: &Readings<'_>, on_ground: Signs, body_link: Option<usize>) -> Tested {
    let before = Changes::of_links(log);
    if let Some(k) = body_link {
        return of_body(&before, k);
    }
    if let Some(finding) = exchanged(&before, on_ground) {
        let exchange = Change::Exchange(Channel::Gyro(0), Channel::Gyro(1));
        return Tested {
            findings: vec![finding],
            changes: vec![exchange],
        };
    }
    let fits = [0, 1].map(|k| before.fit(k, k));
    let mut all = Tested::default();
    for k in 0..2 {
        let (finding, change) = sign(&before, &fits, k, on_ground);
        all.add(finding, change);
    }
    all
}

/// The sign of the readings of the body alone, by those of its link.
fn of_body(changes: &Changes, k: usize) -> Tested {
    let fits = [0, 1].map(|k| changes.fit(k, k));
    let (mut finding, change) = sign(changes, &fits, k, Signs::Unknown);
    let change = match change {
        Some(Change::Factor(channel, _)) => {
            let reading = match channel {
                Channel::Gyro(_) => "body_rate",
                _ => "body_inclination",
            };
            finding = finding.fault(format!("turn round sign of reading.{reading}"));
            Some(Change::Body(channel))
        }
        other => other,
    };
    let mut all = Tested::default();
    all.add(finding, change);
    all
}

fn of_link(k: usize) -> String {
    format!("{}, {}", Channel::Gyro(k), Channel::Inclinometer(k))
}

fn exchanged(changes: &Changes, on_ground: Signs) -> Option<Finding> {
    let share = |k: usize, j: usize| {
        robust_fit(&changes.inclination[k], &[changes.rate[j].as_slice()]).map(|f| f.explained)
    };
    let own = [share(0, 0)?, share(1, 1)?];
    let other = [share(0, 1)?, share(1, 0)?];
    let moves = |x: &[f64]| rms(x) > LEAST_CHANGE;
    let all_move = changes.inclination.iter().all(|x| moves(x));
    let crossed = (0..2).all(|k| other[k] > EXPLAINED && own[k] < 0.5 * other[k]);
    (all_move && crossed).then(|| {
        let figure = format!(
            "each inclination follows the other link's rate: {:.0} and {:.0} % of its changes, its own {:.0} and {:.0} %",
            100.0 * other[0],
            100.0 * other[1],
            100.0 * own[0],
            100.0 * own[1],
        );
        let remedy = if on_ground == Signs::Equal {
            "exchange gyro 1 and gyro 2: the inclinometers are right, by the ground that the wheels pass"
        } else {
            "exchange gyro 1 and gyro 2, or the inclinometers"
        };
        let channel = format!("{}, {}", of_link(0), of_link(1));
        Finding::ok("links exchanged", channel, figure)
            .fault(remedy)
            .with("own", own[0].min(own[1]), "-")
            .with("other", other[0].min(other[1]), "-")
    })
}

fn sign(
    changes: &Changes,
    fits: &[Option<Coefficients>; 2],
    k: usize,
    on_ground: Signs,
) -> (Finding, Option<Change>) {
    let (inclination, turn) = (rms(&changes.inclination[k]), rms(&changes.rate[k]));
    let Some(found) = fits[k].filter(|f| f.explained > EXPLAINED && turn > LEAST_CHANGE) else {
        let [inclined, turned] = [inclination, turn].map(|angle| angle / DEGREE);
        let figure = format!(
            "changes within {SPAN} s: inclinometer {inclined:.2} deg, gyro {turned:.2} deg RMS"
        );
        let finding = Finding::ok(SIGN, of_link(k), figure)
            .with("inclinometer", inclined, "deg")
            .with("gyro", turned, "deg");
        // Two inclinometers that agree on the ground leave the gyroscope.
        let follows = fits[k].is_some_and(|f| f.explained > EXPLAINED);
        let by_robot = rms(&changes.forward);
        if on_ground == Signs::Equal && !follows && inclination > 2.0 * LEAST_CHANGE.max(by_robot) {
            let remedy = format!(
                "{} is wrong: dead, or a column of something else; {} agrees with the other link on the ground",
                Channel::Gyro(k),
                Channel::Inclinometer(k)
            );
            return (finding.fault(remedy), None);
        }
        // On level ground a start remains.
        if let [Some(own), Some(other)] =
            [fits[k], fits[1 - k]].map(|f| f.map(|f| f.of_acceleration()))
            && own < 0.0
            && other > 0.0
        {
            let wrong = Channel::Inclinometer(k);
            let remedy = format!(
                "{wrong} has the wrong sign: it shows the robot's acceleration the other way round than that of the other link"
            );
            return (finding.fault(remedy), Some(Change::Factor(wrong, -1.0)));
        }
        let remedy = if turn < LEAST_CHANGE {
            "drive over an obstacle that turns the links by a few degrees; if the gyro still does not turn, it is dead"
        } else {
            "one of the two may be dead, of another link, or exposed to shocks: look at both while you turn the link by hand"
        };
        return (finding.cannot_tell(remedy), None);
    };
    let coefficient =
        Finding::ok(SIGN, of_link(k), found.figure()).with("coefficient", found.rate, "-");
    let finding = coefficient.clone().with("explained", found.explained, "-");
    let is = |value: f64| (found.rate / value - 1.0).abs() < SCALE_ERROR;
    // Up to here accelerations change an inclinometer as much: at edges, and of the robot.
    let by_robot = rms(&changes.forward) / turn;
    let may_accelerate = (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&found.rate)
        || (found.rate - 1.0).abs() < SCALE_ERROR + by_robot;
    if is(1.0) {
        (finding, None)
    } else if may_accelerate && !is(-1.0) {
        let remedy = "accelerations change the inclinometer as much as the ground: drive slower";
        (coefficient.cannot_tell(remedy), None)
    } else if !found.is_known() {
        // An inclinometer measures the accelerations of impacts.
        let remedy = if is(-1.0) {
            "it looks as if one of them had the wrong sign: turn the link by hand, or record a drive over smooth ground"
        } else {
            "record a drive over smooth ground"
        };
        (finding.cannot_tell(remedy), None)
    } else if is(-1.0) {
        let (wrong, remedy) = wrong_sign(fits, k, on_ground);
        (finding.fault(remedy), Some(Change::Factor(wrong, -1.0)))
    } else {
        let remedy = "one of them has a wrong scale: check units and ranges";
        (finding.fault(remedy), None)
    }
}

/// Which one of the gyroscope and the inclinometer of link `k` has the wrong sign, and what to do.
fn wrong_sign(fits: &[Option<Coefficients>; 2], k: usize, on_ground: Signs) -> (Channel, String) {
    let other = fits[1 - k].filter(|f| f.rate > 0.0);
    let (gyro, inclinometer) = (Channel::Gyro(k), Channel::Inclinometer(k));
    let acceleration = fits[k].map_or(0.0, |f| f.of_acceleration());
    // Encoders that count backwards show in the other link, too.
    let acceleration = acceleration * other.map_or(1.0, |f| f.of_acceleration());
    let (wrong, why) = if on_ground == Signs::Equal && other.is_some() {
        (
            gyro,
            format!("{inclinometer} agrees with the other link on the ground"),
        )
    } else if on_ground == Signs::Different && other.is_some() {
        let why = "it disagrees with the other link on the ground".to_owned();
        (inclinometer, why)
    } else if acceleration > 0.0 {
        (
            gyro,
            format!("{inclinometer} shows the robot's acceleration with the right sign"),
        )
    } else if acceleration < 0.0 {
        (
            inclinometer,
            "it shows the robot's acceleration with the wrong sign".to_owned(),
        )
    } else {
        let why =
            format!("or {inclinometer}: lifting the front of the link must make both positive");
        (gyro, why)
    };
    let (link, key) = (k + 1, if wrong == gyro { "rate" } else { "inclination" });
    let remedy = format!(
        "{wrong} has the wrong sign ({why}): turn round sign of reading.link{link}_{key}, or the axes of imu.link{link}, in \
         SENSORS.toml"
    );
    (wrong, remedy)
}

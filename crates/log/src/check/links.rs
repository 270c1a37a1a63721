//! Gyroscopes against inclinometers: sign, unit, exchange between the links, delay.
//!
//! Over half a second an inclination changes by the integral of its link's rate, and by the
//! acceleration over g that an inclinometer measures when the robot starts or stops. The
//! coefficient of the first is 1; -1 shows a wrong sign, 57.3 degrees for radians, and a link that
//! follows the other link's gyroscope exchanged channels. That of the second is the scale of the
//! encoders: 1/57.3 if they are in degrees, negative if it is the inclinometer whose sign is wrong.

use crate::check::changes::{
    CERTAIN, Changes, Coefficients, DEGREE, FORWARD, GATE, LEAST_CHANGE, SPAN,
    shown_by_inclinometer, span,
};
use crate::check::ground::{self, Signs};
use crate::check::on_links::ROBOT_FILE;
use crate::check::recording::starts;
use crate::check::rest::has_quiet;
use crate::check::{Change, Channel, Finding, Readings, Recording, Verdict, delay, pin_delay};
use robhaz_estimator::SensorFrame;
use robhaz_model::{Carrier, Units};
use robhaz_score::signals::{Allowed, delay, rms, robust_fit, smooth};
use std::f64::consts::TAU;

/// Share of the changes that the gyroscope must explain.
const EXPLAINED: f64 = 0.6;
/// Longest delay that is looked for, in times over which changes are compared: 0.15 s of 0.5 s.
const LONGEST_DELAY: f64 = 0.3;
/// Delay of an inclinometer that is its own lag, s: a low pass of 8 Hz has 20 ms.
const INCLINOMETER_LAG: f64 = 0.025;
/// Delay of a gyroscope behind the inclinometer that is a fault, s.
const GYRO_DELAY: f64 = 0.005;
/// Error of a delay by accelerations of the robot that the encoders do not show, s.
const MARGIN: f64 = 0.005;
/// Error of the slope that is a fault: ten times the scale error of a gyroscope, and more than
/// impacts make.
const SCALE_ERROR: f64 = 0.25;
/// Factor between the encoders' acceleration and that of the inclinometers which is a fault: more
/// than wheels slip that start a robot, less than a mistake in units, edges or gear ratios.
const ACCELERATION_ERROR: f64 = 2.0;

pub const ACCELERATION: &str = "acceleration";
pub const SIGN: &str = "sign and unit";
/// Units of gyroscopes, inclinometers and encoders that are wrong, and what to change before
/// further tests.
pub fn units(log: &Readings<'_>) -> Vec<Finding> {
    let changes = Changes::of_links(log, span(log));
    let unit = |k: usize| {
        let found = changes.fit(k, k).filter(Coefficients::is_known)?;
        let is = |value: f64| (found.rate.abs() / value - 1.0).abs() < SCALE_ERROR;
        // An inclinometer in another unit shows the robot's acceleration in it, too; a slow robot
        // has none, but the noise of a sensor is in its unit.
        let accelerates_by = |unit: f64| {
            let (value, sigma) = found.forward.unwrap_or((0.0, 0.0));
            // The factor between units is 57.3.
            value.abs() > GATE * sigma && (0.2..5.0).contains(&(value.abs() / unit))
        };
        let [gyro, inclinometer] = changes.channels[k];
        let quiet = |channel: Channel| has_quiet(&log.findings, &channel.to_string());
        let is_of_inclinometer = accelerates_by(found.rate.abs()) || quiet(inclinometer);
        let is_of_gyro = accelerates_by(1.0) || quiet(gyro);
        let (remedy, wrong, factor) = if is(1.0 / DEGREE) && is_of_gyro {
            let remedy = "the rate is converted from deg/s twice: state unit = \"rad/s\"";
            (remedy, gyro, 1.0 / DEGREE)
        } else if is(1.0 / DEGREE) {
            let remedy = "the inclination is in degrees: state unit = \"deg\"";
            (remedy, inclinometer, DEGREE)
        } else if is(DEGREE) && is_of_inclinometer {
            let remedy = "the inclination is converted from degrees twice: state unit = \"rad\"";
            (remedy, inclinometer, 1.0 / DEGREE)
        } else if is(DEGREE) {
            let remedy = "the rate is in degrees a second: state unit = \"deg/s\"";
            (remedy, gyro, DEGREE)
        } else {
            return None;
        };
        let finding = Finding::ok(SIGN, both(changes.channels[k]), found.figure()).fault(remedy);
        let finding = finding.change([Change::Factor(wrong, factor)]);
        Some(finding.with("coefficient", found.rate, "-"))
    };
    let links = if log.stated.body.is_some() { 1 } else { 2 };
    (0..links).filter_map(unit).collect()
}

/// Scale of all encoders, by the acceleration that the inclinometers measure, and 1 or -1, the sign
/// of what both links show over that of the encoders, or 0 where it is not known; for right units
/// of the links.
pub fn acceleration(log: &Readings<'_>) -> (Finding, f64) {
    let channel = "encoders 1 to 3";
    let changes = Changes::of_links(log, SPAN);
    let fits = [0, 1].map(|k| changes.fit(k, k));
    let (mut sum, mut weight) = (0.0, 0.0);
    for (value, sigma) in fits.iter().flatten().filter_map(|f| f.forward) {
        sum += value.abs() / (sigma * sigma);
        weight += 1.0 / (sigma * sigma);
    }
    let (found, sigma) = (sum / weight, weight.sqrt().recip());
    if !found.is_finite() || found < GATE * sigma {
        let remedy = "start and stop on even ground within the log";
        let figure = "the inclinometers do not show the acceleration of the wheels";
        let finding = Finding::ok(ACCELERATION, channel, figure).cannot_tell(remedy);
        return (finding, 0.0);
    }
    let scale = 1.0 / found;
    let figure = format!(
        "accelerations by the encoders are {scale:.3} times those by the inclinometers ({:.2} to {ACCELERATION_ERROR:.2} is right)",
        1.0 / ACCELERATION_ERROR
    );
    let is_right = |x: f64| (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&x);
    let margin = GATE * sigma;
    let mut finding = Finding::ok(ACCELERATION, channel, figure).with("scale", scale, "-");
    let within = [found, found + margin, found - margin];
    if !within.iter().any(|found| is_right(1.0 / found)) {
        let (remedy, factor) = encoder_unit(scale, log.stated.robot.gravity);
        let changes = (0..3).map(|i| Change::Factor(Channel::Encoder(i), factor));
        finding = finding.fault(remedy).change(changes);
    }
    // A link whose gyroscope and inclinometer disagree has a wrong sign of its own.
    let agrees = |f: &Coefficients| f.rate > -GATE * f.rate_sigma;
    let own = fits.map(|f| f.filter(agrees).map_or(0.0, |f| f.of_acceleration()));
    (finding, if own[0] * own[1] > 0.0 { own[0] } else { 0.0 })
}

/// The finding of accelerations whose fault is none of the encoders, as the ground shows their distance: a wrong gravity.
pub fn gravity(acceleration: &Finding, log: &Readings<'_>) -> Option<Finding> {
    let scale = acceleration.number("scale")?;
    let is_distance = |f: &Finding| f.verdict == Verdict::Ok && f.number("scale").is_some();
    let gravity = log.stated.robot.gravity;
    let may_be = acceleration.is_fault() && is_of_a_place(scale * gravity);
    (may_be && is_distance(&ground::distance(log))).then(|| {
        let figure = format!(
            "{}; but their distance is that of the ground",
            acceleration.figure
        );
        Finding::ok(ACCELERATION, ROBOT_FILE, figure)
            .with("scale", scale, "-")
            .fault(format!(
                "the inclinometers show accelerations over the gravity of where they are: `gravity` of the robot file is {gravity:.2} m/s^2, and {:.2} would fit",
                scale * gravity
            ))
    })
}

/// Whether this is the gravity (m/s^2) of a place where rovers drive: the Moon has 1.6, the Earth up to 9.83.
fn is_of_a_place(gravity: f64) -> bool {
    (1.0..12.0).contains(&gravity)
}

/// What to do about encoders whose angles are `scale` times the true ones, and the factor that
/// corrects them.
fn encoder_unit(scale: f64, gravity: f64) -> (String, f64) {
    for (unit, name) in [(1.0 / DEGREE, "deg"), (1.0 / TAU, "turns")] {
        if (scale / unit - 1.0).abs() < SCALE_ERROR {
            let remedy = format!("the angles are in another unit: state unit = \"{name}\"");
            return (remedy, 1.0 / unit);
        }
    }
    let mut remedy = format!(
        "check unit, counts a turn and gear ratio: angles are {scale:.3} times the true ones"
    );
    if is_of_a_place(scale * gravity) {
        let fits = scale * gravity;
        remedy += &format!("; or `gravity` of the robot file: {fits:.2} m/s^2 would fit");
    } else if scale > 1.0 {
        remedy += "; or the inclinometers take out accelerations: budget.inclination_measures = \"gravity\"";
    }
    (remedy, 1.0 / scale)
}

/// All findings of the links. `on_ground`: what the ground that the wheels pass shows of the
/// inclinometers.
pub fn findings(log: &Readings<'_>, on_ground: Signs) -> Vec<Finding> {
    let changes = Changes::of_links(log, span(log));
    let fits = [0, 1].map(|k| changes.fit(k, k));
    let of_link = |k: usize, on_ground: Signs| Link {
        changes: &changes,
        k,
        own: fits[k],
        other: fits[1 - k],
        on_ground,
    };
    if log.stated.body.is_some() {
        return vec![of_link(0, Signs::Unknown).sign()];
    }
    match exchanged(&changes, on_ground) {
        Some(finding) => vec![finding],
        None => [0, 1].map(|k| of_link(k, on_ground).sign()).into(),
    }
}

/// What is known of gyroscope and inclinometer of link `k`.
struct Link<'a> {
    changes: &'a Changes,
    k: usize,
    /// How each of both links' inclinometer follows its gyroscope.
    own: Option<Coefficients>,
    other: Option<Coefficients>,
    /// What the ground shows of both inclinometers.
    on_ground: Signs,
}

/// The names of a gyroscope and its inclinometer.
fn both([gyro, inclinometer]: [Channel; 2]) -> String {
    format!("{gyro}, {inclinometer}")
}

fn exchanged(changes: &Changes, on_ground: Signs) -> Option<Finding> {
    let share = |k: usize, j: usize| {
        robust_fit(&changes.inclination[k], &[&changes.rate[j]]).map(|f| f.explained)
    };
    let own = [share(0, 0)?, share(1, 1)?];
    let other = [share(0, 1)?, share(1, 0)?];
    let moves = |x: &[f64]| rms(x) > LEAST_CHANGE;
    let all_move = changes.inclination.iter().all(|x| moves(x));
    let crossed = (0..2).all(|k| other[k] > EXPLAINED && own[k] < 0.5 * other[k]);
    (all_move && crossed).then(|| {
        let shares = |x: [f64; 2]| format!("{:.0} and {:.0} %", 100.0 * x[0], 100.0 * x[1]);
        let (by_other, by_own) = (shares(other), shares(own));
        let figure = format!(
            "each inclination follows the other link's rate: {by_other} of its changes, its own {by_own}"
        );
        let remedy = if on_ground == Signs::Equal {
            "exchange gyro 1 and gyro 2: the inclinometers are right, by the ground that the wheels pass"
        } else {
            "exchange gyro 1 and gyro 2, or the inclinometers"
        };
        let channel = changes.channels.map(both).join(", ");
        Finding::ok("links exchanged", channel, figure)
            .fault(remedy)
            .change([Change::Exchange(Channel::Gyro(0), Channel::Gyro(1))])
            .with("own", own[0].min(own[1]), "-")
            .with("other", other[0].min(other[1]), "-")
    })
}

impl Link<'_> {
    /// Their sign and scale.
    fn sign(&self) -> Finding {
        let (changes, k) = (self.changes, self.k);
        let turn = rms(&changes.rate[k]);
        let channels = changes.channels[k];
        let follows = |f: &Coefficients| f.explained > EXPLAINED && turn > LEAST_CHANGE;
        let Some(found) = self.own.filter(follows) else {
            return self.unlike();
        };
        let coefficient =
            Finding::ok(SIGN, both(channels), found.figure()).with("coefficient", found.rate, "-");
        let finding = coefficient.clone().with("explained", found.explained, "-");
        let is = |value: f64| (found.rate / value - 1.0).abs() < SCALE_ERROR;
        // Up to here accelerations change an inclinometer as much: at edges, and of the robot.
        let by_robot = rms(&changes.forward) / turn;
        let may_accelerate = (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&found.rate)
            || (found.rate - 1.0).abs() < SCALE_ERROR + by_robot;
        if is(1.0) {
            finding
        } else if may_accelerate && !is(-1.0) {
            let remedy =
                "accelerations change the inclinometer as much as the ground: drive slower";
            coefficient.cannot_tell(remedy)
        } else if !found.is_known() {
            // An inclinometer measures the accelerations of impacts.
            let remedy = if is(-1.0) {
                "it looks as if one of them had the wrong sign: turn the link by hand, or record a drive over smooth ground"
            } else {
                "record a drive over smooth ground"
            };
            finding.cannot_tell(remedy)
        } else if is(-1.0) {
            let (wrong, remedy) = self.wrong_sign();
            finding.fault(remedy).change([Change::Factor(wrong, -1.0)])
        } else {
            finding.fault("one of them has a wrong scale: check units and ranges")
        }
    }

    /// The finding of a link whose inclinometer does not follow its gyroscope, or which hardly turns.
    fn unlike(&self) -> Finding {
        let (changes, k) = (self.changes, self.k);
        let (inclination, turn) = (rms(&changes.inclination[k]), rms(&changes.rate[k]));
        let channels @ [gyro, inclinometer] = changes.channels[k];
        let [inclined, turned] = [inclination, turn].map(|angle| angle / DEGREE);
        let figure = format!(
            "changes within {:.1} s: inclinometer {inclined:.2} deg, gyro {turned:.2} deg RMS",
            changes.span
        );
        let finding = Finding::ok(SIGN, both(channels), figure)
            .with("inclinometer", inclined, "deg")
            .with("gyro", turned, "deg");
        // Two inclinometers that agree on the ground leave the gyroscope.
        let follows = self.own.is_some_and(|f| f.explained > EXPLAINED);
        let other = LEAST_CHANGE.max(rms(&changes.forward)).hypot(changes.noise);
        if self.on_ground == Signs::Equal && !follows && inclination > 2.0 * other {
            return finding.fault(format!(
            "{gyro} is wrong: dead, or a column of something else; {inclinometer} agrees with the other link on the ground"
        ));
        }
        // On level ground a start remains.
        let [own, other] = [self.own, self.other].map(|f| f.map_or(0.0, |f| f.of_acceleration()));
        if own < 0.0 && other > 0.0 {
            let remedy = format!(
                "{inclinometer} has the wrong sign: it shows the robot's acceleration the other way round than that of the other link"
            );
            return finding
                .fault(remedy)
                .change([Change::Factor(inclinometer, -1.0)]);
        }
        finding.cannot_tell(match turn < LEAST_CHANGE {
        true => "drive over an obstacle that turns the links by a few degrees; if the gyro still does not turn, it is dead",
        false => "one of the two may be dead, of another link, or exposed to shocks: look at both while you turn the link by hand",
    })
    }

    /// Which one of them has the wrong sign, and what to do.
    fn wrong_sign(&self) -> (Channel, String) {
        let [gyro, inclinometer] = self.changes.channels[self.k];
        let other = self.other.filter(|f| f.rate > 0.0);
        let acceleration = self.own.map_or(0.0, |f| f.of_acceleration());
        // Encoders that count backwards show in the other link, too.
        let acceleration = acceleration * other.map_or(1.0, |f| f.of_acceleration());
        let on_ground = other.map_or(Signs::Unknown, |_| self.on_ground);
        let (wrong, why) = match on_ground {
            Signs::Equal => (
                gyro,
                format!("{inclinometer} agrees with the other link on the ground"),
            ),
            Signs::Different => (
                inclinometer,
                "it disagrees with the other link on the ground".to_owned(),
            ),
            _ if acceleration > 0.0 => (
                gyro,
                format!("{inclinometer} shows the robot's acceleration with the right sign"),
            ),
            _ if acceleration < 0.0 => (
                inclinometer,
                "it shows the robot's acceleration with the wrong sign".to_owned(),
            ),
            _ => (
                gyro,
                format!("or {inclinometer}: lifting the front of the link must make both positive"),
            ),
        };
        let (reading, link) = (wrong.reading(), self.k + 1);
        if wrong != wrong.in_frames() {
            return (wrong, format!("turn round sign of reading.{reading}"));
        }
        let remedy = format!(
            "{wrong} has the wrong sign ({why}): turn round sign of reading.{reading}, or the axes of imu.link{link}, in SENSORS.toml"
        );
        (wrong, remedy)
    }
}

/// Delays between the gyroscope and the inclinometer of each link, or of the body, for right signs
/// and units.
pub fn delays(log: &Readings<'_>) -> Vec<Finding> {
    let acceleration = (log.stated.settings.budget.specific_force).then(|| specific_force(log));
    let mut changes = Changes::of(log, span(log), acceleration.as_deref(), &[]);
    leave_out_starts(&mut changes, &log.recording);
    if log.stated.body.is_some() {
        let of_imu = delay_of(log, &changes, 0);
        let of_pin = pin_delay::finding(log, 2.0 * LONGEST_DELAY * changes.span);
        return [of_imu].into_iter().chain(of_pin).collect();
    }
    // A rate that is made of the angle of a joint follows it as its filter does.
    let of_link = |frame: &SensorFrame, k: usize| [frame.link1, frame.link2][k].rate_error;
    let is_read = |k: &usize| log.frames.iter().all(|frame| of_link(frame, *k) <= 0.0);
    let of_link = |k: usize| {
        let finding = delay_of(log, &changes, k);
        let [delay, sigma] = ["delay", "deviation"].map(|name| finding.number(name).unwrap_or(0.0));
        // A turn makes a gyroscope look late, and no inclinometer.
        let is_certain = delay > 0.0 || delay < -CERTAIN_BESIDE * sigma;
        finding.unless(
            log.has_other_side() && !is_certain,
            "the robot turns on ground that is inclined across, which shows in the gyroscopes of links: record a drive straight on",
        )
    };
    [0, 1].into_iter().filter(is_read).map(of_link).collect()
}

/// Leaves out the changes while the robot starts or stops: what is left of its acceleration there looks like a delay on
/// long slopes, where the links hardly turn.
fn leave_out_starts(changes: &mut Changes, recording: &Recording) {
    let usual = recording.usual_spin().unwrap_or(0.0);
    let half = recording.steps(0.5 * changes.span);
    let starts = starts(&recording.middle_spin, usual, half);
    for inclination in &mut changes.inclination {
        for (x, _) in inclination.iter_mut().zip(&starts).filter(|(_, is)| **is) {
            *x = f64::NAN;
        }
    }
}

/// Deviations of a delay of a gyroscope of one side of two: turns disturb it.
const CERTAIN_BESIDE: f64 = 5.0;

/// Part of the inclinations that is the acceleration of the robot, rad, for inclinometers that
/// measure the specific force: that of Q. 0 near the ends of the log, where it is not known.
fn specific_force(log: &Readings<'_>) -> Vec<f64> {
    let speed = speed_of_q(log, log.recording.steps(0.5 * FORWARD));
    shown_by_inclinometer(log, &speed, 1.0)
}

/// Horizontal speed of Q, m/s, averaged over `2 width` samples: the link with two wheels rolls
/// along its own direction, with the absolute spin of its wheels, and turns Q about the middle of
/// its axles.
fn speed_of_q(log: &Readings<'_>, width: usize) -> Vec<f64> {
    let (recording, geometry) = (&log.recording, &log.stated.robot.geometry);
    let carriers = geometry.carriers.map(Carrier::index);
    let link = usize::from(carriers.iter().sum::<usize>() > 1);
    let of_link = [&recording.inclination[link], &recording.rate[link]];
    let [inclination, rate] = of_link.map(|x| smooth(x, width));
    let on_link: Vec<usize> = (0..3).filter(|i| carriers[*i] == link).collect();
    let height = on_link.iter().map(|i| geometry.axles[*i].y).sum::<f64>() / 2.0;
    let (radius, arm) = (geometry.wheel_radius, geometry.pins.q.y - height);
    let speed = |k: usize| {
        // A wheel of the other link turns against another rate. Where one of the two is missing, it serves as well.
        let spin = on_link.iter().map(|i| recording.spin[*i][k]).sum::<f64>() / 2.0;
        let spin = if spin.is_finite() {
            spin
        } else {
            recording.middle_spin[k]
        };
        (radius * (spin - rate[k]) - arm * rate[k]) * inclination[k].cos()
    };
    (0..rate.len()).map(speed).collect()
}

/// Slip speed at T = N of wheels that creep much, m/s, of a robot of the size of robot A: the estimators' prior, 30 mm/s
/// within a factor of 2.2, by two deviations.
const CREEP: f64 = 0.15;

/// Rate of a link that hardly turns, in standard deviations of a gyroscope's noise.
const HARDLY: f64 = 10.0;

fn delay_of(log: &Readings<'_>, changes: &Changes, k: usize) -> Finding {
    let recording = &log.recording;
    let [gyro, inclinometer] = changes.channels[k];
    let channel = format!("{inclinometer} after {gyro}");
    let (inclination, rate) = (&changes.inclination[k], &changes.rate[k]);
    // Wheels creep in proportion to the slope: while the link turns, the robot accelerates in proportion to the rate, which
    // the inclinometer shows.
    let robot = log.stated.robot;
    let of_creep = CREEP * Units::of(robot).speed() / robot.gravity;
    let errors = (of_creep * rms(rate) / rms(inclination)).powi(2);
    let allowed = Allowed {
        early: GYRO_DELAY + MARGIN + 0.5 * recording.slowest,
        late: INCLINOMETER_LAG + MARGIN + 0.5 * recording.slowest,
        explained: CERTAIN,
        errors: if errors.is_finite() { errors } else { 0.0 },
    };
    let [longest, memory] = [LONGEST_DELAY, 1.0].map(|part| recording.steps(part * changes.span));
    // All samples: those that fit best without a delay would hide it.
    let found = match rms(rate) > LEAST_CHANGE {
        true => delay(inclination, &[rate], longest, memory, recording.dt, allowed),
        false => None,
    };
    let found = found.filter(|delay| delay.explained > EXPLAINED);
    let unknown = [
        "no common motion",
        "drive over an obstacle that turns the links by a few degrees",
    ];
    let whose = ["its", "the gyro's"];
    let finding = delay::finding(&channel, found, &allowed, unknown, whose, |late, offset| {
        format!(
            "{late} readings arrive late: state offset = {offset:.4} of its channel, or read it directly"
        )
    });
    // Where a link hardly turns, accelerations and lags of other sensors look like a delay, which costs
    // nothing there.
    let turning = rms(&recording.while_driving(&recording.rate[k]));
    let costs = found.map_or(0.0, |delay| delay.seconds.abs() * turning);
    let budget = &log.stated.settings.budget;
    let is_less = turning < HARDLY * budget.rate_noise && costs < budget.inclination_noise;
    if finding.is_fault() && is_less {
        let remedy = "drive faster: at this speed it is less than the inclinometer's noise";
        return finding.cannot_tell(remedy);
    }
    finding
}

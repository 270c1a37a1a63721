//! Gyroscopes against inclinometers: sign, unit, exchange between the links, delay.
//!
//! Over half a second an inclination changes by the integral of its link's rate, and by the acceleration over g that an
//! inclinometer measures when the robot starts or stops. The coefficient of the first is 1; -1 shows a wrong sign, 57.3 degrees
//! for radians, and a link that follows the other link's gyroscope exchanged channels. That of the second is the scale of
//! the encoders: 1/57.3 if they are in degrees, negative if it is the inclinometer whose sign is wrong.

use crate::check::delay::{Allowed, Delay, delay};
use crate::check::fit::robust_fit;
use crate::check::ground::Signs;
use crate::check::motion::Motion;
use crate::check::recording::Recording;
use crate::check::report::{Finding, Verdict};
use crate::check::rewire::{Change, Channel, Tested};
use crate::check::signal::{derivative, difference, integral, rms, smooth, zip};
use robhaz_estimator::NoiseBudget;
use robhaz_model::{Carrier, GRAVITY, Robot};
use std::f64::consts::TAU;

/// Time over which changes are compared, s: the specific force of the robot's own motion changes less in it than the
/// angles on uneven ground.
const SPAN: f64 = 0.5;
/// Time over which both are averaged, s.
const SMOOTHING: f64 = 0.02;
/// Time over which the robot's acceleration is averaged, s.
const FORWARD: f64 = 0.1;
/// Change of an angle within [`SPAN`] that shows something, rad: 0.3 deg, several times the noise of a smoothed inclinometer.
const LEAST_CHANGE: f64 = 0.3 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Share of the changes that the gyroscope must explain.
const EXPLAINED: f64 = 0.6;
/// Share from which on a wrong scale is no matter of impacts.
const CERTAIN: f64 = 0.95;
/// Error of the slope that is a fault: ten times the scale error of a gyroscope, and more than impacts make.
const SCALE_ERROR: f64 = 0.25;
/// Longest delay that is looked for, s.
const LONGEST_DELAY: f64 = 0.15;
/// Delay of an inclinometer that is its own lag, s: a low pass of 8 Hz has 20 ms.
const INCLINOMETER_LAG: f64 = 0.025;
/// Delay of a gyroscope behind the inclinometer that is a fault, s.
const GYRO_DELAY: f64 = 0.005;
/// Error of a delay by accelerations of the robot that the encoders do not show, s.
const MARGIN: f64 = 0.005;

/// Factor between the encoders' acceleration and that of the inclinometers which is a fault: more than wheels slip that start
/// a robot, less than a mistake in units, edges or gear ratios.
const ACCELERATION_ERROR: f64 = 2.0;
/// Deviations of a coefficient that tell its sign, or that it is not 1.
const GATE: f64 = 5.0;

const ACCELERATION: &str = "acceleration";
const SIGN: &str = "sign and unit";
const DELAY: &str = "delay";

/// Changes of one angle of each link within [`SPAN`].
struct Changes {
    /// Of the inclinometers, rad.
    inclination: [Vec<f64>; 2],
    /// Of the integrated gyroscopes, rad.
    rate: [Vec<f64>; 2],
    /// Of the angle that the encoders' acceleration makes an inclinometer show, rad; none of inclinometers without it.
    forward: Vec<f64>,
}

/// Coefficients of the changes of an inclination.
#[derive(Clone, Copy)]
struct Coefficients {
    /// Of the integrated rate.
    rate: f64,
    rate_sigma: f64,
    /// Of the acceleration, with its deviation; `None` of inclinometers that do not measure it.
    forward: Option<(f64, f64)>,
    explained: f64,
}

impl Changes {
    /// The changes of a recording, `felt` (rad) by the inclinometers in addition to the angles: left out.
    fn of(recording: &Recording, felt: Option<&[f64]>, forward: &[f64]) -> Self {
        let half = recording.steps(0.5 * SPAN);
        let change = |x: &[f64]| difference(&smooth(x, recording.steps(0.5 * SMOOTHING)), half);
        let inclination = |k: usize| {
            let read = &recording.inclination[k];
            felt.map_or_else(|| read.clone(), |felt| zip(read, felt, |x, felt| x - felt))
        };
        Self {
            inclination: [0, 1].map(|k| change(&inclination(k))),
            rate: [0, 1].map(|k| change(&integral(&recording.rate[k], recording.dt))),
            forward: change(forward),
        }
    }

    /// How inclination `k` follows the gyroscope of link `j` and the acceleration.
    fn fit(&self, recording: &Recording, k: usize, j: usize) -> Option<Coefficients> {
        let (y, rate) = (&self.inclination[k], self.rate[j].as_slice());
        // Residuals are correlated over the span.
        #[expect(
            clippy::cast_precision_loss,
            reason = "the number of steps of half a second"
        )]
        let correlated = (recording.steps(SPAN) as f64).sqrt();
        if let Some(fit) = robust_fit(y, &[rate, self.forward.as_slice()]) {
            let [of_rate, of_forward] = fit.coefficients;
            let [rate_sigma, sigma] = fit.deviations.map(|d| d * correlated);
            return Some(Coefficients {
                rate: of_rate,
                rate_sigma,
                forward: Some((of_forward, sigma)),
                explained: fit.explained,
            });
        }
        let fit = robust_fit(y, &[rate])?;
        Some(Coefficients {
            rate: fit.coefficients[0],
            rate_sigma: correlated * fit.deviations[0],
            forward: None,
            explained: fit.explained,
        })
    }
}

/// Angle that an inclinometer shows more when wheels accelerate the robot as the encoders say, rad; 0 near the ends of the
/// log, where it is not known. Of the encoders alone, so that no other channel can spoil it.
fn forward(recording: &Recording, motion: &Motion, robot: &Robot) -> Vec<f64> {
    let width = recording.steps(0.5 * FORWARD);
    let lever = robot.geometry.wheel_radius / GRAVITY;
    let acceleration = derivative(&motion.middle_spin, width, recording.dt);
    let angle = |a: &f64| if a.is_finite() { lever * a } else { 0.0 };
    acceleration.iter().map(angle).collect()
}

/// What inclinometers that measure the specific force feel of the robot's acceleration, rad: that of Q. 0 near the ends of
/// the log, where it is not known.
fn felt(recording: &Recording, motion: &Motion, robot: &Robot) -> Vec<f64> {
    let width = recording.steps(0.5 * FORWARD);
    let speed = speed_of_q(recording, motion, robot, width);
    let mut felt = derivative(&speed, width, recording.dt);
    for value in &mut felt {
        *value = if value.is_finite() {
            *value / GRAVITY
        } else {
            0.0
        };
    }
    felt
}

/// Horizontal speed of Q, m/s, averaged over `2 width` samples: the link with two wheels rolls along its own direction, with
/// the absolute spin of its wheels, and turns Q about the middle of its axles.
fn speed_of_q(recording: &Recording, motion: &Motion, robot: &Robot, width: usize) -> Vec<f64> {
    let geometry = &robot.geometry;
    let carriers = geometry.carriers.map(Carrier::index);
    let link = usize::from(carriers.iter().sum::<usize>() > 1);
    let (tilt, rate) = (
        smooth(&recording.inclination[link], width),
        smooth(&recording.rate[link], width),
    );
    let on_link = (0..3).filter(|i| carriers[*i] == link);
    let height = on_link.map(|i| geometry.axles[i].y).sum::<f64>() / 2.0;
    let (radius, arm) = (geometry.wheel_radius, geometry.pins.q.y - height);
    let spins = motion.middle_spin.iter();
    spins
        .zip(tilt.iter().zip(&rate))
        .map(|(spin, (tilt, rate))| (radius * (spin - rate) - arm * rate) * tilt.cos())
        .collect()
}

/// What the changes of the inclinations are fitted to.
fn changes(recording: &Recording, motion: &Motion, robot: &Robot, budget: &NoiseBudget) -> Changes {
    let forward = match budget.specific_force {
        true => forward(recording, motion, robot),
        false => Vec::new(),
    };
    Changes::of(recording, None, &forward)
}

/// Units of gyroscopes, inclinometers and encoders that are wrong, and what to change before further tests.
pub fn units(
    recording: &Recording,
    motion: &Motion,
    robot: &Robot,
    budget: &NoiseBudget,
) -> Tested {
    let changes = changes(recording, motion, robot, budget);
    let mut all = Tested::default();
    for k in 0..2 {
        let channel = of_link(k);
        let Some(found) = changes.fit(recording, k, k).filter(Coefficients::is_known) else {
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
        let finding = Finding::fault(SIGN, channel, figure, remedy);
        all.findings
            .push(finding.with("coefficient", found.rate, "-"));
        all.changes.push(change);
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

/// Scale of all encoders, by the acceleration that the inclinometers measure, and its sign; for right units of the links.
pub fn acceleration(
    recording: &Recording,
    motion: &Motion,
    robot: &Robot,
    budget: &NoiseBudget,
) -> (Tested, Sign) {
    let channel = "encoders 1 to 3";
    let changes = changes(recording, motion, robot, budget);
    let fits = [0, 1].map(|k| changes.fit(recording, k, k));
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
        all.findings
            .push(Finding::cannot_tell(ACCELERATION, channel, figure, remedy));
        return (all, Sign::Unknown);
    }
    let scale = 1.0 / found;
    let figure = format!(
        "accelerations by the encoders are {scale:.3} times those by the inclinometers ({:.2} to {ACCELERATION_ERROR:.2} is right)",
        1.0 / ACCELERATION_ERROR
    );
    let is_right = |x: f64| (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&x);
    let margin = GATE * sigma;
    let finding = if is_right(scale)
        || is_right(1.0 / (found + margin))
        || is_right(1.0 / (found - margin))
    {
        Finding::ok(ACCELERATION, channel, figure)
    } else {
        let (remedy, factor) = encoder_unit(scale);
        all.changes
            .extend((0..3).map(|i| Change::Factor(Channel::Encoder(i), factor)));
        Finding::fault(ACCELERATION, channel, figure, remedy)
    };
    all.findings.push(finding.with("scale", scale, "-"));
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

/// What to do about encoders whose angles are `scale` times the true ones, and the factor that corrects them.
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

/// All findings of the links, and what to change. `on_ground`: what the ground that the wheels pass shows of the inclinometers.
pub fn findings(
    recording: &Recording,
    motion: &Motion,
    robot: &Robot,
    budget: &NoiseBudget,
    on_ground: Signs,
) -> Tested {
    let before = changes(recording, motion, robot, budget);
    if let Some(finding) = exchanged(&before, on_ground) {
        let exchange = Change::Exchange(Channel::Gyro(0), Channel::Gyro(1));
        return Tested {
            findings: vec![finding],
            changes: vec![exchange],
        };
    }
    let fits = [0, 1].map(|k| before.fit(recording, k, k));
    let mut all = Tested::default();
    for k in 0..2 {
        let (finding, change) = sign(&before, &fits, k, on_ground);
        all.findings.push(finding);
        all.changes.extend(change);
    }
    // With wrong signs or units a delay has no meaning.
    if all.findings.iter().any(|f| f.verdict == Verdict::Fault) {
        return all;
    }
    let felt = budget
        .specific_force
        .then(|| felt(recording, motion, robot));
    let changes = Changes::of(recording, felt.as_deref(), &[]);
    all.findings
        .extend((0..2).map(|k| delay_of(recording, &changes, k)));
    all
}

fn of_link(k: usize) -> String {
    format!("{}, {}", Channel::Gyro(k), Channel::Inclinometer(k))
}

impl Coefficients {
    /// Whether the coefficient of the rate is known to a tenth of itself.
    fn is_known(&self) -> bool {
        self.explained > CERTAIN && self.rate_sigma < 0.1 * self.rate.abs()
    }

    fn figure(&self) -> String {
        format!(
            "inclinometer over integrated gyro {:.3} (1 is right), {:.0} % explained",
            self.rate,
            100.0 * self.explained
        )
    }

    /// Sign of the coefficient of the acceleration: that of the inclinometer. 0 where it is not known.
    fn of_acceleration(&self) -> f64 {
        let known = self
            .forward
            .filter(|(value, sigma)| value.abs() > GATE * sigma);
        known.map_or(0.0, |(value, _)| value.signum())
    }
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
        Finding::fault("links exchanged", channel, figure, remedy)
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
    let channel = of_link(k);
    let (tilt, turn) = (rms(&changes.inclination[k]), rms(&changes.rate[k]));
    let degrees = |angle: f64| angle / DEGREE;
    let sizes = format!(
        "changes within {SPAN} s: inclinometer {:.2} deg, gyro {:.2} deg RMS",
        degrees(tilt),
        degrees(turn)
    );
    let of_sizes = |finding: Finding| {
        let finding = finding.with("inclinometer", degrees(tilt), "deg");
        (finding.with("gyro", degrees(turn), "deg"), None)
    };
    let Some(found) = fits[k].filter(|f| f.explained > EXPLAINED && turn > LEAST_CHANGE) else {
        // Two inclinometers that agree on the ground leave the gyroscope.
        let follows = fits[k].is_some_and(|f| f.explained > EXPLAINED);
        let by_robot = rms(&changes.forward);
        if on_ground == Signs::Equal && !follows && tilt > 2.0 * LEAST_CHANGE.max(by_robot) {
            let remedy = format!(
                "{} is wrong: dead, or a column of something else; {} agrees with the other link on the ground",
                Channel::Gyro(k),
                Channel::Inclinometer(k)
            );
            return of_sizes(Finding::fault(SIGN, channel, sizes, remedy));
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
            let (finding, _) = of_sizes(Finding::fault(SIGN, channel, sizes, remedy));
            return (finding, Some(Change::Factor(wrong, -1.0)));
        }
        let remedy = if turn < LEAST_CHANGE {
            "drive over an obstacle that turns the links by a few degrees; if the gyro still does not turn, it is dead"
        } else {
            "one of the two may be dead, of another link, or exposed to shocks: look at both while you turn the link by hand"
        };
        return of_sizes(Finding::cannot_tell(SIGN, channel, sizes, remedy));
    };
    let finding = |remedy: Option<String>| {
        let finding = match remedy {
            None => Finding::ok(SIGN, channel.clone(), found.figure()),
            // An inclinometer measures the accelerations of impacts.
            Some(_) if !found.is_known() => {
                let remedy = "record a drive over smooth ground";
                Finding::cannot_tell(SIGN, channel.clone(), found.figure(), remedy)
            }
            Some(remedy) => Finding::fault(SIGN, channel.clone(), found.figure(), remedy),
        };
        let finding = finding.with("coefficient", found.rate, "-");
        finding.with("explained", found.explained, "-")
    };
    let is = |value: f64| (found.rate / value - 1.0).abs() < SCALE_ERROR;
    if is(1.0) {
        return (finding(None), None);
    }
    if !is(-1.0) {
        // Up to here accelerations change an inclinometer as much: at edges, and of the robot.
        let by_robot = rms(&changes.forward) / turn;
        if (1.0 / ACCELERATION_ERROR..ACCELERATION_ERROR).contains(&found.rate)
            || (found.rate - 1.0).abs() < SCALE_ERROR + by_robot
        {
            let remedy =
                "accelerations change the inclinometer as much as the ground: drive slower";
            let finding = Finding::cannot_tell(SIGN, channel.clone(), found.figure(), remedy);
            return (finding.with("coefficient", found.rate, "-"), None);
        }
        let remedy = "one of them has a wrong scale: check units and ranges";
        return (finding(Some(remedy.to_owned())), None);
    }
    let (wrong, remedy) = wrong_sign(fits, k, on_ground);
    let finding = finding(Some(remedy));
    let is_fault = finding.verdict == Verdict::Fault;
    (finding, is_fault.then_some(Change::Factor(wrong, -1.0)))
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

fn delay_of(recording: &Recording, changes: &Changes, k: usize) -> Finding {
    let channel = format!("inclinometer {} after gyro {}", k + 1, k + 1);
    let allowed = Allowed {
        early: GYRO_DELAY + MARGIN,
        late: INCLINOMETER_LAG + MARGIN,
        explained: CERTAIN,
    };
    let allowed = allowed.at_period(recording.slowest);
    // All samples: those that fit best without a delay would hide it.
    let found = Some(&changes.rate[k])
        .filter(|rate| rms(rate) > LEAST_CHANGE)
        .and_then(|rate| {
            delay(
                &changes.inclination[k],
                &[rate],
                recording.steps(LONGEST_DELAY),
                recording.steps(SPAN),
                recording.dt,
                allowed,
            )
        })
        .filter(|delay| delay.explained > EXPLAINED);
    let remedy = "drive over an obstacle that turns the links by a few degrees";
    let Some(found) = found else {
        return Finding::cannot_tell(DELAY, channel, "no common motion", remedy);
    };
    let figure = in_words(&found);
    match allowed.judge(&found) {
        Verdict::Ok => with_numbers(Finding::ok(DELAY, channel, figure), &found),
        Verdict::CannotTell => Finding::cannot_tell(DELAY, channel, figure, remedy),
        Verdict::Fault => {
            let (late, offset) = if found.seconds > 0.0 {
                ("its", -found.seconds)
            } else {
                ("the gyro's", found.seconds)
            };
            let remedy = format!(
                "{late} readings arrive late: state offset = {offset:.4} of its channel, or read it directly"
            );
            with_numbers(Finding::fault(DELAY, channel, figure, remedy), &found)
        }
    }
}

/// A finding with a delay and its deviation.
pub fn with_numbers(finding: Finding, delay: &Delay) -> Finding {
    let finding = finding.with("delay", delay.seconds, "s");
    finding.with("deviation", delay.sigma, "s")
}

/// A delay in milliseconds.
pub fn in_words(delay: &Delay) -> String {
    format!(
        "{:.1} +- {:.1} ms, {:.1} % explained",
        1e3 * delay.seconds,
        1e3 * delay.sigma.max(1e-4),
        100.0 * delay.explained,
    )
}

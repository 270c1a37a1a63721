//! Gyroscopes against inclinometers: sign, unit, exchange between the links, delay.
//!
//! Over half a second an inclination changes by the integral of its link's rate. The slope of one over the other is 1; -1
//! shows a wrong sign, 57.3 degrees for radians, and a link that follows the other link's gyroscope exchanged channels.

use crate::delay::{Allowed, Delay, delay};
use crate::fit::robust_fit;
use crate::motion::Motion;
use crate::recording::Recording;
use crate::report::{Finding, Verdict};
use crate::signal::{derivative, difference, integral, rms, smooth, zip};
use robhaz_estimator::NoiseBudget;
use robhaz_model::{Carrier, GRAVITY, Robot};

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

const SIGN: &str = "sign and unit";
const DELAY: &str = "delay";

/// Changes of one angle of each link within [`SPAN`].
struct Changes {
    /// Of the inclinometers, rad.
    inclination: [Vec<f64>; 2],
    /// Of the integrated gyroscopes, rad.
    rate: [Vec<f64>; 2],
}

impl Changes {
    /// The changes of a recording, `felt` (rad) by the inclinometers in addition to the angles: left out.
    fn of(recording: &Recording, felt: Option<&[f64]>) -> Self {
        let half = recording.steps(0.5 * SPAN);
        let change = |x: &[f64]| difference(&smooth(x, recording.steps(0.5 * SMOOTHING)), half);
        let inclination = |k: usize| {
            let read = &recording.inclination[k];
            felt.map_or_else(|| read.clone(), |felt| zip(read, felt, |x, felt| x - felt))
        };
        Self {
            inclination: [0, 1].map(|k| change(&inclination(k))),
            rate: [0, 1].map(|k| change(&integral(&recording.rate[k], recording.dt))),
        }
    }
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

/// All findings of the links.
pub fn findings(
    recording: &Recording,
    motion: &Motion,
    robot: &Robot,
    budget: &NoiseBudget,
) -> Vec<Finding> {
    let changes = Changes::of(recording, None);
    let mut findings = Vec::new();
    if let Some(exchanged) = exchanged(&changes) {
        findings.push(exchanged);
        return findings;
    }
    let felt = budget
        .specific_force
        .then(|| felt(recording, motion, robot));
    let of_angles = Changes::of(recording, felt.as_deref());
    findings.extend((0..2).map(|k| sign(&changes, &of_angles, k)));
    // With wrong signs or units a delay has no meaning.
    if findings.iter().any(|f| f.verdict == Verdict::Fault) {
        return findings;
    }
    let changes = of_angles;
    findings.extend((0..2).map(|k| delay_of(recording, &changes, k)));
    findings
}

/// Share of the change of inclination `k` that the gyroscope of link `j` explains, and the slope.
fn explained(changes: &Changes, k: usize, j: usize) -> Option<(f64, f64)> {
    let fit = robust_fit(&changes.inclination[k], &[&changes.rate[j]])?;
    Some((fit.explained, fit.coefficients[0]))
}

fn exchanged(changes: &Changes) -> Option<Finding> {
    let share = |k, j| explained(changes, k, j).map(|(share, _)| share);
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
        let remedy = "exchange the gyroscopes, or the inclinometers, of link 1 and link 2";
        Finding::fault("links exchanged", "links 1 and 2", figure, remedy)
    })
}

fn sign(changes: &Changes, of_angles: &Changes, k: usize) -> Finding {
    let channel = format!("link {}: gyro, inclinometer", k + 1);
    let (tilt, turn) = (rms(&changes.inclination[k]), rms(&changes.rate[k]));
    let degrees = |angle: f64| angle / DEGREE;
    let sizes = format!(
        "changes within {SPAN} s: inclinometer {:.2} deg, gyro {:.2} deg RMS",
        degrees(tilt),
        degrees(turn)
    );
    if tilt < LEAST_CHANGE && turn < LEAST_CHANGE {
        let remedy = "drive over an obstacle that turns the links by a few degrees";
        return Finding::cannot_tell(SIGN, channel, sizes, remedy);
    }
    let found = explained(changes, k, k).filter(|(share, _)| *share > EXPLAINED);
    let Some((share, slope)) = found else {
        let remedy = if turn < LEAST_CHANGE {
            "the gyro does not turn; accelerations tilt an inclinometer, too: drive over an obstacle that turns the links by a few \
             degrees, and if the gyro still does not turn, it is dead"
        } else {
            "one of the two may be dead, of another link, or exposed to shocks: look at both while you turn the link by hand"
        };
        return Finding::cannot_tell(SIGN, channel, sizes, remedy);
    };
    let figure = format!(
        "inclinometer over integrated gyro {slope:.3} (1 is right), {:.0} % explained",
        100.0 * share
    );
    let is = |value: f64| (slope / value - 1.0).abs() < SCALE_ERROR;
    let remedy = if is(1.0) {
        return Finding::ok(SIGN, channel, figure);
    } else if is(-1.0) {
        let link = format!("link{}", k + 1);
        format!(
            "one of the two has the wrong sign: lifting the front of the link must make both positive; \
             turn round sign of reading.{link}_rate or of reading.{link}_inclination, or the axes of imu.{link}, \
             in SENSORS.toml"
        )
    } else if is(1.0 / DEGREE) || is(-1.0 / DEGREE) {
        "the inclination is in degrees: state unit = \"deg\"".to_owned()
    } else if is(DEGREE) || is(-DEGREE) {
        "the rate is in degrees a second: state unit = \"deg/s\"".to_owned()
    } else {
        // The robot's accelerations change the inclinometer, too.
        let felt = zip(
            &changes.inclination[k],
            &of_angles.inclination[k],
            |a, b| a - b,
        );
        let share_of_felt = rms(&felt) / rms(&of_angles.inclination[k]);
        if (slope - 1.0).abs() < SCALE_ERROR + share_of_felt {
            let remedy = "accelerations change the inclinometer, too: drive slower";
            return Finding::cannot_tell(SIGN, channel, figure, remedy);
        }
        "one of them has a wrong scale: check units and ranges".to_owned()
    };
    // An inclinometer measures the accelerations of impacts.
    if share < CERTAIN {
        return Finding::cannot_tell(SIGN, channel, figure, "record a drive over smooth ground");
    }
    Finding::fault(SIGN, channel, figure, remedy)
}

fn delay_of(recording: &Recording, changes: &Changes, k: usize) -> Finding {
    let channel = format!("inclinometer {} after gyro {}", k + 1, k + 1);
    let allowed = Allowed {
        early: GYRO_DELAY + MARGIN,
        late: INCLINOMETER_LAG + MARGIN,
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
        Verdict::Ok => Finding::ok(DELAY, channel, figure),
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
            Finding::fault(DELAY, channel, figure, remedy)
        }
    }
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

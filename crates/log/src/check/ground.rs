//! Each wheel passes the ground that the wheel before it has passed: scale of the encoders, signs
//! and exchange of the inclinometers.
//!
//! The axles of wheels of one radius run along one curve. With the heights y_1, y_2, y_3 of the
//! axles relative to Q, which the link angles give, and the distance s from the encoders,
//!
//! ```text
//! (y_2 - y_3)(s) = (y_1 - y_2)(s - lambda)
//! ```
//!
//! where lambda is the distance of the axles. The lambda that fits best, over the true one, is the
//! scale of the encoders. The means of both sides differ where the inclinometers have different
//! offsets.

use crate::check::course::{Course, Links, STEP};
use crate::check::report::{Finding, Verdict};
use crate::check::rewire::{Change, Channel, Tested};
use crate::check::signal::{median, rms, zip};
use robhaz_estimator::NoiseBudget;
use robhaz_model::Robot;

/// Least RMS of the differences of height, m, that shows something: 2 mm.
const LEAST_HEIGHT: f64 = 0.002;
/// Share of the rear difference that the front one explains.
const EXPLAINED: f64 = 0.7;
/// Larger share with other signs that is a fault.
const BETTER: f64 = 0.2;
/// Error of the distance that is a fault: more than slip makes, also at a kerb.
const SCALE_ERROR: f64 = 0.09;
/// Share of the rear curve that the front one explains where no wheel has spun in place.
const CERTAIN: f64 = 0.9;
/// Range of the scale that is looked for.
const SCALES: std::ops::RangeInclusive<f64> = 0.4..=2.5;

const SCALE: &str = "distance";
const SIGNS: &str = "links on the ground";
const CHANNEL: &str = "inclinometer 1, inclinometer 2";

/// Deviations of the inclinometers' bias between the two that are a fault.
const OFFSET_GATE: f64 = 5.0;

const OFFSET: &str = "zero on the ground";

/// Wirings of the two inclinometers.
const WIRINGS: [Links; 4] = [
    [(0, 1.0), (1, 1.0)],
    [(0, -1.0), (1, 1.0)],
    [(0, 1.0), (1, -1.0)],
    [(1, 1.0), (0, 1.0)],
];

/// What makes one of them that of the log.
fn change(wiring: usize) -> Option<Change> {
    let [first, second] = [0, 1].map(Channel::Inclinometer);
    match wiring {
        0 => None,
        3 => Some(Change::Exchange(first, second)),
        link => Some(Change::Factor([first, second][link - 1], -1.0)),
    }
}

/// How well the curve of the front wheels explains that of the rear ones.
#[derive(Clone, Copy)]
struct Passing {
    explained: f64,
    /// Distance found over the true one.
    scale: f64,
    /// Number of steps of the path between the two.
    shift: usize,
}

/// What the curve of the axles shows of the signs of the inclinometers. The same signs on both show
/// the same curve, mirrored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    Equal,
    Different,
    Unknown,
}

/// All findings, and what to change. `course` is `None` for a robot whose axles have different
/// distances.
pub fn findings(
    course: Option<&Course<'_>>,
    robot: &Robot,
    budget: &NoiseBudget,
    speed: f64,
) -> (Tested, Signs) {
    let Some(course) = course else {
        let [front, middle, rear] = robot.geometry.axles.map(|axle| axle.x);
        let (front, rear) = (front - middle, middle - rear);
        let remedy = "none: this test needs equal distances between the axles";
        let figure = format!("axles are {front:.3} and {rear:.3} m apart");
        let mut tested = Tested::default();
        tested.add(
            Finding::ok(SIGNS, CHANNEL, figure).cannot_tell(remedy),
            None,
        );
        return (tested, Signs::Unknown);
    };
    let passings = WIRINGS.map(|links| passing(course, &links));
    let (finding, change) = signs(&passings);
    let signs = match (finding.verdict, change) {
        (Verdict::CannotTell, _) => Signs::Unknown,
        (_, Some(Change::Factor(..))) => Signs::Different,
        _ => Signs::Equal,
    };
    let mut findings = vec![finding];
    if change.is_none() {
        findings.extend(offset(course, passings[0], (robot, budget), speed));
    }
    // Which of the two has the other sign, the gyroscopes know.
    let changes = change
        .filter(|_| signs == Signs::Equal)
        .into_iter()
        .collect();
    (Tested { findings, changes }, signs)
}

fn signs(passings: &[Option<Passing>; 4]) -> (Finding, Option<Change>) {
    let share = |p: &Option<Passing>| p.map_or(0.0, |p| p.explained);
    let own = share(&passings[0]);
    let best = (0..4).max_by(|a, b| share(&passings[*a]).total_cmp(&share(&passings[*b])));
    let best = best.unwrap_or(0);
    let most = share(&passings[best]);
    let mut figure = format!(
        "the curve of the front wheels explains {:.0} % of that of the rear ones",
        100.0 * own
    );
    let change = change(best).filter(|_| most > CERTAIN && most > own + BETTER);
    if change.is_some() {
        figure += &format!(", otherwise wired {:.0} %", 100.0 * most);
    }
    let finding = Finding::ok(SIGNS, CHANNEL, figure)
        .with("explained", own, "-")
        .with("explained otherwise", most, "-");
    let finding = match change {
        Some(Change::Factor(..)) => {
            finding.fault("one of the two has the wrong sign: nose up is positive")
        }
        Some(exchange) => finding.fault(exchange.to_string()),
        None if own > EXPLAINED => finding,
        None => finding.cannot_tell("drive with all wheels over an obstacle of some centimetres"),
    };
    (finding, change)
}

/// Difference of the means of the two curves, over what the inclinometers' biases make of it.
fn offset(
    course: &Course<'_>,
    own: Option<Passing>,
    (robot, budget): (&Robot, &NoiseBudget),
    speed: f64,
) -> Option<Finding> {
    let [front, rear] = course.heights(&WIRINGS[0]);
    // On level ground no distance shows, and none is needed.
    let is_level = |x: &[f64]| {
        let middle = median(x.iter().copied()).unwrap_or(0.0);
        // Not the mean: a start moves the inclinometers.
        median(x.iter().map(|x| (x - middle).abs())).is_some_and(|m| m < LEAST_HEIGHT)
    };
    let shift = match own.filter(|p| p.explained > CERTAIN) {
        Some(own) => own.shift,
        None if is_level(&front) && is_level(&rear) => steps_of(course, 1.0),
        None => return None,
    };
    let n = course.len().checked_sub(shift).filter(|n| *n > shift / 2)?;
    let difference = zip(&rear[shift..], &front[..n], |rear, front| rear - front);
    let mean = median(difference)?;
    let angle = mean / course.spacing();
    // A start within one of the two adds its acceleration over g: v^2/(2 g) over the way.
    let way = n as f64 * STEP;
    let limit =
        OFFSET_GATE * 2.0 * budget.inclination_bias + speed * speed / (2.0 * robot.gravity * way);
    let (angle, limit) = (angle.to_degrees(), limit.to_degrees());
    let figure =
        format!("wheels that pass the same ground differ by {angle:.2} deg, at most {limit:.2}");
    let finding = Finding::ok(OFFSET, CHANNEL, figure).with("difference", angle, "deg");
    let remedy =
        "one of the inclinometers has an offset: zero both in the nominal pose on level ground";
    Some(match angle.abs() <= limit {
        true => finding,
        false => finding.fault(remedy),
    })
}

/// Scale of the encoders, from angles that gyroscopes and inclinometers give together:
/// accelerations do not disturb them.
pub fn distance(fused: &Course<'_>) -> Finding {
    let own = passing(fused, &WIRINGS[0]);
    let channel = "encoders 1 to 3";
    let Some(own) = own.filter(|p| p.explained > EXPLAINED) else {
        let remedy = "drive with all wheels over an obstacle of some centimetres";
        return Finding::ok(SCALE, channel, "the ground shows no distance").cannot_tell(remedy);
    };
    let figure = format!(
        "distance by the encoders over that by the ground {:.3} ({:.2} to {:.2} is right), {:.0} % explained",
        own.scale,
        1.0 - SCALE_ERROR,
        1.0 + SCALE_ERROR,
        100.0 * own.explained
    );
    let finding = Finding::ok(SCALE, channel, figure);
    if (own.scale - 1.0).abs() < SCALE_ERROR {
        return finding.with("scale", own.scale, "-");
    }
    if own.explained < CERTAIN {
        let remedy = "drive without spinning wheels; if no wheel spins, wheel radius, counts a turn or the robot's geometry are wrong";
        return finding.cannot_tell(remedy);
    }
    let remedy = format!(
        "counts a turn are too few or the wheel radius is too large by the factor {:.3}; or the wheels slip that much",
        own.scale
    );
    finding.fault(remedy).with("scale", own.scale, "-")
}

/// Steps of the path in the distance of two axles, for encoders of a scale.
fn steps_of(course: &Course<'_>, scale: f64) -> usize {
    (scale * course.spacing() / STEP) as usize
}

/// The best passing with the angles of `links`. `None` where the ground shows nothing.
fn passing(course: &Course<'_>, links: &Links) -> Option<Passing> {
    let [front, rear] = course.heights(links);
    let (count, spacing) = (course.len(), course.spacing());
    let at = |scale: f64| steps_of(course, scale);
    let explained = |shift: usize| {
        let n = count.checked_sub(shift).filter(|n| *n > at(1.0) / 2)?;
        let (y, x) = (&rear[shift..], &front[..n]);
        let y = zip(y, x, |y, x| if x.is_finite() { y } else { f64::NAN });
        // The same heights, but for a constant: the start may be on a slope, zeros may be wrong.
        let left = deviation(&zip(&y, x, |y, x| y - x));
        let size = deviation(&y);
        (size > LEAST_HEIGHT).then_some(1.0 - (left / size).powi(2))
    };
    let (first, last) = (at(*SCALES.start()), at(*SCALES.end()));
    let best = (first..=last)
        .filter_map(|shift| Some((shift, explained(shift)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    // At an end of the range there is no maximum.
    if best.0 == first || best.0 == last {
        return None;
    }
    Some(Passing {
        explained: best.1,
        scale: best.0 as f64 * STEP / spacing,
        shift: best.0,
    })
}

/// Root of the mean square of the deviations from the mean.
fn deviation(x: &[f64]) -> f64 {
    let finite = || x.iter().filter(|v| v.is_finite());
    let count = u32::try_from(finite().count().max(1)).unwrap_or(u32::MAX);
    let mean = finite().sum::<f64>() / f64::from(count);
    rms(&x.iter().map(|x| x - mean).collect::<Vec<_>>())
}

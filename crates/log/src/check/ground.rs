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
//! offsets. With two distances, lambda in front and mu behind, the ground drops out of differences:
//!
//! ```text
//! (y_2 - y_3)(s + lambda) - (y_2 - y_3)(s) = (y_1 - y_2)(s) - (y_1 - y_2)(s - mu)
//! ```

use crate::check::changes::DEGREE;
use crate::check::course::{Course, Heights, Links, OWN, STEP, steps_of};
use crate::check::on_links::ROBOT_FILE;
use crate::check::{Change, Channel, Finding, Readings, Recording, Verdict};
use robhaz_model::Units;
use robhaz_score::signals::{deviation, median, smooth, subtract};

/// Time over which inclinometers count in [`fused`], s: an acceleration of the robot hardly lasts as long. Where it does,
/// as at 2 m/s over waves of 2.5 m, another time shows another ground.
const SLOW: f64 = 1.0;
/// Share of the rear difference that the front one explains.
pub const EXPLAINED: f64 = 0.7;
/// Larger share with other signs that is a fault.
const BETTER: f64 = 0.2;
/// Error of the distance that is a fault: more than slip makes, also at a kerb.
pub const SCALE_ERROR: f64 = 0.09;
/// Slip speed of all wheels together that a slow drive may have, m/s for robot A: a creep of 30 mm/s at T = N
/// (the estimator's prior) and a mean T/N of 0.05.
const SLIP: f64 = 0.0015;
/// Share of the rear curve that the front one explains where no wheel has spun in place.
pub const CERTAIN: f64 = 0.9;
/// Range of the scale that is looked for.
const SCALES: std::ops::RangeInclusive<f64> = 0.4..=2.5;

pub const SCALE: &str = "distance";
pub const SIGNS: &str = "links on the ground";
/// The channels of what it finds of links.
pub const CHANNEL: &str = "inclinometer 1, inclinometer 2";

/// Standard deviations of the difference between the two that are a fault.
const OFFSET_GATE: f64 = 5.0;

pub const OFFSET: &str = "zero on the ground";

/// Wirings of the two inclinometers: what each link takes of both, and what makes it that of the
/// log.
type Wiring = (Links, Option<Change>);

/// Those that are compared; of readings that are made of the body's, on the link of that number,
/// the sign and the unit of pin Q, and the body on the other link.
fn wirings(body_link: Option<usize>) -> Vec<Wiring> {
    let [first, second] = [0, 1].map(Channel::Inclinometer);
    let (own, flip) = ((OWN, None), |channel| Some(Change::Factor(channel, -1.0)));
    // The link without the body, with a factor of the angle of the pin.
    let pin = |body: usize, factor: f64| {
        let mut links = OWN;
        links[1 - body][1 - body] = factor;
        links[1 - body][body] = 1.0 - factor;
        (links, Some(Change::Factor(Channel::Pin, factor)))
    };
    match body_link {
        Some(body) => {
            let others = [-1.0, DEGREE, 1.0 / DEGREE].map(|factor| pin(body, factor));
            let mut on_other = OWN;
            on_other[1 - body] = OWN[body];
            on_other[body][body] = 2.0;
            on_other[body][1 - body] = -1.0;
            let on_other = (on_other, Some(Change::OtherBody));
            [vec![own, on_other], others.to_vec()].concat()
        }
        None => {
            let exchange = Some(Change::Exchange(first, second));
            vec![
                own,
                ([[-1.0, 0.0], [0.0, 1.0]], flip(first)),
                ([[1.0, 0.0], [0.0, -1.0]], flip(second)),
                ([[0.0, 1.0], [1.0, 0.0]], exchange),
            ]
        }
    }
}

/// How well the curve of the front wheels explains that of the rear ones.
#[derive(Clone, Copy)]
pub struct Passing {
    pub explained: f64,
    /// Distance found over the true one.
    pub scale: f64,
    /// Number of steps of the path between the two.
    pub shift: usize,
}

/// What the curve of the axles shows of the signs of the inclinometers. The same signs on both show
/// the same curve, mirrored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    Equal,
    Different,
    Unknown,
}

/// All findings. `is_forward`: whether the inclinometers show the acceleration of the wheels. The
/// ground is the same for an inertial sensor that is mounted the other way round as for a pin that
/// is.
pub fn findings(log: &Readings<'_>, is_forward: bool) -> (Vec<Finding>, Signs) {
    let course = Course::of(&log.recording, log.stated.robot);
    let wirings = wirings(log.stated.body_link());
    let passings = |course: &Course<'_>| -> Vec<Option<Passing>> {
        (wirings.iter().map(|(links, _)| passing(course, links))).collect()
    };
    let own = passings(&course);
    if let Some(finding) = direction(most(&own), most(&passings(&course.turned_round()))) {
        return (vec![finding], Signs::Unknown);
    }
    let (mut finding, change) = signs(&wirings, &own);
    if change == Some(Change::Factor(Channel::Pin, -1.0)) && !is_forward {
        finding = finding.fault("turn round sign of reading.pin_angle, or those of body_inclination and body_rate: a start shows which");
    }
    let signs = match (finding.verdict, change) {
        (Verdict::CannotTell, _) | (_, Some(Change::Factor(Channel::Pin, _))) => Signs::Unknown,
        (_, Some(Change::Factor(..))) => Signs::Different,
        _ => Signs::Equal,
    };
    // Which of the two has the other sign, the gyroscopes know.
    let mut findings = vec![finding.change(change.filter(|_| signs != Signs::Different))];
    if change.is_none() && course.is_even() {
        findings.extend(offset(&course, own[0], log));
    }
    (findings, signs)
}

/// The share of each wiring.
fn shares(passings: &[Option<Passing>]) -> impl Iterator<Item = f64> {
    let share = |passing: &Option<Passing>| passing.map_or(0.0, |p| p.explained);
    passings.iter().map(share)
}

/// The largest share of any wiring.
fn most(passings: &[Option<Passing>]) -> f64 {
    shares(passings).fold(0.0, f64::max)
}

/// A fault where the wheels pass the same ground in the other order, however the links are wired.
fn direction(own: f64, back: f64) -> Option<Finding> {
    if back < CERTAIN || back < own + BETTER {
        return None;
    }
    let figure = format!(
        "the curve of the front wheels explains {:.0} % of that of the rear ones, {:.0} % if the robot drives the other way",
        100.0 * own.max(0.0),
        100.0 * back
    );
    let finding = Finding::ok(SIGNS, "encoders 1 to 3, torques 1 to 3", figure);
    let remedy = "the signs of all encoders and torques are wrong, forward is positive; or front and rear are exchanged; then look at the inclinometers again";
    Some(finding.explained(own, back).fault(remedy))
}

fn signs(wirings: &[Wiring], passings: &[Option<Passing>]) -> (Finding, Option<Change>) {
    let own = shares(passings).next().unwrap_or(0.0);
    let (mut best, mut most) = (None, own);
    for ((_, change), share) in wirings.iter().zip(shares(passings)) {
        if share > most {
            (best, most) = (*change, share);
        }
    }
    let mut figure = format!(
        "the curve of the front wheels explains {:.0} % of that of the rear ones",
        100.0 * own.max(0.0)
    );
    let change = best.filter(|_| most > CERTAIN && most > own + BETTER);
    if change.is_some() {
        figure += &format!(", otherwise wired {:.0} %", 100.0 * most);
    }
    let finding = Finding::ok(SIGNS, CHANNEL, figure).explained(own, most);
    let finding = match change {
        Some(Change::Factor(Channel::Pin, -1.0)) => {
            finding.fault("turn round sign of reading.pin_angle")
        }
        Some(Change::Factor(Channel::Pin, factor)) => {
            let unit = if factor > 1.0 { "rad" } else { "deg" };
            finding.fault(format!(
                "reading.pin_angle is in another unit: state unit = \"{unit}\""
            ))
        }
        Some(Change::OtherBody) => Finding {
            channel: ROBOT_FILE.to_owned(),
            ..finding.fault("the sensor of the body turns as the other link does: correct `suspension.body` of the robot file, or mount it on the link of the body")
        },
        Some(Change::Factor(..)) => {
            finding.fault("one of the two has the wrong sign: nose up is positive")
        }
        Some(_) => finding.fault("exchange inclinometer 1 and inclinometer 2"),
        None if own > EXPLAINED => finding,
        None => finding.cannot_tell("drive with all wheels over an obstacle of some centimetres"),
    };
    (finding, change)
}

/// Difference of the means of the two curves, over what the inclinometers' biases and errors of the
/// distance make of it.
fn offset(course: &Course<'_>, own: Option<Passing>, log: &Readings<'_>) -> Option<Finding> {
    let (robot, budget) = (log.stated.robot, &log.stated.settings.budget);
    let [front, rear] = course.heights(&OWN);
    // On level ground no distance shows, and none is needed.
    let is_level = |x: &[f64]| {
        let middle = median(x.to_vec()).unwrap_or(0.0);
        // Not the mean: a start moves the inclinometers.
        median(x.iter().map(|x| (x - middle).abs()).collect())
            .is_some_and(|m| m < course.least_height())
    };
    let shift = match own.filter(|p| p.explained > CERTAIN) {
        Some(own) => own.shift,
        None if is_level(&front) && is_level(&rear) => steps_of(course, 1.0),
        None => return None,
    };
    let n = course.len().checked_sub(shift).filter(|n| *n > shift / 2)?;
    let difference = subtract(&rear[shift..], &front[..n]);
    let spacing = course.spacings()[0];
    let angle = median(difference.clone())? / spacing;
    // The heights differ also by errors of the distance, which last about as long as a wheel needs
    // to the place of the next.
    let way = n as f64 * STEP;
    let independent = (way / spacing).max(1.0);
    let of_heights = deviation(&difference) / (spacing * independent.sqrt());
    // A start within one of the two adds its acceleration over g: v^2/(2 g) over the way.
    let spin = log.recording.while_driving(&log.recording.middle_spin);
    let speed = robot.geometry.wheel_radius * median(spin).unwrap_or(0.0).abs();
    let sigma = (2.0 * budget.inclination_bias).hypot(of_heights);
    let limit = OFFSET_GATE * sigma + speed * speed / (2.0 * robot.gravity * way);
    let (angle, limit) = (angle.to_degrees(), limit.to_degrees());
    let figure =
        format!("wheels that pass the same ground differ by {angle:.2} deg, at most {limit:.2}");
    let finding = Finding::ok(OFFSET, CHANNEL, figure).with("difference", angle, "deg");
    if angle.abs() <= limit {
        return Some(finding);
    }
    let remedy =
        "one of the inclinometers has an offset: zero both in the nominal pose on level ground";
    Some(finding.fault(remedy))
}

/// Angles of links 1 and 2, rad: inclinometers over times longer than `slow` (s), gyroscopes over shorter ones. For
/// readings that agree.
fn fused(recording: &Recording, slow: f64) -> [Vec<f64>; 2] {
    [0, 1].map(|k| {
        let (turned, drift) = recording.turned(k);
        let drift = smooth(&drift, recording.steps(0.5 * slow));
        turned.iter().zip(&drift).map(|(a, b)| a + b).collect()
    })
}

/// Scale of the encoders, from angles that gyroscopes and inclinometers give together:
/// accelerations do not disturb them.
pub fn distance(log: &Readings<'_>) -> Finding {
    let (recording, robot) = (&log.recording, log.stated.robot);
    let course = |slow: f64| Course::with(recording, robot, &fused(recording, slow));
    let own = passing(&course(SLOW), &OWN);
    let channel = "encoders 1 to 3";
    let Some(own) = own.filter(|p| p.explained > EXPLAINED) else {
        let remedy = "drive with all wheels over an obstacle of some centimetres";
        return Finding::ok(SCALE, channel, "the ground shows no distance").cannot_tell(remedy);
    };
    let spin = recording.usual_spin().unwrap_or(f64::INFINITY);
    let slip = SLIP * Units::of(robot).speed() / (spin * robot.geometry.wheel_radius);
    let error = SCALE_ERROR.max(slip);
    let figure = format!(
        "distance by the encoders over that by the ground {:.3} ({:.2} to {:.2} is right), {:.0} % explained",
        own.scale,
        1.0 - error,
        1.0 + error,
        100.0 * own.explained
    );
    let finding = Finding::ok(SCALE, channel, figure);
    let is_right = (own.scale - 1.0).abs() < error;
    if !is_right && own.explained < CERTAIN {
        let remedy = "drive without spinning wheels; if no wheel spins, wheel radius, counts a turn or the robot's geometry are wrong";
        return finding.cannot_tell(remedy);
    }
    if own.scale > 1.0 + error && course(SLOW).climbs_faces() {
        let remedy =
            "drive where no wheel climbs a riser: there it rolls further than the robot, or spins";
        return finding.cannot_tell(remedy);
    }
    let finding = finding.with("scale", own.scale, "-");
    if is_right {
        return finding;
    }
    let again = passing(&course(2.0 * SLOW), &OWN);
    if again.is_none_or(|again| (again.scale / own.scale - 1.0).abs() > error) {
        return finding
            .cannot_tell("drive more slowly: accelerations that last look like another ground");
    }
    finding.fault(format!(
        "counts a turn are too few or the wheel radius is too large by the factor {:.3}; or the wheels slip that much",
        own.scale
    ))
}

/// The best passing with the angles of `links`. `None` where the ground shows nothing.
pub fn passing(course: &Course<'_>, links: &Links) -> Option<Passing> {
    let heights = Heights::of(course, links);
    let [spacing, _] = course.spacings();
    let at = |scale: f64| steps_of(course, scale);
    // The true distance is within the way.
    heights.sides(at(1.0))?;
    let (first, last) = (at(*SCALES.start()), at(*SCALES.end()));
    let best = (first..=last)
        .filter_map(|shift| Some((shift, heights.explained(shift)?)))
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

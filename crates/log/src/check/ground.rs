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

use crate::check::readings::Readings;
use crate::check::recording::Recording;
use crate::check::report::{Finding, Verdict};
use crate::check::rewire::{Change, Channel};
use robhaz_model::{Robot, Units, Vec2};
use robhaz_score::signals::{deviation, mean, median, smooth, subtract};

/// Step of the path, m.
const STEP: f64 = 0.002;
/// Least RMS of the differences of height of robot A that shows something, m: 2 mm.
const LEAST_HEIGHT: f64 = 0.002;
/// Largest number of steps of a path: 1 km. What follows shows nothing new.
const MOST_STEPS: usize = 500_000;
/// Relative difference of the two distances between the axles up to which they count as equal.
const EQUAL_SPACING: f64 = 0.02;

/// Time over which inclinometers count in [`fused`], s: an acceleration of the robot does not last
/// as long.
const SLOW: f64 = 1.0;
/// Share of the rear difference that the front one explains.
const EXPLAINED: f64 = 0.7;
/// Larger share with other signs that is a fault.
const BETTER: f64 = 0.2;
/// Error of the distance that is a fault: more than slip makes, also at a kerb.
const SCALE_ERROR: f64 = 0.09;
/// Share of the rear curve that the front one explains where no wheel has spun in place.
const CERTAIN: f64 = 0.9;
/// Inclination of a link from which on its wheels climb a face, rad: there a wheel rolls further
/// than the line between the axles, or spins. Chosen: ground without corners in the shipped scenes
/// stays below 16 deg, `stairs` is beyond it for 7 to 9 % of the time.
const STEEP: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Share of the way on such faces that makes the distance uncertain. Chosen: a single kerb (`step`,
/// `ditch`) takes 0.1 %.
const SHARE_OF_FACES: f64 = 0.01;
/// Range of the scale that is looked for.
const SCALES: std::ops::RangeInclusive<f64> = 0.4..=2.5;

const SCALE: &str = "distance";
const SIGNS: &str = "links on the ground";
const CHANNEL: &str = "inclinometer 1, inclinometer 2";

/// Standard deviations of the difference between the two that are a fault.
const OFFSET_GATE: f64 = 5.0;

const OFFSET: &str = "zero on the ground";

/// The angles that are used for links 1 and 2: parts of the inclinations of both.
type Links = [[f64; 2]; 2];

/// Wirings of the two inclinometers: what each link takes of both, and what makes it that of the
/// log.
type Wiring = (Links, Option<Change>);

const OWN: Links = [[1.0, 0.0], [0.0, 1.0]];

/// Those that are compared; of readings that are made of the body's, on the link of that number,
/// the sign of pin Q.
fn wirings(body_link: Option<usize>) -> Vec<Wiring> {
    let [first, second] = [0, 1].map(Channel::Inclinometer);
    let (own, flip) = ((OWN, None), |channel| Some(Change::Factor(channel, -1.0)));
    match body_link {
        Some(0) => vec![own, ([[1.0, 0.0], [2.0, -1.0]], Some(Change::Pin(0)))],
        Some(_) => vec![own, ([[-1.0, 2.0], [0.0, 1.0]], Some(Change::Pin(1)))],
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

/// All findings. `is_forward`: whether the inclinometers show the acceleration of the wheels. The
/// ground is the same for an inertial sensor that is mounted the other way round as for a pin that
/// is.
pub fn findings(log: &Readings<'_>, is_forward: bool) -> (Vec<Finding>, Signs) {
    let course = Course::new(log, &log.recording.inclination);
    let wirings = wirings(log.stated.body_link());
    let passings = |course: &Course<'_>| -> Vec<Option<Passing>> {
        (wirings.iter().map(|(links, _)| passing(course, links))).collect()
    };
    let own = passings(&course);
    if let Some(finding) = direction(most(&own), most(&passings(&course.turned_round()))) {
        return (vec![finding], Signs::Unknown);
    }
    let (mut finding, change) = signs(&wirings, &own);
    if matches!(change, Some(Change::Pin(_))) && !is_forward {
        finding = finding.fault("turn round sign of reading.pin_angle, or those of body_inclination and body_rate: a start shows which");
    }
    let signs = match (finding.verdict, change) {
        (Verdict::CannotTell, _) | (_, Some(Change::Pin(_))) => Signs::Unknown,
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
        100.0 * own,
        100.0 * back
    );
    let finding = Finding::ok(SIGNS, "encoders 1 to 3, torques 1 to 3", figure)
        .with("explained", own, "-")
        .with("explained otherwise", back, "-");
    let remedy = "the signs of all encoders and torques are wrong, forward is positive; or front and rear are exchanged; then look at the inclinometers again";
    Some(finding.fault(remedy))
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
        100.0 * own
    );
    let change = best.filter(|_| most > CERTAIN && most > own + BETTER);
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
        Some(other) => finding.fault(other.to_string()),
        None if own > EXPLAINED => finding,
        None => finding.cannot_tell("drive with all wheels over an obstacle of some centimetres"),
    };
    (finding, change)
}

/// Difference of the means of the two curves, over what the inclinometers' biases and errors of the
/// distance make of it.
fn offset(course: &Course<'_>, own: Option<Passing>, log: &Readings<'_>) -> Option<Finding> {
    let (robot, budget) = (log.stated.robot, &log.stated.budget);
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

/// Angles of links 1 and 2, rad: inclinometers over long times, gyroscopes over short ones. For
/// readings that agree.
fn fused(recording: &Recording) -> [Vec<f64>; 2] {
    [0, 1].map(|k| {
        let (turned, drift) = recording.turned(k);
        let drift = smooth(&drift, recording.steps(0.5 * SLOW));
        turned.iter().zip(&drift).map(|(a, b)| a + b).collect()
    })
}

/// Scale of the encoders, from angles that gyroscopes and inclinometers give together:
/// accelerations do not disturb them.
pub fn distance(log: &Readings<'_>) -> Finding {
    let course = Course::new(log, &fused(&log.recording));
    let own = passing(&course, &OWN);
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
    let is_right = (own.scale - 1.0).abs() < SCALE_ERROR;
    if !is_right && own.explained < CERTAIN {
        let remedy = "drive without spinning wheels; if no wheel spins, wheel radius, counts a turn or the robot's geometry are wrong";
        return finding.cannot_tell(remedy);
    }
    if own.scale > 1.0 + SCALE_ERROR && course.climbs_faces() {
        let remedy =
            "drive where no wheel climbs a riser: there it rolls further than the robot, or spins";
        return finding.cannot_tell(remedy);
    }
    let finding = finding.with("scale", own.scale, "-");
    if is_right {
        return finding;
    }
    finding.fault(format!(
        "counts a turn are too few or the wheel radius is too large by the factor {:.3}; or the wheels slip that much",
        own.scale
    ))
}

/// Steps of the path in the distance of the front two axles, for encoders of a scale.
fn steps_of(course: &Course<'_>, scale: f64) -> usize {
    (scale * course.spacings()[0] / STEP) as usize
}

/// The best passing with the angles of `links`. `None` where the ground shows nothing.
fn passing(course: &Course<'_>, links: &Links) -> Option<Passing> {
    let [front, rear] = course.heights(links);
    let (count, [spacing, behind]) = (course.len(), course.spacings());
    let at = |scale: f64| steps_of(course, scale);
    let is_even = course.is_even();
    // Both sides of the equation, for a shift of the front wheels.
    let sides = |shift: usize| {
        if is_even {
            let n = count.checked_sub(shift).filter(|n| *n > at(1.0) / 2)?;
            return Some((rear[shift..].to_vec(), front[..n].to_vec()));
        }
        let back = (shift as f64 * behind / spacing) as usize;
        let n = count.checked_sub(shift + back);
        let n = n.filter(|n| *n > at(1.0) / 2)?;
        let moved = |x: &[f64], by: usize| subtract(&x[by..by + n], &x[..n]);
        Some((moved(&rear[back..], shift), moved(&front, back)))
    };
    let explained = |shift: usize| {
        let (y, x) = sides(shift)?;
        let pairs = y.iter().zip(&x);
        let y = pairs.map(|(y, x)| if x.is_finite() { *y } else { f64::NAN });
        let y: Vec<f64> = y.collect();
        // The same heights, but for a constant: the start may be on a slope, zeros may be wrong.
        let left = deviation(&subtract(&y, &x));
        let size = deviation(&y);
        (size > course.least_height()).then_some(1.0 - (left / size).powi(2))
    };
    // The true distance is within the way.
    sides(at(1.0))?;
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

/// The inclinations of a log along the path of the robot.
struct Course<'a> {
    robot: &'a Robot,
    /// Inclination of links 1 and 2 at each step, rad.
    inclination: [Vec<f64>; 2],
}

impl<'a> Course<'a> {
    /// The course of a robot, for angles of links 1 and 2 (rad), in the order of the places: on the
    /// way back from its end.
    fn new(log: &Readings<'a>, inclination: &[Vec<f64>; 2]) -> Self {
        let (samples, back) = samples(log);
        let inclination = inclination.each_ref().map(|x| mean_along(&samples, x));
        let robot = log.stated.robot;
        let course = Self { robot, inclination };
        if back { course.turned_round() } else { course }
    }

    /// The same course driven the other way.
    fn turned_round(&self) -> Self {
        let reversed = |x: &Vec<f64>| x.iter().rev().copied().collect();
        Self {
            robot: self.robot,
            inclination: self.inclination.each_ref().map(reversed),
        }
    }

    /// Number of steps.
    fn len(&self) -> usize {
        self.inclination[0].len()
    }

    /// Distances between front and middle, and middle and rear axle, m.
    fn spacings(&self) -> [f64; 2] {
        let axles = &self.robot.geometry.axles;
        [axles[0].x - axles[1].x, axles[1].x - axles[2].x]
    }

    /// Least RMS of the differences of height that shows something, m.
    fn least_height(&self) -> f64 {
        LEAST_HEIGHT * Units::of(self.robot).length
    }

    /// Whether wheels climb faces that are steeper than [`STEEP`].
    fn climbs_faces(&self) -> bool {
        let steps = SHARE_OF_FACES * self.len() as f64;
        let is_beyond = |x: &[f64]| x.iter().filter(|x| x.abs() > STEEP).count() as f64 > steps;
        self.inclination.iter().any(|x| is_beyond(x))
    }

    /// Whether both spacings are the same.
    fn is_even(&self) -> bool {
        let [front, rear] = self.spacings();
        (front - rear).abs() <= EQUAL_SPACING * front
    }

    /// Heights of an axle above the next one behind it, m: front above middle, middle above rear,
    /// at each step.
    fn heights(&self, links: &Links) -> [Vec<f64>; 2] {
        let geometry = &self.robot.geometry;
        let height = |i: usize, k: usize| {
            let [a, b] = links[geometry.carriers[i].index()];
            let arm: Vec2 = geometry.axles[i] - geometry.pins.q;
            let angle = a * self.inclination[0][k] + b * self.inclination[1][k];
            let (sin, cos) = angle.sin_cos();
            arm.x * sin + arm.y * cos
        };
        let steps = 0..self.len();
        [
            steps.clone().map(|k| height(0, k) - height(1, k)).collect(),
            steps.map(|k| height(1, k) - height(2, k)).collect(),
        ]
    }
}

/// The sample at each step of the path, and the fraction from there to the next one: at a low rate
/// or a high speed a sample takes several steps. And whether the way leads back.
fn samples(log: &Readings<'_>) -> (Vec<(usize, f64)>, bool) {
    let (recording, radius) = (&log.recording, log.stated.robot.geometry.wheel_radius);
    let spin = recording.while_driving(&recording.middle_spin);
    // Most of the way decides the direction.
    let net: f64 = spin.iter().filter(|s| s.is_finite()).sum();
    let direction = if net < 0.0 { -1.0 } else { 1.0 };
    let (mut samples, mut distance) = (vec![(0, 0.0)], 0.0);
    for (k, (spin, slope)) in spin.iter().zip(&recording.slope).enumerate() {
        let advance = direction * radius * spin * slope.cos() * recording.dt;
        if !advance.is_finite() {
            continue;
        }
        let missing = |count: usize| STEP * count as f64 - distance;
        while samples.len() < MOST_STEPS && missing(samples.len()) < advance {
            samples.push((k, missing(samples.len()) / advance));
        }
        distance += advance;
    }
    (samples, direction < 0.0)
}

/// Values of a signal along the path: means over the samples of a step, and between samples on a
/// straight line.
fn mean_along(samples: &[(usize, f64)], x: &[f64]) -> Vec<f64> {
    let at = |(k, part): (usize, f64)| {
        let here = x.get(k).copied().unwrap_or(f64::NAN);
        let next = x.get(k + 1).copied().unwrap_or(here);
        here + (next - here) * part
    };
    let means = samples.windows(2).map(|w| {
        let (from, to) = (w[0].0, w[1].0);
        if to <= from + 1 {
            return 0.5 * (at(w[0]) + at(w[1]));
        }
        mean(&x[from..to]).unwrap_or(f64::NAN)
    });
    means.collect()
}

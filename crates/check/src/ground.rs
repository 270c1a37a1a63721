//! Each wheel passes the ground that the wheel before it has passed: scale of the encoders, signs and exchange of the
//! inclinometers.
//!
//! The axles of wheels of one radius run along one curve. With the heights y_1, y_2, y_3 of the axles relative to Q, which
//! the link angles give, and the distance s from the encoders,
//!
//! ```text
//! (y_2 - y_3)(s) = (y_1 - y_2)(s - lambda)
//! ```
//!
//! where lambda is the distance of the axles. The lambda that fits best, over the true one, is the scale of the encoders.

use crate::course::{Course, Links, STEP};
use crate::report::Finding;
use crate::signal::{rms, zip};
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

/// Wirings of the two inclinometers, and what to do for each.
const WIRINGS: [(Links, &str); 4] = [
    ([(0, 1.0), (1, 1.0)], ""),
    ([(0, -1.0), (1, 1.0)], "change the sign of inclinometer 1"),
    ([(0, 1.0), (1, -1.0)], "change the sign of inclinometer 2"),
    (
        [(1, 1.0), (0, 1.0)],
        "exchange the sensors of link 1 and link 2",
    ),
];

/// How well the curve of the front wheels explains that of the rear ones.
#[derive(Clone, Copy)]
struct Passing {
    explained: f64,
    /// Distance found over the true one.
    scale: f64,
}

/// Distance by the encoders over that by the ground; 1 where the ground shows none.
pub fn scale_of(course: &Course<'_>) -> f64 {
    let own = passing(course, &WIRINGS[0].0).filter(|p| p.explained > EXPLAINED);
    own.map_or(1.0, |p| p.scale)
}

/// All findings: signs from the inclinometers alone, distance from angles that gyroscopes and inclinometers give together,
/// which accelerations of the robot do not disturb. `None` for a robot whose axles have different distances.
pub fn findings(
    course: Option<&Course<'_>>,
    fused: Option<&Course<'_>>,
    robot: &Robot,
) -> Vec<Finding> {
    let (Some(course), Some(fused)) = (course, fused) else {
        let [front, middle, rear] = robot.geometry.axles.map(|axle| axle.x);
        let (front, rear) = (front - middle, middle - rear);
        let remedy = "none: this test needs equal distances between the axles";
        let figure = format!("axles are {front:.3} and {rear:.3} m apart");
        return vec![Finding::cannot_tell(SIGNS, "inclinometers", figure, remedy)];
    };
    let passings = WIRINGS.map(|(links, _)| passing(course, &links));
    vec![signs(&passings), scale(passing(fused, &WIRINGS[0].0))]
}

fn signs(passings: &[Option<Passing>; 4]) -> Finding {
    let channel = "inclinometers";
    let share = |p: &Option<Passing>| p.map_or(0.0, |p| p.explained);
    let own = share(&passings[0]);
    let best = (0..4).max_by(|a, b| share(&passings[*a]).total_cmp(&share(&passings[*b])));
    let best = best.unwrap_or(0);
    let most = share(&passings[best]);
    let figure = format!(
        "the curve of the front wheels explains {:.0} % of that of the rear ones",
        100.0 * own
    );
    if most > CERTAIN && most > own + BETTER {
        let figure = format!("{figure}, otherwise wired {:.0} %", 100.0 * most);
        Finding::fault(SIGNS, channel, figure, WIRINGS[best].1)
    } else if own > EXPLAINED {
        Finding::ok(SIGNS, channel, figure)
    } else {
        let remedy = "drive with all wheels over an obstacle of some centimetres";
        Finding::cannot_tell(SIGNS, channel, figure, remedy)
    }
}

fn scale(own: Option<Passing>) -> Finding {
    let channel = "encoders";
    let Some(own) = own.filter(|p| p.explained > EXPLAINED) else {
        let remedy = "drive with all wheels over an obstacle of some centimetres";
        return Finding::cannot_tell(SCALE, channel, "the ground shows no distance", remedy);
    };
    let figure = format!(
        "distance by the encoders over that by the ground {:.3} ({:.2} to {:.2} is right), {:.0} % explained",
        own.scale,
        1.0 - SCALE_ERROR,
        1.0 + SCALE_ERROR,
        100.0 * own.explained
    );
    if (own.scale - 1.0).abs() < SCALE_ERROR {
        return Finding::ok(SCALE, channel, figure);
    }
    let remedy = format!(
        "counts a turn are too few or the wheel radius is too large by the factor {:.3}; or the wheels slip that much",
        own.scale
    );
    if own.explained < CERTAIN {
        return Finding::cannot_tell(SCALE, channel, figure, "drive without spinning wheels");
    }
    Finding::fault(SCALE, channel, figure, remedy)
}

/// The best passing with the angles of `links`. `None` where the ground shows nothing.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "steps of a path"
)]
fn passing(course: &Course<'_>, links: &Links) -> Option<Passing> {
    let [front, rear] = course.heights(links);
    let (count, spacing) = (course.len(), course.spacing());
    let at = |scale: f64| (scale * spacing / STEP) as usize;
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
    })
}

/// Root of the mean square of the deviations from the mean.
fn deviation(x: &[f64]) -> f64 {
    let finite = || x.iter().filter(|v| v.is_finite());
    let count = u32::try_from(finite().count().max(1)).unwrap_or(u32::MAX);
    let mean = finite().sum::<f64>() / f64::from(count);
    rms(&x.iter().map(|x| x - mean).collect::<Vec<_>>())
}

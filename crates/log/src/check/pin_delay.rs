//! Delay of the angle of pin Q behind the inertial sensor in the body: with the right one the wheels
//! pass the same ground.

use crate::check::course::{Course, Heights, OWN, steps_of};
use crate::check::ground::passing;
use crate::check::{Finding, Readings, delay};
use robhaz_score::signals::{delayed, subtract};

/// Share of the rear difference that the front one explains where the ground shows something, and
/// where it shows a delay.
const EXPLAINED: f64 = 0.7;
const CERTAIN: f64 = 0.9;
/// Delay of the angle of pin Q that is the lag of an inclinometer, s: a low pass of 8 Hz has 20 ms.
const ALLOWED_DELAY: f64 = 0.03;
/// Error of the distance between two axles by slip, -.
const SLIP: f64 = 0.03;
/// Residual share without a delay over that with it, which is a fault.
const WORSE: f64 = 2.0;
/// Largest number of delays of each sign that are tried.
const MOST_LAGS: isize = 40;

const PIN: &str = "pin_angle after body_inclination";

/// Delay of the angle of pin Q behind the body, for right signs and units: with it the wheels pass
/// the same ground best. `longest` (s) is looked for. `None` of sensors on the links.
pub fn finding(log: &Readings<'_>, longest: f64) -> Option<Finding> {
    let (recording, robot, body) = (&log.recording, log.stated.robot, log.stated.body_link()?);
    let of_body = &recording.inclination[body];
    let pin = subtract(&recording.inclination[1 - body], of_body);
    let as_read = Course::of(recording, robot);
    let shift = passing(&as_read, &OWN).map_or(steps_of(&as_read, 1.0), |p| p.shift);
    let passing_at = |lag: isize| {
        let turned = delayed(&pin, -lag);
        let other = of_body.iter().zip(&turned).map(|(a, b)| a + b).collect();
        let mut links = recording.inclination.clone();
        links[1 - body] = other;
        Heights::of(&Course::with(recording, robot, &links), &OWN).explained(shift)
    };
    let steps = recording.steps(longest) as isize;
    let coarse = (steps / MOST_LAGS).max(1);
    let lags = (-steps / coarse..=steps / coarse).map(|k| k * coarse);
    let shares = lags.filter_map(|lag| Some((lag, passing_at(lag)?)));
    let best = shares.max_by(|a, b| a.1.total_cmp(&b.1));
    let remedy = "drive with all wheels over an obstacle of some centimetres";
    let (Some(own), Some((lag, share))) = (passing_at(0), best) else {
        let figure = "the ground shows no delay";
        return Some(Finding::ok(delay::TEST, PIN, figure).cannot_tell(remedy));
    };
    let seconds = lag as f64 * recording.dt;
    let figure = format!(
        "{:.1} ms: the curve of the front wheels explains {:.1} % of that of the rear ones, {:.1} % without delay",
        1e3 * seconds,
        100.0 * share,
        100.0 * own
    );
    let finding = Finding::ok(delay::TEST, PIN, figure);
    // A distance that is wrong by slip looks like a delay, too.
    let spin = recording.usual_spin()?;
    let way = SLIP * as_read.spacings()[0];
    let by_slip = way / (spin * robot.geometry.wheel_radius);
    let of_steps = 0.5 * recording.slowest + 0.5 * coarse as f64 * recording.dt;
    let allowed = ALLOWED_DELAY + of_steps + by_slip;
    if share < EXPLAINED {
        return Some(finding.cannot_tell(remedy));
    }
    let finding = finding.with("delay", seconds, "s");
    if seconds.abs() <= allowed || 1.0 - own < WORSE * (1.0 - share) {
        return Some(finding);
    }
    if share < CERTAIN {
        let remedy = "the pin may be late, by more than this; compare the clocks of both sensors";
        return Some(finding.cannot_tell(remedy));
    }
    let late = match seconds > 0.0 {
        true => "pin_angle",
        false => "body_inclination and body_rate",
    };
    Some(finding.fault(format!(
        "{late} arrive late: state offset = {:.4} of their channel",
        -seconds.abs()
    )))
}

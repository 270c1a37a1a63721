//! Torques of left and right against the encoders of both sides.

use super::frames::{period, values};
use crate::check::recording::steps;
use crate::check::{Finding, still};
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;
use robhaz_score::signals::{derivative, fit, high_pass, smooth};

/// The test.
pub const TEST: &str = "torques of the sides";
/// Time over which speeds and torques are averaged, s, of an ordinary drive.
const SMOOTHING: f64 = 0.1;
/// Time over which set speeds and slopes do not change, s, of an ordinary drive.
const SLOWLY: f64 = 0.5;
/// Share of the torques' differences that a speed control explains.
const EXPLAINED: f64 = 0.5;
/// Least drive over [`SMOOTHING`]: of as many independent samples two of noise explain that share once in 10 000 logs,
/// `(1 - share)^((n - 3)/2)`.
const LEAST: f64 = 30.0;

/// Whether the difference of the torques of wheel `i` of both sides answers that of its encoders, as a
/// speed control does; false where one of both, torque or encoder, is exchanged. `None` where the log
/// does not show it.
pub fn follows(frames: &[WholeFrame], rover: &WholeRover, i: usize, pace: f64) -> Option<bool> {
    let difference = |of: fn(&WholeFrame) -> &[Option<f64>; 6]| {
        values(frames, |frame| Some(of(frame)[i]? - of(frame)[i + 3]?))
    };
    let dt = period(frames)?;
    let turning = still::turning(frames.iter().map(|f| (f.time, f.wheel_angle)), &rover.side);
    // A count of frames.
    let driven = dt * turning.iter().filter(|turns| **turns).count() as f64;
    if driven < LEAST * pace * SMOOTHING {
        return None;
    }
    let half = steps(0.5 * pace * SMOOTHING, dt);
    let angle = difference(|f| &f.wheel_angle);
    let torque = difference(|f| &f.motor_torque);
    let speed = derivative(&angle, half, dt);
    // Set speeds differ in a turn, torques on a slope: both slowly.
    let slow = steps(pace * SLOWLY, dt);
    let [speed, angle, torque] = [speed, angle, smooth(&torque, half)].map(|x| high_pass(&x, slow));
    let found = fit(&torque, &[&speed, &angle])?;
    let size = |x: &[f64]| {
        let known = x.iter().filter(|x| x.is_finite());
        known.map(|x| x * x).sum::<f64>().sqrt()
    };
    let of_speed = found.coefficients.first()? * size(&speed);
    let of_angle = found.coefficients.get(1)? * size(&angle);
    let answer = match of_speed.abs() > of_angle.abs() {
        true => of_speed,
        false => of_angle,
    };
    (found.explained > EXPLAINED).then_some(answer < 0.0)
}

/// The torques of both sides: each answers its own encoder.
pub fn finding(follows: [Option<bool>; 3]) -> Finding {
    let (test, channel) = (TEST, "torques and encoders");
    let numbers = |which: Option<bool>| {
        let found = (1..=3).filter(|i| follows[i - 1] == which);
        found.map(|i| i.to_string()).collect::<Vec<_>>().join(", ")
    };
    let [wrong, unknown] = [Some(false), None].map(numbers);
    if !wrong.is_empty() {
        let figure = format!("of wheels {wrong} the torque answers the encoder of the other side");
        let remedy = format!(
            "exchange the columns of left and right of the motor_torque or of the angle of wheels {wrong}, not of both: turn a left wheel by hand, and the angle that changes is the left one"
        );
        return Finding::ok(test, channel, figure).fault(remedy);
    }
    if !unknown.is_empty() {
        let figure = format!("of wheels {unknown} the torques show no answer of a speed control");
        let remedy = "drive over bumps under one side under speed control";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let figure = "the differences of left and right torques answer those of the encoders";
    Finding::ok(test, channel, figure)
}

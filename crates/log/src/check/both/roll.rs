//! The roll against its rate.

use super::across::{LEAST_TURN, SMOOTHING};
use super::frames::{LONGEST_GAP, held, values, wheel_turns};
use crate::check::recording::{range, steps};
use crate::check::{Finding, StatedBoth, way};
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;
use robhaz_score::signals::{Fit, derivative, fit, integral, median, smooth};
use std::ops::RangeInclusive;

/// Standard deviations of the sensor's constant error beyond which a mean is a slope or a zero.
const GATE: f64 = 3.0;

/// What is read of the roll: time, roll, its rate, turns of the wheels, yaw rate.
type RollReading = [f64; 5];

/// Of a part of a log without gaps, at each reading alike smoothed: the roll, what its rate adds up to, and what the
/// direction of the specific force has besides: a rover accelerates across as it turns, as O turns about the middle
/// wheels, and as it rolls about the line on which it stands.
fn rolls(part: &[RollReading], rover: &WholeRover, dt: f64) -> [Vec<f64>; 5] {
    let (geometry, gravity) = (&rover.side.geometry, rover.side.gravity);
    let half = steps(0.5 * SMOOTHING, dt);
    let column = |i: usize| -> Vec<f64> { part.iter().map(|reading| reading[i]).collect() };
    // As smooth as a derivative.
    let smooth = |x: &[f64]| smooth(&smooth(x, half), half);
    let slope = |i: usize| derivative(&column(i), half, dt);
    let of_rate = integral(&column(2), dt);
    let per_turn = geometry.wheel_radius / 6.0 / gravity;
    let yaw = smooth(&column(4));
    let turns = slope(3).into_iter().zip(yaw);
    let turning = turns.map(|(turn, yaw)| per_turn * turn * yaw).collect();
    let times = |factor: f64, x: Vec<f64>| x.iter().map(|x| factor / gravity * x).collect();
    [
        smooth(&column(1)),
        smooth(&of_rate),
        turning,
        times(rover.ahead_of_middle(), slope(4)),
        times(-rover.height_of_pivot(), slope(2)),
    ]
}

/// The zero of the roll. No other reading shows it: ground that falls to one side does the same.
pub fn zero(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    at_rest: Option<(f64, bool)>,
) -> Finding {
    let turned = held(frames, wheel_turns);
    let steps: Vec<f64> = turned.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let mean = way::mean_over(&steps, &values(frames, |f| f.roll));
    // A log that does not drive shows none.
    let mean = if mean.is_nan() { 0.0 } else { mean };
    let allowed = GATE * stated.settings.budget.inclination_bias;
    let [shown, at_most] = [mean, allowed].map(f64::to_degrees);
    let figure =
        format!("mean over the way {shown:.2} deg, by the sensor at most {at_most:.2} deg");
    let finding = Finding::ok("zero of the roll", "body_roll", figure).with("mean", shown, "deg");
    if mean.abs() <= allowed {
        return finding;
    }
    let of_rest = at_rest.map(|(roll, is_slope)| match is_slope {
        true => format!("at rest it shows {roll:.4} rad, which is its zero if the rover stood level"),
        false => format!("at rest it shows {roll:.4} rad, so that ground or bumps under one side cause the mean, if the rover stood level"),
    });
    if let (Some(of_rest), Some((_, false))) = (&of_rest, at_rest) {
        return finding.cannot_tell(of_rest.as_str());
    }
    let of_rest = of_rest.map_or(String::new(), |of_rest| format!("{of_rest}; "));
    finding.cannot_tell(format!(
        "{of_rest}if neither ground nor bumps were higher under one side, {mean:.4} rad is the zero of body_roll: state it as its offset, of an IMU as roll_offset; driven to and fro on the same ground, or stood on it both ways round, the mean of both rolls is the zero, and each degree of it moves load from side to side"
    ))
}

/// The sign of the roll against its rate, over half a second of an ordinary drive. What both have in common over the
/// whole log shows nothing: a gyroscope's bias.
pub fn roll(frames: &[WholeFrame], stated: &StatedBoth<'_>, pace: f64) -> Finding {
    /// Longest time, s: a gyroscope that drifts by 0.1 deg/s turns by less than [`LEAST_TURN`].
    const LONGEST: f64 = 5.0;
    /// Error of each part of the acceleration across: tyres yield, wheels slip, and a sensor is not in O.
    const OF_ACROSS: f64 = 0.5;
    /// Ratio of right readings.
    const RIGHT: RangeInclusive<f64> = 0.7..=1.4;
    let (mut wheels, mut yaw) = (0.0, 0.0);
    let reading = |f: &WholeFrame| {
        wheels = wheel_turns(f).unwrap_or(wheels);
        yaw = f.rates[2].unwrap_or(yaw);
        Some([f.time, f.roll?, f.rates[0]?, wheels, yaw])
    };
    let readings: Vec<RollReading> = frames.iter().filter_map(reading).collect();
    let periods = readings.windows(2).map(|w| w[1][0] - w[0][0]);
    let dt = median(periods.collect()).filter(|dt| *dt > 0.0);
    let dt = dt.unwrap_or(LONGEST_GAP);
    // Twice the step of the filter of a gyroscope's drift: slow drifts cancel.
    let apart = (0.5 * pace).min(LONGEST);
    let step = steps(apart, dt);
    let mut changes: Vec<[f64; 5]> = Vec::new();
    for part in readings.chunk_by(|a, b| b[0] - a[0] <= LONGEST_GAP) {
        let of_part = rolls(part, stated.rover, dt);
        let change = |k: usize| of_part.each_ref().map(|x| x[k] - x[k - step]);
        changes.extend((step..part.len()).map(change));
    }
    changes.retain(|change| change.iter().all(|x| x.is_finite()));
    let column = |i: usize| -> Vec<f64> { changes.iter().map(|change| change[i]).collect() };
    let by_rate = column(1);
    let (test, channel) = ("roll and its rate", "body_roll, body_roll_rate");
    if range(&by_rate) < LEAST_TURN {
        let figure = format!("the body rolls by less than 2 deg in {apart:.1} s");
        let remedy = "drive over bumps under one side, or lift one side by hand, while recording";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let constant = vec![1.0; by_rate.len()];
    // What does not change at all has none of it.
    let times = |found: Option<Fit>| found.map_or(0.0, |found| found.coefficients[0]);
    let [read, turning, swinging, rolling] =
        [0, 2, 3, 4].map(|i| times(fit(&column(i), &[&by_rate, &constant])));
    let across = match stated.settings.budget.specific_force {
        true => [turning, swinging, rolling],
        false => [0.0; 3],
    };
    let ratio = read - across.iter().sum::<f64>();
    let error = OF_ACROSS * across.iter().map(|part| part.abs()).sum::<f64>();
    let figure = format!("the roll changes {ratio:.2} times as its rate says");
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio {
        ratio if RIGHT.contains(&ratio) => finding,
        ratio if ratio + error < 0.0 => finding.fault(
            "turn the sign of body_roll or of body_roll_rate: lift the left side by hand, then both must be positive",
        ),
        ratio if ratio + error < *RIGHT.start() || ratio - error > *RIGHT.end() => {
            finding.fault("check the units of both")
        }
        _ => finding.cannot_tell("lift one side by hand, slowly: a body that rolls fast accelerates across, which its roll as read contains"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{rover, stated, turn_left};
    use super::*;
    use crate::check::report::Verdict;

    /// Of an inclinometer without acceleration.
    fn of_angle(rover: &WholeRover) -> StatedBoth<'_> {
        let mut stated = stated(rover);
        stated.settings.budget.specific_force = false;
        stated
    }

    /// The roll of a body that rolls to and fro, times `read`; 1 is a reading of the specific force.
    fn rolling(spin: f64, read: [f64; 2]) -> Finding {
        let rover = rover();
        // Of the line on which it stands.
        let across = rover.height_of_pivot() * spin * spin / rover.side.gravity;
        let frames = turn_left(|f| {
            f.rates[2] = Some(0.0);
            f.roll = Some(0.06 * (read[0] + read[1] * across) * (spin * f.time).sin());
            f.rates[0] = Some(0.06 * spin * (spin * f.time).cos());
        });
        roll(&frames, &stated(&rover), 1.0)
    }

    /// Closed form: a rover that rolls about the line on which it stands accelerates across by h times the roll's
    /// acceleration: at 9 rad/s the direction of the specific force turns by 3.2 times the roll, and nothing is wrong.
    /// Within 0.25: the smoothing takes a part of what is taken out. A wrong sign and unit show there, too.
    #[test]
    fn a_fast_roll_turns_the_specific_force() {
        for spin in [1.0, 3.0, 6.0, 9.0] {
            let ratio = |read: [f64; 2]| rolling(spin, read).numbers[0].value;
            assert!(
                (ratio([1.0, 1.0]) - 1.0).abs() < 0.25,
                "{spin} {}",
                ratio([1.0, 1.0])
            );
            assert_eq!(rolling(spin, [1.0, 1.0]).verdict, Verdict::Ok);
            assert_eq!(rolling(spin, [-1.0, -1.0]).verdict, Verdict::Fault);
            assert_eq!(rolling(spin, [57.3, 57.3]).verdict, Verdict::Fault);
        }
    }

    /// Closed form: a bias of the rate changes nothing of the ratio. The ends of the log leave two hundredths.
    #[test]
    fn a_bias_of_the_rate_shows_nothing() {
        const BIAS: f64 = 0.1;
        let rolling = turn_left(|f| {
            f.roll = Some(0.03 * (3.0 * f.time).sin());
            f.rates[0] = Some(0.09 * (3.0 * f.time).cos() + BIAS);
        });
        let found = roll(&rolling, &of_angle(&rover()), 1.0);
        assert!((found.numbers[0].value - 1.0).abs() < 0.02, "{found:?}");
    }

    /// The roll over a gap of 3 s, in which it changes by 0.3 rad, is not that of its rate there.
    #[test]
    fn a_gap_shows_no_roll() {
        let rolling = |f: &mut WholeFrame| {
            f.roll = Some(0.1 * (3.0 * f.time).sin());
            f.rates[0] = Some(0.3 * (3.0 * f.time).cos());
        };
        let mut frames = turn_left(rolling);
        for frame in frames.iter_mut().filter(|f| f.time > 5.0) {
            frame.roll = frame.roll.map(|roll| roll + 0.3);
        }
        frames.retain(|f| !(2.0..5.0).contains(&f.time));
        assert_eq!(roll(&frames, &of_angle(&rover()), 1.0).verdict, Verdict::Ok);
    }

    /// A roll that is off by 5 deg throughout a drive may be a slope: not called right, and the zero is named.
    #[test]
    fn a_zero_of_the_roll_is_not_called_right() {
        let rover = rover();
        let verdict = |roll: f64| {
            let frames = turn_left(|f| f.roll = Some(roll.to_radians()));
            let found = zero(&frames, &of_angle(&rover), None);
            assert!((found.numbers[0].value - roll).abs() < 1e-9, "{found:?}");
            found.verdict
        };
        assert_eq!(verdict(0.0), Verdict::Ok);
        assert_eq!(verdict(5.0), Verdict::CannotTell);
    }
}

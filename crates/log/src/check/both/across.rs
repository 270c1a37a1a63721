//! What the readings of both sides show against each other: roll, yaw, and torques of left and right.

use crate::check::report::Finding;
use crate::check::stated::StatedBoth;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::{Coupling, WholeRover};
use robhaz_score::signals::{derivative, fit, high_pass, median, smooth};

/// Time over which speeds and torques are averaged, s.
const SMOOTHING: f64 = 0.1;
/// Time over which set speeds and slopes do not change, s.
const SLOWLY: f64 = 0.5;
/// Share of the torques' differences that a speed control explains.
const EXPLAINED: f64 = 0.5;
/// Error of a joint's zero that is to be found, rad: 2 deg of the differential cost 2 % of N.
const LARGEST_ZERO: f64 = 0.035;
/// Turn of the body that shows a sign, rad.
const LEAST_TURN: f64 = 0.03;

/// Size of the yaw over a log, rad.
pub fn turn(frames: &[WholeFrame]) -> f64 {
    let steps = frames.windows(2).filter_map(|w| {
        let [_, _, rate] = w[0].rates;
        Some(rate? * (w[1].time - w[0].time))
    });
    steps.sum::<f64>().abs()
}

/// The sign of the roll against its rate: changes over a tenth of a second.
pub fn roll(frames: &[WholeFrame]) -> Finding {
    let readings = frames
        .iter()
        .filter_map(|f| Some((f.time, f.roll?, f.rates[0]?)));
    let (mut turned, mut angle, mut products, mut squares) = (0.0, Vec::new(), 0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    for (time, roll, rate) in readings {
        if let Some((before, old)) = last.replace((time, rate)) {
            turned += 0.5 * (old + rate) * (time - before);
        }
        angle.push((time, roll, turned));
    }
    // Twice the step of the filter of a gyroscope's drift: slow drifts cancel.
    let step = angle.partition_point(|(t, ..)| *t < angle.first().map_or(0.0, |a| a.0) + 0.5);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (a, b) in angle.iter().zip(angle.iter().skip(step.max(1))) {
        let (by_roll, by_rate) = (b.1 - a.1, b.2 - a.2);
        products += by_roll * by_rate;
        squares += by_rate * by_rate;
        (low, high) = (low.min(by_rate), high.max(by_rate));
    }
    let (test, channel) = ("roll and its rate", "body_roll, body_roll_rate");
    let range = high - low;
    if range.is_nan() || range < LEAST_TURN {
        let figure = "the body rolls by less than 2 deg in half a second";
        let remedy = "drive over bumps under one side, or lift one side by hand, while recording";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let ratio = products / squares;
    let figure = format!("the roll changes {ratio:.2} times as its rate says");
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio {
        ratio if ratio < 0.0 => finding.fault(
            "turn the sign of body_roll or of body_roll_rate: lift the left side by hand, then both must be positive",
        ),
        ratio if !(0.7..=1.4).contains(&ratio) => finding.fault("check the units of both"),
        _ => finding,
    }
}

/// The zeros of the joints. All wheels pass the same ground, so on a long way the mean of a joint's angle is
/// zero, but for what the ground's slope changes from the first footprint to the last.
pub fn zeros(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> [Finding; 3] {
    type Of = fn(&WholeFrame) -> Option<f64>;
    let geometry = &stated.rover.side.geometry;
    let footprint = (geometry.axles[0].x - geometry.axles[2].x).abs();
    let reading =
        |of: Of| -> Vec<f64> { frames.iter().map(|f| of(f).unwrap_or(f64::NAN)).collect() };
    let half = ((0.5 * SMOOTHING / period(frames).unwrap_or(SMOOTHING)).round() as usize).max(1);
    let averaged = |of: Of| smooth(&reading(of), half);
    let turned = averaged(|f| f.wheel_angle.iter().copied().sum());
    let steps: Vec<f64> = turned.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let length =
        geometry.wheel_radius / 6.0 * steps.iter().filter(|step| step.is_finite()).sum::<f64>();
    let range = |of: Of| {
        let known = averaged(of).into_iter().filter(|x| x.is_finite());
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = known.fold(ends, |(low, high), x| (x.min(low), x.max(high)));
        high - low
    };
    let slopes = range(|f| f.inclination) + range(|f| f.roll);
    let allowed = 3.0 * stated.joint[1] + 0.5 * footprint * slopes / length;
    let coupling = match stated.rover.coupling {
        Coupling::Differential => "differential_angle",
        Coupling::RearBogie => "rear_bogie_angle",
    };
    let of_joint = |channel: &str, of: Of| {
        let parts = steps
            .iter()
            .zip(reading(of))
            .filter(|(step, x)| (*step * x).is_finite());
        let (sum, all) = parts.fold((0.0, 0.0), |(sum, all), (step, x)| {
            (sum + step * x, all + step)
        });
        let mean = sum / all;
        let [shown, at_most] = [mean, allowed].map(f64::to_degrees);
        let figure = format!("mean over {length:.1} m {shown:.2} deg, at most {at_most:.2} deg");
        let finding = Finding::ok("zero over the way", channel, figure).with("mean", shown, "deg");
        if mean.abs() > allowed {
            finding.fault(format!("subtract {mean:.4} rad from {channel}: state it as its offset, or set its zero on level ground"))
        } else if allowed < LARGEST_ZERO {
            finding
        } else {
            finding.cannot_tell("drive some metres more over ground that is less uneven")
        }
    };
    [
        of_joint("left_pin_angle", |f| f.pins[0]),
        of_joint("right_pin_angle", |f| f.pins[1]),
        of_joint(coupling, |f| f.coupling),
    ]
}

/// Median time between frames, s.
fn period(frames: &[WholeFrame]) -> Option<f64> {
    let steps = frames.windows(2).map(|w| w[1].time - w[0].time);
    median(steps.collect()).filter(|dt| *dt > 0.0)
}

/// The sign of the yaw rate against the wheels: in a turn to the left the right ones are faster.
pub fn yaw(frames: &[WholeFrame], rover: &WholeRover) -> Finding {
    let radius = rover.side.geometry.wheel_radius;
    let track: f64 = rover.half_tracks.iter().sum::<f64>() / 3.0;
    let (mut products, mut squares, mut turned, mut last) = (0.0, 0.0, 0.0_f64, None);
    for frame in frames {
        let sum = |side: usize| {
            let wheels = frame.wheel_angle[3 * side..][..3].iter();
            wheels.copied().sum::<Option<f64>>()
        };
        let (Some(left), Some(right), [.., Some(rate)]) = (sum(0), sum(1), frame.rates) else {
            continue;
        };
        let faster = radius * (right - left) / (6.0 * track);
        if let Some((time, before)) = last.replace((frame.time, faster)) {
            let by_gyro: f64 = rate * (frame.time - time);
            products += by_gyro * (faster - before);
            squares += by_gyro * by_gyro;
            turned += by_gyro;
        }
    }
    let (test, channel) = ("yaw and wheels", "body_yaw_rate");
    if turned.abs() < 10.0 * LEAST_TURN {
        let figure = format!("turned by {:.1} deg", turned.to_degrees());
        let remedy = "drive a turn of 20 deg or more";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let ratio = products / squares;
    let figure = format!(
        "turned by {:.0} deg; the wheels {ratio:.2} times as much, in a skid turn more than 1",
        turned.to_degrees()
    );
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio < 0.0 {
        true => finding.fault(
            "turn the sign of body_yaw_rate, to the left positive; or left and right wheels are exchanged",
        ),
        false => finding,
    }
}

/// Whether the difference of the torques of wheel `i` of both sides answers that of its encoders, as a
/// speed control does; false where one of both, torque or encoder, is exchanged. `None` where the log
/// does not show it.
pub fn torque_follows(frames: &[WholeFrame], i: usize) -> Option<bool> {
    let difference = |of: fn(&WholeFrame) -> &[Option<f64>; 6]| -> Vec<f64> {
        let of_frame = |frame: &WholeFrame| Some(of(frame)[i]? - of(frame)[i + 3]?);
        frames
            .iter()
            .map(|f| of_frame(f).unwrap_or(f64::NAN))
            .collect()
    };
    let dt = period(frames)?;
    let half = ((0.5 * SMOOTHING / dt).round() as usize).max(1);
    let [angle, torque] = [
        difference(|f| &f.wheel_angle),
        difference(|f| &f.motor_torque),
    ];
    let speed = derivative(&angle, half, dt);
    // Set speeds differ in a turn, torques on a slope: both slowly.
    let slow = ((SLOWLY / dt).round() as usize).max(1);
    let [speed, angle, torque] = [speed, angle, smooth(&torque, half)].map(|x| high_pass(&x, slow));
    let found = fit(&torque, &[&speed, &angle])?;
    let size = |x: &[f64]| {
        x.iter()
            .filter(|x| x.is_finite())
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt()
    };
    let of_speed = found.coefficients.first()? * size(&speed);
    let of_angle = found.coefficients.get(1)? * size(&angle);
    let answer = if of_speed.abs() > of_angle.abs() {
        of_speed
    } else {
        of_angle
    };
    (found.explained > EXPLAINED).then_some(answer < 0.0)
}

/// The torques of both sides: each answers its own encoder.
pub fn torques(follows: [Option<bool>; 3]) -> Finding {
    let (test, channel) = ("torques of the sides", "torques and encoders");
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
    let finding = Finding::ok(
        test,
        channel,
        "the differences of left and right torques answer those of the encoders",
    );
    match unknown.is_empty() {
        true => finding,
        false => {
            let figure =
                format!("of wheels {unknown} the torques show no answer of a speed control");
            Finding::ok(test, channel, figure)
                .cannot_tell("drive over bumps under one side under speed control")
        }
    }
}

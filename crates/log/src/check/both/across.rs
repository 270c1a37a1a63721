//! What the readings of joints and body show by themselves and against the wheels: missing ones, ranges, the sign of
//! yaw, zeros of the joints.

use super::frames::{
    self, LONGEST_GAP, Of, Reading, held, period, readings, values, wheel_turns, yaw_bias,
    yaw_steps,
};
use crate::check::recording::{add, steps};
use crate::check::way::{Way, range};
use crate::check::{Channel, Finding, Recorded, StatedBoth, dead, rest, still};
use crate::frames::side_frame;
use robhaz_estimator::whole::WholeFrame;
use robhaz_estimator::{NoiseBudget, SensorFrame};
use robhaz_model::WholeRover;
use robhaz_score::signals::{median, smooth};
use std::f64::consts::PI;

/// Time over which turns of the wheels and slopes are averaged, s.
pub const SMOOTHING: f64 = 0.1;
/// Turn of the body that shows a sign, rad.
pub const LEAST_TURN: f64 = 0.03;
/// Standard deviations of a bias beyond which it is a turn: a false alarm in 16 000.
const GATE: f64 = 4.0;
/// Turn of the wheels over that of the gyroscope that is none: a skid turn has more than 1.
const SMALL: f64 = 0.3;

/// Readings of the body and the joints that are not there.
pub fn silences(frames: &[WholeFrame], rover: &WholeRover) -> Vec<Finding> {
    let found = readings(rover).into_iter().filter_map(|(name, of)| {
        let read = |f: &WholeFrame| (f.time, of(f).is_some_and(f64::is_finite));
        dead::silent(name, frames.iter().map(read))
    });
    found.collect()
}

/// Readings of a rover that are beyond what it can do, as angles in another unit are.
pub fn ranges(frames: &[WholeFrame], rover: &WholeRover) -> Vec<Finding> {
    /// Share of the frames beyond its range that is no spike.
    const OFTEN: f64 = 0.05;
    /// Angle of a pin over its end stop that no zero explains.
    const BEYOND: f64 = 1.5;
    /// Largest angle of differential, rear bogie and body, rad: the rover has tipped over.
    const LARGEST: f64 = 1.0;
    let stop = &rover.side.geometry.stop;
    let of_pin = BEYOND * stop.lower.abs().max(stop.upper.abs());
    // Of the pins, the coupling, inclination and roll.
    let largest = [of_pin, of_pin, LARGEST, LARGEST, LARGEST];
    let finding = |((channel, of), most): (Reading, f64)| {
        let all: Vec<f64> = frames.iter().filter_map(of).map(f64::abs).collect();
        let beyond = all.iter().filter(|angle| **angle > most).count();
        // Counts of frames.
        (beyond as f64 > OFTEN * all.len() as f64).then(|| {
            let largest = all.iter().copied().fold(0.0, f64::max);
            let figure = format!("up to {largest:.2} rad, where {most:.2} is what the rover can do");
            let finding =
                Finding::ok("range of joints", channel, figure).with("largest", largest, "rad");
            // No direction is beyond half a turn.
            let is_direction = channel.starts_with("body_") && largest < 1.01 * PI;
            let usual = median(all).filter(|_| is_direction);
            match usual {
                Some(usual) if usual > rest::UPSIDE_DOWN => {
                    rest::upside_down(finding, Channel::BodyInclination)
                }
                Some(usual) if usual > LARGEST => {
                    let key = match channel {
                        "body_roll" => "roll_offset",
                        _ => "inclination_offset",
                    };
                    rest::impossible(
                        finding,
                        &format!("subtract it from {channel}, of an IMU with {key} of imu.body"),
                    )
                }
                _ => finding.fault(format!("check its unit and zero: angles in degrees have unit = \"deg\" in reading.{channel}")),
            }
        })
    };
    let angles = readings(rover).into_iter().zip(largest);
    let torques = (0..6).filter_map(|i| torque_range(frames, rover, i));
    angles.filter_map(finding).chain(torques).collect()
}

/// A torque beyond that with which a wheel that carried the whole rover would slip at a friction of 1.
fn torque_range(frames: &[WholeFrame], rover: &WholeRover, i: usize) -> Option<Finding> {
    let side = &rover.side;
    let weight = 2.0 * side.mass.total() * side.gravity;
    let most = weight * side.geometry.wheel_radius;
    let mut all = values(frames, |f| Some(f.motor_torque[i]?.abs()));
    all.retain(|torque| torque.is_finite());
    // Half of the time it is more: no spikes.
    let usual = median(all).filter(|usual| *usual > most)?;
    let name = frames::of_wheel(i, "motor_torque");
    let figure = format!(
        "{usual:.1} N m in half of the frames, where a wheel that carries the whole rover slips at {most:.1}"
    );
    let remedy = "check its unit: N m at the wheel; of mN m state unit, of a current in A or mA torque_constant (and gear_ratio)";
    let finding = Finding::ok("range of torques", name, figure).with("usual", usual, "N m");
    Some(finding.fault(remedy))
}

/// Whether what no side has by itself repeats its value while the wheels turn: the coupling's angle, and all of the body.
pub fn stuck(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Vec<Finding> {
    let left: Vec<SensorFrame> = frames.iter().map(|frame| side_frame(frame, 0)).collect();
    let driving = still::driving(&left, &stated.rover.side);
    let drives = still::drives(&driving, Channel::Pin);
    let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    let (budget, [pin, _]) = (stated.settings.budget, stated.joint);
    let drives_ever = drives.contains(&true);
    let finding = |((name, of), noise): (Reading, f64)| {
        let values = values(frames, of);
        let words = ["what this sensor writes", "wheels turn"];
        let same = dead::same(name, name, &values, words).filter(|_| drives_ever && noise > 0.0);
        same.unwrap_or_else(|| still::stuck(name, (&times, &values), &drives, Some(noise)))
    };
    let (angles, rates) = (budget.inclination_noise, budget.rate_noise);
    let noises = [pin, pin, pin, angles, angles, rates, rates, rates];
    // Of these each side has a finding, but of a differential's body made of the coupling, too.
    let is_of_sides = |((name, _), _): &(Reading, f64)| {
        name.ends_with("_pin_angle") || ["body_inclination", "body_rate"].contains(name)
    };
    let all = readings(stated.rover).into_iter().zip(noises);
    let (of_sides, others): (Vec<_>, Vec<_>) = all.partition(is_of_sides);
    let dead = of_sides.into_iter().map(finding).filter(Finding::is_fault);
    others.into_iter().map(finding).chain(dead).collect()
}

/// The noise at rest of the two angles that no side has by itself: of the coupling and of the roll.
pub fn noise_at_rest(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Vec<Finding> {
    let Some(rest) = frames::rest(frames) else {
        return Vec::new();
    };
    let [.., (coupling, of_coupling), _, (roll, of_roll), _, _, _] = readings(stated.rover);
    let (pin, inclination) = (stated.joint[0], stated.settings.budget.inclination_noise);
    let noise = |name: &str, of: Of, channel, noise| {
        let values = rest.iter().filter_map(|f| of(f));
        let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let channel = Recorded {
            channel,
            noise,
            values,
        };
        let finding = rest::noise(&channel, None);
        Finding {
            channel: name.to_owned(),
            ..finding
        }
    };
    vec![
        noise(coupling, of_coupling, Channel::Pin, pin),
        noise(roll, of_roll, Channel::BodyInclination, inclination),
    ]
}

/// The sign of the yaw rate against the wheels: in a turn to the left the right ones are faster.
pub fn yaw(frames: &[WholeFrame], rover: &WholeRover, budget: &NoiseBudget) -> Finding {
    let (mut products, mut squares, mut turned, mut time) = (0.0, 0.0, 0.0_f64, 0.0);
    let steps = yaw_steps(frames, rover).into_iter();
    for step in steps.filter(|step| step.time < LONGEST_GAP) {
        let by_gyro = step.rate * step.time;
        products += by_gyro * step.by_wheels;
        squares += by_gyro * by_gyro;
        turned += by_gyro;
        time += step.time;
    }
    let [_, bias] = yaw_bias(frames, budget);
    let (test, channel) = ("yaw and wheels", "body_yaw_rate");
    if turned.abs() < 10.0 * LEAST_TURN + GATE * bias * time {
        let figure = format!("turned by {:.1} deg", turned.to_degrees());
        let remedy = match GATE * bias * time > LEAST_TURN {
            true => {
                "stand for a second first, which shows the gyroscope's bias, and drive a turn of 20 deg or more"
            }
            false => "drive a turn of 20 deg or more",
        };
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let ratio = products / squares;
    let figure = format!(
        "turned by {:.0} deg; the wheels {ratio:.2} times as much, in a skid turn more than 1",
        turned.to_degrees()
    );
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio {
        ratio if ratio < -SMALL => finding.fault(
            "turn the sign of body_yaw_rate, to the left positive; or left and right wheels are exchanged",
        ),
        ratio if ratio < SMALL => finding.fault("check the unit of body_yaw_rate: rad/s or deg/s"),
        _ => finding,
    }
}

/// Wheels of left and right that turn against each other while the body does not spin: motors that are
/// mounted mirror-wise count the other way.
pub fn opposed(frames: &[WholeFrame], rover: &WholeRover) -> Option<Finding> {
    let (mut sums, mut spun) = ([0.0; 3], [0.0; 2]);
    for step in yaw_steps(frames, rover) {
        let [left, right] = step.sides;
        add(&mut sums, [left * left, right * right, left * right]);
        spun[0] += step.by_wheels * step.by_wheels;
        spun[1] += step.by_wheels * step.rate * step.time.min(LONGEST_GAP);
    }
    let [left, right, product] = sums;
    let (correlation, share) = (product / (left * right).sqrt(), spun[1] / spun[0]);
    (correlation < -0.5 && share.abs() < SMALL).then(|| {
        let figure = format!("they turn against each other (correlation {correlation:.2}), and the body does not spin");
        let finding = Finding::ok("left and right wheels", "encoders of both sides", figure);
        finding.with("correlation", correlation, "-").fault("motors that are mounted mirror-wise count the other way: turn the signs of all angles and torques of the side that counts backwards on the way forward")
    })
}

/// The zeros of the joints.
pub fn zeros(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> [Finding; 3] {
    let geometry = &stated.rover.side.geometry;
    let half = steps(0.5 * SMOOTHING, period(frames).unwrap_or(SMOOTHING));
    let averaged = |of: Of| smooth(&held(frames, of), half);
    let turned = averaged(wheel_turns);
    let step = |w: &[f64]| geometry.wheel_radius / 6.0 * (w[1] - w[0]).abs();
    let way = Way {
        steps: turned.windows(2).map(step).collect(),
        footprint: geometry.wheelbase(),
        slopes: range(&averaged(|f| f.inclination)) + range(&averaged(|f| f.roll)),
        bias: stated.joint[1],
    };
    let [left, right, coupling, ..] = readings(stated.rover);
    [left, right, coupling].map(|(channel, of): Reading| way.zero(channel, &values(frames, of)))
}

#[cfg(test)]
mod tests {
    use super::super::frames::without_yaw_bias;
    use super::super::testing::{rover, stated, turn_left};
    use super::*;
    use crate::check::report::Verdict;

    /// A yaw rate in deg/s is no wrong sign, and a gap in a turn is no turn of the wheels: the ratio stays
    /// near 1.
    #[test]
    fn the_yaw_has_sign_and_unit() {
        let remedy = |change: fn(&mut WholeFrame)| {
            let finding = yaw(&turn_left(change), &rover(), &NoiseBudget::typical());
            finding.remedy.unwrap_or_default()
        };
        assert_eq!(remedy(|_| ()), "");
        assert!(remedy(|f| f.rates[2] = f.rates[2].map(f64::to_degrees)).contains("unit"));
        assert!(remedy(|f| f.rates[2] = f.rates[2].map(|x| -x)).contains("turn the sign"));
        let mut frames = turn_left(|_| ());
        frames.retain(|f| !(2.0..6.0).contains(&f.time));
        let found = yaw(&frames, &rover(), &NoiseBudget::typical());
        assert_eq!(found.verdict, Verdict::Ok);
    }

    /// A roll, and a coupling in another unit, that are too loud at rest, by deviations of 5 deg and of 57 times 0.05 deg.
    #[test]
    fn noise_at_rest_is_tested() {
        let rover = rover();
        let verdicts = |[coupling, roll]: [f64; 2]| {
            let frames = turn_left(|f| {
                let white = (7.7e4 * f.time).sin() * std::f64::consts::SQRT_2;
                f.wheel_angle = [Some(0.0); 6];
                f.coupling = Some((coupling * white).to_radians());
                f.roll = Some((roll * white).to_radians());
            });
            let found = noise_at_rest(&frames, &stated(&rover));
            let of = |f: Finding| (f.channel, f.verdict, f.remedy.unwrap_or_default());
            found.into_iter().map(of).collect::<Vec<_>>()
        };
        let [(coupling, of_coupling, _), (roll, of_roll, _)] = &verdicts([0.05, 0.1])[..] else {
            panic!("two")
        };
        assert_eq!([coupling, roll], ["differential_angle", "body_roll"]);
        assert_eq!([of_coupling, of_roll], [&Verdict::Ok; 2]);
        let loud = verdicts([57.3 * 0.05, 5.0]);
        assert!(
            loud.iter()
                .all(|(_, verdict, _)| *verdict == Verdict::Fault)
        );
        assert!(loud[0].2.contains("check the unit"), "{loud:?}");
    }

    /// A gyroscope with a bias of 3 deg/s that drives straight on for 10 s: it does not turn where that is stated, a rest
    /// shows it, and a turn behind it has its sign.
    #[test]
    fn a_stated_bias_is_no_turn() {
        const BIAS: f64 = 0.05;
        let budget = |rate_bias: f64| NoiseBudget {
            rate_bias,
            ..NoiseBudget::typical()
        };
        let straight = turn_left(|f| {
            f.wheel_angle = [Some(2.0 * f.time); 6];
            f.rates[2] = Some(BIAS);
        });
        let verdict = |stated: f64| yaw(&straight, &rover(), &budget(stated)).verdict;
        assert_eq!(verdict(0.0), Verdict::Fault);
        assert_eq!(verdict(BIAS), Verdict::CannotTell);
        let mut turn = turn_left(|f| f.rates[2] = f.rates[2].map(|rate| rate + BIAS));
        let first = turn[0];
        for frame in &mut turn {
            frame.time += 1.0;
        }
        let rest = |k: u32| WholeFrame {
            time: 0.02 * f64::from(k),
            rates: [Some(0.0), Some(0.0), Some(BIAS)],
            ..first
        };
        let frames: Vec<_> = (0..50).map(rest).chain(turn).collect();
        let corrected = without_yaw_bias(&frames, &budget(BIAS));
        let found = yaw(&corrected, &rover(), &budget(BIAS));
        assert_eq!(found.verdict, Verdict::Ok);
        assert!((found.numbers[0].value - 1.0).abs() < 0.05, "{found:?}");
    }

    /// Motors mounted mirror-wise: the right wheels count backwards. A rover that spins on the spot, and one
    /// that drives on, have none.
    #[test]
    fn mirrored_motors_are_found() {
        let right = |f: &mut WholeFrame, way: f64| {
            f.wheel_angle = [1.0, 1.0, 1.0, way, way, way].map(|way| Some(2.0 * way * f.time));
        };
        let found = |way: f64, rate: f64| {
            let spins = |f: &mut WholeFrame| {
                right(f, way);
                f.rates[2] = Some(rate);
            };
            opposed(&turn_left(spins), &rover())
        };
        assert!(found(-1.0, 0.0).is_some());
        assert!(found(1.0, 0.0).is_none());
        // 2 rad/s at 0.075 m, half track 0.208 m: clockwise.
        assert!(found(-1.0, -0.72).is_none());
    }

    /// Joints in degrees are beyond what a rover can do; spikes are not.
    #[test]
    fn angles_in_degrees_are_out_of_range() {
        let pin = |f: &mut WholeFrame, x: f64| f.pins[1] = Some(x);
        let found = |change: &dyn Fn(&mut WholeFrame)| ranges(&turn_left(change), &rover());
        assert!(found(&|f| pin(f, 0.4 * f.time.sin())).is_empty());
        let spike = |f: &mut WholeFrame| pin(f, if f.time < 0.1 { 20.0 } else { 0.0 });
        assert!(found(&spike).is_empty());
        let degrees = found(&|f| pin(f, (0.2 * f.time.sin()).to_degrees()));
        assert_eq!(degrees.len(), 1);
        assert_eq!(degrees[0].channel, "right_pin_angle");
    }

    /// Without a roll the slopes are not known, and no zero is wrong.
    #[test]
    fn without_a_roll_no_zero_shows() {
        let rover = rover();
        let frames = turn_left(|f| (f.roll, f.pins) = (None, [Some(0.2); 2]));
        for zero in zeros(&frames, &stated(&rover)) {
            assert_eq!(zero.verdict, Verdict::CannotTell, "{}", zero.figure);
        }
    }
}

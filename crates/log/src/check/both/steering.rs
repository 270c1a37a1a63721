//! Whether the wheels are steered as the rover turns.

use super::STRAIGHT;
use super::frames::{self, LONGEST_GAP, body_turn, yaw_steps};
use super::wiring::ENDS;
use crate::check::Finding;
use crate::check::recording::{add, driving_speed};
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;
use robhaz_score::signals::{deviation, mean};

/// Steering from which on a wheel does not roll straight ahead, and shows its sign, rad.
const LEAST_STEERING: f64 = 0.05;
/// Time over which a steering angle is compared, s.
const STEERING_STEP: f64 = 0.1;

/// Whether the rover turns without steering: its wheels are dragged across.
pub fn skids(frames: &[WholeFrame]) -> bool {
    let is_turned = |angle: &f64| angle.abs() > LEAST_STEERING;
    let steers = |f: &WholeFrame| f.steering.iter().flatten().any(is_turned);
    body_turn(frames) > STRAIGHT && !frames.iter().any(steers)
}

/// A part of a drive over which steering angles are compared.
struct Part<'a> {
    /// Speed (m/s) and yaw rate (rad/s), and that of the wheels, if none slips.
    speed: f64,
    rate: f64,
    by_wheels: f64,
    /// Speeds of the wheels, rad/s.
    rims: [f64; 6],
    /// The frame at its end.
    end: &'a WholeFrame,
}

/// The parts of a log without gaps.
fn parts<'a>(frames: &'a [WholeFrame], rover: &WholeRover) -> Vec<Part<'a>> {
    let radius = rover.side.geometry.wheel_radius;
    let mut parts = Vec::new();
    // Time at the start of a part, s; of its steps the turns of all wheels and of the body by them, the sum of the yaw rates
    // and their number.
    let (mut start, mut sums) = (None, [0.0; 4]);
    let mut before = [0.0; 6];
    for step in yaw_steps(frames, rover) {
        let (time, [left, right]) = (step.end.time, step.sides);
        let angles = step.end.wheel_angle.map(Option::unwrap_or_default);
        if step.time > LONGEST_GAP || start.is_none() {
            (start, sums, before) = (Some(time), [0.0; 4], angles);
            continue;
        }
        add(&mut sums, [left + right, step.by_wheels, step.rate, 1.0]);
        let elapsed = time - start.unwrap_or(time);
        if elapsed >= STEERING_STEP {
            let [turned, by_wheels, rate, count] = std::mem::take(&mut sums);
            parts.push(Part {
                speed: radius * turned / (2.0 * elapsed),
                rate: rate / count,
                by_wheels: by_wheels / elapsed,
                rims: core::array::from_fn(|i| (angles[i] - before[i]) / elapsed),
                end: step.end,
            });
            (start, before) = (Some(time), angles);
        }
    }
    parts
}

/// The steering of each wheel against the turn: an angle that the log lacks counts as 0.
pub fn steering(frames: &[WholeFrame], rover: &WholeRover) -> Vec<Finding> {
    let geometry = &rover.side.geometry;
    let least = driving_speed(&rover.side);
    let mut parts = parts(frames, rover);
    // At rest a turn has no direction.
    parts.retain(|part| part.speed.abs() >= least);
    // Of each wheel the sums of the squares of the angle that the turn asks for and of that read, and of their product.
    let mut sums = [[0.0; 3]; 6];
    for part in &parts {
        for (i, [asked, read, product]) in sums.iter_mut().enumerate() {
            let side = if i < 3 { 1.0 } else { -1.0 };
            let ahead = geometry.axles[i % 3].x - geometry.axles[1].x;
            let along = part.speed - part.rate * side * rover.half_tracks[i % 3];
            let angle = (part.rate * ahead * along.signum()).atan2(along.abs());
            let found = part.end.steering[i].unwrap_or(0.0);
            *asked += angle * angle;
            *read += found * found;
            *product += angle * found;
        }
    }
    let has = |i: usize| frames.iter().any(|f| f.steering[i].is_some());
    if !(0..6).any(has) {
        return unread(&parts, rover).into_iter().collect();
    }
    let size = |square: f64| (square / parts.len() as f64).sqrt();
    let steers = (0..6).any(|i| has(i) && size(sums[i][1]) > LEAST_STEERING);
    let of_wheel = |i: usize| {
        let [asked, _, product] = sums[i];
        let name = frames::of_wheel(i, "steering");
        // Wheels beside the turn's centre do not steer; without a turn nothing shows.
        if !(steers && size(asked) > LEAST_STEERING) {
            return None;
        }
        let ratio = product / asked;
        let figure = format!("{ratio:.2} of what the turn asks for");
        let finding = Finding::ok("steering and turn", &name, figure).with("ratio", ratio, "-");
        Some(match ratio {
            _ if !has(i) => finding.fault(format!(
                "other wheels steer, and {name} is not in the log, or not mapped: it counts as 0"
            )),
            ratio if ratio < -0.5 => {
                finding.fault(format!("turn the sign of {name}: to the left positive"))
            }
            ratio if ratio > 10.0 => finding.fault(format!("state unit = \"deg\" of {name}")),
            ratio if (0.5..2.0).contains(&ratio) => finding,
            _ => finding.cannot_tell("drive a turn in which no wheel is dragged across"),
        })
    };
    let all: Vec<Finding> = (0..6).filter_map(of_wheel).collect();
    let is_turned = |f: &Finding| {
        let ratio = f.numbers.first().map_or(0.0, |number| number.value);
        f.is_fault() && (-2.0..-0.5).contains(&ratio)
    };
    if all.len() < 2 || !all.iter().all(is_turned) {
        return all;
    }
    vec![opposite(&all, follows(&parts))]
}

/// Whether the rims of the end wheels roll by so much further than straight ahead as wheels do that are steered into the
/// turn, though the log has no steering angle.
fn unread(parts: &[Part<'_>], rover: &WholeRover) -> Option<Finding> {
    let geometry = &rover.side.geometry;
    let radius = geometry.wheel_radius;
    // What steered wheels roll more than the turn asks for along the rover: its square, that of the speed, and the product
    // with what is read.
    let [mut asked, mut speed, mut product] = [0.0; 3];
    for part in parts {
        for side in [0, 1] {
            let out = if side == 0 { 1.0 } else { -1.0 };
            // Those of the middle wheels, which do not steer.
            let middle = 0.5 * radius * (part.rims[1] + part.rims[4]);
            let along = |i: usize| middle - part.rate * out * rover.half_tracks[i];
            let beyond = |i: usize| radius * part.rims[3 * side + i] - along(i);
            for end in [0, 2] {
                let ahead = part.rate * (geometry.axles[end].x - geometry.axles[1].x);
                let steered = along(end).hypot(ahead).copysign(along(end)) - along(end);
                asked += steered * steered;
                product += steered * beyond(end);
                speed += part.speed * part.speed;
            }
        }
    }
    /// Least way that steering adds, over the way, that shows.
    const LEAST: f64 = 0.01;
    let share = product / asked;
    let is_steered = asked > LEAST * LEAST * speed && (0.5..2.0).contains(&share);
    is_steered.then(|| {
        let figure = format!("front and rear wheels roll further than the turn asks for along the rover, by {share:.2} of what steered ones do");
        Finding::ok("steering and turn", "steering", figure)
            .with("ratio", share, "-")
            .fault("of steered wheels map left_wheel1_steering and so on: without them all wheels count as straight ahead")
    })
}

/// Correlation of the yaw rate with that of the wheels, whatever its bias.
fn follows(parts: &[Part<'_>]) -> f64 {
    let of = |of: fn(&Part<'_>) -> f64| parts.iter().map(of).collect::<Vec<f64>>();
    let (rates, turns) = (of(|part| part.rate), of(|part| part.by_wheels));
    let [rate, turn] = [&rates, &turns].map(|x| mean(x).unwrap_or(0.0));
    let products = rates.iter().zip(&turns);
    let products: Vec<f64> = products.map(|(a, b)| (a - rate) * (b - turn)).collect();
    mean(&products).unwrap_or(0.0) / (deviation(&rates) * deviation(&turns))
}

/// All steered wheels the other way round than the turn asks for: one cause, and not one of each. `follows`: see there.
fn opposite(all: &[Finding], follows: f64) -> Finding {
    /// Correlation that shows a sign.
    const CORRELATED: f64 = 0.5;
    let numbers = all.iter().flat_map(|f| &f.numbers);
    let ratios: Vec<String> = numbers.map(|n| format!("{:.2}", n.value)).collect();
    let figure = format!("{} of what the turn asks for", ratios.join(", "));
    let yaw = "turn the sign of body_yaw_rate, to the left positive (of an IMU: world, up and forward of imu.body)";
    let wheels = format!(
        "front and rear wheels are exchanged: {ENDS}\nor turn the signs of all steering angles, to the left positive: no reading tells these two, look at the rover"
    );
    Finding::ok("steering and turn", "all steered wheels", figure).fault(match follows {
        follows if follows > CORRELATED => wheels,
        follows if follows < -CORRELATED => yaw.to_owned(),
        _ => format!("{yaw}\nor {wheels}"),
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{rover, turn_left};
    use super::*;

    /// Closed form of steering along the way: right as it is; a sign, degrees, and an angle that is not
    /// there are each found at their wheel, and at no other.
    #[test]
    fn steering_is_that_of_the_turn() {
        let faults = |change: fn(&mut WholeFrame)| {
            let found = steering(&turn_left(change), &rover());
            assert_eq!(found.len(), 4, "{found:?}");
            let faults = found.into_iter().filter(|f| f.is_fault());
            faults
                .map(|f| (f.channel, f.remedy.unwrap_or_default()))
                .collect::<Vec<_>>()
        };
        assert!(faults(|_| ()).is_empty());
        type Case = (fn(&mut WholeFrame), &'static str);
        let cases: [Case; 3] = [
            (
                |f| f.steering[3] = f.steering[3].map(|x| -x),
                "turn the sign",
            ),
            (
                |f| f.steering[3] = f.steering[3].map(f64::to_degrees),
                "deg",
            ),
            (|f| f.steering[3] = None, "not in the log"),
        ];
        for (change, remedy) in cases {
            let found = faults(change);
            assert!(
                found.len() == 1 && found[0].0 == "right_wheel1_steering",
                "{found:?}"
            );
            assert!(found[0].1.contains(remedy), "{found:?}");
        }
        // All the other way round: one cause, and the wheels' speeds tell the gyroscope's sign where the turn changes.
        let reversed = |f: &mut WholeFrame| f.steering = f.steering.map(|x| Some(-x?));
        let slalom = |of_gyro: f64| {
            let rover = rover();
            let geometry = &rover.side.geometry;
            turn_left(|f| {
                let (turned, rate) = (0.2 * f.time.sin(), 0.2 * f.time.cos());
                for i in 0..6 {
                    let across = rover.half_tracks[i % 3] * if i < 3 { 1.0 } else { -1.0 };
                    let ahead = geometry.axles[i % 3].x - geometry.axles[1].x;
                    let rolled = 0.2 * f.time - turned * across;
                    f.wheel_angle[i] = Some(rolled / geometry.wheel_radius);
                    let angle = (rate * ahead).atan2(0.2 - rate * across);
                    f.steering[i] = f.steering[i].map(|_| -of_gyro * angle);
                }
                f.rates[2] = Some(of_gyro * rate);
            })
        };
        for (frames, [yaw, ends]) in [
            (turn_left(reversed), [true; 2]),
            (slalom(1.0), [false, true]),
            (slalom(-1.0), [true, false]),
        ] {
            let found = steering(&frames, &rover());
            assert_eq!(found.len(), 1, "{found:?}");
            let remedy = found[0].remedy.clone().unwrap_or_default();
            assert_eq!(remedy.contains("body_yaw_rate"), yaw, "{remedy}");
            assert_eq!(remedy.contains("wheel1 and wheel3"), ends, "{remedy}");
        }
        assert!(skids(&turn_left(|f| f.steering = [None; 6])) && !skids(&turn_left(|_| ())));
        // Straight on nothing shows.
        let straight = |f: &mut WholeFrame| (f.rates[2], f.steering) = (Some(0.0), [Some(0.0); 6]);
        assert!(steering(&turn_left(straight), &rover()).is_empty());
        // Without steering angles: steered wheels roll further than those of a rover that skids.
        let unread = |skids: bool| {
            let frames = turn_left(|f| {
                for (angle, steering) in f.wheel_angle.iter_mut().zip(&mut f.steering) {
                    let share = steering.take().filter(|_| skids).map_or(1.0, f64::cos);
                    *angle = angle.map(|angle| angle * share);
                }
            });
            let found = steering(&frames, &rover());
            found.iter().filter(|f| f.is_fault()).count()
        };
        assert_eq!([unread(true), unread(false)], [0, 1]);
    }
}

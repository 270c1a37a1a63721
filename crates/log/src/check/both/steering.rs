//! Whether the wheels are steered as the rover turns.

use super::STRAIGHT;
use super::frames::{LONGEST_GAP, body_turn, wheel_turns};
use crate::check::recording::driving_speed;
use crate::check::report::Finding;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;

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
    /// Speed (m/s) and yaw rate (rad/s).
    speed: f64,
    rate: f64,
    /// The frame at its end.
    end: &'a WholeFrame,
}

/// The parts of a log without gaps.
fn parts<'a>(frames: &'a [WholeFrame], rover: &WholeRover) -> Vec<Part<'a>> {
    let radius = rover.side.geometry.wheel_radius;
    let mut parts = Vec::new();
    // Time (s) and angle (rad) of the wheels at the start of a part; of its frames the sum of the yaw rates and
    // their number; time of the frame before.
    let (mut start, mut yaw, mut count) = (None::<(f64, f64)>, 0.0, 0.0);
    let mut last = None::<f64>;
    for frame in frames {
        let (Some(now), [.., Some(rate)]) = (wheel_turns(frame), frame.rates) else {
            continue;
        };
        let before = last.replace(frame.time).unwrap_or(frame.time);
        if frame.time - before > LONGEST_GAP {
            start = None;
        }
        (yaw, count) = (yaw + rate, count + 1.0);
        if let Some((time, from)) = start {
            if frame.time - time < STEERING_STEP {
                continue;
            }
            parts.push(Part {
                speed: radius * (now - from) / (6.0 * (frame.time - time)),
                rate: yaw / count,
                end: frame,
            });
        }
        (start, yaw, count) = (Some((frame.time, now)), 0.0, 0.0);
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
    for Part { speed, rate, end } in &parts {
        for (i, [asked, read, product]) in sums.iter_mut().enumerate() {
            let side = if i < 3 { 1.0 } else { -1.0 };
            let ahead = geometry.axles[i % 3].x - geometry.axles[1].x;
            let along = speed - rate * side * rover.half_tracks[i % 3];
            let angle = (rate * ahead * along.signum()).atan2(along.abs());
            let found = end.steering[i].unwrap_or(0.0);
            *asked += angle * angle;
            *read += found * found;
            *product += angle * found;
        }
    }
    let has = |i: usize| frames.iter().any(|f| f.steering[i].is_some());
    let size = |square: f64| (square / parts.len() as f64).sqrt();
    let steers = (0..6).any(|i| has(i) && size(sums[i][1]) > LEAST_STEERING);
    let of_wheel = |i: usize| {
        let [asked, _, product] = sums[i];
        let name = format!("{}_wheel{}_steering", ["left", "right"][i / 3], i % 3 + 1);
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
    (0..6).filter_map(of_wheel).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{rover, turn_left};
    use super::*;
    use crate::check::report::Verdict;

    /// Closed form of steering along the way: right as it is; a sign, degrees, and an angle that is not
    /// there are each found at their wheel, and at no other.
    #[test]
    fn steering_is_that_of_the_turn() {
        let faults = |change: fn(&mut WholeFrame)| {
            let found = steering(&turn_left(change), &rover());
            assert_eq!(found.len(), 4, "{found:?}");
            let faults = found.into_iter().filter(|f| f.verdict == Verdict::Fault);
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
        assert!(skids(&turn_left(|f| f.steering = [None; 6])) && !skids(&turn_left(|_| ())));
        // Straight on nothing shows, and without steering nothing is asked.
        let straight = |f: &mut WholeFrame| (f.rates[2], f.steering) = (Some(0.0), [Some(0.0); 6]);
        assert!(steering(&turn_left(straight), &rover()).is_empty());
        assert!(steering(&turn_left(|f| f.steering = [None; 6]), &rover()).is_empty());
    }
}

//! Single wrong torques: what no drive of such a robot gives, and readings that jump to and fro. The estimators leave
//! them out, and the other tests do not see them.

use crate::check::torques::range_of_overflow;
use crate::check::{Channel, Finding};
use robhaz_estimator::whole::WholeFrame;
use robhaz_estimator::{LARGEST_TORQUE, SensorFrame};
use robhaz_model::{Robot, Units};
use std::borrow::Cow;

/// Step (N m) and slope (N m/s) of a torque of robot A within which it may change: what the estimators take at once.
const REACH: [f64; 2] = [1.0, 100.0];
/// A jump is beyond so many times the change that nine of ten are within, and so many deviations of the stated noise.
const UNUSUAL: f64 = 10.0;
/// Share of the readings from which on those beyond the largest torque have another unit.
const MANY: f64 = 0.05;

const TEST: &str = "spikes";

/// The findings, each with the number of its torque, and the frames.
type Found<'a, F> = (Vec<(usize, Finding)>, Cow<'a, [F]>);

/// Those of one side: a finding for each torque with such readings, and the frames without them. `noise` is the stated
/// one, N m.
pub fn of_side<'a>(frames: &'a [SensorFrame], robot: &Robot, noise: f64) -> Found<'a, SensorFrame> {
    findings(frames, |f| f.time, |f| &mut f.motor_torque, robot, noise)
}

/// The same of both sides, with one side of the rover.
pub fn of_both<'a>(frames: &'a [WholeFrame], side: &Robot, noise: f64) -> Found<'a, WholeFrame> {
    findings(frames, |f| f.time, |f| &mut f.motor_torque, side, noise)
}

/// The same of frames with N torques.
fn findings<'a, F: Clone, const N: usize>(
    frames: &'a [F],
    time: fn(&F) -> f64,
    torques: fn(&mut F) -> &mut [Option<f64>; N],
    robot: &Robot,
    noise: f64,
) -> Found<'a, F> {
    let (mut found, mut mended) = (Vec::new(), Cow::Borrowed(frames));
    for i in 0..N {
        let read = |frame: &F| (time(frame), torques(&mut frame.clone())[i]);
        let read: Vec<(f64, Option<f64>)> = frames.iter().map(read).collect();
        let wrong = wrong(&read, robot, noise);
        let Some(&first) = wrong.first() else {
            continue;
        };
        for k in &wrong {
            torques(&mut mended.to_mut()[*k])[i] = None;
        }
        let size = |k: &usize| read[*k].1.unwrap_or(f64::NAN);
        let largest = wrong
            .iter()
            .map(size)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let largest = largest.unwrap_or(f64::NAN);
        let of = read.iter().filter(|(_, value)| value.is_some()).count();
        let count = wrong.len();
        let figure = format!(
            "wrong readings: {count} of {of}, first at {:.3} s, up to {} N m",
            read[first].0,
            shown(largest)
        );
        let finding = Finding::ok(TEST, Channel::Torque(i % 3), figure)
            .fault("the estimators leave them out: check cable, connector and bus, and what is logged where there is no reading")
            .with("time", read[first].0, "s")
            .with("readings", count as f64, "-")
            .with("largest", largest, "N m");
        found.push((i, finding));
    }
    (found, mended)
}

fn shown(torque: f64) -> String {
    match torque.abs() < 1e5 {
        true => format!("{torque:.1}"),
        false => format!("{torque:.1e}"),
    }
}

/// The frames of those of a torque: times (s) and values (N m).
fn wrong(read: &[(f64, Option<f64>)], robot: &Robot, noise: f64) -> Vec<usize> {
    let unit = Units::of(robot).torque();
    let known = read.iter().enumerate();
    let known =
        known.filter_map(|(k, (time, value))| Some((k, *time, value.filter(|v| !v.is_nan())?)));
    let (absurd, good): (Vec<_>, Vec<_>) =
        known.partition(|(.., value)| value.abs() > LARGEST_TORQUE * unit);
    let all: Vec<f64> = read
        .iter()
        .filter_map(|(_, value)| value.filter(|v| v.is_finite()))
        .collect();
    // Counts.
    if absurd.len() as f64 > MANY * all.len() as f64 || range_of_overflow(&all).is_some() {
        return Vec::new();
    }
    let mut changes: Vec<f64> = good.windows(2).map(|w| (w[1].2 - w[0].2).abs()).collect();
    changes.sort_by(f64::total_cmp);
    let usual = changes.get(changes.len() * 9 / 10).copied().unwrap_or(0.0);
    let least = UNUSUAL * usual.max(noise);
    let jumps = |w: &&[(usize, f64, f64)]| {
        let by = [w[0], w[2]].map(|(_, time, value)| {
            let reach = least + (REACH[0] + REACH[1] * (time - w[1].1).abs()) * unit;
            let by = w[1].2 - value;
            if by.abs() > reach { by.signum() } else { 0.0 }
        });
        by[0] * by[1] > 0.0
    };
    let jumps = good.windows(3).filter(jumps).map(|w| w[1].0);
    let mut wrong: Vec<usize> = absurd.iter().map(|(k, ..)| *k).chain(jumps).collect();
    wrong.sort_unstable();
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(change: impl Fn(usize) -> Option<f64>) -> (Vec<(usize, Finding)>, Vec<SensorFrame>) {
        let frame = |k: usize| {
            let usual = 2.0 + (0.05 * k as f64).sin() + 0.1 * (7.3 * k as f64).sin();
            SensorFrame {
                time: 0.01 * k as f64,
                motor_torque: [Some(usual), Some(change(k).unwrap_or(usual)), Some(usual)],
                ..SensorFrame::default()
            }
        };
        let frames: Vec<SensorFrame> = (0..1000).map(frame).collect();
        let (found, mended) = of_side(&frames, &Robot::default_a(), 0.1);
        (found, mended.into_owned())
    }

    /// Readings of any size by themselves, a sentinel here and there and in a row, are named, and no other test sees
    /// them; a torque that changes, an overflow and another unit are none.
    #[test]
    fn wrong_torques_are_named_and_left_out() {
        for size in [30.0, 300.0, -999.0, 1e300] {
            for by in [37, 500] {
                let (named, mended) = found(|k| (k % by == 9).then_some(size));
                let [(1, finding)] = &named[..] else {
                    panic!("{size} {by}: {named:?}")
                };
                let count = (0..1000).filter(|k| k % by == 9).count();
                assert_eq!(
                    finding.number("readings"),
                    Some(count as f64),
                    "{finding:?}"
                );
                assert_eq!(finding.number("largest"), Some(size), "{finding:?}");
                let left = mended.iter().filter_map(|f| f.motor_torque[1]);
                assert!(left.clone().all(|x| x.abs() < 5.0) && left.count() == 1000 - count);
            }
        }
        let (named, _) = found(|k| (500..520).contains(&k).then_some(-999.0));
        assert_eq!(named.len(), 1, "{named:?}");
        let step = |k: usize| (k > 500).then_some(30.0);
        let overflow = |k: usize| Some((0.05 * k as f64).sin().rem_euclid(655.36));
        let other_unit = |k: usize| Some(2000.0 + 300.0 * (0.05 * k as f64).sin());
        let none: [&dyn Fn(usize) -> Option<f64>; 4] = [&|_| None, &step, &overflow, &other_unit];
        for (i, change) in none.into_iter().enumerate() {
            assert!(found(change).0.is_empty(), "{i}");
        }
    }
}

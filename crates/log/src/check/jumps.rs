//! Angles of the wheels that jump: single wrong readings, and encoders that count from a new zero.
//!
//! A step of an angle is a jump if no torque explains it: it differs from the step at the speeds before
//! and behind it by more than a wheel can be stopped or spun within that time. Single wrong readings show
//! further, where one wheel alone goes to and fro within two steps. Further tests see the angles without
//! their jumps.
//!
//! The estimators' own gate is narrower: it trusts unit and torques of the readings, which are still to
//! be checked here, and it knows nothing of the steps behind.

use crate::check::still::wrapped;
use crate::check::{Channel, Finding};
use crate::jitter::{Jitter, angles, count_angle};
use robhaz_estimator::SensorFrame;
use robhaz_model::{Robot, Units};
use robhaz_score::signals::median;
use std::borrow::Cow;

/// Change of the spin speed within a step that a true impact may show, beside that to a stop, rad/s:
/// half a metre a second at the rim of robot A.
const LARGEST_CHANGE: f64 = 5.0;
/// Standard deviations of the stamps' errors beyond which a step is none of them.
const GATE: f64 = 5.0;
/// Counts of the encoder by which a step may err: two of its own, two of the speeds.
const COUNTS: f64 = 4.0;
/// Least jump, rad: text formats of few digits.
const LEAST: f64 = 1e-3;
/// Steps before and behind a step over which the speeds are taken.
const STEPS: usize = 4;
/// A step longer than this times the median is a gap, in which a wheel may turn.
const GAP: f64 = 2.5;
/// Relative difference of two jumps that are the same.
const SAME: f64 = 0.25;
/// Jumps of one encoder beyond which it is named without its times.
const FEW: usize = 3;

const TEST: &str = "jumps";

/// A jump of an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jump {
    /// The frame behind it.
    frame: usize,
    /// rad
    by: f64,
    /// Time by which the angle is ahead of the wheel's speed, s.
    ahead: f64,
    /// Whether the angle counts from where it began in the log, or from zero.
    restarts: bool,
    /// Whether the next step jumps back: a single wrong reading.
    single: bool,
}

/// The findings, and the frames without the jumps.
pub fn findings<'a>(
    frames: &'a [SensorFrame],
    robot: &Robot,
    counts: f64,
) -> (Vec<Finding>, Cow<'a, [SensorFrame]>) {
    let change = LARGEST_CHANGE / Units::of(robot).time;
    // By as much a step may err by its stamps.
    let stamps = GATE * std::f64::consts::SQRT_2 * Jitter::of(frames, counts).sigma;
    let mut of_wheels = [0, 1, 2].map(|i| jumps(frames, i, change, counts, stamps));
    let bends = [0, 1, 2].map(|i| bends(frames, i));
    for (i, jumps) in of_wheels.iter_mut().enumerate() {
        jumps.extend(small(&bends, i, counts, stamps));
        jumps.sort_by_key(|jump| (jump.frame, !jump.single));
        jumps.dedup_by_key(|jump| jump.frame);
    }
    drop_set_clocks(&mut of_wheels);
    let mut found = Vec::new();
    let common = common_reset(&of_wheels);
    for (i, jumps) in of_wheels.iter().enumerate() {
        let own = jumps.iter().filter(|jump| Some(jump.frame) != common);
        found.extend(finding(frames, i, &own.copied().collect::<Vec<_>>()));
    }
    if let Some(frame) = common {
        let at = frames[frame].time;
        let figure =
            format!("all encoders count from a new zero at {at:.3} s, the time stamps go on");
        let finding = Finding::ok(TEST, "encoders", figure).fault(
            "the encoders were reset: continue the angles before they are logged, or split the log there",
        );
        found.push(finding.with("time", at, "s"));
    }
    if found.is_empty() {
        let figure = "no step that a wheel cannot make";
        found.push(Finding::ok(TEST, "encoders", figure));
    }
    let mut mended = Cow::Borrowed(frames);
    for (i, jumps) in of_wheels.iter().enumerate().filter(|(_, j)| !j.is_empty()) {
        mend(mended.to_mut(), i, jumps);
    }
    (found, mended)
}

/// The jumps of an encoder; none if they are those of an angle that starts anew after a turn or an
/// overflow, which is a finding of its own.
fn jumps(frames: &[SensorFrame], wheel: usize, change: f64, counts: f64, stamps: f64) -> Vec<Jump> {
    let read = angles(frames, wheel);
    let step = |k: usize| (read[k].1 - read[k - 1].1, read[k].2 - read[k - 1].2);
    let steps: Vec<(f64, f64)> = (1..read.len()).map(step).collect();
    let Some(usual) = median(steps.iter().map(|(dt, _)| *dt).collect()) else {
        return Vec::new();
    };
    let count = count_angle(counts);
    let speed = |steps: &[(f64, f64)]| {
        let of = |(dt, by): &(f64, f64)| (*dt > 0.0).then(|| by / dt);
        median(steps.iter().filter_map(of).collect())
    };
    let mut found: Vec<Jump> = Vec::new();
    for (k, &(dt, by)) in steps.iter().enumerate() {
        if !(dt > 0.0 && dt < GAP * usual) {
            continue;
        }
        let before = speed(&steps[k.saturating_sub(STEPS)..k]);
        let behind = speed(&steps[(k + 1).min(steps.len())..(k + 1 + STEPS).min(steps.len())]);
        let (Some(before), Some(behind)) = (before.or(behind), behind.or(before)) else {
            continue;
        };
        let fastest = before.abs().max(behind.abs());
        let mean = 0.5 * (before + behind);
        let jump = by - mean * dt;
        let by_stamps = mean.abs() * stamps;
        if jump.abs() <= LEAST.max(COUNTS * count) + (fastest + change) * dt + by_stamps {
            continue;
        }
        if let Some(last) = found.last_mut().filter(|last| last.frame == read[k].0)
            && (last.by + jump).abs() < SAME * jump.abs()
        {
            last.single = true;
            continue;
        }
        let angle = read[k + 1].2;
        let near = |zero: f64| (angle - zero).abs() < COUNTS * count + LEAST + 2.0 * fastest * dt;
        found.push(Jump {
            frame: read[k + 1].0,
            by: jump,
            ahead: jump / mean,
            restarts: near(0.0) || near(read[0].2),
            single: false,
        });
    }
    let mut sizes = found.iter().filter(|jump| !jump.single).map(|jump| jump.by);
    let first = sizes.next().unwrap_or(0.0);
    let is_same = |by: f64| (by - first).abs() < 0.01 * first.abs();
    let equal = sizes.clone().filter(|by| is_same(*by)).count();
    // Of some among others the column is that of another quantity.
    let is_other = equal > 0 && equal < sizes.count();
    if is_other || wrapped(frames, Channel::Encoder(wheel)).is_some() {
        found.retain(|jump| jump.single);
    }
    found
}

/// A reading beside the line from the one before to the one behind.
#[derive(Clone, Copy)]
struct Bend {
    /// By how much it lies above, rad.
    by: f64,
    /// By how much the wheel turns from the one before, rad.
    turn: f64,
    /// Time from the one before, s.
    step: f64,
    /// The frame.
    frame: usize,
}

/// The bends of a wheel's angle, without those at gaps.
fn bends(frames: &[SensorFrame], wheel: usize) -> Vec<Bend> {
    let read = angles(frames, wheel);
    let steps = read.windows(2).map(|w| w[1].1 - w[0].1);
    let usual = median(steps.collect()).unwrap_or(0.0);
    let bend = |w: &[(usize, f64, f64)]| {
        let [(_, t0, a0), (frame, t1, a1), (_, t2, a2)] = [w[0], w[1], w[2]];
        let is_even = (t1 - t0).max(t2 - t1) < GAP * usual && t2 > t0;
        let half = (a2 - a0) * (t1 - t0) / (t2 - t0);
        is_even.then_some(Bend {
            by: a1 - a0 - half,
            turn: half.abs(),
            step: t1 - t0,
            frame,
        })
    };
    read.windows(3).filter_map(bend).collect()
}

/// Single wrong readings that torque and inertia would allow, but no motion makes: the reading lies beside its
/// neighbours by far more than usual, and these lie by half of that on the other side, as the line through a wrong
/// one does. What all wheels show at once is of the stamps, or of the robot.
fn small(bends: &[Vec<Bend>; 3], wheel: usize, counts: f64, stamps: f64) -> Vec<Jump> {
    /// Bends that nine of ten are within, times this.
    const UNUSUAL: f64 = 10.0;
    /// Share of the turn from reading to reading by which the ground may stop and spin a wheel within one.
    const OF_TURN: f64 = 0.1;
    /// What the neighbours have of it, at least and at most.
    const OF_NEIGHBOURS: std::ops::Range<f64> = -0.7..-0.3;
    let own = &bends[wheel];
    let mut sizes: Vec<f64> = own.iter().map(|bend| bend.by.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = sizes.get(sizes.len() * 9 / 10).copied().unwrap_or(0.0);
    let count = count_angle(counts);
    let least = LEAST.max(COUNTS * count).max(UNUSUAL * usual);
    let others = || (0..3).filter(|other| *other != wheel);
    let is_alone = |bend: &Bend| {
        others().map(|other| &bends[other]).all(|other| {
            let found = other.binary_search_by_key(&bend.frame, |bend| bend.frame);
            found.map_or(true, |k| other[k].by.abs() < 0.5 * bend.by.abs())
        })
    };
    let single = |w: &[Bend]| {
        let [before, bend, behind] = [w[0], w[1], w[2]];
        let by_stamps = bend.turn / bend.step * stamps;
        let is_far = bend.by.abs() > least + OF_TURN * bend.turn + by_stamps;
        let is_opposite = |other: Bend| OF_NEIGHBOURS.contains(&(other.by / bend.by));
        let are_opposite = is_opposite(before) && is_opposite(behind);
        (is_far && are_opposite && is_alone(&bend)).then_some(Jump {
            frame: bend.frame,
            by: bend.by,
            ahead: 0.0,
            restarts: false,
            single: true,
        })
    };
    own.windows(3).filter_map(single).collect()
}

/// Leaves out the jumps of a clock that was set back: all wheels have turned on by the same time. An
/// encoder that restarts at zero, or where the log began, was reset.
fn drop_set_clocks(of_wheels: &mut [Vec<Jump>; 3]) {
    let [first, ..] = &*of_wheels;
    let at = |jumps: &[Jump], frame: usize| jumps.iter().copied().find(|j| j.frame == frame);
    let is_clock = |jump: &Jump| {
        let all = [0, 1, 2].map(|i| at(&of_wheels[i], jump.frame));
        let [Some(a), Some(b), Some(c)] = all else {
            return false;
        };
        let mean = (a.ahead + b.ahead + c.ahead) / 3.0;
        let is_mean = |j: &Jump| (j.ahead - mean).abs() < SAME * mean.abs();
        let all = [a, b, c];
        mean > 0.0 && all.iter().all(is_mean) && !all.iter().all(|j| j.restarts || j.single)
    };
    let of_clock = first.iter().filter(|j| is_clock(j));
    let clock: Vec<usize> = of_clock.map(|j| j.frame).collect();
    for jumps in of_wheels {
        jumps.retain(|jump| !clock.contains(&jump.frame));
    }
}

/// The frame at which all encoders count from a new zero.
fn common_reset(of_wheels: &[Vec<Jump>; 3]) -> Option<usize> {
    let resets = |jumps: &[Jump], frame| jumps.iter().any(|j| j.frame == frame && !j.single);
    let [first, others @ ..] = of_wheels;
    let mut frames = first.iter().filter(|j| !j.single).map(|j| j.frame);
    frames.find(|frame| others.iter().all(|jumps| resets(jumps, *frame)))
}

fn finding(frames: &[SensorFrame], wheel: usize, jumps: &[Jump]) -> Option<Finding> {
    let first = jumps.first()?;
    let channel = Channel::Encoder(wheel);
    let of = |single: bool| jumps.iter().filter(move |jump| jump.single == single);
    let list = |single: bool| {
        let one = |jump: &Jump| format!("{:+.3} rad at {:.3} s", jump.by, frames[jump.frame].time);
        let first: Vec<String> = of(single).take(FEW).map(one).collect();
        let more = of(single).count().saturating_sub(FEW);
        let more = (more > 0).then(|| format!(" and {more} more"));
        first.join(", ") + &more.unwrap_or_default()
    };
    let mut parts = Vec::new();
    let mut remedies = Vec::new();
    if of(true).next().is_some() {
        parts.push(format!("single wrong readings: {}", list(true)));
        remedies.push("the estimators leave them out: check cable, connector and bus");
    }
    if of(false).next().is_some() {
        parts.push(format!("a new zero: {}", list(false)));
        // Equal ones may be those of an angle that starts anew, at a speed that hides it.
        let is_same = |jump: &Jump| (jump.by - first.by).abs() < 0.01 * first.by.abs();
        let are_equal = of(false).count() > 1 && of(false).all(is_same);
        remedies.push(match are_equal {
            true => "the encoder was reset: continue the angle before it is logged; or the angle starts anew after a turn or an overflow: state `wrap` of its reading in a description",
            false => "the encoder was reset: continue the angle before it is logged",
        });
    }
    let finding = Finding::ok(TEST, channel, parts.join("; ")).fault(remedies.join("\n"));
    let finding = finding.with("time", frames[first.frame].time, "s");
    Some(finding.with("jump", first.by, "rad"))
}

/// Takes single wrong readings away, and continues the angle behind a new zero.
fn mend(frames: &mut [SensorFrame], wheel: usize, jumps: &[Jump]) {
    let mut jumps = jumps.iter().peekable();
    let mut offset = 0.0;
    for (k, frame) in frames.iter_mut().enumerate() {
        let angle = &mut frame.wheel_angle[wheel];
        match jumps.next_if(|jump| jump.frame == k) {
            Some(jump) if jump.single => *angle = None,
            Some(jump) => offset -= jump.by,
            None => {}
        }
        *angle = angle.map(|angle| angle + offset);
    }
}

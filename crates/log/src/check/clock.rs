//! The time stamps of a log: its parts between long gaps and jumps of the clock.
//!
//! Wheels that turn at a steady speed are a clock, too: where all three have turned by much more or
//! less than the time stamps say, the clock was set. Where they turn by whole periods more, and the stamps go on evenly,
//! rows are lost, and the stamps were made from their number. Small errors of the stamps, too, show by the wheels.

use crate::check::Finding;
use crate::jitter::Jitter;
use robhaz_estimator::{NoiseBudget, SensorFrame};
use robhaz_score::signals::{median, rms};

/// Time over which speeds before and after a step are taken, s.
const SPAN: f64 = 0.1;
/// Least number of frames of that time.
const LEAST_FRAMES: usize = 4;
/// Spin speed of a wheel that can serve as a clock, rad/s: 20 mm/s at the rim of the default robot.
const LEAST_SPIN: f64 = 0.2;
/// Relative difference of the speeds before and after, and of the jumps that the wheels show.
const STEADY: f64 = 0.25;
/// Jump, in periods, that is none of jitter or a lost frame.
const LEAST_JUMP: f64 = 2.5;
/// Deviation of a stamped step from the period, over it, up to which stamps go on evenly.
const EVEN: f64 = 0.05;
/// Errors of the steps around a step, over which it is a jump of the clock and no jitter.
const GATE: f64 = 6.0;
/// Share of the steps that are longer by the wheels which may be shorter: errors of encoders are both alike.
const SHORTER: f64 = 0.1;
/// Longest median step, s: more is no log of a robot. It keeps sums of times finite.
const LONGEST_STEP: f64 = 1e6;

/// Errors of the stamps that are no fault, s: of stamps with four decimals. `estimate` counts them by itself.
const ROUNDED: f64 = 2e-4;

const TEST: &str = "clock";
const CHANNEL: &str = "time stamps, encoders";

/// The parts of a log.
pub struct Clock<'a> {
    /// Those between gaps and jumps that are long enough to show something.
    pub parts: Vec<&'a [SensorFrame]>,
    /// Median step of these, s; of irregular stamps a quarter of the mean, if that is more. `None`
    /// without a part.
    pub step: Option<f64>,
}

/// What the wheels say of the time stamps.
struct Shown {
    /// The frames behind a step that contradicts the wheels, and by how much the clock was set back (forward: negative), s.
    jumps: Vec<(usize, f64)>,
    /// The frames behind which the wheels have turned by whole periods more than the stamps, which go on evenly, and how
    /// many; less: negative.
    periods: Vec<(usize, f64)>,
    /// Whether the wheels turn steadily somewhere.
    tells: bool,
}

/// Angles of all wheels in a frame.
struct Turn {
    frame: usize,
    time: f64,
    angle: [f64; 3],
}

impl<'a> Clock<'a> {
    /// Gap at which a log is split, s, and least length of its parts: some times the widths of the
    /// filters of this crate.
    pub const BREAK: f64 = 1.0;
    /// Gap at which a log of a low rate is split, in periods.
    const BREAK_PERIODS: f64 = 5.0;

    /// The parts of frames.
    pub fn of(frames: &'a [SensorFrame]) -> Self {
        let Shown { jumps, .. } = shown(frames);
        let longest = Self::BREAK.max(Self::BREAK_PERIODS * usual_step(frames));
        let (mut frame, mut jump) = (0, jumps.iter().peekable());
        let goes_on = |a: &SensorFrame, b: &SensorFrame| {
            frame += 1;
            let (step, jumps) = (b.time - a.time, jump.next_if(|(at, _)| *at <= frame));
            jumps.is_none() && step > 0.0 && step <= longest
        };
        let mut parts: Vec<&[SensorFrame]> = frames.chunk_by(goes_on).collect();
        parts.retain(|part| part.len() >= 3);
        // Shorter parts show nothing. So the pauses between them are no longer than what is
        // recorded.
        if parts.iter().any(|part| length(part) >= Self::BREAK) {
            parts.retain(|part| length(part) >= Self::BREAK);
        } else {
            let longest = parts.iter().copied().max_by_key(|part| part.len());
            parts = longest.into_iter().collect();
        }
        Self {
            step: step_of(&parts),
            parts,
        }
    }
}

/// The finding.
pub fn finding(frames: &[SensorFrame]) -> Finding {
    let found = shown(frames);
    let time = |frame: usize| frames.get(frame).map_or(0.0, |f| f.time);
    let size = |(_, back): &(usize, f64)| back.abs();
    let largest = (found.jumps.iter()).max_by(|a, b| size(a).total_cmp(&size(b)));
    if let Some((frame, back)) = largest {
        let figure = format!(
            "the clock was set {} by {:.3} s at {:.3} s{}",
            if *back > 0.0 { "back" } else { "forward" },
            back.abs(),
            time(*frame),
            match found.jumps.len() {
                1 => String::new(),
                n => format!(", the largest of {n} jumps"),
            }
        );
        let remedy =
            "split the log there; stamp readings with a monotonic clock, when they are taken";
        let finding = Finding::ok(TEST, CHANNEL, figure).fault(remedy);
        return finding.with("set back", *back, "s");
    }
    let lost = lost(found.periods);
    if let [(first, _), ..] = lost[..] {
        let (times, rows) = (lost.len(), lost.iter().map(|(_, rows)| rows).sum::<f64>());
        let set_back = match times {
            1 => " or the clock was set back",
            _ => "",
        };
        let figure = format!(
            "rows are lost{set_back}, and the stamps go on as if none were: {rows} rows in {times} places, where the wheels turn by whole periods more than the stamps say, first at {:.3} s",
            time(first)
        );
        let remedy = "record the time at which each row is taken: one that is made from the number of the row is wrong behind each lost one";
        let finding = Finding::ok(TEST, CHANNEL, figure).fault(remedy);
        return finding.with("lost rows", rows, "-");
    }
    if found.tells {
        return Finding::ok(TEST, CHANNEL, "the wheels turn as the time stamps say");
    }
    let finding = Finding::ok(TEST, CHANNEL, "the wheels do not turn steadily");
    finding.cannot_tell("record a drive at a steady speed")
}

/// The finding of the errors that the frames show against the stated one; the budget then has the one that counts.
pub fn jitter(frames: &[SensorFrame], budget: &mut NoiseBudget) -> Finding {
    let stated = budget.jitter;
    let jitter = Jitter::of(frames, budget.encoder_counts);
    let [measured, allowed] = [jitter.sigma, stated].map(|time| 1e3 * time);
    let of_unit = jitter.unit.map_or(String::new(), |unit| {
        format!("; the stamps are whole numbers of {:.3} ms", 1e3 * unit)
    });
    let figure = format!(
        "the stamps err by {measured:.2} ms by the wheels, budget {allowed:.2} ms{of_unit}"
    );
    let mut finding = Finding::ok("jitter", "time stamps", figure);
    if !jitter.is_shown {
        finding.figure =
            format!("the wheels do not turn steadily, or by too much between readings{of_unit}");
        finding = finding.cannot_tell("record a drive at a steady speed, at a higher rate");
    } else if jitter.exceeds(stated.max(ROUNDED)) {
        let finer = jitter.unit.map_or("", |_| ", with more digits");
        finding = finding.fault(format!(
            "budget.jitter = \"{measured:.1} ms\" (estimate takes it by itself); better: stamp readings when they are taken{finer}"
        ));
    }
    budget.jitter = jitter.counted(stated);
    finding.with("jitter", jitter.sigma, "s")
}

/// The frames behind lost rows, and their numbers; none where errors of the encoders explain them.
fn lost(periods: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    let (mut lost, less): (Vec<_>, Vec<_>) = periods.iter().partition(|(_, rows)| *rows > 0.0);
    // Counts.
    if less.len() as f64 > SHORTER * lost.len() as f64 {
        lost.clear();
    }
    lost
}

fn steps(frames: &[SensorFrame]) -> impl Iterator<Item = f64> + '_ {
    frames.windows(2).map(|w| w[1].time - w[0].time)
}

/// Time from the first to the last frame, s.
pub fn length(part: &[SensorFrame]) -> f64 {
    match part {
        [first, .., last] => last.time - first.time,
        _ => 0.0,
    }
}

/// The step of parts, s. With a quarter of the mean there are at most four samples a frame.
fn step_of(parts: &[&[SensorFrame]]) -> Option<f64> {
    let median = median(parts.iter().flat_map(|part| steps(part)).collect())?;
    let time: f64 = parts.iter().map(|part| length(part)).sum();
    let count: usize = parts.iter().map(|part| part.len() - 1).sum();
    let step = median.max(0.25 * time / count as f64);
    (step > 0.0 && step.is_finite()).then_some(step)
}

/// Median step of frames, s.
fn usual_step(frames: &[SensorFrame]) -> f64 {
    let step = median(steps(frames).filter(|step| *step > 0.0).collect());
    step.unwrap_or(0.0).min(LONGEST_STEP)
}

fn shown(frames: &[SensorFrame]) -> Shown {
    let turns: Vec<Turn> = frames.iter().enumerate().filter_map(turn).collect();
    let read = frames.iter().filter(|f| f.wheel_angle[0].is_some());
    // Encoders may have a lower rate than the frames.
    let period = usual_step(frames) * (frames.len() / read.count().max(1)).max(1) as f64;
    // A positive number; the cast saturates.
    let count = if period > 0.0 { SPAN / period } else { 0.0 };
    let width = (count as usize).max(LEAST_FRAMES);
    let count = resolution(&turns);
    let mut shown = Shown {
        jumps: Vec::new(),
        periods: Vec::new(),
        tells: false,
    };
    for k in (1 + width)..turns.len().saturating_sub(width) {
        let window = &turns[k - 1 - width..=k + width];
        let Some(found) = wheels_late(window, count) else {
            continue;
        };
        shown.tells = true;
        let steps = turns[k - 2..=k + 1].windows(2);
        let uneven = steps.map(|w| (w[1].time - w[0].time - period).abs());
        let is_even = uneven.fold(0.0, f64::max) <= EVEN * period;
        let rows = (found.iter().sum::<f64>() / (3.0 * period)).round();
        let is_whole = |late: &f64| (late - rows * period).abs() < STEADY * period;
        if is_even && rows != 0.0 && found.iter().all(is_whole) {
            shown.periods.push((turns[k].frame, rows));
        }
        let mean = found.iter().sum::<f64>() / 3.0;
        let agree = found.iter().all(|d| (d - mean).abs() < STEADY * mean.abs());
        if mean.abs() > (LEAST_JUMP * period).max(GATE * jitter_of(window)) && agree {
            shown.jumps.push((turns[k].frame, mean));
        }
    }
    shown
}

/// Deviation of the steps of a window from what the first wheel turns in them, but for the middle one, s.
fn jitter_of(window: &[Turn]) -> f64 {
    let (before, after) = window.split_at(window.len() / 2);
    let errors = [before, after].into_iter().flat_map(|part| {
        let [first, .., last] = part else {
            return Vec::new();
        };
        let pace = (last.time - first.time) / (last.angle[0] - first.angle[0]);
        let error = |w: &[Turn]| (w[1].angle[0] - w[0].angle[0]) * pace - (w[1].time - w[0].time);
        part.windows(2).map(error).collect()
    });
    rms(&errors.collect::<Vec<f64>>())
}

fn turn((frame, f): (usize, &SensorFrame)) -> Option<Turn> {
    let [a, b, c] = f.wheel_angle;
    let angle = [a?, b?, c?];
    let finite = angle.iter().all(|a| a.is_finite());
    finite.then_some(Turn {
        frame,
        time: f.time,
        angle,
    })
}

/// Least change of each encoder, rad: its count, if it is coarse.
fn resolution(turns: &[Turn]) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let change = |w: &[Turn]| (w[1].angle[i] - w[0].angle[i]).abs();
        let changes = turns.windows(2).map(change);
        changes.filter(|c| *c > 0.0).fold(f64::INFINITY, f64::min)
    })
}

/// By how much the three wheels have turned longer than the time stamps say in the middle step of a
/// window, s; 0 within the `count` (rad) of an encoder. `None` if a wheel does not turn at one
/// speed before and after.
fn wheels_late(window: &[Turn], count: [f64; 3]) -> Option<[f64; 3]> {
    let middle = window.len() / 2;
    let (before, after) = window.split_at(middle);
    let ([first, .., last], [next, .., end]) = (before, after) else {
        return None;
    };
    let mut late = [0.0; 3];
    for (i, late) in late.iter_mut().enumerate() {
        let speed = |a: &Turn, b: &Turn| (b.angle[i] - a.angle[i]) / (b.time - a.time);
        let (v0, v1) = (speed(first, last), speed(next, end));
        let mean = 0.5 * (v0 + v1);
        // Written so that a NaN fails too.
        if !(mean.abs() > LEAST_SPIN && (v1 - v0).abs() < STEADY * mean.abs()) {
            return None;
        }
        let found = (next.angle[i] - last.angle[i]) / mean - (next.time - last.time);
        let least = 3.0 * count[i] / mean.abs();
        let step = next.time - last.time;
        // A wheel that turns on never falls behind by more than the step: an angle that starts anew does.
        let is_of_clock = found > -(1.0 + STEADY) * step;
        let is_late = found.abs() > least && is_of_clock;
        *late = if is_late { found } else { 0.0 };
    }
    Some(late)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::LinkReading;

    /// Frames at 1 kHz of wheels that turn at 2 rad/s, with a changed clock.
    fn frames(clock: impl Fn(f64) -> f64) -> Vec<SensorFrame> {
        let link = LinkReading {
            inclination: Some(0.0),
            rate: Some(0.0),
            rate_error: 0.0,
        };
        (0..10_000)
            .map(|k| 1e-3 * f64::from(k))
            .map(|t| SensorFrame {
                time: clock(t),
                wheel_angle: [1.0, 1.01, 0.99].map(|speed| Some(2.0 * speed * t)),
                motor_torque: [Some(0.0); 3],
                link1: link,
                link2: link,
                contact_angle: [None; 3],
                ..SensorFrame::default()
            })
            .collect()
    }

    /// Closed form: a clock that is set by 0.2 s, back or forward, and lost frames, which are no
    /// jump. Rows that are not in order are left out when a log is read: so here.
    #[test]
    fn jumps_of_the_clock_are_found() {
        let set = |by: f64| {
            let mut frames = frames(|t| if t > 5.0 { t + by } else { t });
            let mut latest = f64::NEG_INFINITY;
            frames.retain(|f| {
                let is_later = f.time > latest;
                latest = latest.max(f.time);
                is_later
            });
            frames
        };
        for by in [-0.2, 0.2] {
            let frames = set(by);
            let clock = Clock::of(&frames);
            let jumps = shown(&frames).jumps;
            let [(_, back)] = jumps[..] else {
                panic!("{jumps:?}")
            };
            // To 2 %: the wheels' speeds differ.
            assert!((back + by).abs() < 0.005, "{jumps:?}");
            assert_eq!(clock.parts.len(), 2);
        }
        let mut lost = set(0.0);
        lost.retain(|f| !(4.0..4.2).contains(&f.time));
        let found = shown(&lost);
        assert!(found.jumps.is_empty() && found.tells && Clock::of(&lost).parts.len() == 1);
    }

    /// Stamps that err by three periods, in their order, show no jump of the clock.
    #[test]
    fn jitter_is_no_jump_of_the_clock() {
        let mut random = robhaz_sim::random::Stream::new(1, "stamps");
        let mut frames = frames(|t| t);
        let mut times: Vec<f64> = frames
            .iter()
            .map(|f| f.time + 3e-3 * random.normal())
            .collect();
        times.sort_by(f64::total_cmp);
        frames
            .iter_mut()
            .zip(times)
            .for_each(|(f, time)| f.time = time);
        let found = shown(&frames);
        assert!(found.jumps.is_empty(), "{:?}", found.jumps);
    }

    /// Closed form: frames that are lost behind stamps of their number, one and two at a time; with their own stamps, and
    /// where one reading is repeated and the next one has caught up, none is.
    #[test]
    fn lost_rows_show_by_the_wheels() {
        let renumbered = |mut frames: Vec<SensorFrame>| {
            for (k, frame) in frames.iter_mut().enumerate() {
                frame.time = 1e-3 * k as f64;
            }
            frames
        };
        let mut kept = frames(|t| t);
        // A start shows how fine the encoders are.
        for frame in &mut kept {
            let by = (1.0 - frame.time).max(0.0).powi(2);
            frame.wheel_angle = frame.wheel_angle.map(|angle| Some(angle? + by));
        }
        let all = kept.clone();
        kept.retain(|f| {
            ![3.0, 5.0, 7.0, 7.001]
                .iter()
                .any(|at| (f.time - at).abs() < 1e-6)
        });
        let lost = |frames: &[SensorFrame]| lost(shown(frames).periods);
        assert!(lost(&kept).is_empty());
        let renumbered = renumbered(kept);
        let rows: Vec<f64> = lost(&renumbered).iter().map(|(_, rows)| *rows).collect();
        assert_eq!(rows, [1.0, 1.0, 2.0]);
        assert!(shown(&renumbered).jumps.is_empty());
        let mut repeated = all;
        for k in [3000, 5000] {
            repeated[k].wheel_angle = repeated[k - 1].wheel_angle;
        }
        assert!(lost(&repeated).is_empty());
    }

    /// Parts end at long gaps; parts that are too short are left out.
    #[test]
    fn a_log_is_split_at_gaps() {
        let mut found = frames(|t| if t > 4.0 { t + 1.7e9 } else { t });
        let clock = Clock::of(&found);
        assert_eq!(clock.parts.len(), 2);
        assert!((clock.step.unwrap_or(0.0) - 1e-3).abs() < 1e-6);
        found.truncate(4100);
        assert_eq!(Clock::of(&found).parts.len(), 1);
        assert!(Clock::of(&found[..2]).step.is_none() && Clock::of(&[]).parts.is_empty());
    }
}
